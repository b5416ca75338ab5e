//! Square systems of linear equations of a robot's size, solved again and again in the same memory.

/// L and U of a matrix whose rows were exchanged.
#[derive(Debug, Clone, Default)]
pub(super) struct Factors {
    size: usize,
    /// Row after row: U on and above the diagonal, L without its ones below.
    elements: Vec<f64>,
    /// Which row was taken in each turn.
    pivots: Vec<usize>,
}

impl Factors {
    /// Of a matrix, row after row; `false`: it is singular, or no number.
    pub fn of(&mut self, matrix: &[f64], size: usize) -> bool {
        self.size = size;
        self.elements.clear();
        self.elements.extend_from_slice(matrix);
        self.pivots.clear();
        (0..size).all(|k| self.eliminate(k))
    }

    /// Column `k` below the diagonal.
    fn eliminate(&mut self, k: usize) -> bool {
        let (n, a) = (self.size, &mut self.elements);
        let mut pivot = k;
        for row in k + 1..n {
            if a[row * n + k].abs() > a[pivot * n + k].abs() {
                pivot = row;
            }
        }
        self.pivots.push(pivot);
        if pivot != k {
            for column in 0..n {
                a.swap(k * n + column, pivot * n + column);
            }
        }
        let (above, below) = a.split_at_mut((k + 1) * n);
        let top = &above[k * n..];
        if top[k] == 0.0 || !top[k].is_finite() {
            return false;
        }
        for row in below.chunks_exact_mut(n) {
            let factor = row[k] / top[k];
            row[k] = factor;
            for (element, top) in row[k + 1..].iter_mut().zip(&top[k + 1..]) {
                *element -= factor * top;
            }
        }
        true
    }

    /// A x = b into `x`, which is b before.
    pub fn solve(&self, x: &mut [f64]) {
        let n = self.size;
        for (k, &pivot) in self.pivots.iter().enumerate() {
            x.swap(k, pivot);
        }
        for row in 0..n {
            let known = &self.elements[row * n..row * n + row];
            x[row] -= known.iter().zip(x.iter()).map(|(a, x)| a * x).sum::<f64>();
        }
        for row in (0..n).rev() {
            let of = &self.elements[row * n..(row + 1) * n];
            let known: f64 = of[row + 1..].iter().zip(&x[row + 1..]).map(|(a, x)| a * x).sum();
            x[row] = (x[row] - known) / of[row];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Factors;

    #[test]
    fn a_solution_solves_its_equations_and_singular_ones_are_told() {
        let size = 6;
        // Zeros on the diagonal, so that rows have to be exchanged.
        let matrix: Vec<f64> = (0..size * size)
            .map(|k| if k % (size + 1) == 0 { 0.0 } else { ((k * k * 7 + 3 * k) % 23) as f64 - 11.0 })
            .collect();
        let wanted: Vec<f64> = (0..size).map(|k| 0.3 * k as f64 - 1.0).collect();
        let row = |k: usize| matrix[k * size..(k + 1) * size].iter().zip(&wanted).map(|(a, x)| a * x).sum();
        let mut x: Vec<f64> = (0..size).map(row).collect();
        let mut factors = Factors::default();
        assert!(factors.of(&matrix, size));
        factors.solve(&mut x);
        for (found, wanted) in x.iter().zip(&wanted) {
            assert!((found - wanted).abs() < 1e-13, "{found} {wanted}");
        }
        assert!(!factors.of(&[1.0, 2.0, 2.0, 4.0], 2) && !factors.of(&[f64::NAN, 2.0, 2.0, 4.0], 2));
    }
}
