//! Signals of rows by their names.
use super::Experiment;

/// How fast the torque of a joint changes, N m/s.
pub(crate) const RATE_OF_LOAD: &str = "rate of the load";

/// Of the joint of a row.
pub(crate) fn velocity_of(experiment: &dyn Experiment, row: usize) -> Option<Vec<f64>> {
    signal_of(experiment, row, "velocity")
}

/// A signal of a row, by its name.
pub(crate) fn signal_of(experiment: &dyn Experiment, row: usize, name: &str) -> Option<Vec<f64>> {
    experiment.signal(row, name)
}
