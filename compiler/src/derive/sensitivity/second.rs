//! Second moments, symmetric and not, together with what they do as inertias.
use super::axes::Turn;
use crate::derive::model::{is_right_angle, rotate};
use crate::expression::{Matrix3, Sym, Vector3};

/// A matrix M = Σ m a bᵀ and the diagonal of `tr(M) 1 − M`.
///
/// The diagonal is there twice because sums of turned elements do not cancel in the graph: what is not used
/// costs nothing.
#[derive(Clone, Copy)]
pub(super) struct Second<'g> {
    /// M
    pub m: Matrix3<'g>,
    /// Diagonal of `tr(M) 1 − M`: for M = Σ m r rᵀ the moments of inertia.
    pub polar: Vector3<'g>,
}

/// `a bᵀ`
pub(super) fn outer<'g>(a: Vector3<'g>, b: Vector3<'g>) -> Matrix3<'g> {
    Matrix3([0, 1, 2].map(|r| [0, 1, 2].map(|c| a[r] * b[c])))
}

/// `R M Rᵀ`
pub(super) fn turn_matrix<'g>(turn: Turn<'g>, m: &Matrix3<'g>) -> Matrix3<'g> {
    let (u, v) = ((turn.0 + 1) % 3, (turn.0 + 2) % 3);
    turn_with(turn, m, m[(u, u)] - m[(v, v)]).0
}

/// `R M Rᵀ` by the double angle on the plane that turns, where the diagonal differs by `difference`; and what
/// goes from one of its diagonal elements to the other.
fn turn_with<'g>(turn: Turn<'g>, m: &Matrix3<'g>, difference: Sym<'g>) -> (Matrix3<'g>, Sym<'g>) {
    let (axis, s, c) = turn;
    if is_right_angle(turn) {
        let columns = [0, 1, 2].map(|k| rotate(axis, s, c, m.column(k)));
        let rows = Matrix3::from_columns(columns).0.map(|row| rotate(axis, s, c, Vector3(row)).0);
        return (Matrix3(rows), s.zero());
    }
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let (ss, sc) = (s * s, s * c);
    let sum = m[(u, v)] + m[(v, u)];
    let along = ss * difference + sc * sum;
    let across = ss * sum - sc * difference;
    let mut out = *m;
    out[(u, u)] = m[(u, u)] - along;
    out[(v, v)] = m[(v, v)] + along;
    out[(u, v)] = m[(u, v)] - across;
    out[(v, u)] = m[(v, u)] - across;
    out[(u, axis)] = c * m[(u, axis)] - s * m[(v, axis)];
    out[(v, axis)] = s * m[(u, axis)] + c * m[(v, axis)];
    out[(axis, u)] = c * m[(axis, u)] - s * m[(axis, v)];
    out[(axis, v)] = s * m[(axis, u)] + c * m[(axis, v)];
    (out, along)
}

impl<'g> Second<'g> {
    pub fn new(m: Matrix3<'g>) -> Self {
        let polar = Vector3([0, 1, 2].map(|k| m[((k + 1) % 3, (k + 1) % 3)] + m[((k + 2) % 3, (k + 2) % 3)]));
        Self { m, polar }
    }

    /// `[w]× M` of a symmetric M: its trace is zero.
    pub fn crossed(&self, w: Vector3<'g>) -> Self {
        let m = w.skew() * self.m;
        let polar = |k: usize| {
            let (u, v) = ((k + 1) % 3, (k + 2) % 3);
            w[v] * self.m[(k, u)] - w[u] * self.m[(k, v)]
        };
        Self { m, polar: Vector3([0, 1, 2].map(polar)) }
    }

    pub fn scaled(&self, factor: f64) -> Self {
        Self { m: self.m.map(|x| x * factor), polar: Vector3(self.polar.0.map(|x| x * factor)) }
    }

    pub fn plus(&self, other: &Self) -> Self {
        Self { m: self.m + other.m, polar: self.polar + other.polar }
    }

    /// `R M Rᵀ`
    pub fn turned(&self, turn: Turn<'g>) -> Self {
        let (axis, _, c) = turn;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let (m, along) = turn_with(turn, &self.m, self.polar[v] - self.polar[u]);
        let mut polar = self.polar;
        if !is_right_angle(turn) {
            polar[u] = polar[u] + along;
            polar[v] = polar[v] - along;
        } else if c.is_zero() {
            (polar[u], polar[v]) = (polar[v], polar[u]);
        }
        Self { m, polar }
    }

    /// `M + a bᵀ`
    pub fn plus_outer(&self, a: Vector3<'g>, b: Vector3<'g>) -> Self {
        self.plus(&Self::new(outer(a, b)))
    }

    /// `M + a bᵀ + b aᵀ`
    pub fn plus_symmetric(&self, a: Vector3<'g>, b: Vector3<'g>) -> Self {
        let m = outer(a, b);
        self.plus(&Self::new(m + m.transpose()))
    }

    /// `tr(M) 1 − M`
    pub fn complement(&self) -> Matrix3<'g> {
        let mut out = self.m.map(|x| -x);
        for k in 0..3 {
            out[(k, k)] = self.polar[k];
        }
        out
    }

    /// `tr(M)`-free way to the difference `M_bb − M_cc`.
    pub fn difference(&self, b: usize, c: usize) -> Sym<'g> {
        self.polar[c] - self.polar[b]
    }
}
