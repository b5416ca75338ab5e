//! What a few signals cannot explain of another one.
use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};

/// What takes out of picked samples what a constant and other signals explain of them by least squares.
pub(super) struct Detrend<'p> {
    picked: &'p [usize],
    /// Samples × (constant, signals).
    signals: DMatrix<f64>,
    /// Of the normal equations; `None` where they cannot be solved.
    factor: Option<Cholesky<f64, Dyn>>,
}

impl<'p> Detrend<'p> {
    pub fn new(picked: &'p [usize], others: &[&[f64]]) -> Self {
        let signal = |row: usize, column: usize| match column {
            0 => 1.0,
            _ => others[column - 1][picked[row]],
        };
        let signals = DMatrix::from_fn(picked.len(), others.len() + 1, signal);
        let mut gram = signals.tr_mul(&signals);
        for i in 0..gram.nrows() {
            gram[(i, i)] *= 1.0 + 1e-9;
            gram[(i, i)] += 1e-300;
        }
        Self { picked, factor: gram.cholesky(), signals }
    }

    /// The picked samples of a signal less what the others explain.
    pub fn of(&self, signal: &[f64]) -> Vec<f64> {
        self.of_picked(self.picked.iter().map(|&i| signal[i]))
    }

    /// The same of what the picked samples hold.
    pub fn of_picked(&self, signal: impl Iterator<Item = f64>) -> Vec<f64> {
        let y = DVector::from_iterator(self.picked.len(), signal);
        let rest = match &self.factor {
            Some(factor) => &y - &self.signals * factor.solve(&self.signals.tr_mul(&y)),
            None => y,
        };
        rest.iter().copied().collect()
    }
}
