//! What a subtree of bodies answers to a change of its motion.
use super::axes::Turn;
use super::motion::Moving;
use crate::derive::model::rotate;
use crate::derive::{BodyInertia, RobotModel};
use crate::expression::{Graph, Matrix3, Sym, Vector3};
use crate::tree::{Motion, Rotation};

/// Force, and moment about a body's origin.
pub(super) type Wrench<'g> = (Vector3<'g>, Vector3<'g>);

/// Change of the motion of a subtree, rigid but for the velocity v(r) that its points already have:
/// δa(r) = `acceleration` + `angular` × r + factor · `spin` × v(r).
#[derive(Clone, Copy)]
pub(super) struct Change<'g> {
    /// Of the origin.
    pub acceleration: Vector3<'g>,
    /// Angular acceleration.
    pub angular: Vector3<'g>,
    /// Angular velocity.
    pub spin: Vector3<'g>,
    /// Wrench that changes besides, because the subtree's wrench is carried along.
    pub carried: Wrench<'g>,
}

/// Sums over all bodies of a subtree; r and v(r) = ṙ from the origin, in any axes, not turning.
#[derive(Clone, Copy)]
pub(super) struct Subtree<'g> {
    /// Mass Σ m, first moment Σ m r, and J = Σ m r rᵀ in the place of the inertia `tr(J) 1 − J`.
    pub moments: BodyInertia<'g>,
    /// factor · Σ m v
    pub momentum: Vector3<'g>,
    /// factor · Σ m v rᵀ
    pub flow: Matrix3<'g>,
}

/// `tr(M) 1 − M`
fn complement<'g>(m: &Matrix3<'g>) -> Matrix3<'g> {
    let mut out = m.map(|x| -x);
    for k in 0..3 {
        let (u, v) = ((k + 1) % 3, (k + 2) % 3);
        out[(k, k)] = m[(u, u)] + m[(v, v)];
    }
    out
}

/// `a bᵀ`
fn outer<'g>(a: Vector3<'g>, b: Vector3<'g>) -> Matrix3<'g> {
    Matrix3([0, 1, 2].map(|r| [0, 1, 2].map(|c| a[r] * b[c])))
}

/// `R M Rᵀ` of a symmetric matrix: 13 operations.
pub(super) fn turn_symmetric_matrix<'g>(turn: Turn<'g>, m: &Matrix3<'g>) -> Matrix3<'g> {
    let (axis, s, c) = turn;
    if s.is_right_angle() {
        return turn_matrix(turn, m);
    }
    let zero = Vector3([s.zero(); 3]);
    BodyInertia { mass: s.zero(), first_moment: zero, second_moment: *m }.turned(axis, s, c).second_moment
}

fn turn_symmetric<'g>(turn: Turn<'g>, m: &BodyInertia<'g>) -> BodyInertia<'g> {
    let (axis, s, c) = turn;
    BodyInertia {
        mass: m.mass,
        first_moment: rotate(axis, s, c, m.first_moment),
        second_moment: turn_symmetric_matrix(turn, &m.second_moment),
    }
}

/// `R M Rᵀ`: 24 operations, by the double angle on the plane that turns.
pub(super) fn turn_matrix<'g>((axis, s, c): Turn<'g>, m: &Matrix3<'g>) -> Matrix3<'g> {
    if s.is_right_angle() {
        let columns = [0, 1, 2].map(|k| rotate(axis, s, c, m.column(k)));
        return Matrix3(Matrix3::from_columns(columns).0.map(|row| rotate(axis, s, c, Vector3(row)).0));
    }
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let (ss, sc) = (s * s, s * c);
    let (difference, sum) = (m[(u, u)] - m[(v, v)], m[(u, v)] + m[(v, u)]);
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
    out
}

impl<'g> Subtree<'g> {
    /// Of one rigid body.
    pub fn rigid(moments: BodyInertia<'g>, w: Vector3<'g>, factor: f64) -> Self {
        Self {
            moments,
            momentum: w.cross(moments.first_moment.scale(w[0].constant(factor))),
            flow: w.skew() * moments.second_moment.map(|x| x * factor),
        }
    }

    /// Both together.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            moments: self.moments.plus(&other.moments),
            momentum: self.momentum + other.momentum,
            flow: self.flow + other.flow,
        }
    }

    /// In turned axes.
    pub fn turned(&self, turn: Option<Turn<'g>>) -> Self {
        let Some(turn) = turn else { return *self };
        Self {
            moments: turn_symmetric(turn, &self.moments),
            momentum: rotate(turn.0, turn.1, turn.2, self.momentum),
            flow: turn_matrix(turn, &self.flow),
        }
    }

    /// In axes turned by a constant.
    pub fn turned_constant(&self, graph: &'g Graph, rotation: &Rotation) -> Self {
        rotation.0.iter().rev().fold(*self, |body, &(axis, angle)| {
            let angle = Sym::new(graph, graph.constant(angle));
            body.turned(Some((axis, angle.sin(), angle.cos())))
        })
    }

    /// Seen from an origin from which the present one is at `arm` and moves with `velocity` (times factor).
    pub fn shifted(&self, arm: Vector3<'g>, velocity: Vector3<'g>) -> Self {
        let BodyInertia { mass, first_moment, second_moment } = self.moments;
        let moved = first_moment + arm.scale(mass);
        let half = first_moment + arm.scale(mass * 0.5);
        let second = second_moment + outer(arm, half) + outer(half, arm);
        Self {
            moments: BodyInertia { mass, first_moment: moved, second_moment: second },
            momentum: self.momentum + velocity.scale(mass),
            flow: self.flow + outer(self.momentum, arm) + outer(velocity, moved),
        }
    }

    /// Wrench that a change of the motion needs.
    pub fn response(&self, change: &Change<'g>) -> Wrench<'g> {
        let BodyInertia { mass, first_moment: l, second_moment } = self.moments;
        let force = change.acceleration.scale(mass)
            + change.angular.cross(l)
            + change.spin.cross(self.momentum)
            + change.carried.0;
        let moment = l.cross(change.acceleration)
            + complement(&second_moment) * change.angular
            + complement(&self.flow) * change.spin
            + change.carried.1;
        (force, moment)
    }

    /// The force on a joint as a linear function of a change of the whole subtree's motion: factors of
    /// `acceleration`, `angular` and `spin`. The first two are also the momentum per unit of its velocity.
    pub fn functional(&self, motion: Motion, axis: Vector3<'g>) -> [Vector3<'g>; 3] {
        let BodyInertia { mass, first_moment: l, second_moment } = self.moments;
        match motion {
            Motion::Revolute { .. } => {
                [axis.cross(l), complement(&second_moment) * axis, complement(&self.flow).transpose() * axis]
            }
            _ => [axis.scale(mass), l.cross(axis), self.momentum.cross(axis)],
        }
    }
}

/// Wrench that one rigid body needs to move.
pub(super) fn rigid_wrench<'g>(moments: &BodyInertia<'g>, motion: &Moving<'g>) -> Wrench<'g> {
    let (l, j, u) = (moments.first_moment, moments.second_moment, motion.u);
    let force = u * l + motion.a.scale(moments.mass);
    // Twice the axial vector of U J.
    let moment = |a: usize| {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        let squares = motion.w[c] * motion.w[c] - motion.w[b] * motion.w[b];
        u[(c, a)] * j[(a, b)] - u[(b, a)] * j[(a, c)] + u[(c, b)] * j[(b, b)] - u[(b, c)] * j[(c, c)]
            + squares * j[(b, c)]
    };
    (force, Vector3([0, 1, 2].map(moment)) + l.cross(motion.a))
}

/// Moments of all bodies, with J instead of L; constants are moved along the joint axes to the parents so
/// that J has no element on its joint axis (torques do not change by that).
pub(super) fn moments<'g>(model: &RobotModel<'g, '_>) -> Vec<BodyInertia<'g>> {
    let second = |body: &BodyInertia<'g>| {
        let l = body.second_moment;
        let half = (l[(0, 0)] + l[(1, 1)] + l[(2, 2)]) * 0.5;
        let mut j = l.map(|x| -x);
        for k in 0..3 {
            j[(k, k)] = half - l[(k, k)];
        }
        j
    };
    let mut out: Vec<BodyInertia<'g>> =
        model.inertias.iter().map(|b| BodyInertia { second_moment: second(b), ..*b }).collect();
    for (index, body) in model.tree.bodies.iter().enumerate().rev() {
        let (Some(parent), Motion::Revolute { axis, .. }) = (body.parent, body.motion) else { continue };
        let movable = out[index].second_moment[(axis, axis)];
        if movable.constant_value().is_none() {
            continue;
        }
        out[index].second_moment[(axis, axis)] = movable.zero();
        let direction = model.placed(&body.placement, model.along(axis, movable.constant(1.0)));
        out[parent].second_moment = out[parent].second_moment + outer(direction.scale(movable), direction);
    }
    out
}
