//! Least squares, with instruments or without, and covariances.
use crate::identify::triangle::Triangle;
use nalgebra::{DMatrix, DVector};

/// A column that is this part of its length away from the others is a sum of them.
const DEPENDENT: f64 = 1e-9;

/// The regression of a triangle whose first `instruments` unknowns are instruments: of what these explain of regressors
/// and right-hand side (two-stage least squares; with as many instruments as regressors `(Zᵀ W)⁻¹ Zᵀ y`).
pub fn staged(triangle: &Triangle, instruments: usize) -> (DMatrix<f64>, DVector<f64>) {
    let (matrix, right) = (triangle.matrix(), triangle.right());
    if instruments == 0 {
        return (matrix, right);
    }
    let own = matrix.ncols() - instruments;
    (matrix.view((0, instruments), (instruments, own)).into_owned(), right.rows(0, instruments).into_owned())
}

/// Shortest `‖W θ − y‖`; the place of a column that is a sum of others where there is one.
pub fn least_squares(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Result<DVector<f64>, usize> {
    let mut columns = matrix.clone();
    let mut scale = Vec::with_capacity(columns.ncols());
    for (k, mut column) in columns.column_iter_mut().enumerate() {
        let length = column.norm();
        if !(length > 0.0 && length.is_finite()) {
            return Err(k);
        }
        column /= length;
        scale.push(length);
    }
    let qr = columns.qr();
    let r = qr.r();
    if let Some(k) = (0..r.ncols()).find(|&k| r[(k, k)].abs() <= DEPENDENT) {
        return Err(k);
    }
    let mut target = right.clone();
    qr.q_tr_mul(&mut target);
    let own = target.rows(0, r.ncols()).into_owned();
    let solution = r.solve_upper_triangular(&own).ok_or(0_usize)?;
    Ok(DVector::from_iterator(solution.len(), solution.iter().zip(&scale).map(|(x, s)| x / s)))
}

/// `(Wᵀ W)⁻¹`
pub fn inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let n = matrix.ncols();
    let mut columns = matrix.clone();
    let scale: Vec<f64> = columns.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    columns.column_iter_mut().zip(&scale).for_each(|(mut c, s)| c /= *s);
    let r = columns.qr().r();
    let half = r.solve_upper_triangular(&DMatrix::identity(n, n));
    let half = half.unwrap_or_else(|| DMatrix::from_element(n, n, f64::INFINITY));
    let full = &half * half.transpose();
    DMatrix::from_fn(n, n, |i, j| full[(i, j)] / (scale[i] * scale[j]))
}

/// Mean square that no unknowns explain (8.3).
pub fn variance(triangle: &Triangle) -> f64 {
    triangle.rest() / triangle.rows().saturating_sub(triangle.columns()).max(1) as f64
}

pub fn scatter(all: &mut DMatrix<f64>, small: &DMatrix<f64>, places: &[usize]) {
    for (i, &a) in places.iter().enumerate() {
        for (j, &b) in places.iter().enumerate() {
            all[(a, b)] += small[(i, j)];
        }
    }
}

/// Covariance from replicates with one stretch left out each (the estimator CR3).
pub fn jackknife(values: &[DVector<f64>]) -> DMatrix<f64> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<DVector<f64>>() / count;
    let n = mean.len();
    let sum = values.iter().fold(DMatrix::zeros(n, n), |sum, value| {
        let away = value - &mean;
        sum + &away * away.transpose()
    });
    sum * ((count - 1.0) / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instruments_of_another_copy_do_not_shrink() {
        // y = 2 x, seen through two copies of x with noise of their own: least squares gives 2 / (1 + 1/4), instruments 2.
        let mut triangle = Triangle::new(2);
        let wave = |i: usize, f: f64| (f * i as f64).sin() * std::f64::consts::SQRT_2;
        let count = 20_000;
        let x: Vec<f64> = (0..count).map(|i| wave(i, 0.37)).collect();
        let noisy = |f: f64| -> Vec<f64> { (0..count).map(|i| x[i] + 0.5 * wave(i, f)).collect() };
        let right: Vec<f64> = x.iter().map(|x| 2.0 * x).collect();
        triangle.absorb(count, &mut [noisy(0.91), noisy(1.73), right].concat());
        let (matrix, right) = staged(&triangle, 1);
        let instrumental = least_squares(&matrix, &right).unwrap();
        assert!((instrumental[0] - 2.0).abs() < 1e-3, "{instrumental}");
        let own = triangle.reduced(&[1], &[]);
        let plain = least_squares(&own.matrix(), &own.right()).unwrap();
        assert!((plain[0] - 1.6).abs() < 1e-3, "{plain}");
    }

    #[test]
    fn a_column_that_is_a_sum_of_others_is_named() {
        let matrix =
            DMatrix::from_row_slice(4, 3, &[1.0, 2.0, 3.0, 0.0, 1.0, 1.0, 2.0, 0.0, 2.0, 1.0, 1.0, 2.0]);
        assert_eq!(least_squares(&matrix, &DVector::repeat(4, 1.0)), Err(2));
        assert_eq!(least_squares(&DMatrix::zeros(4, 1), &DVector::repeat(4, 1.0)), Err(0));
    }
}
