//! Least squares in rounded arithmetic, for coefficients that are too long to print.

/// Solves `matrix · x ≈ right` for a matrix (rows) of full column rank, by Householder reflections.
pub fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let columns = matrix.first().map_or(0, Vec::len);
    for k in 0..columns {
        reflect(&mut matrix, &mut right, k);
    }
    let mut x = vec![0.0; columns];
    for k in (0..columns).rev() {
        let known: f64 = (k + 1..columns).map(|c| matrix[k][c] * x[c]).sum();
        x[k] = (right[k] - known) / matrix[k][k];
    }
    x
}

/// Clears column `k` below the diagonal.
fn reflect(matrix: &mut [Vec<f64>], right: &mut [f64], k: usize) {
    let norm = matrix[k..].iter().map(|row| row[k] * row[k]).sum::<f64>().sqrt();
    if norm == 0.0 {
        return;
    }
    let mut v: Vec<f64> = matrix[k..].iter().map(|row| row[k]).collect();
    v[0] += norm.copysign(v[0]);
    let half_square = 0.5 * v.iter().map(|x| x * x).sum::<f64>();
    for c in k..matrix[k].len() {
        let factor = v.iter().zip(&matrix[k..]).map(|(v, row)| v * row[c]).sum::<f64>() / half_square;
        for (v, row) in v.iter().zip(&mut matrix[k..]) {
            row[c] -= factor * v;
        }
    }
    let factor = v.iter().zip(&right[k..]).map(|(v, x)| v * x).sum::<f64>() / half_square;
    for (v, x) in v.iter().zip(&mut right[k..]) {
        *x -= factor * v;
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

    #[test]
    fn recovers_coefficients() {
        let mut random = Random::new(3);
        let matrix: Vec<Vec<f64>> = (0..20).map(|_| (0..6).map(|_| random.symmetric()).collect()).collect();
        let wanted = [1.0, -2.0, 0.5, 3.0, -0.25, 7.0];
        let right = matrix.iter().map(|row| row.iter().zip(wanted).map(|(a, x)| a * x).sum()).collect();
        for (x, y) in solve(matrix, right).iter().zip(wanted) {
            assert!((x - y).abs() < 1e-13);
        }
    }
}
