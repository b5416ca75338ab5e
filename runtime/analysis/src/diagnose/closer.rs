//! What is left of torques above their noise, held against what is left behind faster filters: an effect is seen there too, motion that a slow filter
//! takes off is not.
use super::error_fall::LEFT;
use super::{Diagnosis, ErrorFall, errors, left_alike};
use crate::experiments::{Experiment, MotionExperiment};
use bipedc_effects::effect::Effect;
use std::collections::BTreeMap;

/// A faster filter that lets so much noise through tells nothing, nor one that takes off large parts of the motion otherwise: the mean product of two residuals
/// is uncertain by so large a part of the squares by which an error is above its noise.
const UNCERTAIN: f64 = 0.5;
/// Behind a faster filter fast motion leaves no more than this part of its squares above the noise.
const GONE: f64 = 0.25;
/// An error stands out of noise of which it has so large a part of the squares: several hundred samples tell a quarter of it from nothing.
const SEEN: f64 = 0.45;

/// What is left of the rows of one log behind a faster filter.
#[derive(Debug, Clone, Default)]
pub struct Closer {
    /// Of the slower filter and of this one.
    pub cutoffs_hz: [f64; 2],
    /// Behind both alike, see [`left_alike`](super::left_alike()).
    pub alike: BTreeMap<String, f64>,
    /// What the noise of the measured motion leaves behind the slower filter.
    pub motion: BTreeMap<String, f64>,
    /// There alone.
    pub rows: BTreeMap<String, ErrorFall>,
    /// How many independent samples the slower filter leaves.
    pub independent: f64,
}

impl Closer {
    /// What effects leave of one log behind a filter and a faster one; `own_blocks`: in its blocks that judge.
    pub fn new(
        (here, closer): (&MotionExperiment<'_>, &MotionExperiment<'_>),
        effects: &[Effect],
        own_blocks: bool,
    ) -> Self {
        let judge: Option<&dyn Experiment> = (!own_blocks).then_some(closer);
        let [first, last] =
            [here.time().first(), here.time().last()].map(|time| time.copied().unwrap_or(0.0));
        let motion =
            here.rows().iter().enumerate().map(|(row, what)| (what.name.clone(), here.motion_noise(row)));
        let cutoffs_hz = [here, closer].map(|experiment| experiment.recording().cutoff_hz);
        Self {
            cutoffs_hz,
            motion: motion.collect(),
            alike: left_alike((here, closer), effects, own_blocks),
            rows: errors(closer, judge, [&[], effects]).rows,
            independent: 2.0 * cutoffs_hz[0] * (last - first),
        }
    }

    /// The mean square of a row, left behind the slower filter, that is not left behind the faster one, and its standard deviation by chance.
    pub fn gone(&self, row: &str, fall: &ErrorFall) -> Option<[f64; 2]> {
        let (both, faster) = (self.both(row)?, self.rows.get(row)?);
        let deviation = fall.told_here() * faster.told_here() / self.independent.max(1.0).sqrt();
        Some([fall.told_here().powi(2) - both.powi(2), deviation])
    }

    /// Looks at rows above their noise; tells which of them are not when they are held against this.
    fn settles(&self, rows: &mut BTreeMap<String, ErrorFall>, passed: &[String]) -> Vec<String> {
        let loud =
            rows.iter_mut().filter(|(row, fall)| fall.above_noise().is_some() && !passed.contains(row));
        let settled = loud.filter_map(|(row, fall)| {
            let faster = self.rows.get(row)?;
            self.look(row, fall, faster);
            fall.above_noise().is_none().then(|| row.clone())
        });
        settled.collect()
    }

    fn look(&self, row: &str, fall: &mut ErrorFall, faster: &ErrorFall) {
        let uncertain = fall.told_here() * faster.told_here() / self.independent.max(1.0).sqrt();
        let tells = uncertain <= UNCERTAIN * (LEFT * LEFT - 1.0) * fall.noise.powi(2);
        if let Some(both) = self.both(row).filter(|both| *both < fall.told() && tells) {
            fall.behind_both = Some(both);
        }
        if is_gone(fall, faster) {
            fall.gone_at_hz = Some(self.cutoffs_hz[1]);
        }
    }

    /// What is left of a row behind both filters alike, with no more of the motion's noise in it than the slower one leaves.
    fn both(&self, row: &str) -> Option<f64> {
        let noise = self.motion.get(row).copied().unwrap_or(0.0);
        let [slower, faster] = self.cutoffs_hz;
        let beyond = (noise_alike(faster / slower) - 1.0) * noise.powi(2);
        self.alike.get(row).map(|both| (both.powi(2) - beyond).max(0.0).sqrt())
    }
}

/// Whether next to nothing but noise is left behind the faster filter, of an error that would stand out of that noise.
fn is_gone(fall: &ErrorFall, faster: &ErrorFall) -> bool {
    let above = |fall: &ErrorFall| fall.told_here().powi(2) - fall.noise.powi(2);
    let would_be_seen = above(fall) >= SEEN * faster.noise.powi(2);
    let is_noise = faster.noises().is_some_and(|times| times <= LEFT);
    is_noise && would_be_seen && above(faster) <= GONE * above(fall)
}

/// The mean product of what white noise of a position leaves of its acceleration behind two filters, the second so many times faster, as a multiple of the mean
/// square behind the slower one: zero-phase filters of the fourth order have the gain 1 / (1 + x⁸), and at its cut-off the slower one has taken half of what the
/// faster one has not touched. 2.06 of filters of 10 and 16 Hz.
fn noise_alike(faster: f64) -> f64 {
    const FINE: u32 = 200;
    // Beyond four times the slower cut-off nothing is left.
    let gain = |x: f64| 1.0 / (1.0 + x.powi(8));
    let frequencies = (1..4 * FINE).map(|i| f64::from(i) / f64::from(FINE));
    let [both, own] = frequencies.fold([0.0; 2], |[both, own], x| {
        let power = x.powi(4) * gain(x);
        [both + power * gain(x / faster), own + power * gain(x)]
    });
    both / own
}

impl Diagnosis {
    /// Takes what is left behind a faster filter too for what is left, where it is less; but in rows of which more was seen than that they
    /// are above the noise: what happens within a few degrees of a reversal is taken off by both filters. Tells which rows above the noise are not then.
    pub fn look_behind(&mut self, judged: &Closer) -> Vec<String> {
        let structured: Vec<String> = self.structured().map(|part| part.joint.clone()).collect();
        judged.settles(&mut self.rows, &structured)
    }

    /// The same of the log that teaches.
    pub fn look_behind_training(&mut self, taught: &Closer) {
        taught.settles(&mut self.rows_training, &[]);
        // All torques together are what their rows are.
        let gone = self.rows_training.values().find_map(|fall| fall.gone_at_hz);
        let mut efforts = taught.rows.keys().filter_map(|row| self.rows_training.get(row));
        let is_noise = efforts.all(|fall| fall.above_noise().is_none());
        if let Some(all) = self.rms_training.get_mut("effort").filter(|_| is_noise) {
            all.gone_at_hz = gone;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::filtered::acceleration_response;
    use crate::signal::Butterworth;

    fn fall(after: f64, noise: f64) -> ErrorFall {
        ErrorFall { after, noise, ..ErrorFall::default() }
    }

    fn looked(here: [f64; 2], faster: [f64; 2], alike: f64) -> ErrorFall {
        let by_name = |value| BTreeMap::from([("hip".to_owned(), value)]);
        let [mut rows, faster] = [here, faster].map(|[after, noise]| by_name(fall(after, noise)));
        let alike = BTreeMap::from([("hip".to_owned(), alike)]);
        let motion = BTreeMap::new();
        let closer = Closer { cutoffs_hz: [10.0, 16.0], alike, motion, rows: faster, independent: 400.0 };
        closer.settles(&mut rows, &[]);
        rows.remove("hip").unwrap()
    }

    /// By filters as they are: the second derivatives of white noise.
    #[test]
    fn noise_of_a_motion_is_larger_behind_two_filters_alike() {
        let step = 0.004;
        let responses =
            [10.0, 16.0].map(|hz| acceleration_response(&Butterworth::new(hz, 1.0 / step).unwrap(), step));
        let middle = responses.each_ref().map(|response| response.len() / 2);
        let product = |a: usize, b: usize| -> f64 {
            let half = middle[0].min(middle[1]);
            (0..2 * half)
                .map(|i| responses[a][middle[a] - half + i] * responses[b][middle[b] - half + i])
                .sum()
        };
        let told = noise_alike(1.6);
        assert!((told / (product(0, 1) / product(0, 0)) - 1.0).abs() < 0.05, "{told}");
        assert!((noise_alike(1.0) - 1.0).abs() < 1e-12);
        // Nothing but noise is left.
        let rows = BTreeMap::from([("hip".to_owned(), fall(0.17, 0.1))]);
        let alike = BTreeMap::from([("hip".to_owned(), 0.1 * told.sqrt())]);
        let (motion, cutoffs_hz) = (BTreeMap::from([("hip".to_owned(), 0.1)]), [10.0, 16.0]);
        let mut settled = rows.clone();
        let faster = BTreeMap::from([("hip".to_owned(), fall(0.36, 0.34))]);
        Closer { cutoffs_hz, alike, motion, rows: faster, independent: 400.0 }.settles(&mut settled, &[]);
        assert!(rows["hip"].above_noise().is_some());
        assert!((settled["hip"].behind_both.unwrap() - 0.1).abs() < 1e-3);
    }

    #[test]
    fn fast_motion_is_gone_behind_a_faster_filter_and_an_effect_is_not() {
        // A filter takes off 0.68 N m of a joint's fast motion, and hardly any of them behind the next one.
        let motion = looked([0.69, 0.11], [0.36, 0.34], 0.21);
        assert_eq!((motion.gone_at_hz, motion.above_noise()), (Some(16.0), None));
        // An effect of that size stays.
        let effect = looked([0.69, 0.11], [0.76, 0.34], 0.69);
        assert_eq!(effect.gone_at_hz, None);
        assert!(effect.above_noise().unwrap() > 6.0);
        // Where it drowns in the noise nothing is told.
        let drowned = looked([0.2, 0.11], [0.36, 0.34], 0.2);
        assert_eq!(drowned.gone_at_hz, None);
        assert!(drowned.above_noise().is_some());
        // A part that is small, and left behind one of both alone.
        assert_eq!(looked([0.2, 0.11], [0.36, 0.34], 0.12).above_noise(), None);
        // So much noise that a mean product may be anything.
        assert!(looked([0.2, 0.11], [3.0, 2.9], 0.12).above_noise().is_some());
    }
}
