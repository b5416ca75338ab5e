//! Errors before and after effects: of a kind of channel, a row, a step.
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// An error before and after.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ErrorFall {
    /// Of both.
    pub unit: String,
    /// Of the nominal model.
    pub before: f64,
    /// With the effects and corrections.
    pub after: f64,
    /// Estimated noise of the measurement; 0 if unknown.
    #[serde(default)]
    pub noise: f64,
    /// Of one row: the error below which nothing is worth an explanation, its noise or what no model and no sensor is right by; 0 of
    /// several rows together.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub resolution: f64,
    /// As `before`, but where the joint sticks; `None` if it never does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub before_moving: Option<f64>,
    /// As `after`, but where the joint sticks and dry friction may be anything within its bounds; `None` if it never does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after_moving: Option<f64>,
    /// Of one row: as `after`, but where nothing jumps: away from samples at which a joint with dry friction or play turns about, or
    /// a drive is at its limit, and where the joint does not stick; `None` if nothing does, or too few samples are left.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub away_from_jumps: Option<f64>,
    /// Of one torque, where it is less: what is left behind this filter and a faster one alike, see [`left_alike`](super::left_alike()); the rest is
    /// what the filter takes off the motion. `None` where nobody looked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub behind_both: Option<f64>,
    /// Of one torque above its noise: the cut-off (Hz) of a faster filter behind which nothing but noise is left, though what is left here would be seen there;
    /// it is what this filter takes off the motion. `None`: there is none, or nobody looked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gone_at_hz: Option<f64>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// Errors above so many times their noise are no noise.
pub(super) const LEFT: f64 = 1.4;
/// The same where one row of a training log is held against that row of the log that judges: fast motion that a filter takes off may differ.
pub(super) const PLAINLY: f64 = 2.0;

/// Whether an error is larger than before by more than effects that say nothing may make it, and no noise.
pub fn rises(before: f64, after: f64, noise: f64) -> bool {
    const RISES: f64 = 1.1;
    const HEARD: f64 = 1.15;
    after > RISES * before && after > HEARD * noise
}

impl ErrorFall {
    /// Errors before and after, in the unit of the row, without the samples at which joints stick, where that is another figure: at rest friction is anything between its bounds, and the error
    /// there says nothing of it.
    pub fn where_free(&self) -> Option<[f64; 2]> {
        const OTHER: f64 = 1.25;
        let [before, after] = [self.before_moving?, self.after_moving?];
        (self.after > OTHER * after).then_some([before, after])
    }

    /// The remaining error in multiples of the noise where it is no noise, nor too small to be worth a word. What is said of it, in words
    /// and as a flag, hangs on this.
    pub fn above_noise(&self) -> Option<f64> {
        let times = self.noises().filter(|_| self.gone_at_hz.is_none())?;
        (times > LEFT && self.told() > LEFT * self.resolution).then_some(times)
    }

    /// Whether the nominal model's error was no more than noise, as [`above_noise`](Self::above_noise) has it of what remains.
    pub fn was_noise(&self) -> bool {
        let told = self.before_moving.unwrap_or(self.before);
        self.noise > 0.0 && (told <= LEFT * self.noise || told <= LEFT * self.resolution)
    }

    /// The remaining error in multiples of the noise, where the model says what the torque is; `None` if the noise is unknown.
    pub fn noises(&self) -> Option<f64> {
        (self.noise > 0.0).then(|| self.told() / self.noise)
    }

    /// The remaining error where the model says what the torque is and the filter what the motion is.
    pub fn told(&self) -> f64 {
        self.behind_both.unwrap_or_else(|| self.told_here())
    }

    /// The same behind this filter alone.
    pub(super) fn told_here(&self) -> f64 {
        self.away_from_jumps.or(self.after_moving).unwrap_or(self.after)
    }
}

/// Errors (root mean squares) before and after an effect entered, by kind of channel.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct StepErrors {
    /// On held-out data.
    pub held_out: BTreeMap<String, [f64; 2]>,
    /// On the training data.
    pub training: BTreeMap<String, [f64; 2]>,
}

impl StepErrors {
    /// The kind of channel that tells most of the step: `main`, unless its error stays and another falls.
    pub fn telling<'s>(&'s self, main: &'s str) -> &'s str {
        telling(self.held_out.iter().map(|(name, [before, after])| (name.as_str(), *before, *after)), main)
    }
}

/// An error that falls by less than this part stays.
const STAYS: f64 = 0.005;

pub(super) fn telling<'s>(falls: impl Iterator<Item = (&'s str, f64, f64)>, main: &'s str) -> &'s str {
    let mut most = (main, STAYS);
    for (name, before, after) in falls {
        let part = if before > 0.0 { (before - after) / before } else { 0.0 };
        if name == main && part > STAYS {
            return main;
        }
        if part > most.1 {
            most = (name, part);
        }
    }
    most.0
}
