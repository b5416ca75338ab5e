//! Forward recursion in the joint axes.
use super::axes::Axes;
use crate::derive::RobotModel;
use crate::derive::model::rotate_constant;
use crate::expression::{Matrix3, Sym, Vector3};
use crate::tree::JointMotion;
use bipedc_runtime::Argument;

/// Motion of a body in some axes.
#[derive(Clone, Copy)]
pub(super) struct Moving<'g> {
    /// Angular velocity ω.
    pub w: Vector3<'g>,
    /// ω̇
    pub wd: Vector3<'g>,
    /// Classical acceleration of the frame's origin, minus gravity.
    pub a: Vector3<'g>,
    /// U = [ω̇]× + [ω]×[ω]×
    pub u: Matrix3<'g>,
}

impl<'g> Moving<'g> {
    fn new(w: Vector3<'g>, wd: Vector3<'g>, a: Vector3<'g>) -> Self {
        let p = |r: usize, c: usize| w[r] * w[c];
        let u = Matrix3([
            [-(p(1, 1) + p(2, 2)), p(0, 1) - wd[2], p(0, 2) + wd[1]],
            [p(0, 1) + wd[2], -(p(0, 0) + p(2, 2)), p(1, 2) - wd[0]],
            [p(0, 2) - wd[1], p(1, 2) + wd[0], -(p(0, 0) + p(1, 1))],
        ]);
        Self { w, wd, a, u }
    }
}

/// A body's place and motion.
#[derive(Clone, Copy)]
pub(super) struct Link<'g> {
    /// Motion in the joint axes.
    pub joint: Moving<'g>,
    /// The same in the body's own axes.
    pub own: Moving<'g>,
    /// Origin as seen from the parent's origin. These two are in the parent's joint axes where the axes are
    /// joined, else in its own.
    pub arm: Vector3<'g>,
    /// Velocity of the origin relative to the parent's origin.
    pub arm_velocity: Vector3<'g>,
}

/// Motions of all bodies under the given accelerations, gravity as an upward acceleration of the world.
pub(super) fn forward<'g>(
    model: &RobotModel<'g, '_>,
    axes: &[Axes<'g>],
    accelerations: &[Sym<'g>],
    gravity: bool,
) -> Vec<Link<'g>> {
    let zero = model.zero3();
    let world = Moving::new(zero, zero, if gravity { -model.gravity() } else { zero });
    let mut out: Vec<Link<'g>> = Vec::new();
    for (index, body) in model.tree.bodies.iter().enumerate() {
        let _work = model.work(index, "motion");
        let hub = match body.parent {
            Some(p) if axes[index].joined => out[p].joint,
            Some(p) => out[p].own,
            None => world,
        };
        let arm = match body.parent {
            Some(p) if axes[index].joined => {
                axes[p].out(Vector3::constant(model.graph, body.placement.translation)) + slide(model, index)
            }
            Some(_) => model.offset(index),
            None => zero,
        };
        let (joint, sliding) = step(model, axes[index].joined, index, accelerations, &hub, arm);
        let turned = axes[index];
        let own =
            Moving::new(turned.into_body(joint.w), turned.into_body(joint.wd), turned.into_body(joint.a));
        out.push(Link { joint, own, arm, arm_velocity: hub.w.cross(arm) + sliding });
    }
    out
}

/// Travel of a slide along its axis.
fn slide<'g>(model: &RobotModel<'g, '_>, index: usize) -> Vector3<'g> {
    let body = &model.tree.bodies[index];
    match body.motion {
        JointMotion::Prismatic { axis, .. } => {
            model.along(axis, model.signed(index, model.input(Argument::Q, body.q_index)))
        }
        _ => model.zero3(),
    }
}

/// Motion in the joint axes, and the velocity of a slide in the hub's.
fn step<'g>(
    model: &RobotModel<'g, '_>,
    joined: bool,
    index: usize,
    accelerations: &[Sym<'g>],
    hub: &Moving<'g>,
    arm: Vector3<'g>,
) -> (Moving<'g>, Vector3<'g>) {
    let body = &model.tree.bodies[index];
    let rotation = &body.placement.rotation;
    let down = |x| if joined { x } else { rotate_constant(model.graph, &rotation.inverse(), x) };
    let up = |x| if joined { x } else { rotate_constant(model.graph, rotation, x) };
    let velocity = model.signed(index, model.input(Argument::V, body.v_index));
    let acceleration = model.signed(index, accelerations[body.v_index]);
    let still = model.zero3();
    if body.motion == JointMotion::Free {
        return (free(model, index, accelerations, hub), still);
    }
    let (mut w, mut wd) = (down(hub.w), down(hub.wd));
    let mut a = down(hub.a + hub.u * arm);
    match body.motion {
        JointMotion::Revolute { axis, .. } => {
            wd = wd + w.cross(model.along(axis, velocity));
            wd[axis] = wd[axis] + acceleration;
            w[axis] = w[axis] + velocity;
            (Moving::new(w, wd, a), still)
        }
        JointMotion::Prismatic { axis, .. } => {
            a = a + w.cross(model.along(axis, velocity * 2.0));
            a[axis] = a[axis] + acceleration;
            (Moving::new(w, wd, a), up(model.along(axis, velocity)))
        }
        JointMotion::Free => unreachable!("handled above"),
    }
}

/// A free root: its twist components and their derivatives are given in its own axes.
fn free<'g>(
    model: &RobotModel<'g, '_>,
    index: usize,
    accelerations: &[Sym<'g>],
    world: &Moving<'g>,
) -> Moving<'g> {
    let first = model.tree.bodies[index].v_index;
    let given = |offset: usize| Vector3([0, 1, 2].map(|k| accelerations[first + offset + k]));
    let linear = model.input3(Argument::V, first);
    let w = model.input3(Argument::V, first + 3);
    let a = given(0) + w.cross(linear) + model.down(index, world.a);
    Moving::new(w, given(3), a)
}
