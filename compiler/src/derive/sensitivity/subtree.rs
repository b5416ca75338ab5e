//! What a subtree of bodies answers to a change of its motion.
use super::axes::Turn;
use super::motion::Moving;
use super::second::Second;
use crate::derive::RobotModel;
use crate::derive::model::rotate;
use crate::expression::{Graph, Matrix3, Sym, Vector3};
use crate::tree::{JointMotion, Rotation};

/// Force, and moment about a body's origin.
pub(in crate::derive) type Wrench<'g> = (Vector3<'g>, Vector3<'g>);

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

/// Mass, first moment Σ m r, and J = Σ m r rᵀ in the place of the inertia `tr(J) 1 − J`.
#[derive(Clone, Copy)]
pub(super) struct Moments<'g> {
    pub mass: Sym<'g>,
    pub first: Vector3<'g>,
    pub second: Second<'g>,
}

impl<'g> Moments<'g> {
    /// In turned axes.
    pub fn turned(&self, turn: Option<Turn<'g>>) -> Self {
        let Some((axis, s, c)) = turn else { return *self };
        Self {
            mass: self.mass,
            first: rotate(axis, s, c, self.first),
            second: self.second.turned((axis, s, c)),
        }
    }
}

/// Sums over all bodies of a subtree; r and v(r) = ṙ from the origin, in any axes, not turning.
#[derive(Clone, Copy)]
pub(super) struct Subtree<'g> {
    pub moments: Moments<'g>,
    /// factor · Σ m v
    pub momentum: Vector3<'g>,
    /// factor · Σ m v rᵀ
    pub flow: Second<'g>,
}

impl<'g> Subtree<'g> {
    /// Of one rigid body.
    pub fn rigid(moments: Moments<'g>, w: Vector3<'g>, factor: f64) -> Self {
        Self {
            moments,
            momentum: w.cross(moments.first.scale(moments.mass.constant(factor))),
            flow: moments.second.scaled(factor).crossed(w),
        }
    }

    /// Both together.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            moments: Moments {
                mass: self.moments.mass + other.moments.mass,
                first: self.moments.first + other.moments.first,
                second: self.moments.second.plus(&other.moments.second),
            },
            momentum: self.momentum + other.momentum,
            flow: self.flow.plus(&other.flow),
        }
    }

    /// In turned axes.
    pub fn turned(&self, turn: Option<Turn<'g>>) -> Self {
        let Some((axis, s, c)) = turn else { return *self };
        Self {
            moments: self.moments.turned(turn),
            momentum: rotate(axis, s, c, self.momentum),
            flow: self.flow.turned((axis, s, c)),
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
        let Moments { mass, first, second } = self.moments;
        let moved = first + arm.scale(mass);
        let half = first + arm.scale(mass * 0.5);
        Self {
            moments: Moments { mass, first: moved, second: second.plus_symmetric(arm, half) },
            momentum: self.momentum + velocity.scale(mass),
            flow: self.flow.plus_outer(self.momentum, arm).plus_outer(velocity, moved),
        }
    }

    /// Wrench that a change of the motion needs.
    pub fn response(&self, change: &Change<'g>) -> Wrench<'g> {
        let Moments { mass, first: l, second } = self.moments;
        let force = change.acceleration.scale(mass)
            + change.angular.cross(l)
            + change.spin.cross(self.momentum)
            + change.carried.0;
        let moment = l.cross(change.acceleration)
            + second.complement() * change.angular
            + self.flow.complement() * change.spin
            + change.carried.1;
        (force, moment)
    }

    /// The force on a joint as a linear function of a change of the whole subtree's motion: factors of
    /// `acceleration`, `angular` and `spin`. The first two are also the momentum per unit of its velocity.
    pub fn functional(&self, motion: JointMotion, axis: Vector3<'g>) -> [Vector3<'g>; 3] {
        let Moments { mass, first: l, second } = self.moments;
        match motion {
            JointMotion::Revolute { .. } => {
                [axis.cross(l), second.complement() * axis, self.flow.complement().transpose() * axis]
            }
            _ => [axis.scale(mass), l.cross(axis), self.momentum.cross(axis)],
        }
    }
}

/// Wrench that one rigid body needs to move.
pub(super) fn rigid_wrench<'g>(moments: &Moments<'g>, motion: &Moving<'g>) -> Wrench<'g> {
    let (l, j, u, w) = (moments.first, moments.second.m, motion.u, motion.w);
    let force = u * l + motion.a.scale(moments.mass);
    // Twice the axial vector of U J; where both elements of the diagonal count, through L ω̇ instead.
    let moment = |a: usize| {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        let diagonal = if j[(b, b)].is_zero() || j[(c, c)].is_zero() {
            u[(c, b)] * j[(b, b)] - u[(b, c)] * j[(c, c)]
        } else {
            moments.second.polar[a] * motion.wd[a] + moments.second.difference(b, c) * (w[b] * w[c])
        };
        let squares = w[c] * w[c] - w[b] * w[b];
        diagonal + u[(c, a)] * j[(a, b)] - u[(b, a)] * j[(a, c)] + squares * j[(b, c)]
    };
    (force, Vector3([0, 1, 2].map(moment)) + l.cross(motion.a))
}

/// Moments of all bodies, with J instead of L; constants are moved along the joint axes to the parents so
/// that J has no element on its joint axis (torques do not change by that).
pub(super) fn moments<'g>(model: &RobotModel<'g, '_>) -> Vec<Moments<'g>> {
    let second = |l: Matrix3<'g>| {
        let half = (l[(0, 0)] + l[(1, 1)] + l[(2, 2)]) * 0.5;
        let mut m = l.map(|x| -x);
        for k in 0..3 {
            m[(k, k)] = half - l[(k, k)];
        }
        Second { m, polar: Vector3([0, 1, 2].map(|k| l[(k, k)])) }
    };
    let mut out: Vec<Moments<'g>> = model
        .inertias
        .iter()
        .map(|b| Moments { mass: b.mass, first: b.first_moment, second: second(b.second_moment) })
        .collect();
    for (index, body) in model.tree.bodies.iter().enumerate().rev() {
        let (Some(parent), JointMotion::Revolute { axis, .. }) = (body.parent, body.motion) else { continue };
        let movable = out[index].second.m[(axis, axis)];
        if movable.constant_value().is_none() {
            continue;
        }
        let mut kept = out[index].second.m;
        kept[(axis, axis)] = movable.zero();
        out[index].second = Second::new(kept);
        let direction = model.placed(&body.placement, model.along(axis, movable.constant(1.0)));
        let sum = out[parent].second.plus_outer(direction.scale(movable), direction);
        out[parent].second = sum;
    }
    out
}
