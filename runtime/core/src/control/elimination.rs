//! Linear equations of the size of a robot's actuators, without a panic.
use super::slices::{get, set};
use crate::real::Scalar;

/// A pivot below so many roundings of the largest element of its row, which is 1, is none.
const ROUNDINGS: f64 = 1e3;

/// A square matrix, column after column.
struct Square<'m, R> {
    elements: &'m mut [R],
    size: usize,
}

impl<R: Scalar> Square<'_, R> {
    /// 0 outside, where nobody looks.
    fn at(&self, row: usize, column: usize) -> R {
        self.elements.get(column * self.size + row).copied().unwrap_or(R::constant(0.0))
    }

    fn set(&mut self, row: usize, column: usize, value: R) {
        if let Some(element) = self.elements.get_mut(column * self.size + row) {
            *element = value;
        }
    }

    fn exchange_rows(&mut self, a: usize, b: usize) {
        for column in 0..self.size {
            let (first, second) = (self.at(a, column), self.at(b, column));
            self.set(a, column, second);
            self.set(b, column, first);
        }
    }

    fn scale_row(&mut self, row: usize, factor: R) {
        for column in 0..self.size {
            let scaled = self.at(row, column) * factor;
            self.set(row, column, scaled);
        }
    }
}

/// `A x = b` into `b` by Gauss' elimination with row exchanges; A column after column, destroyed. `false`: A is singular, or no
/// number.
pub(crate) fn solve<R: Scalar>(matrix: &mut [R], right: &mut [R]) -> bool {
    solve_all(matrix, right.len(), right)
}

/// The same for several right sides of `size` numbers, one after the other.
pub(crate) fn solve_all<R: Scalar>(matrix: &mut [R], size: usize, rights: &mut [R]) -> bool {
    let mut a = Square { elements: matrix, size };
    if !equilibrate(&mut a, rights) {
        return false;
    }
    let least = R::constant(ROUNDINGS * R::EPSILON);
    for k in 0..size {
        let mut pivot = k;
        for row in k + 1..size {
            if a.at(row, k).abs() > a.at(pivot, k).abs() {
                pivot = row;
            }
        }
        // What is no number is no pivot either.
        let usable = a.at(pivot, k).abs() > least;
        if !usable {
            return false;
        }
        a.exchange_rows(k, pivot);
        for right in rights.chunks_exact_mut(size) {
            let (first, second) = (get(right, k), get(right, pivot));
            set(right, k, second);
            set(right, pivot, first);
        }
        eliminate_below(&mut a, rights, k);
    }
    for right in rights.chunks_exact_mut(size.max(1)) {
        for k in (0..size).rev() {
            let mut sum = get(right, k);
            for column in k + 1..size {
                sum = R::fused(-a.at(k, column), get(right, column), sum);
            }
            set(right, k, sum / a.at(k, k));
        }
    }
    true
}

/// Rows get 1 as largest element: outputs may have any units.
fn equilibrate<R: Scalar>(a: &mut Square<'_, R>, rights: &mut [R]) -> bool {
    for row in 0..a.size {
        let mut largest = R::constant(0.0);
        for column in 0..a.size {
            let x = a.at(row, column).abs();
            if !x.is_finite() {
                return false;
            }
            largest = largest.larger(x);
        }
        let factor = R::constant(1.0) / largest;
        if !factor.is_finite() {
            return false;
        }
        a.scale_row(row, factor);
        for right in rights.chunks_exact_mut(a.size) {
            set(right, row, get(right, row) * factor);
        }
    }
    true
}

fn eliminate_below<R: Scalar>(a: &mut Square<'_, R>, rights: &mut [R], k: usize) {
    for row in k + 1..a.size {
        let factor = a.at(row, k) / a.at(k, k);
        for column in k + 1..a.size {
            let rest = R::fused(-factor, a.at(k, column), a.at(row, column));
            a.set(row, column, rest);
        }
        for right in rights.chunks_exact_mut(a.size) {
            let rest = R::fused(-factor, get(right, k), get(right, row));
            set(right, row, rest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elimination_solves_and_says_when_it_cannot() {
        let rows = [[0.0, 2.0, 1.0], [1e6, -1e6, 0.5e6], [3e-9, 0.0, 2e-9]];
        let x = [1.0, -2.0, 0.5];
        let mut b = rows.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>());
        let mut columns: [f64; 9] = core::array::from_fn(|k| rows[k % 3][k / 3]);
        assert!(solve(&mut columns, &mut b));
        assert!(b.iter().zip(x).all(|(b, x)| (b - x).abs() < 1e-14), "{b:?}");
        for mut singular in
            [[1.0, 2.0, 2.0, 4.0], [0.0; 4], [f64::NAN, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, f64::INFINITY]]
        {
            assert!(!solve(&mut singular, &mut [1.0, 1.0]));
        }
        assert!(solve::<f64>(&mut [], &mut []));
        let (mut two, mut rights) = ([2.0, 1.0, 0.0, 4.0], [2.0, 5.0, -4.0, 2.0]);
        assert!(solve_all(&mut two, 2, &mut rights));
        assert_eq!(rights, [1.0, 1.0, -2.0, 1.0]);
        // Of single precision its own rounding counts.
        assert!(!solve(&mut [1.0f32, 1.0, 1.0, 1.000_01], &mut [1.0, 1.0]));
        assert!(solve(&mut [1.0f64, 1.0, 1.0, 1.000_01], &mut [1.0, 1.0]));
    }
}
