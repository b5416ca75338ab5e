//! Least squares in rounded arithmetic, for coefficients that are too long to print.

/// Solves `matrix · x ≈ right` for a matrix (rows) of full column rank and several right sides, by
/// Householder reflections. Rows in, rows out: `x[k]` holds unknown `k` for all right sides.
pub fn solve(matrix: &[Vec<f64>], right: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let columns = matrix.first().map_or(0, Vec::len);
    let mut rows: Vec<Vec<f64>> = matrix.iter().zip(right).map(|(a, b)| [&a[..], b].concat()).collect();
    for k in 0..columns {
        reflect(&mut rows[k..], k);
    }
    for k in (0..columns).rev() {
        let (above, solved) = rows[..columns].split_at_mut(k + 1);
        let row = &mut above[k];
        let (factors, unknown) = row.split_at_mut(columns);
        for (other, x) in (k + 1..columns).zip(solved) {
            for (sum, x) in unknown.iter_mut().zip(&x[columns..]) {
                *sum -= factors[other] * x;
            }
        }
        unknown.iter_mut().for_each(|x| *x /= factors[k]);
    }
    rows.truncate(columns);
    rows.into_iter().map(|row| row[columns..].to_vec()).collect()
}

/// Clears column `k` in all rows but the first.
fn reflect(rows: &mut [Vec<f64>], k: usize) {
    let norm = rows.iter().map(|row| row[k] * row[k]).sum::<f64>().sqrt();
    if norm == 0.0 {
        return;
    }
    let mut v: Vec<f64> = rows.iter().map(|row| row[k]).collect();
    v[0] += norm.copysign(v[0]);
    let half_square = 0.5 * v.iter().map(|x| x * x).sum::<f64>();
    let mut factors = vec![0.0; rows[0].len() - k];
    for (v, row) in v.iter().zip(&*rows) {
        factors.iter_mut().zip(&row[k..]).for_each(|(sum, x)| *sum += v * x);
    }
    for (v, row) in v.iter().zip(rows) {
        let v = v / half_square;
        row[k..].iter_mut().zip(&factors).for_each(|(x, factor)| *x -= v * factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_effects::random::Random;

    #[test]
    fn recovers_coefficients() {
        let mut random = Random::new(3);
        let matrix: Vec<Vec<f64>> = (0..20).map(|_| (0..6).map(|_| random.symmetric()).collect()).collect();
        let wanted = [[1.0, 5.0], [-2.0, 0.0], [0.5, 1.0], [3.0, -1.0], [-0.25, 4.0], [7.0, 2.0]];
        let product = |row: &Vec<f64>, side: usize| row.iter().zip(wanted).map(|(a, x)| a * x[side]).sum();
        let right: Vec<Vec<f64>> = matrix.iter().map(|row| vec![product(row, 0), product(row, 1)]).collect();
        for (x, y) in solve(&matrix, &right).iter().zip(wanted) {
            assert!((x[0] - y[0]).abs() < 1e-13 && (x[1] - y[1]).abs() < 1e-13);
        }
    }
}
