//! Errors where a row's joint does not stick: there the model says what the torque is (see `motion::sticking`).
use super::Experiment;

/// Squared errors of one row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moving {
    /// Their sum over the samples that count and at which the joint does not stick.
    pub squares: f64,
    /// How many.
    pub samples: usize,
    /// Part of the samples that count at which it does.
    pub sticking: f64,
}

impl Moving {
    /// Root mean square.
    pub fn rms(&self) -> f64 {
        (self.squares / self.samples.max(1) as f64).sqrt()
    }
}

/// The one judgement of `compare`, `diagnose` and reports: errors without the samples at which a row's joint sticks, of those that
/// `counts` (sample, of how many) says; `None` where it never sticks or never moves.
pub(crate) fn moving(
    experiment: &dyn Experiment,
    row: usize,
    residual: &[f64],
    counts: &dyn Fn(usize, usize) -> bool,
) -> Option<Moving> {
    let sticks = experiment.sticks(row);
    let counted = |i: &usize| counts(*i, residual.len());
    let (stuck, moved): (Vec<usize>, Vec<usize>) =
        (0..sticks.len().min(residual.len())).filter(counted).partition(|i| sticks[*i]);
    let sticking = stuck.len() as f64 / (stuck.len() + moved.len()).max(1) as f64;
    let squares = moved.iter().map(|i| residual[*i] * residual[*i]).sum();
    let found = Moving { squares, samples: moved.len(), sticking };
    (!stuck.is_empty() && !moved.is_empty()).then_some(found)
}
