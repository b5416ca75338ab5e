//! Composite rigid bodies: mass matrix, centre of mass with Jacobian.
use super::inertia::BodyInertia;
use super::model::RobotModel;
use crate::expression::{Sym, Vector3};
use crate::tree::JointMotion;

/// Inertia of every body together with all that hangs on it, in its own frame.
pub fn composites<'g>(model: &RobotModel<'g, '_>) -> Vec<BodyInertia<'g>> {
    let mut out = model.inertias.clone();
    for index in (0..out.len()).rev() {
        let _work = model.work(index, "sums of what it carries");
        if let Some(parent) = model.tree.bodies[index].parent {
            out[parent] = out[parent].plus(&out[index].in_parent(model, index));
        }
    }
    out
}

/// Linear and angular momentum (about the body's origin, in its axes) per unit of its joint's velocity.
pub(super) fn unit_momentum<'g>(
    model: &RobotModel<'g, '_>,
    index: usize,
    body: &BodyInertia<'g>,
) -> (Vector3<'g>, Vector3<'g>) {
    let axis = model.joint_axis(index);
    match model.tree.bodies[index].motion {
        JointMotion::Revolute { .. } => body.momentum(model.zero3(), axis),
        _ => body.momentum(axis, model.zero3()),
    }
}

/// Mass matrix `D` (4.19a), symmetric, `nv × nv`, all entries.
pub fn mass_matrix<'g>(model: &RobotModel<'g, '_>) -> Vec<Vec<Sym<'g>>> {
    let tree = model.tree;
    let composite = composites(model);
    let mut d = vec![vec![model.constant(0.0); tree.nv]; tree.nv];
    for (index, body) in tree.bodies.iter().enumerate() {
        let _work = model.work(index, "mass matrix");
        if body.motion == JointMotion::Free {
            free_block(&mut d, body.v_index, &composite[index]);
            continue;
        }
        let (mut force, mut moment) = unit_momentum(model, index, &composite[index]);
        let mut at = index;
        loop {
            for (k, x) in projections(model, at, force, moment) {
                d[k][body.v_index] = x;
                d[body.v_index][k] = x;
            }
            let Some(parent) = tree.bodies[at].parent else { break };
            force = model.up(at, force);
            moment = model.up(at, moment) + model.offset(at).cross(force);
            at = parent;
        }
    }
    d
}

/// Rows of `v` that belong to the body and what the wrench does on them.
fn projections<'g>(
    model: &RobotModel<'g, '_>,
    index: usize,
    force: Vector3<'g>,
    moment: Vector3<'g>,
) -> Vec<(usize, Sym<'g>)> {
    let body = &model.tree.bodies[index];
    match body.motion {
        JointMotion::Free => (0..3)
            .map(|k| (body.v_index + k, force[k]))
            .chain((0..3).map(|k| (body.v_index + 3 + k, moment[k])))
            .collect(),
        JointMotion::Revolute { axis, .. } => vec![(body.v_index, model.signed(index, moment[axis]))],
        JointMotion::Prismatic { axis, .. } => vec![(body.v_index, model.signed(index, force[axis]))],
    }
}

fn free_block<'g>(d: &mut [Vec<Sym<'g>>], first: usize, body: &BodyInertia<'g>) {
    let coupling = body.first_moment.skew();
    for r in 0..3 {
        d[first + r][first + r] = body.mass;
        for c in 0..3 {
            d[first + 3 + r][first + 3 + c] = body.second_moment[(r.min(c), r.max(c))];
            d[first + 3 + r][first + c] = coupling[(r, c)];
            d[first + c][first + 3 + r] = coupling[(r, c)];
        }
    }
}
