//! Small dense factorisations on slices that the caller keeps: nalgebra's allocate for sizes known at run time only.
//!
//! Every row of a matrix takes [`row_length`] numbers.
mod elimination;
mod four;
mod positive;
mod products;
mod tiles;

pub(super) use elimination::{eliminate, substitute};
pub(super) use positive::{Filled, backward, factor, forward, forward_one, gram, survey};
pub(super) use products::{add_rows, dot, dots, transpose};
pub(super) use tiles::row_length;

#[cfg(test)]
mod tests {
    use super::tiles::SIDE;
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// Numbers that look random; the same every time.
    fn numbers(count: usize) -> Vec<f64> {
        (0..count).map(|i| ((i * i + 7 * i) as f64 * 0.731).sin()).collect()
    }

    fn positive(n: usize) -> DMatrix<f64> {
        let a = DMatrix::from_row_slice(n, n, &numbers(n * n));
        &a * a.transpose() + DMatrix::identity(n, n) * 0.1
    }

    /// With rows of whole chunks, and something beyond the columns.
    fn padded(a: &DMatrix<f64>) -> Vec<f64> {
        let mut rows = vec![f64::NAN; a.nrows() * row_length(a.ncols())];
        for (to, from) in rows.chunks_exact_mut(row_length(a.ncols())).zip(a.row_iter()) {
            to.iter_mut().zip(from.iter()).for_each(|(to, from)| *to = *from);
        }
        rows
    }

    #[test]
    fn agree_with_nalgebra() {
        for (n, columns) in [(9, 5), (8, 4), (6, 11), (18, 23), (1, 1)] {
            let d = positive(n);
            let mut l = padded(&d);
            assert!(factor(&mut l, n));
            let mut b = DMatrix::from_fn(n, columns, |i, j| ((3 * i + 5 * j + 1) as f64).sin());
            // The last columns are zero but in the last row, as where a limb has contacts of its own.
            b.view_mut((0, columns.min(4)), (n - 1, columns - columns.min(4))).fill(0.0);
            let mut y = padded(&b);
            y.iter_mut().filter(|y| y.is_nan()).for_each(|y| *y = 0.0);
            let mut filled = Vec::new();
            survey(&y, columns, &mut filled);
            assert!(n <= SIDE || (filled[0].has(0) && !filled[0].has(1)));
            let mut product = vec![0.0; columns];
            let x = numbers(n);
            add_rows(&y, &x, &mut product);
            let expected = b.transpose() * DVector::from_row_slice(&x);
            assert!((DVector::from_row_slice(&product) - expected).amax() < 1e-12);
            let mut other = vec![0.0; n];
            dots(&y, &product, &mut other);
            let expected = &b * DVector::from_row_slice(&product);
            assert!((DVector::from_row_slice(&other) - expected).amax() < 1e-12);
            forward(&l, n, &mut y, columns, &mut filled);
            let mut g = vec![0.0; columns * row_length(columns)];
            gram(&y, columns, &filled, &mut g);
            let expected = b.transpose() * d.clone().try_inverse().unwrap() * &b;
            let found = DMatrix::from_fn(columns, columns, |i, j| g[i * row_length(columns) + j]);
            assert!((found - &expected).amax() < 1e-10 * expected.amax());
            let mut x = numbers(n);
            let right = DVector::from_row_slice(&x);
            forward_one(&l, n, &mut x);
            backward(&l, n, &mut x);
            assert!((&d * DVector::from_row_slice(&x) - &right).amax() < 1e-12);
        }
    }

    #[test]
    fn elimination_solves_and_refuses() {
        let mut order = Vec::new();
        for n in [1, 7, 8, 13, 22] {
            let a = DMatrix::from_row_slice(n, n, &numbers(n * n)) + DMatrix::identity(n, n) * 0.3;
            let mut factors = padded(&a);
            assert!(eliminate(&mut factors, n, &mut order));
            // Any number of right sides.
            for scale in [1.0, -3.0] {
                let mut x: Vec<f64> = (1..=n).map(|i| scale * (i as f64).cos()).collect();
                let right = DVector::from_row_slice(&x);
                assert!(substitute(&factors, n, &order, &mut x));
                assert!((&a * DVector::from_row_slice(&x) - right).amax() < 1e-10);
            }
        }
        let singular = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 4.0]);
        assert!(!eliminate(&mut padded(&singular), 2, &mut order));
        assert!(!factor(&mut padded(&DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 2.0, 1.0])), 2));
        assert!(!factor(&mut [f64::NAN; 4], 1));
    }
}
