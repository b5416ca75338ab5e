//! Whether measured efforts jump where their joints turn about, as dry friction does, or whether drives answer too slowly for that.
//!
//! A joint that is led along a smooth motion (efforts that were computed, stiff drives) is pushed by friction that changes its sign at one
//! sample: the sign of its speed as it is tells that. Where a drive yields or a joint sticks for a while, its effort passes from one
//! side to the other without a jump, and a sign smoothed over some width of speeds is nearer to it. Both look alike behind the filter of
//! positions; they differ in what the effort has beyond it.
use super::experiment::MotionExperiment;
use crate::experiments::Experiment;
use crate::experiments::corners::SMOOTHING;
use crate::signal::Butterworth;
use bipedc_effects::effect::{Effect, Simulation};
use std::borrow::Cow;

/// The second look is at frequencies beyond so many times the cut-off, or beyond this part of half the sampling rate.
const FARTHER: f64 = 3.0;
const PART_OF_BAND: f64 = 0.5;
/// It must lie this far beyond the first.
const APART: f64 = 1.2;
/// A jump is as large at both looks; one of a slow drive is gone at the second. Where efforts jumped the second found 0.79 to 1.0 of the first
/// up to 16 Hz (twenty logs of three robots), where drives yield 0.65 at most (forty logs of six robots).
const ALIKE: f64 = 0.75;
/// So many standard errors a jump is away from none.
const CLEAR: f64 = 6.0;
/// A sign as it is changes over this part of the width that is stated: within a sample of any motion.
const SHARP: f64 = 1e-3;

impl MotionExperiment<'_> {
    /// The effect as it acts on the efforts of a joint: dry friction with a sign as sharp as it is where these jump with it. A sign that
    /// was stated to be wider than usual stays what it is.
    pub(super) fn as_it_jumps<'e>(&self, joint: usize, effect: &'e Effect) -> Cow<'e, Effect> {
        if !matches!(effect.kind.simulation, Simulation::Dry(_)) {
            return Cow::Borrowed(effect);
        }
        let stated = effect.value(SMOOTHING);
        if !self.effort_jumps(joint) || stated > self.usual_width(joint, effect) {
            return Cow::Borrowed(effect);
        }
        let mut sharp = effect.clone();
        sharp.parameters.insert(SMOOTHING.to_owned(), SHARP * stated);
        Cow::Owned(sharp)
    }

    /// Whether dry friction of the description acts with a sign as sharp as it is: no function of one state tells that.
    pub fn has_sharp_signs(&self) -> bool {
        let is_sharp = |effect: &Effect| {
            self.joint(effect).is_some_and(|j| matches!(self.as_it_jumps(j, effect), Cow::Owned(_)))
        };
        self.described().iter().any(is_sharp)
    }

    /// The widest sign that says nothing of the robot: that of the library, or of a sliding joint twice what a search takes for it.
    fn usual_width(&self, joint: usize, effect: &Effect) -> f64 {
        if self.layout.joints[joint].prismatic {
            return 2.0 * self.reversal_speed(joint);
        }
        let mut unstated = effect.clone();
        unstated.parameters.remove(SMOOTHING);
        unstated.value(SMOOTHING)
    }

    fn effort_jumps(&self, joint: usize) -> bool {
        *self.jumps[joint].get_or_init(|| {
            let recording = &self.recording;
            let Some(effort) = &recording.effort[joint] else { return false };
            let sign: Vec<f64> = self.of_motor(joint, 1).iter().map(|speed| sign_of(*speed)).collect();
            let rate = recording.step.recip();
            let first = recording.cutoff_hz;
            let second = (FARTHER * first).min(PART_OF_BAND * 0.5 * rate);
            if second < APART * first {
                return false;
            }
            let around = (rate / first).ceil() as usize;
            let look = |beyond: f64| -> Option<(f64, f64)> {
                let filter = Butterworth::new(beyond, rate).ok()?;
                let stretches = recording.segments.iter().filter(|stretch| stretch.len() > 4 * around);
                let mut sums = Sums::default();
                for stretch in stretches {
                    let fast = |signal: &[f64]| beyond_filter(&filter, &signal[stretch.clone()]);
                    let (effort, sign) = (fast(effort), fast(&sign));
                    let inner = around..stretch.len() - around;
                    sums.add(&effort[inner.clone()], &sign[inner]);
                }
                sums.slope()
            };
            let (Some((near, _)), Some((far, error))) = (look(first), look(second)) else { return false };
            far > CLEAR * error && far > ALIKE * near
        })
    }
}

fn sign_of(speed: f64) -> f64 {
    if speed == 0.0 { 0.0 } else { speed.signum() }
}

/// What a signal has beyond a filter.
fn beyond_filter(filter: &Butterworth, signal: &[f64]) -> Vec<f64> {
    signal.iter().zip(filter.zero_phase(signal)).map(|(all, slow)| all - slow).collect()
}

/// Sums of a regression of one signal on another.
#[derive(Default)]
struct Sums {
    xx: f64,
    xy: f64,
    yy: f64,
    count: f64,
}

impl Sums {
    fn add(&mut self, y: &[f64], x: &[f64]) {
        for (y, x) in y.iter().zip(x) {
            self.xx += x * x;
            self.xy += x * y;
            self.yy += y * y;
        }
        self.count += y.len() as f64;
    }

    /// y per x with its standard error; `None` where x stays zero.
    fn slope(&self) -> Option<(f64, f64)> {
        if self.xx <= 1e-9 * self.count || self.count < 10.0 {
            return None;
        }
        let slope = self.xy / self.xx;
        let left = (self.yy - slope * self.xy).max(0.0) / self.count;
        Some((slope, (left / self.xx).sqrt()))
    }
}
