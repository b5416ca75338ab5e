//! What a regressor is worth: its singular values, costs made of them, and their derivatives by every element.
use crate::identify::Triangle;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// The smooth condition number is made of this power of the eigenvalues of the information.
const POWER: i32 = 4;

/// What is made small.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// Condition number of the regressor (thesis 5.16, 5.24).
    Condition,
    /// Minus the logarithm of the determinant of the information `WᵀW` (D-optimal).
    Information,
}

/// Which length the regressor's columns have when its condition number is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scaling {
    /// 1: parameters of different units are compared by what they do.
    Unit,
    /// Their own in SI units, as the thesis has it (5.9, 5.16, table 5.1).
    Own,
}

/// What a set of postures is worth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quality {
    /// Of the regressor.
    pub condition_number: f64,
    /// `ln det WᵀW` (SI units); differences between sets mean something.
    pub log_determinant: f64,
}

/// Singular value decomposition of a regressor: by how much its columns were divided, singular values, largest first,
/// and right singular vectors as rows. `None` if a column is zero.
fn spectrum(rows: &DMatrix<f64>, scaling: Scaling) -> Option<(DVector<f64>, DVector<f64>, DMatrix<f64>)> {
    let mut triangle = Triangle::new(rows.ncols());
    let mut values = rows.as_slice().to_vec();
    values.resize(values.len() + rows.nrows(), 0.0);
    triangle.absorb(rows.nrows(), &mut values);
    let mut lengths = triangle.lengths();
    if lengths.iter().any(|length| !(length.is_finite() && *length > 1e-100)) {
        return None;
    }
    if scaling == Scaling::Own {
        lengths.fill(1.0);
    }
    let mut factor = triangle.matrix();
    factor.column_iter_mut().zip(lengths.iter()).for_each(|(mut column, length)| column /= *length);
    let svd = factor.try_svd(false, true, f64::EPSILON, 10_000)?;
    Some((lengths, svd.singular_values, svd.v_t?))
}

/// Condition number of the regressor, and `ln det WᵀW`; infinite and minus infinite if it does not tell everything.
pub fn quality(rows: &DMatrix<f64>, scaling: Scaling) -> (f64, f64) {
    let Some((lengths, singular, _)) = spectrum(rows, scaling) else {
        return (f64::INFINITY, f64::NEG_INFINITY);
    };
    let (most, least) = (singular.max(), singular.min());
    if least <= 1e-13 * most {
        return (f64::INFINITY, f64::NEG_INFINITY);
    }
    let logarithms = singular.iter().chain(lengths.iter()).map(|x| 2.0 * x.ln());
    (most / least, logarithms.sum())
}

/// The smooth cost and its derivative by each element of the regressor; `None` where it is infinite.
///
/// With `S` the scaled regressor, `C = SᵀS = V Λ Vᵀ` and a cost `Σ φ(λ)` the derivative by `C` is `Φ = V φ'(Λ) Vᵀ`,
/// so by column k of the regressor `2/‖w_k‖ ((SΦ)_k − s_k (CΦ)_kk)`: the second part is the scaling's.
pub fn slopes(rows: &DMatrix<f64>, criterion: Criterion, scaling: Scaling) -> Option<(f64, DMatrix<f64>)> {
    let (lengths, singular, v_t) = spectrum(rows, scaling)?;
    let lambda = singular.map(|s| s * s);
    if lambda.min() <= 1e-24 * lambda.max() {
        return None;
    }
    let size = lambda.len() as f64;
    let (cost, slope, scaled) = match criterion {
        Criterion::Condition => {
            // (ln Σ λᵖ + ln Σ λ⁻ᵖ)/2p: between ln κ and ln κ + ln(n)/p.
            let p = f64::from(POWER);
            let (up, down): (f64, f64) =
                (lambda.iter().map(|l| l.powi(POWER)).sum(), lambda.iter().map(|l| l.powi(-POWER)).sum());
            let slope = lambda.map(|l| 0.5 * (l.powi(POWER - 1) / up - l.powi(-POWER - 1) / down));
            (0.5 * (up.ln() + down.ln()) / p, slope, scaling == Scaling::Unit)
        }
        Criterion::Information => {
            let logarithms: f64 = singular.iter().chain(lengths.iter()).map(|x| 2.0 * x.ln()).sum();
            (-logarithms / size, lambda.map(|l| -1.0 / (l * size)), false)
        }
    };
    let phi = v_t.tr_mul(&(DMatrix::from_diagonal(&slope) * &v_t));
    let mut unit = rows.clone();
    unit.column_iter_mut().zip(lengths.iter()).for_each(|(mut column, length)| column /= *length);
    let mut out = &unit * phi;
    for (k, mut column) in out.column_iter_mut().enumerate() {
        let part = if scaled { unit.column(k).dot(&column) } else { 0.0 };
        column.axpy(-part, &unit.column(k), 1.0);
        column *= 2.0 / lengths[k];
    }
    Some((cost, out))
}
