//! The noise of a row as what its model leaves shows it.
use super::{Channel, Row};
use crate::measure::coloured::coloured_noise;

/// Standard deviation of the measurement's noise in a row, of whose measurement a model leaves `residual`: at least the row's own
/// estimate, which takes noise as white, and more where neighbouring samples are noisy alike.
///
/// The one estimate of `diagnose`, `compare` and reports.
pub(crate) fn heard(row: &Row, residual: &[f64]) -> f64 {
    // Other rows are of filtered signals, or tables, whose samples have no neighbours.
    let coloured = (row.channel == Channel::Effort).then(|| coloured_noise(residual)).flatten();
    coloured.map_or(row.noise, |coloured| coloured.max(row.noise))
}
