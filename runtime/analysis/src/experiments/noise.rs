//! The noise of a row as what its model leaves shows it.
use super::{Channel, Experiment};
use crate::measure::residual_noise::residual_noise;

/// Standard deviation of what noise leaves in a row, of whose measurement a model leaves `residual`: noise of the row's own measurement and of
/// the motion.
///
/// The one estimate of `diagnose`, `compare` and reports.
pub(crate) fn noise_of(experiment: &dyn Experiment, row: usize, residual: &[f64]) -> f64 {
    let both = experiment.rows()[row].noise.hypot(experiment.motion_noise(row));
    // What is heard may be the motion's: the two are no sum.
    heard(experiment, row, residual).max(both)
}

/// Standard deviation of the measurement's noise in a row, of whose measurement a model leaves `residual`: at least the row's own
/// estimate, which takes noise as white and of one size, and more where neighbouring samples are noisy alike or noise changes in time.
pub(crate) fn heard(experiment: &dyn Experiment, row: usize, residual: &[f64]) -> f64 {
    let what = &experiment.rows()[row];
    let velocity = || experiment.signal(row, "velocity").unwrap_or_default();
    // Other rows are of filtered signals, or tables, whose samples have no neighbours.
    let left = (what.channel == Channel::Effort).then(|| residual_noise(residual, velocity)).flatten();
    left.map_or(what.noise, |left| left.max(what.noise))
}
