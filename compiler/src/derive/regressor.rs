//! Regressor of the inverse dynamics, one column after the other: Newton–Euler with one parameter 1 and the others 0.
//!
//! A column is the wrench that this parameter needs, carried from its body to the root. Joints in a row whose axes are parallel
//! turn it once, by the sum of their angles, and moments about their axes need no turn at all. For the one wrench per body of
//! inverse dynamics that is no gain, for ten columns it is.
use super::inertia::unit;
use super::kinematics::forward_each;
use super::model::{rotate, rotate_constant};
use super::newton_euler::body_wrench;
use super::shared_columns::share;
use super::{Motions, RobotModel};
use crate::expression::{Sym, Vector3};
use crate::tree::JointMotion;

/// Force and moment.
type Wrench<'g> = (Vector3<'g>, Vector3<'g>);

/// Columns of the regressor: ten for each body, rows in the order of `v`.
pub fn inverse_dynamics<'g>(model: &RobotModel<'g, '_>) -> Vec<Vec<Sym<'g>>> {
    let tree = model.tree;
    let turns = turns(model);
    let mut columns = vec![vec![model.constant(0.0); tree.nv]; 10 * tree.bodies.len()];
    forward_each(model, Motions::ALL, |index, motion| {
        if tree.bodies[index].is_virtual {
            return;
        }
        for parameter in 0..10 {
            let _work = model.work(index, "wrench of a unit parameter");
            let wrench = body_wrench(&unit(model.graph, tree, index, parameter), motion);
            carry(model, &turns, index, wrench, &mut columns[10 * index + parameter]);
        }
        share(model, index, &mut columns, true);
    });
    columns
}

/// Projects the wrench of a body (its axes, about its origin) onto all joints from there to the root.
fn carry<'g>(
    model: &RobotModel<'g, '_>,
    turns: &[Option<Turn<'g>>],
    body: usize,
    (mut force, mut moment): Wrench<'g>,
    column: &mut [Sym<'g>],
) {
    // Whether the wrench is in the axes that its row of parallel joints has where all its angles are 0.
    let mut in_row = false;
    for index in model.tree.path_to_root(body) {
        let body = &model.tree.bodies[index];
        match (body.motion, turns[index]) {
            (JointMotion::Free, _) => {
                column[body.v_index..][..3].copy_from_slice(&force.0);
                column[body.v_index + 3..][..3].copy_from_slice(&moment.0);
            }
            (JointMotion::Revolute { axis, .. }, turn) => {
                if let (Some((s, c)), false) = (turn, in_row) {
                    (force, moment) = (rotate(axis, s, c, force), rotate(axis, s, c, moment));
                }
                column[body.v_index] = model.signed(index, moment[axis]);
            }
            (JointMotion::Prismatic { axis, .. }, _) => {
                column[body.v_index] = model.signed(index, force[axis]);
            }
        }
        let Some(parent) = body.parent else { continue };
        in_row = false;
        let mut arm = model.offset(index);
        if let (Some(axis), Some((s, c))) = (row_before(model, index), turns[parent]) {
            in_row = true;
            arm = rotate(axis, s, c, arm);
        } else {
            let placed = |x| rotate_constant(model.graph, &body.placement.rotation, x);
            (force, moment) = (placed(force), placed(moment));
        }
        moment = moment + arm.cross(force);
    }
}

/// The axis that a body's joint has in common with its parent's, if they are parallel.
fn row_before(model: &RobotModel<'_, '_>, index: usize) -> Option<usize> {
    let body = &model.tree.bodies[index];
    let parent = &model.tree.bodies[body.parent?];
    match (body.motion, parent.motion) {
        (JointMotion::Revolute { axis, .. }, JointMotion::Revolute { axis: before, .. })
            if axis == before && body.placement.rotation.is_identity() =>
        {
            Some(axis)
        }
        _ => None,
    }
}

/// Sine and cosine.
type Turn<'g> = (Sym<'g>, Sym<'g>);

/// Of each revolute joint's angle, in rows of parallel axes of the sum of all from the first one on.
fn turns<'g>(model: &RobotModel<'g, '_>) -> Vec<Option<Turn<'g>>> {
    let mut turns: Vec<Option<Turn<'g>>> = Vec::new();
    for (index, body) in model.tree.bodies.iter().enumerate() {
        let _work = model.work(index, "turn by parallel axes");
        let own = matches!(body.motion, JointMotion::Revolute { .. }).then(|| model.sin_cos(index));
        let before = row_before(model, index).and(body.parent).and_then(|parent| turns[parent]);
        turns.push(match (own, before) {
            (Some((s, c)), Some((sum_s, sum_c))) => Some((sum_s * c + sum_c * s, sum_c * c - sum_s * s)),
            (own, _) => own,
        });
    }
    turns
}
