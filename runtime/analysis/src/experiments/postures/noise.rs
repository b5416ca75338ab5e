//! How noisy the rows of a posture table are.
//!
//! Postures do not repeat and have no frequencies, so there are only upper bounds: what remains after the best
//! inertial parameters (a false model makes it too large), and what the scatter of the total force makes of the
//! centre of pressure (false gains make it too large). The smaller one counts.
use super::PostureExperiment;
use crate::experiments::noise::root_mean_square;
use crate::experiments::{Experiment, Inertial};
use nalgebra::{DMatrix, DVector};

/// Readings within this part of the largest one count as clipped.
pub(super) const CLIPPED: f64 = 1e-3;
/// Smallest noise that is believed, by row kind: x, y (m), total force (N).
const SMALLEST: [f64; 3] = [1e-6, 1e-6, 1e-3];

/// The limit if at least three and a twentieth of the readings stay at their largest value.
pub(crate) fn is_clipped(forces: &[f64]) -> Option<f64> {
    let largest = forces.iter().copied().fold(0.0, f64::max);
    let at_limit = forces.iter().filter(|f| **f >= largest * (1.0 - CLIPPED)).count();
    (largest > 0.0 && at_limit >= 3 && 20 * at_limit >= forces.len()).then_some(largest)
}

impl PostureExperiment<'_> {
    /// One standard deviation per row.
    pub(super) fn noise(&self) -> Vec<f64> {
        let leftover = self.after_inertia();
        let scatter = self.by_total_force();
        let rows = self.kinds.iter().zip(leftover);
        rows.map(|(&kind, leftover)| {
            leftover.min(scatter.map_or(f64::INFINITY, |s| s[kind])).max(SMALLEST[kind])
        })
        .collect()
    }

    /// Each row's residual after least squares in the inertial parameters, all rows of its kind together.
    fn after_inertia(&self) -> Vec<f64> {
        let count = self.number.len();
        let rows = self.residual.iter().enumerate();
        rows.map(|(row, residual)| {
            let plain = root_mean_square(residual);
            let Some(inertial) = self.inertial(row) else { return plain };
            remainder(inertial, residual, count).unwrap_or(plain)
        })
        .collect()
    }

    /// From how much the total force scatters about its mean, if corners are logged.
    fn by_total_force(&self) -> Option<[f64; 3]> {
        let (sensors, count) = (self.corners.len(), self.number.len());
        if sensors == 0 || count < 8 {
            return None;
        }
        let totals: Vec<f64> = (0..count).map(|i| self.corners.iter().map(|r| r.force[i]).sum()).collect();
        let mean = totals.iter().sum::<f64>() / count as f64;
        let variance = totals.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / (count - 1) as f64;
        let each = variance / sensors as f64;
        let mut sums = [0.0; 2];
        for (i, total) in totals.iter().enumerate() {
            let places = self.places(i);
            let forces: Vec<f64> = self.corners.iter().map(|r| r.force[i]).collect();
            let center = super::predict::pressure(&forces, &places)?;
            for (axis, sum) in sums.iter_mut().enumerate() {
                let arms: f64 = places.iter().map(|p| (p[axis] - center[axis]).powi(2)).sum();
                *sum += each * arms / (total * total);
            }
        }
        let [x, y] = sums.map(|s| (s / count as f64).sqrt());
        Some([x, y, variance.sqrt()])
    }
}

/// Standard deviation of what least squares leaves; `None` with too few samples.
fn remainder(inertial: &Inertial, residual: &[f64], count: usize) -> Option<f64> {
    let width = inertial.columns.len();
    let matrix = DMatrix::from_row_slice(count, width, &inertial.values);
    let mut columns = matrix.clone();
    for mut column in columns.column_iter_mut() {
        let norm = column.norm();
        if norm > 0.0 {
            column /= norm;
        }
    }
    let svd = columns.svd(true, false);
    let largest = svd.singular_values.max();
    let rank = svd.singular_values.iter().filter(|s| **s > 1e-6 * largest).count();
    let basis = svd.u?;
    let mut left = DVector::from_column_slice(residual);
    for (k, singular) in svd.singular_values.iter().enumerate() {
        if *singular > 1e-6 * largest {
            let direction = basis.column(k);
            let part = direction.dot(&left);
            left.axpy(-part, &direction, 1.0);
        }
    }
    let free = count.checked_sub(rank).filter(|free| *free >= count / 4)?;
    Some((left.norm_squared() / free as f64).sqrt())
}
