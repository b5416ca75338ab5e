//! Positions, rotations and Jacobians of links and contact points, in world axes.
use super::kinematics::{Motions, forward};
use super::model::RobotModel;
use crate::expression::{Matrix3, Sym, Vector3};
use crate::tree::{Frame, JointMotion};

/// Where a frame is.
#[derive(Debug, Clone, Copy)]
pub struct Pose<'g> {
    /// Columns are the frame's axes in the world.
    pub rotation: Matrix3<'g>,
    /// Origin in the world, m.
    pub position: Vector3<'g>,
}

/// Poses of all bodies.
pub fn world_poses<'g>(model: &RobotModel<'g, '_>) -> Vec<Pose<'g>> {
    let mut out: Vec<Pose<'g>> = Vec::new();
    for index in 0..model.tree.bodies.len() {
        let _work = model.work(index, "pose in the world");
        let columns = |parent: Option<Matrix3<'g>>| {
            let rows = match parent {
                // Row r of R_parent R_body is R_bodyᵀ applied to row r of R_parent.
                Some(rotation) => [0, 1, 2].map(|r| model.down(index, rotation.row(r)).0),
                None => Matrix3::identity(model.graph).0.map(|row| model.down(index, Vector3(row)).0),
            };
            Matrix3(rows)
        };
        let pose = match model.tree.bodies[index].parent.map(|p| out[p]) {
            Some(parent) => Pose {
                rotation: columns(Some(parent.rotation)),
                position: parent.position + parent.rotation * model.offset(index),
            },
            None => Pose { rotation: columns(None), position: model.offset(index) },
        };
        out.push(pose);
    }
    out
}

/// Pose of a link or contact point.
pub fn frame_pose<'g>(model: &RobotModel<'g, '_>, poses: &[Pose<'g>], frame: &Frame) -> Pose<'g> {
    let shift = Vector3::constant(model.graph, frame.placement.translation);
    let local = |rotation: Matrix3<'g>| {
        let inverse = frame.placement.rotation.inverse();
        Matrix3(rotation.0.map(|row| super::model::rotate_constant(model.graph, &inverse, Vector3(row)).0))
    };
    match frame.body.map(|body| poses[body]) {
        Some(body) => {
            Pose { rotation: local(body.rotation), position: body.position + body.rotation * shift }
        }
        None => Pose { rotation: local(Matrix3::identity(model.graph)), position: shift },
    }
}

/// Jacobian of a point at `position` on `body` with respect to `v`: for each column the linear and the
/// angular velocity in world axes.
pub fn jacobian<'g>(
    model: &RobotModel<'g, '_>,
    poses: &[Pose<'g>],
    body: Option<usize>,
    position: Vector3<'g>,
) -> Vec<(Vector3<'g>, Vector3<'g>)> {
    let zero = model.zero3();
    let mut columns = vec![(zero, zero); model.tree.nv];
    for index in body.into_iter().flat_map(|b| model.tree.path_to_root(b)) {
        let _work = model.work(index, "Jacobian");
        let moved = &model.tree.bodies[index];
        let pose = poses[index];
        let arm = position - pose.position;
        match moved.motion {
            JointMotion::Free => {
                for k in 0..3 {
                    let axis = pose.rotation.column(k);
                    columns[moved.v_index + k] = (axis, zero);
                    columns[moved.v_index + 3 + k] = (axis.cross(arm), axis);
                }
            }
            JointMotion::Revolute { axis, .. } => {
                let sign = model.signed(index, model.constant(1.0));
                let axis = pose.rotation.column(axis).scale(sign);
                columns[moved.v_index] = (axis.cross(arm), axis);
            }
            JointMotion::Prismatic { axis, .. } => {
                let sign = model.signed(index, model.constant(1.0));
                columns[moved.v_index] = (pose.rotation.column(axis).scale(sign), zero);
            }
        }
    }
    columns
}

/// The same of a frame at its origin, in its own axes: from the frame upward, without its pose in the world.
pub fn body_jacobian<'g>(model: &RobotModel<'g, '_>, frame: &Frame) -> Vec<(Vector3<'g>, Vector3<'g>)> {
    let (zero, unit) = (model.zero3(), |k: usize| model.along(k, model.constant(1.0)));
    let mut columns = vec![(zero, zero); model.tree.nv];
    let inverse = frame.placement.rotation.inverse();
    // Columns: axes of the body at hand in the frame's.
    let turned = [0, 1, 2].map(|k| super::model::rotate_constant(model.graph, &inverse, unit(k)));
    let mut rotation = Matrix3([0, 1, 2].map(|r| turned.map(|axis| axis[r])));
    // From the origin of the body at hand to the frame's, in the frame's axes.
    let mut arm = rotation * Vector3::constant(model.graph, frame.placement.translation);
    for index in frame.body.into_iter().flat_map(|b| model.tree.path_to_root(b)) {
        let _work = model.work(index, "Jacobian");
        let moved = &model.tree.bodies[index];
        let turning = |k: usize| (rotation.column(k).cross(arm), rotation.column(k));
        match moved.motion {
            JointMotion::Free => {
                for k in 0..3 {
                    columns[moved.v_index + k] = (rotation.column(k), zero);
                    columns[moved.v_index + 3 + k] = turning(k);
                }
            }
            JointMotion::Revolute { axis, .. } => {
                let (linear, angular) = turning(axis);
                let sign = model.signed(index, model.constant(1.0));
                columns[moved.v_index] = (linear.scale(sign), angular.scale(sign));
            }
            JointMotion::Prismatic { axis, .. } => {
                let sign = model.signed(index, model.constant(1.0));
                columns[moved.v_index] = (rotation.column(axis).scale(sign), zero);
            }
        }
        if moved.motion != JointMotion::Free {
            rotation = Matrix3(rotation.0.map(|row| model.up(index, Vector3(row)).0));
            arm = arm + rotation * model.offset(index);
        }
    }
    columns
}

/// Jacobian rate times velocity: acceleration of the point, and angular acceleration, with `a = 0`, in
/// world axes.
pub fn jacobian_rate_times_velocity<'g>(
    model: &RobotModel<'g, '_>,
    poses: &[Pose<'g>],
    frame: &Frame,
) -> [Sym<'g>; 6] {
    let zero = [model.constant(0.0); 6];
    let Some(body) = frame.body else { return zero };
    let motion = forward(model, Motions { velocity: true, acceleration: false, gravity: false })[body];
    let shift = Vector3::constant(model.graph, frame.placement.translation);
    let _work = model.work(body, "acceleration of the point");
    let linear = poses[body].rotation * (motion.acceleration + motion.u * shift);
    let angular = poses[body].rotation * motion.angular_acceleration;
    [linear[0], linear[1], linear[2], angular[0], angular[1], angular[2]]
}
