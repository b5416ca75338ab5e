//! What a description means where its digits end: the same robot with its nearly right angles made right.
//!
//! Numbers are always those of the description: an angle of 1.5708 rad turns by 1.5708 rad. But some answers are yes or no
//! (which parameters can be told apart, is the robot planar, can this foot move sideways), and a robot 1e-11 rad away from
//! parallel axes must not get another answer than the one that its author drew. All of these ask [`Tree::structure`].
use super::placement::{NEARLY_RIGHT, Rotation, SNAP, snap};
use super::{Placement, Tree};
use crate::description::model::{Base, Joint, Pose, RobotDescription};
use bipedc_effects::diagnostic::Diagnostic;

/// Lengths below this (m) are dust of an export: nobody means a nanometre.
const DUST: f64 = 1e-9;

impl Tree {
    /// The tree to ask about structure: nearly right angles are right in it, and lengths below 1 nm are zero. Which angles
    /// that concerns stands in [`Tree::nearly_right_angles`].
    pub fn structure(&self) -> &Self {
        self.right_angled.as_deref().unwrap_or(self)
    }

    /// Adds what [`Tree::structure`] returns, if it is another tree.
    pub(super) fn with_structure(
        mut self,
        description: &RobotDescription,
        base: &Base,
    ) -> Result<Self, Diagnostic> {
        let mut assumed = Vec::new();
        let mut other = Self::as_written(&right_angled(description, &mut assumed), base)?;
        other.straighten(&mut assumed);
        if other != self {
            other.nearly_right_angles.clone_from(&assumed);
            self.right_angled = Some(Box::new(other));
            self.nearly_right_angles = assumed;
        }
        Ok(self)
    }

    /// Angles that are nearly right only once fixed joints are taken together.
    fn straighten(&mut self, assumed: &mut Vec<(String, f64)>) {
        for body in &mut self.bodies {
            for &(_, angle) in &body.placement.rotation.0 {
                if snap(angle, NEARLY_RIGHT) != angle {
                    assumed.push((format!("joint `{}` with the fixed joints before it", body.joint), angle));
                }
            }
            straighten(&mut body.placement);
            straighten(&mut body.main_link);
        }
        for frame in self.links.iter_mut().chain(&mut self.points) {
            straighten(&mut frame.placement);
        }
    }
}

fn straighten(placement: &mut Placement) {
    placement.rotation = Rotation(placement.rotation.0.clone()).simplified(NEARLY_RIGHT);
    placement.translation = placement.translation.map(clean);
}

fn clean(x: f64) -> f64 {
    if x.abs() < DUST { 0.0 } else { x }
}

/// The description with right angles, coordinate axes and without dust.
fn right_angled(description: &RobotDescription, assumed: &mut Vec<(String, f64)>) -> RobotDescription {
    let mut out = description.clone();
    for joint in &mut out.joints {
        let name = format!("joint `{}`", joint.name);
        straighten_pose(&mut joint.origin, &name, assumed);
        straighten_axis(joint, &name, assumed);
    }
    for point in out.feet.iter_mut().flat_map(|foot| &mut foot.points) {
        point.position = point.position.map(clean);
    }
    out
}

fn straighten_pose(pose: &mut Pose, name: &str, assumed: &mut Vec<(String, f64)>) {
    pose.xyz = pose.xyz.map(clean);
    for angle in &mut pose.rpy {
        let right = snap(*angle, NEARLY_RIGHT);
        if right != *angle && snap(*angle, SNAP) == *angle {
            assumed.push((name.to_owned(), *angle));
        }
        *angle = right;
    }
}

/// An axis within 1e-4 rad of a coordinate axis, or of the plane of two.
fn straighten_axis(joint: &mut Joint, name: &str, assumed: &mut Vec<(String, f64)>) {
    let axis = joint.axis;
    let kept = axis.map(|x| if x.abs() < NEARLY_RIGHT { 0.0 } else { x });
    let off = (0..3).filter(|&k| kept[k] == 0.0).fold(0.0, |sum: f64, k| sum.hypot(axis[k]));
    let length = kept.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
    // Beyond that, two small components are a direction beside the coordinate axis, as for the frame of the digits' tree.
    if off == 0.0 || off >= NEARLY_RIGHT {
        return;
    }
    if off > SNAP {
        assumed.push((format!("axis of {name}"), off));
    }
    joint.axis = kept.map(|x| x / length);
}
