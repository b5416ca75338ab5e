//! What free runs miss, for people and for programs.
use crate::robot::{Joint, JointLayout};
use serde::Serialize;

/// What a joint's free run misses.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FreeChannel {
    /// Of the joint.
    pub name: String,
    /// Of `rms` and `rms_end`: `rad` or `m`.
    pub unit: &'static str,
    /// Root mean square of measured minus predicted position over all samples of all windows; `None` (JSON: null) if no
    /// window came to its end.
    pub rms: Option<f64>,
    /// The same over the last samples of the windows.
    pub rms_end: Option<f64>,
    /// `rms` / root mean square of the measured way from the window's start: 1 is as bad as a joint that is said to stand
    /// still. `None` if it did.
    pub relative: Option<f64>,
}

/// How far the model stays with the robot. Its JSON keys are its field names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FreeRun {
    /// Length, s.
    pub window: f64,
    /// How many were integrated.
    pub windows: usize,
    /// Those of them in which the prediction left the measurement by more than half a turn (1 m), or was not finite; they
    /// are not part of the errors.
    pub diverged: usize,
    /// Those of them that took more steps than allowed, because the model is stiff; they are not part of the errors.
    pub capped: usize,
    /// One per joint, in the order of the model.
    pub channels: Vec<FreeChannel>,
    /// Over all joints and samples.
    pub rms: Option<f64>,
    /// Of `rms`: that of the channels, `mixed` if they differ.
    pub unit: &'static str,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
}

impl FreeRun {
    /// `counts`: windows, diverged ones, capped ones.
    pub(super) fn new(
        layout: &JointLayout,
        sums: &[Sums],
        [windows, diverged, capped]: [usize; 3],
        window: f64,
        assumptions: Vec<String>,
    ) -> Self {
        let channels: Vec<_> =
            layout.joints.iter().zip(sums).map(|(joint, sums)| sums.channel(joint)).collect();
        let unit = match channels.first() {
            Some(first) if channels.iter().all(|channel| channel.unit == first.unit) => first.unit,
            _ => "mixed",
        };
        let rms = sums.iter().fold(Sums::default(), |total, own| total.merged(own)).rms();
        Self { window, windows, diverged, capped, channels, rms, unit, assumptions }
    }
}

/// Sums over the samples of one joint.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Sums {
    samples: usize,
    ends: usize,
    error_squares: f64,
    end_squares: f64,
    way_squares: f64,
}

impl Sums {
    /// `way` is the measured way from the window's start.
    pub fn add(&mut self, error: f64, way: f64, is_end: bool) {
        self.samples += 1;
        self.error_squares += error * error;
        self.way_squares += way * way;
        if is_end {
            self.ends += 1;
            self.end_squares += error * error;
        }
    }

    fn merged(mut self, other: &Self) -> Self {
        self.samples += other.samples;
        self.error_squares += other.error_squares;
        self
    }

    fn rms(&self) -> Option<f64> {
        (self.samples > 0).then(|| (self.error_squares / self.samples as f64).sqrt())
    }

    fn channel(&self, joint: &Joint) -> FreeChannel {
        FreeChannel {
            name: joint.name.clone(),
            unit: if joint.prismatic { "m" } else { "rad" },
            rms: self.rms(),
            rms_end: (self.ends > 0).then(|| (self.end_squares / self.ends as f64).sqrt()),
            relative: (self.way_squares > 0.0).then(|| (self.error_squares / self.way_squares).sqrt()),
        }
    }
}
