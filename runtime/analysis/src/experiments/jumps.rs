//! What is left of rows away from samples at which something jumps: there, in all joints, the filter knows less of the motion than the
//! sensors do.
use super::Experiment;
use super::corners::{Corners, corners, landings, wide_corners};
use bipedc_effects::effect::Effect;

/// Least part of a row's samples that must be left away from jumps.
const AWAY: f64 = 0.2;

/// Samples at which effects jump at some joint, or near enough for the filter to smear it there: a joint with dry friction or play turns
/// about, a drive is at its limit.
pub(crate) struct Jumps(Vec<bool>);

impl Jumps {
    /// Of these effects and those of the description: what an amended description has jumps as it did when it was found.
    pub fn of(experiment: &dyn Experiment, effects: &[Effect]) -> Self {
        let all = [experiment.described(), effects].concat();
        if all.is_empty() {
            return Self(Vec::new());
        }
        let of_rows = |corners: fn(&dyn Experiment, usize, &[Effect]) -> Corners| {
            (0..experiment.rows().len()).fold(landings(experiment, &all), |mut flags, row| {
                let own = corners(experiment, row, &all).left_out;
                flags.resize(flags.len().max(own.len()), false);
                flags.iter_mut().zip(own).for_each(|(flag, own)| *flag |= own);
                flags
            })
        };
        let leaves_enough = |jumps: &Vec<bool>| {
            let left = jumps.iter().filter(|jumps| !**jumps).count();
            left as f64 >= AWAY * jumps.len() as f64
        };
        Self(Some(of_rows(wide_corners)).filter(leaves_enough).unwrap_or_else(|| of_rows(corners)))
    }

    /// Whether anything jumps, ever.
    pub fn are_some(&self) -> bool {
        self.0.contains(&true)
    }

    /// Whether something jumps at a sample, or near it.
    pub fn hold(&self, sample: usize) -> bool {
        self.0.get(sample).is_some_and(|jumps| *jumps)
    }

    /// Root mean square of what is left of a row at the samples that count, where nothing jumps and its joint does not stick; `None` if
    /// nothing jumps, or too few samples are left.
    pub fn away(
        &self,
        experiment: &dyn Experiment,
        row: usize,
        residual: &[f64],
        counts: &dyn Fn(usize, usize) -> bool,
    ) -> Option<f64> {
        if !self.are_some() {
            return None;
        }
        let sticks = experiment.sticks(row);
        let told = |i: &usize| counts(*i, residual.len()) && !sticks.get(*i).is_some_and(|sticks| *sticks);
        let all: Vec<usize> = (0..residual.len()).filter(told).collect();
        let away = |i: &&usize| !self.hold(**i);
        let kept: Vec<f64> = all.iter().filter(away).map(|i| residual[*i]).collect();
        let squares: f64 = kept.iter().map(|x| x * x).sum();
        (kept.len() as f64 >= AWAY * all.len() as f64).then(|| (squares / kept.len().max(1) as f64).sqrt())
    }
}
