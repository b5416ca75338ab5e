//! Products of columns with each other.
use nalgebra::{DMatrix, DMatrixView};

/// Columns that are multiplied at a time: what lies above the diagonal is a mirror image and is not computed twice.
const PANEL: usize = 32;
/// Samples that are turned at a time: they stay in the cache.
const SAMPLES: usize = 512;

/// `xᵀ x` of `samples × n`: n × n, symmetric to the last bit.
pub(crate) fn gram(x: &DMatrix<f64>) -> DMatrix<f64> {
    let mut gram = DMatrix::zeros(x.ncols(), x.ncols());
    add_lower(x, &mut gram);
    mirror(&mut gram);
    gram
}

/// Adds `xᵀ x` to a sum, on and below its diagonal; above it the sum is of no use until it was [`mirror`]ed.
pub(crate) fn add_lower(x: &DMatrix<f64>, gram: &mut DMatrix<f64>) {
    let (samples, n) = x.shape();
    for begin in (0..samples).step_by(SAMPLES) {
        let part = x.rows(begin, SAMPLES.min(samples - begin));
        // Not `gemm_tr`, which has no kernel for blocks.
        let transposed = turned(&part);
        for first in (0..n).step_by(PANEL) {
            let width = PANEL.min(n - first);
            let below = transposed.rows(first, n - first);
            let columns = part.columns(first, width);
            gram.view_mut((first, first), (n - first, width)).gemm(1.0, &below, &columns, 1.0);
        }
    }
}

/// The transposed, some columns at a time: nalgebra's own reads each number from another line of the cache.
fn turned(x: &DMatrixView<'_, f64>) -> DMatrix<f64> {
    const TILE: usize = 4;
    let (samples, n) = x.shape();
    let mut turned = DMatrix::zeros(n, samples);
    for first in (0..n).step_by(TILE) {
        let columns = x.columns(first, TILE.min(n - first));
        for (mut sample, values) in turned.column_iter_mut().zip(columns.row_iter()) {
            sample.rows_mut(first, values.len()).tr_copy_from(&values);
        }
    }
    turned
}

/// What lies below the diagonal stands above it too.
pub(crate) fn mirror(gram: &mut DMatrix<f64>) {
    gram.fill_upper_triangle_with_lower_triangle();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_products_are_all_of_them() {
        for (samples, n) in [(1, 1), (40, 3), (513, 70), (300, 129)] {
            let x = DMatrix::from_fn(samples, n, |r, c| ((r * 31 + c * 17) as f64 * 0.37).sin());
            let (found, all) = (gram(&x), x.transpose() * &x);
            assert!((&found - &all).amax() <= 1e-12 * all.amax());
            assert_eq!(found, found.transpose());
        }
    }
}
