//! Joints by which a URDF moves a planar robot about the world: two slides and a turn without anything that weighs before them.
use crate::description::geometry::Frame;
use crate::description::model::{JointKind, Link};
use crate::description::urdf::{Tree, UrdfRobot};

/// What the base coordinates of a planar robot take the place of.
pub(super) struct BaseJoints<'r> {
    /// In the order of the tree.
    pub joints: Vec<&'r str>,
    /// The link that they carry.
    pub carried: &'r str,
}

/// The joints from the root on that carry everything, if these are two slides and a turn in the plane.
pub(super) fn base_joints<'r>(
    (robot, tree, frames): (&'r UrdfRobot, &Tree, &[Frame]),
) -> Option<BaseJoints<'r>> {
    let mut link = tree.root;
    let mut moving = Vec::new();
    while moving.len() < 3 {
        let [(joint, child)] = tree.below[link][..] else { return None };
        if robot.links[link].inertial.is_some_and(|inertial| inertial.mass > 0.0) {
            return None;
        }
        if robot.joints[joint].kind.moves() {
            moving.push((joint, frames[child].direction(robot.joints[joint].axis)));
        }
        link = child;
    }
    let slides = |&(joint, _): &(usize, [f64; 3])| robot.joints[joint].kind == JointKind::Prismatic;
    let (slides, turns): (Vec<_>, Vec<_>) = moving.iter().partition(|joint| slides(joint));
    let ([(_, a), (_, b)], [(_, turn)]) = (&slides[..], &turns[..]) else { return None };
    let in_plane = a[1].abs().max(b[1].abs()) < 1e-9 && turn[0].hypot(turn[2]) < 1e-9;
    let joints = moving.iter().map(|&(joint, _)| robot.joints[joint].name.as_str()).collect();
    let carried = robot.links[link].name.as_str();
    let apart = (a[2] * b[0] - a[0] * b[2]).abs() > 1e-3;
    (in_plane && apart).then_some(BaseJoints { joints, carried })
}

/// Whether nothing that weighs is outside of what hangs on a link: a waist called `base_to_torso` is no joint of the base.
pub(super) fn carries_all(robot: &UrdfRobot, link: &str) -> bool {
    let mut below = vec![link];
    let mut next = 0;
    while let Some(&parent) = below.get(next) {
        let children = robot.joints.iter().filter(|joint| joint.parent == parent);
        below.extend(children.map(|joint| joint.child.as_str()));
        next += 1;
    }
    let mass = |link: &Link| link.inertial.as_ref().map_or(0.0, |inertial| inertial.mass);
    let outside = robot.links.iter().filter(|link| !below.contains(&link.name.as_str()));
    // Links between the joints of a base may have a little mass, which some simulators need.
    outside.map(mass).sum::<f64>() <= 1e-3 * robot.links.iter().map(mass).sum::<f64>()
}
