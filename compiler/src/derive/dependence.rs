//! Which of several constraints says nothing new.

/// A row whose rest is below this part of it, once those before it are taken away, is one of their sums.
const DEPENDENT: f64 = 1e-9;

/// The first row of a matrix that is a sum of rows before it; none: they are independent, or no numbers.
pub fn dependent_row(rows: &[Vec<f64>]) -> Option<usize> {
    // Orthonormal, of the rows so far.
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        let size = norm(row);
        if !size.is_finite() {
            return None;
        }
        let mut rest = row.clone();
        // Twice, because the first round leaves rounding of the size of what it takes away.
        for _ in 0..2 {
            for unit in &basis {
                let part: f64 = rest.iter().zip(unit).map(|(a, b)| a * b).sum();
                rest.iter_mut().zip(unit).for_each(|(x, y)| *x -= part * y);
            }
        }
        let left = norm(&rest);
        if left <= DEPENDENT * size {
            return Some(index);
        }
        basis.push(rest.iter().map(|x| x / left).collect());
    }
    None
}

fn norm(row: &[f64]) -> f64 {
    row.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::dependent_row;

    #[test]
    fn the_first_row_that_says_nothing_new_is_told() {
        let row = |x: [f64; 3]| x.to_vec();
        let [a, b] = [row([1.0, 2.0, 0.0]), row([0.0, 1.0, 1e-3])];
        let sum = row([1e6, 2.5e6, 5e2]);
        assert_eq!(dependent_row(&[a.clone(), b.clone(), row([0.0, 0.0, 1.0])]), None);
        assert_eq!(dependent_row(&[a.clone(), b.clone(), sum]), Some(2));
        assert_eq!(dependent_row(&[a.clone(), row([0.0; 3]), b]), Some(1));
        assert_eq!(dependent_row(&[a, row([f64::NAN; 3])]), None);
    }
}
