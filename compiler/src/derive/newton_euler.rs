//! Recursive Newton–Euler in body frames: inverse dynamics, bias, gravity.
use super::kinematics::{BodyMotion, Motions, forward};
use super::model::RobotModel;
use super::{BodyInertia, frames};
use crate::expression::{Sym, Vector3};
use crate::tree::JointMotion;
use bipedc_runtime::Argument;

/// Force and moment about the frame's origin that a body needs to move as it does, in its axes.
pub fn body_wrench<'g>(body: &BodyInertia<'g>, motion: &BodyMotion<'g>) -> (Vector3<'g>, Vector3<'g>) {
    let (l, inertia) = (body.first_moment, body.second_moment);
    let (u, p, wd) = (motion.u, motion.products, motion.angular_acceleration);
    let force = u * l + motion.acceleration.scale(body.mass);
    let i = |r, c| inertia[(r, c)];
    // L ω̇ + ω × L ω, written with elements of U and of ω ωᵀ that exist already.
    let euler = Vector3([
        i(0, 0) * wd[0] + (i(2, 2) - i(1, 1)) * p[(1, 2)] - i(0, 1) * u[(2, 0)]
            + i(0, 2) * u[(1, 0)]
            + i(1, 2) * (p[(1, 1)] - p[(2, 2)]),
        i(1, 1) * wd[1] + (i(0, 0) - i(2, 2)) * p[(0, 2)] - i(1, 2) * u[(0, 1)]
            + i(0, 1) * u[(2, 1)]
            + i(0, 2) * (p[(2, 2)] - p[(0, 0)]),
        i(2, 2) * wd[2] + (i(1, 1) - i(0, 0)) * p[(0, 1)] - i(0, 2) * u[(1, 2)]
            + i(1, 2) * u[(0, 2)]
            + i(0, 1) * (p[(0, 0)] - p[(1, 1)]),
    ]);
    (force, euler + l.cross(motion.acceleration))
}

/// [`body_wrench`] of all bodies.
pub fn body_wrenches<'g>(
    model: &RobotModel<'g, '_>,
    moving: &[BodyMotion<'g>],
) -> Vec<(Vector3<'g>, Vector3<'g>)> {
    let of_body = |(index, (body, motion))| {
        let _work = model.work(index, "wrench that its motion needs");
        body_wrench(body, motion)
    };
    model.inertias.iter().zip(moving).enumerate().map(of_body).collect()
}

/// Generalised forces that `motions` need, in the order of `v`, less what external forces at the contact
/// points (world axes) contribute.
///
/// D q̈ + H − Wᵀ… of (4.6), (4.25); Newton–Euler instead of the thesis' Lagrangian, which the tests use as
/// the independent derivation.
pub fn generalised_forces<'g>(
    model: &RobotModel<'g, '_>,
    motions: Motions,
    external_forces: bool,
) -> Vec<Sym<'g>> {
    let moving = forward(model, motions);
    let mut wrenches = body_wrenches(model, &moving);
    if external_forces {
        subtract_external(model, &mut wrenches);
    }
    project(model, wrenches)
}

/// Sums wrenches from the leaves to the root and projects them onto the joints.
pub fn project<'g>(
    model: &RobotModel<'g, '_>,
    mut wrenches: Vec<(Vector3<'g>, Vector3<'g>)>,
) -> Vec<Sym<'g>> {
    let mut out = vec![model.constant(0.0); model.tree.nv];
    for (index, body) in model.tree.bodies.iter().enumerate().rev() {
        let _work = model.work(index, "wrench handed to its parent");
        let (force, moment) = wrenches[index];
        match body.motion {
            JointMotion::Free => {
                for k in 0..3 {
                    out[body.v_index + k] = force[k];
                    out[body.v_index + 3 + k] = moment[k];
                }
            }
            JointMotion::Revolute { axis, .. } => out[body.v_index] = model.signed(index, moment[axis]),
            JointMotion::Prismatic { axis, .. } => out[body.v_index] = model.signed(index, force[axis]),
        }
        if let Some(parent) = body.parent {
            let (up_force, up_moment) = (model.up(index, force), model.up(index, moment));
            let (f, n) = wrenches[parent];
            wrenches[parent] = (f + up_force, n + up_moment + model.offset(index).cross(up_force));
        }
    }
    out
}

fn subtract_external<'g>(model: &RobotModel<'g, '_>, wrenches: &mut [(Vector3<'g>, Vector3<'g>)]) {
    let poses = frames::world_poses(model);
    for (k, point) in model.tree.points.iter().enumerate() {
        let Some(body) = point.body else { continue };
        let _work = model.work(body, "external forces");
        let force = poses[body].rotation.transpose() * model.input3(Argument::Forces, 3 * k);
        let arm = Vector3::constant(model.graph, point.placement.translation);
        let (f, n) = wrenches[body];
        wrenches[body] = (f - force, n - arm.cross(force));
    }
}
