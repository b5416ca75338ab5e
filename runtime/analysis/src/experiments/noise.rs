//! The noise of a row as what its model leaves shows it.
use super::{Channel, Experiment};
use crate::measure::coloured::telling_velocity;
use crate::measure::residual_noise::residual_noise;
use bipedc_effects::effect::{Effect, Law};
use std::borrow::Cow;

/// Standard deviation of what noise leaves in a row, of whose measurement a model leaves `residual`: noise of the row's own measurement and of
/// the motion.
///
/// The one estimate of `diagnose`, `compare` and reports.
pub(crate) fn noise_of(experiment: &dyn Experiment, row: usize, residual: &[f64]) -> f64 {
    noise_beside(experiment, row, residual, experiment.motion_noise(row))
}

/// The same where the noise of motion is another one, by effects beside the experiment's own.
pub(crate) fn noise_beside(experiment: &dyn Experiment, row: usize, residual: &[f64], of_motion: f64) -> f64 {
    let both = experiment.rows()[row].noise.hypot(of_motion);
    // What is heard may be the motion's: the two are no sum.
    heard(experiment, row, residual).max(both)
}

/// Standard deviation of the measurement's noise in a row, of whose measurement a model leaves `residual`: at least the row's own
/// estimate, which takes noise as white and of one size, and more where neighbouring samples are noisy alike or noise changes in time.
pub(crate) fn heard(experiment: &dyn Experiment, row: usize, residual: &[f64]) -> f64 {
    let what = &experiment.rows()[row];
    let rows = experiment.rows().len();
    // Where joints stick what is left is no noise, and friction that follows the noise of a speed jumps there.
    let sticks = experiment.sticks(row);
    let free = free(sticks, residual);
    let free = if free.len() >= FEWEST { free } else { Cow::Borrowed(residual) };
    let told = |velocity: Vec<f64>| match free.len() == residual.len() {
        true => velocity,
        false => self::free(sticks, &velocity).into_owned(),
    };
    let velocity =
        || told(telling_velocity(row, rows, |row| experiment.signal(row, "velocity").unwrap_or_default()));
    let of_signal = || experiment.measured(row).map_or(f64::INFINITY, |signal| root_mean_square(&signal));
    // Other rows are of filtered signals, or tables, whose samples have no neighbours.
    let left =
        (what.channel == Channel::Effort).then(|| residual_noise(&free, velocity, of_signal())).flatten();
    let most = where_free(sticks, residual);
    left.map_or(what.noise, |left| left.min(most).max(what.noise))
}

/// By how much the springs among these effects yield together, rad/(N m) or m/N.
pub(crate) fn yielding<'e>(effects: impl Iterator<Item = &'e Effect>) -> f64 {
    let springs = effects.filter(|effect| effect.kind.law == Law::SeriesElasticity);
    springs.map(|spring| spring.value("stiffness").recip()).sum()
}

pub(super) fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Fewest samples at which a joint does not stick that tell the noise alone.
const FEWEST: usize = 1000;

/// Values where a joint does not stick, one after the other.
fn free<'v>(sticks: &[bool], values: &'v [f64]) -> Cow<'v, [f64]> {
    if !sticks.contains(&true) {
        return Cow::Borrowed(values);
    }
    let is_free = |i: usize| !sticks.get(i).is_some_and(|sticks| *sticks);
    Cow::Owned((0..values.len()).filter(|i| is_free(*i)).map(|i| values[i]).collect())
}

/// Root mean square of what is left where a joint does not stick; without a limit if it always does.
fn where_free(sticks: &[bool], residual: &[f64]) -> f64 {
    let free = free(sticks, residual);
    if free.is_empty() { f64::INFINITY } else { root_mean_square(&free) }
}
