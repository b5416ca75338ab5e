//! The least change of torques where equations cannot all be met: limits hold, equations are missed as little as possible.
use super::least_change::{Active, Conditions, Room, Search, dot, nearest};
use super::slices::{copy, get, set};
use crate::real::Scalar;

/// The nearest point where inequalities are met and equations as well as they can be: the least of |x − x₀|² + w |A x − b|², w the `weight`. Rows are
/// unit vectors; inequalities are changed: afterwards they are those whose nearest point to 0 is `point`. `factor` has size² numbers, `centre`
/// and `point` size.
pub(crate) fn nearest_compromise<R: Scalar>(
    conditions: Conditions<'_, R>,
    x: &mut [R],
    weight: f64,
    (factor, centre, point): (&mut [R], &mut [R], &mut [R]),
    room: &mut Room<'_, R>,
    active: &mut Active,
) -> Search {
    let Conditions { rows, bounds, size, equations, count } = conditions;
    let weight = R::constant(weight);
    let (one, zero) = (R::constant(1.0), R::constant(0.0));
    let Some((equal, rows)) = rows.split_at_mut_checked(equations * size) else { return Search::Impossible };
    let Some((goals, bounds)) = bounds.split_at_mut_checked(equations) else { return Search::Impossible };
    // H = 1 + w AᵀA, and what pulls away from x₀.
    factor.fill(zero);
    for k in 0..size {
        set(factor, k * size + k, one);
    }
    point.fill(zero);
    for (index, goal) in goals.iter().enumerate() {
        let row = equal.get(index * size..(index + 1) * size).unwrap_or(&[]);
        let miss = *goal - dot(row, x);
        for (k, a) in row.iter().enumerate() {
            set(point, k, R::fused(weight * *a, miss, get(point, k)));
            for (j, b) in row.iter().enumerate() {
                set(factor, j * size + k, R::fused(weight * *a, *b, get(factor, j * size + k)));
            }
        }
    }
    if !decompose(factor, size) {
        return Search::Impossible;
    }
    forward(factor, point);
    backward(factor, point);
    centre.iter_mut().zip(x.iter().zip(point.iter())).for_each(|(c, (x, change))| *c = *x + *change);
    for (index, bound) in bounds.iter_mut().enumerate().take(count.saturating_sub(equations)) {
        let row = rows.get_mut(index * size..(index + 1) * size).unwrap_or(&mut []);
        *bound = *bound - dot(row, centre);
        forward(factor, row);
    }
    let mut changed = Conditions { rows, bounds, size, equations: 0, count: count.saturating_sub(equations) };
    changed.normalise(0);
    point.fill(zero);
    let found = nearest(&changed, point, room, active);
    copy(point, x);
    backward(factor, x);
    x.iter_mut().zip(centre.iter()).for_each(|(x, c)| *x = *c + *x);
    found
}

/// L of a symmetric positive definite matrix, in its lower triangle, column after column; `false`: it is none.
fn decompose<R: Scalar>(a: &mut [R], size: usize) -> bool {
    for k in 0..size {
        let mut pivot = get(a, k * size + k);
        for j in 0..k {
            let x = get(a, j * size + k);
            pivot = R::fused(-x, x, pivot);
        }
        let root = pivot.sqrt();
        if !(root > R::constant(0.0) && root.is_finite()) {
            return false;
        }
        set(a, k * size + k, root);
        for i in k + 1..size {
            let mut sum = get(a, k * size + i);
            for j in 0..k {
                sum = R::fused(-get(a, j * size + i), get(a, j * size + k), sum);
            }
            set(a, k * size + i, sum / root);
        }
    }
    true
}

/// L⁻¹ b into b.
fn forward<R: Scalar>(factor: &[R], b: &mut [R]) {
    let size = b.len();
    for k in 0..size {
        let mut sum = get(b, k);
        for j in 0..k {
            sum = R::fused(-get(factor, j * size + k), get(b, j), sum);
        }
        set(b, k, sum / get(factor, k * size + k));
    }
}

/// L⁻ᵀ b into b.
fn backward<R: Scalar>(factor: &[R], b: &mut [R]) {
    let size = b.len();
    for k in (0..size).rev() {
        let mut sum = get(b, k);
        for j in k + 1..size {
            sum = R::fused(-get(factor, k * size + j), get(b, j), sum);
        }
        set(b, k, sum / get(factor, k * size + k));
    }
}
