//! Small dense factorisations on slices that the caller keeps: nalgebra's allocate for sizes known at run time only.

/// Turns the lower triangle of `a` (`n × n`, row after row) into its Cholesky factor, with reciprocals on the
/// diagonal. `false`: the matrix is not positive definite; `a` is of no use then.
pub(super) fn cholesky(a: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        let (above, row) = a.split_at_mut(i * n);
        for j in 0..i {
            let other = &above[j * n..j * n + j];
            row[j] = (row[j] - dot(&row[..j], other)) * above[j * n + j];
        }
        let rest = row[i] - dot(&row[..i], &row[..i]);
        // Written so that NaN fails too.
        if !(rest > 0.0 && rest.is_finite()) {
            return false;
        }
        row[i] = rest.sqrt().recip();
    }
    true
}

/// `L Y = B` in place, `B` with `columns` columns, row after row.
pub(super) fn forward(l: &[f64], n: usize, b: &mut [f64], columns: usize) {
    for i in 0..n {
        let (above, row) = b.split_at_mut(i * columns);
        let row = &mut row[..columns];
        for (j, solved) in above.chunks_exact(columns).enumerate() {
            let factor = l[i * n + j];
            if factor != 0.0 {
                row.iter_mut().zip(solved).for_each(|(x, y)| *x -= factor * y);
            }
        }
        let reciprocal = l[i * n + i];
        row.iter_mut().for_each(|x| *x *= reciprocal);
    }
}

/// `Lᵀ x = b` in place.
pub(super) fn backward(l: &[f64], n: usize, b: &mut [f64]) {
    for i in (0..n).rev() {
        let x = b[i] * l[i * n + i];
        b[i] = x;
        let row = &l[i * n..i * n + i];
        b[..i].iter_mut().zip(row).for_each(|(y, factor)| *y -= factor * x);
    }
}

/// The lower triangle of `Yᵀ Y` into both triangles of `g`; `Y` is `n × columns`, row after row.
pub(super) fn gram(y: &[f64], columns: usize, g: &mut [f64]) {
    g.fill(0.0);
    for row in y.chunks_exact(columns) {
        for (i, &factor) in row.iter().enumerate() {
            if factor != 0.0 {
                let target = &mut g[i * columns..i * columns + i + 1];
                target.iter_mut().zip(row).for_each(|(x, y)| *x += factor * y);
            }
        }
    }
    for i in 0..columns {
        for j in 0..i {
            g[j * columns + i] = g[i * columns + j];
        }
    }
}

/// Solves `a x = b` in place by elimination with row exchanges; `a` (`n × n`, row after row) is destroyed.
/// `false`: singular to working precision; `b` is of no use then.
pub(super) fn solve(a: &mut [f64], n: usize, b: &mut [f64]) -> bool {
    for k in 0..n {
        let largest = |best: usize, row: usize| {
            if a[row * n + k].abs() > a[best * n + k].abs() { row } else { best }
        };
        let pivot = (k + 1..n).fold(k, largest);
        let size = a[pivot * n + k].abs();
        if size <= f64::MIN_POSITIVE || !size.is_finite() {
            return false;
        }
        if pivot != k {
            let (upper, lower) = a.split_at_mut(pivot * n);
            upper[k * n..(k + 1) * n].swap_with_slice(&mut lower[..n]);
            b.swap(k, pivot);
        }
        let (upper, lower) = a.split_at_mut((k + 1) * n);
        let pivot_row = &upper[k * n + k..];
        let reciprocal = pivot_row[0].recip();
        let known = b[k];
        for (row, value) in lower.chunks_exact_mut(n).zip(&mut b[k + 1..n]) {
            let factor = row[k] * reciprocal;
            if factor != 0.0 {
                row[k..].iter_mut().zip(pivot_row).for_each(|(x, y)| *x -= factor * y);
                *value -= factor * known;
            }
        }
    }
    for k in (0..n).rev() {
        let row = &a[k * n..(k + 1) * n];
        b[k] = (b[k] - dot(&row[k + 1..], &b[k + 1..n])) / row[k];
    }
    b[..n].iter().all(|x| x.is_finite())
}

/// Four sums side by side: one would wait for itself.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, a_rest) = a.as_chunks::<4>();
    let (b4, b_rest) = b.as_chunks::<4>();
    for (x, y) in a4.iter().zip(b4) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn agree_with_nalgebra() {
        let (n, columns) = (9, 5);
        let d = positive(n);
        let mut l: Vec<f64> = d.transpose().as_slice().to_vec();
        assert!(cholesky(&mut l, n));
        let mut y = numbers(n * columns);
        let b = DMatrix::from_row_slice(n, columns, &y);
        forward(&l, n, &mut y, columns);
        let mut g = vec![0.0; columns * columns];
        gram(&y, columns, &mut g);
        let expected = b.transpose() * d.clone().try_inverse().unwrap() * &b;
        assert!((DMatrix::from_row_slice(columns, columns, &g) - &expected).amax() < 1e-10 * expected.amax());
        let mut x = numbers(n);
        let right = DVector::from_row_slice(&x);
        forward(&l, n, &mut x, 1);
        backward(&l, n, &mut x);
        assert!((&d * DVector::from_row_slice(&x) - right).amax() < 1e-12);
    }

    #[test]
    fn elimination_solves_and_refuses() {
        let n = 7;
        let a = DMatrix::from_row_slice(n, n, &numbers(n * n));
        let mut x = numbers(n);
        let right = DVector::from_row_slice(&x);
        assert!(solve(a.transpose().as_mut_slice(), n, &mut x));
        assert!((&a * DVector::from_row_slice(&x) - right).amax() < 1e-10);
        assert!(!solve(&mut [1.0, 2.0, 2.0, 4.0], 2, &mut [1.0, 1.0]));
        assert!(!cholesky(&mut [1.0, 0.0, 2.0, 1.0], 2));
        assert!(!cholesky(&mut [f64::NAN], 1));
    }
}
