//! What is left of rows away from samples at which something jumps: there, in all joints, the filter knows less of the motion than the
//! sensors do.
use super::Experiment;
use super::corners::{Corners, corners, departures, landings, wide_corners};
use bipedc_effects::effect::Effect;

/// Least part of a row's samples that must be left away from jumps.
const AWAY: f64 = 0.2;

/// How far within a rest its beginning and its end are felt, in halves of a period of the cut-off.
const DEPARTURE: usize = 2;

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
                let rests = long_rests(experiment.sticks(row), DEPARTURE * experiment.smeared());
                let jumps = |i: usize| own[i] && !rests.get(i).is_some_and(|rests| *rests);
                (0..own.len()).for_each(|i| flags[i] |= jumps(i));
                flags
            })
        };
        let wide = Self(of_rows(wide_corners));
        if wide.leave_enough() { wide } else { Self(of_rows(corners)) }
    }

    /// Whether samples enough are left away from them to say anything.
    pub fn leave_enough(&self) -> bool {
        let left = self.0.iter().filter(|jumps| !**jumps).count();
        left as f64 >= AWAY * self.0.len() as f64
    }

    /// Where a joint begins and ceases to move, whatever acts there.
    pub fn at_departures(experiment: &dyn Experiment) -> Self {
        let mut all: Vec<bool> = Vec::new();
        for row in 0..experiment.rows().len() {
            let rests = long_rests(experiment.sticks(row), experiment.smeared());
            let near = departures(experiment, row);
            all.resize(all.len().max(near.len()), false);
            (0..near.len()).for_each(|i| all[i] |= near[i] && !rests[i]);
        }
        Self(all)
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

/// Samples that have nothing but rest around them, so far: the noise of a speed changes its sign there, and nothing jumps.
fn long_rests(sticks: &[bool], around: usize) -> Vec<bool> {
    let mut rests = vec![false; sticks.len()];
    let mut begin = 0;
    for run in sticks.chunk_by(|a, b| a == b) {
        let end = begin + run.len();
        if run[0] && run.len() > 2 * around {
            rests[begin + around..end - around].fill(true);
        }
        begin = end;
    }
    rests
}

#[cfg(test)]
mod tests {
    use super::long_rests;

    #[test]
    fn a_rest_is_felt_where_it_begins_and_ends() {
        let sticks = [false, true, true, true, true, true, false, true, true, false];
        let rests: Vec<usize> = (0..10).filter(|&i| long_rests(&sticks, 2)[i]).collect();
        assert_eq!(rests, [3]);
        assert_eq!(long_rests(&sticks, 0), sticks);
        assert!(long_rests(&[], 2).is_empty());
    }
}
