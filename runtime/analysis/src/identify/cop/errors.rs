//! How far centres of pressure are missed (thesis 8.1, figure 8.6a).
use super::PostureTable;
use crate::identify::BaseSet;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Singular values below this part of the largest, columns scaled to length 1, tell nothing.
const UNSEEN: f64 = 1e-7;
/// Postures that are left out together.
const FOLDS: usize = 6;

/// Distances between measured and estimated centre of pressure over all postures (the thesis' figures), m.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct PressureErrors {
    /// Mean distance.
    pub mean: f64,
    /// Standard deviation of the distances.
    pub standard_deviation: f64,
    /// Largest distance.
    pub max: f64,
    /// Root mean square over both coordinates.
    pub rms: f64,
    /// Number of postures.
    pub postures: usize,
}

impl PressureErrors {
    /// From what is missed in x and y.
    pub fn of(missed: &[[f64; 2]]) -> Self {
        let n = missed.len().max(1) as f64;
        let lengths: Vec<f64> = missed.iter().map(|[x, y]| x.hypot(*y)).collect();
        let mean = lengths.iter().sum::<f64>() / n;
        let variance = lengths.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / n;
        Self {
            mean,
            standard_deviation: variance.sqrt(),
            max: lengths.iter().copied().fold(0.0, f64::max),
            rms: (lengths.iter().map(|l| l * l).sum::<f64>() / (2.0 * n)).sqrt(),
            postures: missed.len(),
        }
    }
}

/// Errors of base parameters on a table.
pub fn pressure_errors(table: &PostureTable, base: &BaseSet, values: &[f64]) -> PressureErrors {
    let (w, y) = table.regression(base);
    let missed = y - w * DVector::from_column_slice(values);
    PressureErrors::of(&table.centers(&missed))
}

/// Errors of inertial parameters (ten per body) on a table.
pub fn of_parameters(table: &PostureTable, base: &BaseSet, parameters: &[f64]) -> PressureErrors {
    pressure_errors(table, base, &base.values(parameters))
}

/// Plain least squares (5.23); directions that the rows do not tell stay at `held`.
pub fn least_squares(w: &DMatrix<f64>, y: &DVector<f64>, held: &[f64]) -> DVector<f64> {
    let held = DVector::from_column_slice(held);
    let lengths: Vec<f64> = w.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE.sqrt())).collect();
    let mut scaled = w.clone();
    scaled.column_iter_mut().zip(&lengths).for_each(|(mut column, length)| column /= *length);
    let mut right = y - w * &held;
    // Many rows are a small triangle.
    if w.nrows() > 2 * w.ncols() {
        let qr = scaled.qr();
        qr.q_tr_mul(&mut right);
        right = right.rows(0, w.ncols()).into_owned();
        scaled = qr.r();
    }
    let change = scaled.svd(true, true).solve(&right, UNSEEN);
    let mut change = change.unwrap_or_else(|_| DVector::zeros(held.len()));
    change.iter_mut().zip(&lengths).for_each(|(x, length)| *x /= length);
    held + change
}

/// Errors on postures that did not teach: blocks of neighbouring postures are left out in turn.
pub fn held_out(table: &PostureTable, base: &BaseSet, held: &[f64]) -> PressureErrors {
    let (w, y) = table.regression(base);
    let (postures, folds) = (table.postures(), FOLDS.min(table.postures().max(1)));
    let fold = |row: usize| (row / 2) * folds / postures.max(1);
    let mut missed = DVector::zeros(y.len());
    for out in 0..folds {
        let (own, rest): (Vec<usize>, Vec<usize>) = (0..y.len()).partition(|row| fold(*row) == out);
        let theta = least_squares(&w.select_rows(&rest), &y.select_rows(&rest), held);
        let error = y.select_rows(&own) - w.select_rows(&own) * theta;
        own.iter().zip(error.iter()).for_each(|(row, e)| missed[*row] = *e);
    }
    PressureErrors::of(&table.centers(&missed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_distances() {
        let errors = PressureErrors::of(&[[3e-3, 4e-3], [0.0, 1e-3]]);
        assert!((errors.mean - 3e-3).abs() < 1e-15 && (errors.standard_deviation - 2e-3).abs() < 1e-15);
        assert!((errors.max - 5e-3).abs() < 1e-15);
        assert!((errors.rms - (26e-6_f64 / 4.0).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn what_is_not_told_stays() {
        let w = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 2.0, 0.0, 1.0, 0.0]);
        let y = DVector::from_column_slice(&[2.0, 4.0, 2.0]);
        let theta = least_squares(&w, &y, &[0.0, 7.0]);
        assert!((theta[0] - 2.0).abs() < 1e-12 && theta[1] == 7.0);
    }
}
