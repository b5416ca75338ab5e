//! What a few signals cannot explain of another one.
use nalgebra::{DMatrix, DVector};

/// The picked samples of a signal less what a constant and the others explain of them by least squares.
pub(super) fn detrended(residual: &[f64], picked: &[usize], others: &[&[f64]]) -> Vec<f64> {
    let y = DVector::from_iterator(picked.len(), picked.iter().map(|&i| residual[i]));
    let x =
        DMatrix::from_fn(
            picked.len(),
            others.len() + 1,
            |r, c| {
                if c == 0 { 1.0 } else { others[c - 1][picked[r]] }
            },
        );
    let mut gram = x.tr_mul(&x);
    for i in 0..gram.nrows() {
        gram[(i, i)] *= 1.0 + 1e-9;
        gram[(i, i)] += 1e-300;
    }
    match gram.cholesky() {
        Some(cholesky) => {
            let fitted = &x * cholesky.solve(&x.tr_mul(&y));
            (y - fitted).iter().copied().collect()
        }
        None => y.iter().copied().collect(),
    }
}
