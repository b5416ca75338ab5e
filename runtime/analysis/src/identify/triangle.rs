//! Tall, skinny least squares in constant memory: a triangle takes rows in and keeps all that least squares needs.
//!
//! Rows `[W | y]` are folded into the triangular factor `R` of their QR decomposition by Householder reflections
//! (Golub and Van Loan, 5.2 and 6.5), so `RᵀR = [W | y]ᵀ[W | y]` without the digits that forming this product would
//! lose: the error grows with the condition number of W, not with its square.
use crate::physical::LeastSquares;
use nalgebra::{DMatrix, DVector};

/// Rows whose square is this part of the diagonal's do not count.
const NOTHING: f64 = 1e-40;
/// Squares below this have lost digits.
const TINY: f64 = 1e-280;

/// The triangular factor of rows with `columns` unknowns and one right-hand side.
#[derive(Debug, Clone, PartialEq)]
pub struct Triangle {
    /// Number of unknowns.
    columns: usize,
    /// Column after column, `(columns + 1)²`; below the diagonal nothing is ever read.
    factor: Vec<f64>,
    /// Number of rows taken in; with weights, of rows that count.
    rows: usize,
}

impl Triangle {
    /// No rows yet.
    pub fn new(columns: usize) -> Self {
        Self { columns, factor: vec![0.0; (columns + 1) * (columns + 1)], rows: 0 }
    }

    /// Number of unknowns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Number of rows taken in.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// What the physical program minimises.
    pub fn least_squares(&self) -> LeastSquares {
        let (factor, right) = (self.matrix(), self.right());
        LeastSquares { factor, right, rest: self.rest(), rows: self.rows }
    }

    /// Takes in `count` rows, given column after column (right-hand side last); the values are used up.
    pub fn absorb(&mut self, count: usize, rows: &mut [f64]) {
        self.rows += count;
        self.reflect(count, rows);
    }

    fn reflect(&mut self, count: usize, rows: &mut [f64]) {
        if count == 0 {
            return;
        }
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
            // SAFETY: the processor has what the function is compiled for.
            return unsafe { wide::reflect(&mut self.factor, self.columns + 1, count, rows) };
        }
        reflect::<false>(&mut self.factor, self.columns + 1, count, rows);
    }

    /// Takes in the rows of another triangle, each multiplied by `weight`; its unknown `k` is unknown `places[k]` here.
    pub fn merge(&mut self, other: &Self, places: &[usize], weight: f64) {
        let (from, width) = (other.columns + 1, self.columns + 1);
        let mut rows = vec![0.0; from * width];
        for (k, to) in places.iter().copied().chain([self.columns]).enumerate() {
            for i in 0..=k {
                rows[to * from + i] = weight * other.factor[k * from + i];
            }
        }
        self.rows += other.rows;
        self.reflect(from, &mut rows);
    }

    /// The same rows over the unknowns `kept` only; `known` times their columns are taken from the right-hand side, all
    /// other unknowns are zero. An unknown may be both: then only its value is counted from elsewhere.
    pub fn reduced(&self, kept: &[usize], known: &[(usize, f64)]) -> Self {
        let width = self.columns + 1;
        let column =
            |k: usize| (0..width).map(move |i| if i <= k { self.factor[k * width + i] } else { 0.0 });
        let mut rows: Vec<f64> = kept.iter().flat_map(|&k| column(k)).collect();
        let mut right: Vec<f64> = column(self.columns).collect();
        for &(k, value) in known {
            right.iter_mut().zip(column(k)).for_each(|(y, x)| *y -= value * x);
        }
        rows.extend(right);
        let mut new = Self::new(kept.len());
        new.reflect(width, &mut rows);
        new.rows = self.rows;
        new
    }

    /// Takes in the rows of a triangle over the same unknowns.
    pub fn add(&mut self, other: &Self) {
        let places: Vec<usize> = (0..self.columns).collect();
        self.merge(other, &places, 1.0);
    }

    /// The square factor of the unknowns, `R` with `‖W θ − y‖² = ‖R θ − z‖² + rest`.
    pub fn matrix(&self) -> DMatrix<f64> {
        let width = self.columns + 1;
        DMatrix::from_fn(
            self.columns,
            self.columns,
            |i, j| {
                if i <= j { self.factor[j * width + i] } else { 0.0 }
            },
        )
    }

    /// `z` of [`Self::matrix`].
    pub fn right(&self) -> DVector<f64> {
        let start = self.columns * (self.columns + 1);
        DVector::from_column_slice(&self.factor[start..start + self.columns])
    }

    /// Sum of squares that no unknowns explain.
    pub fn rest(&self) -> f64 {
        self.factor.last().map_or(0.0, |x| x * x)
    }

    /// Sum of squares of the right-hand side.
    pub fn right_squares(&self) -> f64 {
        self.right().norm_squared() + self.rest()
    }

    /// Sum of squares left over by `theta`.
    pub fn squares(&self, theta: &DVector<f64>) -> f64 {
        (self.matrix() * theta - self.right()).norm_squared() + self.rest()
    }

    /// The normal equations' residual `Wᵀ (y − W θ)`.
    pub fn score(&self, theta: &DVector<f64>) -> DVector<f64> {
        let r = self.matrix();
        r.tr_mul(&(self.right() - &r * theta))
    }

    /// Lengths of the columns of W.
    pub fn lengths(&self) -> DVector<f64> {
        let r = self.matrix();
        DVector::from_iterator(self.columns, r.column_iter().map(|c| c.norm()))
    }
}

/// Folds `count` rows (column after column, `width` columns) into an upper triangular factor. `FUSED`: multiply and add
/// in one step, for processors that have it.
#[inline(always)]
fn reflect<const FUSED: bool>(triangle: &mut [f64], width: usize, count: usize, rows: &mut [f64]) {
    for k in 0..width {
        let (head, tail) = rows.split_at_mut((k + 1) * count);
        let pivot = &head[k * count..];
        let below = dot::<FUSED>(pivot, pivot);
        let top = triangle[k * width + k];
        // What is far below rounding changes nothing, and its square could underflow.
        if below <= NOTHING * top * top || below < TINY {
            continue;
        }
        let length = (top * top + below).sqrt();
        // The sign that adds up instead of cancelling.
        let first = if top > 0.0 { top + length } else { top - length };
        let diagonal = if top > 0.0 { -length } else { length };
        let scale = 2.0 / (first * first + below);
        for (j, column) in tail.chunks_exact_mut(count).enumerate().map(|(j, c)| (k + 1 + j, c)) {
            let corner = &mut triangle[j * width + k];
            let factor = scale * (first * *corner + dot::<FUSED>(pivot, column));
            *corner -= factor * first;
            for (x, p) in column.iter_mut().zip(pivot) {
                *x = times_plus::<FUSED>(-factor, *p, *x);
            }
        }
        triangle[k * width + k] = diagonal;
    }
}

/// The same, compiled for wide registers whatever the rest of the program is compiled for.
#[cfg(target_arch = "x86_64")]
mod wide {
    #[target_feature(enable = "avx2,fma")]
    pub(super) fn reflect(triangle: &mut [f64], width: usize, count: usize, rows: &mut [f64]) {
        super::reflect::<true>(triangle, width, count, rows);
    }
}

#[inline(always)]
fn times_plus<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// Sum of products, in sixteen parts so that it runs in lanes.
#[inline(always)]
fn dot<const FUSED: bool>(a: &[f64], b: &[f64]) -> f64 {
    const PARTS: usize = 16;
    let mut sums = [0.0; PARTS];
    let ((a_parts, a_rest), (b_parts, b_rest)) = (a.as_chunks::<PARTS>(), b.as_chunks::<PARTS>());
    for (x, y) in a_parts.iter().zip(b_parts) {
        for i in 0..PARTS {
            sums[i] = times_plus::<FUSED>(x[i], y[i], sums[i]);
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of a little linear problem, column after column.
    fn rows(count: usize, from: usize) -> Vec<f64> {
        let at = |i: usize| (i + from) as f64;
        let columns: [&dyn Fn(usize) -> f64; 4] =
            [&|i| (0.3 * at(i)).sin(), &|i| (0.7 * at(i)).cos() + 0.2, &|i| 1.0 + 0.01 * at(i), &|i| {
                2.0 * (0.3 * at(i)).sin() - 3.0 * ((0.7 * at(i)).cos() + 0.2) + 0.5 * (1.0 + 0.01 * at(i))
            }];
        columns.iter().flat_map(|c| (0..count).map(c).collect::<Vec<_>>()).collect()
    }

    #[test]
    fn pieces_make_the_same_triangle_as_the_whole() {
        let mut whole = Triangle::new(3);
        whole.absorb(100, &mut rows(100, 0));
        let mut first = Triangle::new(3);
        first.absorb(33, &mut rows(33, 0));
        let mut second = Triangle::new(3);
        second.absorb(60, &mut rows(60, 33));
        second.absorb(7, &mut rows(7, 93));
        first.add(&second);
        let gram = |t: &Triangle| t.matrix().tr_mul(&t.matrix());
        assert!((gram(&whole) - gram(&first)).norm() < 1e-12 * gram(&whole).norm());
        assert_eq!(first.rows(), 100);
        let truth = DVector::from_column_slice(&[2.0, -3.0, 0.5]);
        assert!(first.squares(&truth) < 1e-24);
        assert!(first.score(&truth).norm() < 1e-12);
        let nothing = DVector::zeros(3);
        assert!((first.squares(&nothing) - first.right_squares()).abs() < 1e-12);
    }

    #[test]
    fn known_unknowns_move_to_the_right() {
        let mut whole = Triangle::new(3);
        whole.absorb(80, &mut rows(80, 0));
        let part = whole.reduced(&[2, 0], &[(1, 1.5), (0, 0.25)]);
        assert_eq!((part.rows(), part.columns()), (80, 2));
        for theta in [[0.0, 0.0], [0.5, 2.0], [-1.0, 7.0]] {
            let own = part.squares(&DVector::from_column_slice(&theta));
            let all = whole.squares(&DVector::from_column_slice(&[theta[1] + 0.25, 1.5, theta[0]]));
            assert!((own - all).abs() < 1e-10 * all.max(1.0), "{own} {all}");
        }
    }

    #[test]
    fn columns_that_hardly_exist_do_no_harm() {
        let mut triangle = Triangle::new(2);
        for round in 0..5 {
            let tiny = 1e-160 * f64::from(round);
            let mut rows: Vec<f64> = [tiny, -tiny, 1.0, 1.0, 2.0, 2.0].to_vec();
            triangle.absorb(2, &mut rows);
        }
        assert!(triangle.matrix().iter().all(|x| x.is_finite()));
        assert!((triangle.right_squares() - 40.0).abs() < 1e-12);
    }

    #[test]
    fn weights_and_places() {
        let mut part = Triangle::new(3);
        part.absorb(50, &mut rows(50, 0));
        let mut wide = Triangle::new(5);
        wide.merge(&part, &[4, 0, 2], 2.0);
        let theta = DVector::from_column_slice(&[-3.1, 7.0, 0.5, 9.0, 2.2]);
        let own = DVector::from_column_slice(&[2.2, -3.1, 0.5]);
        assert!((wide.squares(&theta) - 4.0 * part.squares(&own)).abs() < 1e-10);
    }
}
