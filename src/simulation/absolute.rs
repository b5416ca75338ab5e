//! Planar robots taken apart, for [`bipedc_analysis::simulate::FreeStepper`].
use crate::film::poses;
use bipedc_analysis::simulate::{FreeBodies, FreeLink, FreePoint, Pin};
use bipedc_compiler::tree::{BaseKind, Body, JointMotion, Tree};
use bipedc_effects::diagnostic::Diagnostic;

/// The links of a planar robot with their joints and contact points. Joints are in the order of the tree's bodies; see [`joint_order`].
///
/// # Errors
/// Another base; joints that are not revolute about y.
pub fn free_bodies(tree: &Tree) -> Result<FreeBodies, Diagnostic> {
    if tree.base != BaseKind::Planar {
        return Err(Diagnostic::error("only planar robots are taken apart").help("choose --base planar"));
    }
    let solid = links(tree);
    let index = |body: usize| solid.iter().position(|&other| other == body);
    let mut found = FreeBodies { gravity: [tree.gravity[0], tree.gravity[2]], ..FreeBodies::default() };
    for &body in &solid {
        let Body { inertia, .. } = &tree.bodies[body];
        let [x, _, z] = center(&tree.bodies[body]);
        let about_center = inertia.second_moment[1][1] - inertia.mass * (x * x + z * z);
        found.links.push(FreeLink { mass: inertia.mass, inertia: about_center });
    }
    for body in joints(tree) {
        let own = &tree.bodies[body];
        let Some(parent) = own.parent else { continue };
        let turns_in_plane = matches!(own.motion, JointMotion::Revolute { axis: 1, reversed: false });
        if !turns_in_plane || !own.placement.rotation.is_identity() {
            return Err(Diagnostic::error(format!("`{}` does not turn about y", own.joint)));
        }
        let (Some(first), Some(second)) = (index(parent), index(body)) else { continue };
        let (at, before) = (own.placement.translation, center(&tree.bodies[parent]));
        let after = center(own);
        found.pins.push(Pin {
            links: [first, second],
            anchors: [[at[0] - before[0], at[2] - before[2]], [-after[0], -after[2]]],
        });
    }
    for point in &tree.points {
        if let Some((body, link)) = point.body.and_then(|body| Some((body, index(body)?))) {
            let (at, center) = (point.placement.translation, center(&tree.bodies[body]));
            found.points.push(FreePoint { link, place: [at[0] - center[0], at[2] - center[2]] });
        }
    }
    Ok(found)
}

/// Indices into `v` of the joints, in the order of the pins.
pub fn joint_order(tree: &Tree) -> Vec<usize> {
    joints(tree).map(|body| tree.bodies[body].v_index).collect()
}

/// Coordinates of the free bodies (x, z, pitch of each centre of mass) for a configuration of the tree.
pub fn free_coordinates(tree: &Tree, q: &[f64]) -> Vec<f64> {
    let poses = poses(tree, q);
    let mut found = Vec::new();
    for body in links(tree) {
        let ([x, _, z], pose) = (center(&tree.bodies[body]), &poses[body]);
        let pitch = 2.0 * pose.orientation[1].atan2(pose.orientation[3]);
        let (s, c) = pitch.sin_cos();
        found.extend([pose.position[0] + c * x + s * z, pose.position[2] + c * z - s * x, pitch]);
    }
    found
}

/// Bodies that are links, not the base's slides.
fn links(tree: &Tree) -> Vec<usize> {
    (0..tree.bodies.len()).filter(|&body| !tree.bodies[body].is_virtual).collect()
}

/// Bodies that the robot's own joints move.
fn joints(tree: &Tree) -> impl Iterator<Item = usize> + '_ {
    (0..tree.bodies.len())
        .filter(|&body| tree.joints.iter().any(|joint| joint.v_index == tree.bodies[body].v_index))
}

fn center(body: &Body) -> [f64; 3] {
    body.inertia.first_moment.map(|moment| moment / body.inertia.mass)
}
