//! Forward recursion of angular velocity, angular acceleration and acceleration, in body frames.
use super::model::RobotModel;
use crate::expression::{Matrix3, Sym, Vector3};
use crate::tree::JointMotion;
use bipedc_runtime::Argument;

/// What moves and what stands still in a forward recursion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Motions {
    /// Velocities count (else all are zero).
    pub velocity: bool,
    /// Accelerations count.
    pub acceleration: bool,
    /// Gravity counts, as an upward acceleration of the world.
    pub gravity: bool,
}

impl Motions {
    /// Everything.
    pub const ALL: Self = Self { velocity: true, acceleration: true, gravity: true };
    /// Velocity and gravity: the bias.
    pub const NO_ACCELERATION: Self = Self { acceleration: false, ..Self::ALL };
    /// Gravity alone.
    pub const AT_REST: Self = Self { velocity: false, ..Self::NO_ACCELERATION };
}

/// Motion of one body, in its own axes.
#[derive(Debug, Clone, Copy)]
pub struct BodyMotion<'g> {
    /// Angular velocity ω.
    pub angular_velocity: Vector3<'g>,
    /// ω̇
    pub angular_acceleration: Vector3<'g>,
    /// Classical acceleration of the frame's origin, minus gravity where it counts.
    pub acceleration: Vector3<'g>,
    /// U = [ω̇]× + [ω]×[ω]×: acceleration of a point r is `acceleration + U r`.
    pub u: Matrix3<'g>,
    /// ω ωᵀ.
    pub products: Matrix3<'g>,
}

impl<'g> BodyMotion<'g> {
    fn new(w: Vector3<'g>, wd: Vector3<'g>, acceleration: Vector3<'g>) -> Self {
        let products = Matrix3([0, 1, 2].map(|r| [0, 1, 2].map(|c| w[r] * w[c])));
        let p = |r, c| products[(r, c)];
        let u = Matrix3([
            [-(p(1, 1) + p(2, 2)), p(0, 1) - wd[2], p(0, 2) + wd[1]],
            [p(0, 1) + wd[2], -(p(0, 0) + p(2, 2)), p(1, 2) - wd[0]],
            [p(0, 2) - wd[1], p(1, 2) + wd[0], -(p(0, 0) + p(1, 1))],
        ]);
        Self { angular_velocity: w, angular_acceleration: wd, acceleration, u, products }
    }
}

/// Motions of all bodies.
pub fn forward<'g>(model: &RobotModel<'g, '_>, motions: Motions) -> Vec<BodyMotion<'g>> {
    forward_each(model, motions, |_, _| ())
}

/// The same; each body is visited as soon as its motion is derived, before the next one's.
pub fn forward_each<'g>(
    model: &RobotModel<'g, '_>,
    motions: Motions,
    mut visit: impl FnMut(usize, &BodyMotion<'g>),
) -> Vec<BodyMotion<'g>> {
    let mut out: Vec<BodyMotion<'g>> = Vec::new();
    let zero = model.zero3();
    let world = BodyMotion::new(zero, zero, if motions.gravity { -model.gravity() } else { zero });
    for index in 0..model.tree.bodies.len() {
        let work = model.work(index, "motion");
        let parent = model.tree.bodies[index].parent.map_or(&world, |p| &out[p]);
        let body = step(model, motions, index, parent);
        drop(work);
        visit(index, &body);
        out.push(body);
    }
    out
}

fn step<'g>(
    model: &RobotModel<'g, '_>,
    motions: Motions,
    index: usize,
    parent: &BodyMotion<'g>,
) -> BodyMotion<'g> {
    let body = &model.tree.bodies[index];
    let rate = |argument, on: bool| -> Sym<'g> {
        let x = model.input(argument, body.v_index);
        if on { model.signed(index, x) } else { x.zero() }
    };
    if body.motion == JointMotion::Free {
        return free(model, motions, index, parent);
    }
    let carried = parent.acceleration + parent.u * model.offset(index);
    let mut w = model.down(index, parent.angular_velocity);
    let mut wd = model.down(index, parent.angular_acceleration);
    let mut acceleration = model.down(index, carried);
    let (velocity, joint_acceleration) =
        (rate(Argument::V, motions.velocity), rate(Argument::A, motions.acceleration));
    match body.motion {
        JointMotion::Revolute { axis, .. } => {
            wd = wd + w.cross(model.along(axis, velocity));
            wd[axis] = wd[axis] + joint_acceleration;
            w[axis] = w[axis] + velocity;
        }
        JointMotion::Prismatic { axis, .. } => {
            acceleration = acceleration + w.cross(model.along(axis, velocity * 2.0));
            acceleration[axis] = acceleration[axis] + joint_acceleration;
        }
        JointMotion::Free => {}
    }
    BodyMotion::new(w, wd, acceleration)
}

/// A free root: its twist components and their derivatives are inputs in its own axes.
fn free<'g>(
    model: &RobotModel<'g, '_>,
    motions: Motions,
    index: usize,
    world: &BodyMotion<'g>,
) -> BodyMotion<'g> {
    let first = model.tree.bodies[index].v_index;
    let read = |argument, on: bool, offset: usize| {
        if on { model.input3(argument, first + offset) } else { model.zero3() }
    };
    let w = read(Argument::V, motions.velocity, 3);
    let linear = read(Argument::V, motions.velocity, 0);
    let wd = read(Argument::A, motions.acceleration, 3);
    // d/dt of components in a turning frame: the classical acceleration has ω × v besides.
    let acceleration =
        read(Argument::A, motions.acceleration, 0) + w.cross(linear) + model.down(index, world.acceleration);
    BodyMotion::new(w, wd, acceleration)
}
