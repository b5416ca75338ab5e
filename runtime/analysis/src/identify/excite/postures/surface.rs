//! The surface of postures whose other sole lies flat at its placement.
use super::standing::StanceModel;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// A sole is where it should be when it misses by less, m and rad.
const CLOSED: f64 = 1e-11;
/// Corrections until then; more of them means that the placement is out of reach.
const CORRECTIONS: usize = 12;
/// Largest correction of a joint, rad or m.
const LARGEST: f64 = 0.3;
/// Closures worse conditioned than this are singular: a straight leg.
const SINGULAR: f64 = 1e-8;

/// Directions in which a posture may move.
#[derive(Debug, Clone)]
pub struct Tangent {
    /// Joints per motion of the placement (x, y, yaw), `joints × 3`.
    pub along: DMatrix<f64>,
    /// Orthonormal motions of the joints that leave the sole where it is, `joints × (joints - 6)`.
    pub free: DMatrix<f64>,
}

/// The shortest motion of the joints with this twist of the sole; `None` where the leg is singular.
fn inverse(jacobian: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let square = jacobian * jacobian.transpose();
    let eigen = SymmetricEigen::new(square.clone());
    let (least, most) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
    if least.is_nan() || least <= SINGULAR * most {
        return None;
    }
    let back = square.cholesky()?.inverse();
    Some(jacobian.transpose() * back)
}

/// Directions at a posture; `None` where the leg is singular.
pub fn tangent(standing: &StanceModel<'_>, q: &[f64]) -> Option<Tangent> {
    let bodies = standing.bodies(q);
    let jacobian = standing.jacobian(&bodies, &standing.parts.soles[1].place);
    let inverse = inverse(&jacobian)?;
    let n = q.len();
    let eigen = SymmetricEigen::new(jacobian.tr_mul(&jacobian));
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let free = eigen.eigenvectors.select_columns(&order[..n.saturating_sub(6)]);
    Some(Tangent { along: inverse.select_columns(&[0, 1, 5]), free })
}

/// The posture near `q` whose sole lies at the placement; `None` if there is none.
pub fn closed(standing: &StanceModel<'_>, q: &[f64], placement: &[f64; 3]) -> Option<Vec<f64>> {
    let mut q = q.to_vec();
    for _ in 0..CORRECTIONS {
        let bodies = standing.bodies(&q);
        let missed = standing.missed(&bodies, placement);
        if missed.iter().all(|x| x.abs() < CLOSED) {
            return Some(q);
        }
        let jacobian = standing.jacobian(&bodies, &standing.parts.soles[1].place);
        let step = inverse(&jacobian)? * DVector::from_column_slice(missed.as_slice());
        if step.iter().any(|x| x.is_nan() || x.abs() >= LARGEST) {
            return None;
        }
        q.iter_mut().zip(step.iter()).for_each(|(q, step)| *q -= step);
    }
    None
}
