//! Products of a few dense columns with a vector, several columns at once so that sums are not written and read again for each of them.

/// Rows of columns (one after the other, each of `height` numbers) from `first` on times a vector, into `out`.
#[inline(always)]
pub(super) fn times((columns, height, first): (&[f64], usize, usize), x: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    let rows = |column: usize| &columns[column * height + first..(column + 1) * height];
    let mut next = 0;
    while next + 4 <= x.len() {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| rows(next + k));
        let [p, q, r, s] = [0, 1, 2, 3].map(|k| x[next + k]);
        for ((((out, a), b), c), d) in out.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            *out = (((*out + a * p) + b * q) + c * r) + d * s;
        }
        next += 4;
    }
    for (column, &x) in x.iter().enumerate().skip(next) {
        out.iter_mut().zip(rows(column)).for_each(|(out, a)| *out += a * x);
    }
}

/// Σ aᵢ bᵢ in eight sums, as far as the shorter one goes.
#[inline(always)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let size = a.len().min(b.len());
    let (a, b) = (a[..size].chunks_exact(8), b[..size].chunks_exact(8));
    let (behind_a, behind_b) = (a.remainder(), b.remainder());
    let mut sums = [0.0; 8];
    for (a, b) in a.zip(b) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    let whole = (0..4).fold(0.0, |whole, k| whole + (sums[k] + sums[k + 4]));
    behind_a.iter().zip(behind_b).fold(whole, |whole, (a, b)| whole + a * b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_those_of_nalgebra_to_the_last_bit() {
        let number = |k: usize| ((k * 7919 + 13) % 1009) as f64 / 97.0 - 5.0;
        for (rows, columns) in [(1, 1), (7, 3), (8, 4), (29, 5), (64, 9), (0, 2)] {
            let first = 3;
            let height = first + rows;
            let values: Vec<f64> = (0..height * columns).map(number).collect();
            let x: Vec<f64> = (0..columns).map(|k| number(k + 500)).collect();
            let whole = nalgebra::DMatrix::from_column_slice(height, columns, &values);
            let below = whole.rows(first, rows).into_owned();
            let mut out = vec![f64::NAN; rows];
            times((&values, height, first), &x, &mut out);
            let mut wanted = nalgebra::DVector::zeros(rows);
            wanted.gemv(1.0, &below, &nalgebra::DVector::from_column_slice(&x), 0.0);
            assert_eq!(out, wanted.as_slice());
            let y: Vec<f64> = (0..rows).map(|k| number(k + 77)).collect();
            let other = nalgebra::DVector::from_column_slice(&y);
            for column in 0..columns {
                assert_eq!(dot(below.column(column).as_slice(), &y), below.column(column).dot(&other));
            }
        }
    }
}
