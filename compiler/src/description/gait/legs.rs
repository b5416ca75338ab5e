//! Legs of a robot that walks in the plane: which joints they have, and which way these bend.
use super::form::{DoubleSupport, Walker};
use super::joint_names::JointNames;
use crate::description::geometry::{Frame, Vector, norm, subtract};
use crate::description::model::{Foot, Joint, JointKind, RobotDescription};
use bipedc_effects::diagnostic::Diagnostic;

impl<'d> Walker<'d> {
    pub(super) fn foot(&self, name: &str) -> Result<&'d Foot, Diagnostic> {
        let found = self.of.feet.iter().find(|foot| foot.name == name);
        found.ok_or_else(|| Diagnostic::error(format!("the robot has no foot `{name}`")))
    }

    /// Moving joints from the root to a foot's link.
    pub(super) fn chain(&self, foot: &Foot) -> Vec<&'d Joint> {
        let mut found = Vec::new();
        let mut link = foot.link.as_str();
        while let Some(joint) = self.of.joints.iter().find(|joint| joint.child == link) {
            if joint.kind.moves() {
                found.push(joint);
            }
            link = &joint.parent;
        }
        found.reverse();
        found
    }

    /// The joints of a foot that no other foot hangs on.
    pub(super) fn leg(&self, foot: &Foot) -> Vec<&'d Joint> {
        let others: Vec<&str> = (self.of.feet.iter().filter(|other| other.name != foot.name))
            .flat_map(|other| self.chain(other))
            .map(|joint| joint.name.as_str())
            .collect();
        self.chain(foot).into_iter().filter(|joint| !others.contains(&joint.name.as_str())).collect()
    }

    pub(super) fn frame(&self, link: &str) -> Frame {
        self.frames.iter().find(|(name, _)| *name == link).map_or(Frame::IDENTITY, |found| found.1)
    }

    /// The joints of a leg between its first one and a sole, those that turn.
    fn inner(&self, foot: &Foot) -> Vec<&'d Joint> {
        let leg = self.leg(foot);
        let last = leg.len() - usize::from(foot.points.len() > 1 && !leg.is_empty());
        let turns = |joint: &&Joint| joint.kind != JointKind::Prismatic;
        leg.get(1..last).unwrap_or(&[]).iter().copied().filter(turns).collect()
    }

    /// Whether a leg is bent at a joint while all joints are at zero.
    fn is_bent(&self, foot: &Foot, joint: &Joint) -> bool {
        let leg = self.leg(foot);
        let place = |joint: &Joint| self.frame(&joint.child).position;
        let at = leg.iter().position(|other| other.name == joint.name).unwrap_or(0);
        let Some(before) = at.checked_sub(1).map(|before| place(leg[before])) else { return false };
        let end = |point: Vector| self.frame(&foot.link).point(point);
        let behind = leg.get(at + 1).map(|next| place(next));
        let Some(behind) = behind.or_else(|| foot.points.first().map(|point| end(point.position))) else {
            return false;
        };
        let [upper, lower] = [subtract(place(joint), before), subtract(behind, place(joint))];
        let cross = upper[2] * lower[0] - upper[0] * lower[2];
        let flat = |v: Vector| norm([v[0], 0.0, v[2]]);
        cross.abs() > STRAIGHT * flat(upper) * flat(lower)
    }

    /// The way of a knee ahead, as people's.
    fn ahead(&self, joint: &Joint) -> f64 {
        self.frame(&joint.child).direction(joint.axis)[1].signum()
    }
}

/// Sine of the angle up to which a leg counts as straight.
const STRAIGHT: f64 = 0.1;

/// Knees of legs that are straight with all joints at zero, each with the way in which it bends: 1 or −1, by its limits; the first of a leg, where these do not
/// tell, ahead as people's.
pub fn knees(of: &RobotDescription) -> Vec<(&str, f64)> {
    let robot = walker(of);
    let mut found = Vec::new();
    for foot in &of.feet {
        for (k, joint) in robot.inner(foot).into_iter().enumerate() {
            let way = bending(joint).or_else(|| (k == 0).then(|| robot.ahead(joint)));
            found.extend(way.filter(|_| !robot.is_bent(foot, joint)).map(|way| (joint.name.as_str(), way)));
        }
    }
    found
}

fn walker(of: &RobotDescription) -> Walker<'_> {
    Walker { of, double: DoubleSupport::default(), frames: frames(of), names: JointNames::default() }
}

/// 1 or −1: the way in which a joint bends, by the side on which most of its range is; none where that is not clear, or where it slides.
pub(super) fn bending(joint: &Joint) -> Option<f64> {
    let (lower, upper) = joint.position_limits.filter(|_| joint.kind != JointKind::Prismatic)?;
    let middle = 0.5 * (lower + upper);
    (middle.abs() > 0.25 * (upper - lower)).then(|| middle.signum())
}

/// Height of the hips above the feet, all joints at zero, m.
pub fn hip_height(of: &RobotDescription) -> f64 {
    walker(of).height()
}

/// A good walking speed to begin with, a fifth of √(g · leg length), in two digits, m/s.
pub fn usual_speed(of: &RobotDescription) -> f64 {
    let speed = 0.2 * (norm(of.gravity) * hip_height(of)).sqrt();
    format!("{speed:.1e}").parse().unwrap_or(speed)
}

/// Frames of all links in that of the root link, all joints at zero.
pub(super) fn frames(of: &RobotDescription) -> Vec<(&str, Frame)> {
    let mut found = vec![(of.root_link.as_str(), Frame::IDENTITY)];
    let mut next = 0;
    while let Some(&(link, frame)) = found.get(next) {
        let below = of.joints.iter().filter(|joint| joint.parent == link);
        found.extend(below.map(|joint| (joint.child.as_str(), frame.compose(&Frame::of(&joint.origin)))));
        next += 1;
    }
    found
}
