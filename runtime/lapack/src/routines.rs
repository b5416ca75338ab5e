//! The computations behind the symbols, safe.
use super::{View, ViewMut};
use nalgebra::{DMatrix, RealField};
use std::ffi::c_int;

/// A symmetric matrix of which one triangle is given.
pub fn filled<T: RealField + Copy>(a: &View<'_, T>, upper: bool) -> DMatrix<T> {
    DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| if (i <= j) == upper { a[(i, j)] } else { a[(j, i)] })
}

/// Eigenvalues, ascending, and their vectors.
pub fn eigen<T: RealField + Copy>(
    a: &View<'_, T>,
    upper: bool,
    w: &mut [T],
    z: Option<ViewMut<'_, T>>,
) -> c_int {
    let Some(found) = filled(a, upper).try_symmetric_eigen(T::default_epsilon(), 0) else { return 1 };
    let mut order: Vec<usize> = (0..w.len()).collect();
    order.sort_by(|&i, &j| {
        found.eigenvalues[i].partial_cmp(&found.eigenvalues[j]).unwrap_or(std::cmp::Ordering::Equal)
    });
    for (value, &i) in w.iter_mut().zip(&order) {
        *value = found.eigenvalues[i];
    }
    if let Some(mut z) = z {
        for (k, &i) in order.iter().enumerate() {
            z.set_column(k, &found.eigenvectors.column(i));
        }
    }
    0
}

/// Singular values, descending, and the vectors that are asked for.
pub fn singular<T: RealField + Copy>(
    a: &View<'_, T>,
    s: &mut [T],
    u: Option<ViewMut<'_, T>>,
    vt: Option<ViewMut<'_, T>>,
) -> c_int {
    let owned = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)]);
    let Some(found) = owned.try_svd(u.is_some(), vt.is_some(), T::default_epsilon(), 0) else { return 1 };
    s.copy_from_slice(found.singular_values.as_slice());
    if let (Some(mut u), Some(from)) = (u, found.u) {
        u.copy_from(&from);
    }
    if let (Some(mut vt), Some(from)) = (vt, found.v_t) {
        vt.copy_from(&from);
    }
    0
}

/// Cholesky in place; the number of the first bad pivot, or 0.
pub fn cholesky<T: RealField + Copy>(a: &mut ViewMut<'_, T>, upper: bool) -> c_int {
    // Element (i, j), i >= j, of the lower factor lies mirrored where the upper one is asked for.
    let at = |i: usize, j: usize| if upper { (j, i) } else { (i, j) };
    for j in 0..a.nrows() {
        let mut pivot = a[at(j, j)];
        for k in 0..j {
            pivot -= a[at(j, k)] * a[at(j, k)];
        }
        if pivot <= T::zero() || !pivot.is_finite() {
            return c_int::try_from(j + 1).unwrap_or(c_int::MAX);
        }
        let pivot = pivot.sqrt();
        a[at(j, j)] = pivot;
        for i in j + 1..a.nrows() {
            let mut sum = a[at(i, j)];
            for k in 0..j {
                sum -= a[at(i, k)] * a[at(j, k)];
            }
            a[at(i, j)] = sum / pivot;
        }
    }
    0
}

/// Solves with the factor of [`cholesky`].
pub fn cholesky_solve<T: RealField + Copy>(a: &View<'_, T>, upper: bool, b: &mut ViewMut<'_, T>) {
    let at = |i: usize, j: usize| if upper { a[(j, i)] } else { a[(i, j)] };
    let n = a.nrows();
    for c in 0..b.ncols() {
        for i in 0..n {
            let sum = (0..i).fold(b[(i, c)], |sum, k| sum - at(i, k) * b[(k, c)]);
            b[(i, c)] = sum / at(i, i);
        }
        for i in (0..n).rev() {
            let sum = (i + 1..n).fold(b[(i, c)], |sum, k| sum - at(k, i) * b[(k, c)]);
            b[(i, c)] = sum / at(i, i);
        }
    }
}

/// Solves a system by LU; 1 if it is singular.
pub fn solve<T: RealField + Copy>(a: &View<'_, T>, b: &mut ViewMut<'_, T>) -> c_int {
    let owned = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)]);
    let mut x = DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| b[(i, j)]);
    if !owned.lu().solve_mut(&mut x) {
        return 1;
    }
    b.copy_from(&x);
    0
}

/// `β C`, where zero times anything is zero: C may be uninitialised then.
fn scaled<T: RealField + Copy>(beta: T, c: T) -> T {
    if beta == T::zero() { T::zero() } else { beta * c }
}

/// `C ← α A B + β C`; `turned` says which of A and B are transposed.
pub fn multiply<T: RealField + Copy>(
    a: &View<'_, T>,
    b: &View<'_, T>,
    turned: [bool; 2],
    [alpha, beta]: [T; 2],
    c: &mut ViewMut<'_, T>,
) {
    let inner = if turned[0] { a.nrows() } else { a.ncols() };
    let left = |i: usize, k: usize| if turned[0] { a[(k, i)] } else { a[(i, k)] };
    let right = |k: usize, j: usize| if turned[1] { b[(j, k)] } else { b[(k, j)] };
    for j in 0..c.ncols() {
        for i in 0..c.nrows() {
            let sum = (0..inner).fold(T::zero(), |sum, k| sum + left(i, k) * right(k, j));
            c[(i, j)] = alpha * sum + scaled(beta, c[(i, j)]);
        }
    }
}

/// One triangle of `C ← α (A Bᵀ + B Aᵀ) + β C`; `turned`: of `α (Aᵀ B + Bᵀ A) + β C`.
pub fn rank_two<T: RealField + Copy>(
    a: &View<'_, T>,
    b: &View<'_, T>,
    turned: bool,
    upper: bool,
    [alpha, beta]: [T; 2],
    c: &mut ViewMut<'_, T>,
) {
    let inner = if turned { a.nrows() } else { a.ncols() };
    let of = |m: &View<'_, T>, i: usize, k: usize| if turned { m[(k, i)] } else { m[(i, k)] };
    for j in 0..c.ncols() {
        let rows = if upper { 0..j + 1 } else { j..c.nrows() };
        for i in rows {
            let sum = (0..inner)
                .fold(T::zero(), |sum, k| sum + of(a, i, k) * of(b, j, k) + of(b, i, k) * of(a, j, k));
            c[(i, j)] = alpha * sum + scaled(beta, c[(i, j)]);
        }
    }
}
