//! Left and right: which joints mirror each other at the x-z plane, and with which sign.
use super::Known;
use super::table::Section;
use crate::description::geometry::{Frame, norm, subtract};
use crate::description::model::{JointKind, SymmetricPair};
use crate::description::source::{Messages, Place, short};
use crate::description::urdf::UrdfRobot;
use std::collections::HashSet;

/// How far axes may be from mirror images of each other.
const AXIS_TOLERANCE: f64 = 1e-3;

pub(super) fn read_symmetry(
    top: &Section<'_, '_>,
    known: Known<'_>,
    messages: &mut Messages<'_>,
) -> Vec<SymmetricPair> {
    let Some(section) = top.section("symmetry", messages) else { return Vec::new() };
    section.check_keys(&["joints"], messages);
    let frames = known.frames();
    let mut pairs = Vec::new();
    let mut used = HashSet::new();
    for mut pair in section.sections("joints", messages) {
        pair.title = "the pairs of [symmetry]".into();
        pair.check_keys(&["left", "right", "sign"], messages);
        let mut joint = |key| {
            let Some((name, at)) = pair.string(key, messages) else {
                if !pair.has(key) {
                    let message = format!("a pair of [symmetry] has no `{key}`");
                    messages.error(pair.at, message, "write { left = \"…\", right = \"…\", sign = 1 }");
                }
                return None;
            };
            known.check_joint(&name, at, "[symmetry]", messages);
            if !used.insert(name.clone()) {
                let message = format!("[symmetry]: joint `{}` stands in two pairs", short(&name));
                messages.error(at, message, "each joint has one mirror image");
            }
            Some(name)
        };
        let (Some(left), Some(right)) = (joint("left"), joint("right")) else { continue };
        let sign = read_sign(&pair, [&left, &right], known, &frames, messages);
        pairs.push(SymmetricPair { left, right, sign });
    }
    pairs
}

fn read_sign(
    pair: &Section<'_, '_>,
    joints: [&str; 2],
    known: Known<'_>,
    frames: &[Frame],
    messages: &mut Messages<'_>,
) -> f64 {
    let derived = known.robot.and_then(|robot| mirror_sign(robot, frames, joints[0], joints[1]));
    let at: Place = pair.get("sign").and_then(|entry| entry.at);
    let [left, right] = joints.map(short);
    match (pair.number("sign", messages), derived) {
        (Some(sign), _) if sign.abs() != 1.0 => {
            let message = format!("[symmetry]: the sign of `{left}` and `{right}` is {sign}");
            messages.error(at, message, "write 1 (pitch joints) or -1 (roll and yaw joints)");
            1.0
        }
        (Some(sign), Some(derived)) if sign != derived => {
            let message = format!(
                "[symmetry]: sign = {sign} for `{left}` and `{right}`, but their axes mirror each other with {derived}"
            );
            messages.warning(at, message, format!("write sign = {derived}, or leave it out"));
            sign
        }
        (Some(sign), _) => sign,
        (None, Some(derived)) => derived,
        (None, None) => {
            if known.robot.is_some_and(|robot| robot.tree.is_some()) && !pair.has("sign") {
                let message =
                    format!("[symmetry]: `{left}` and `{right}` do not mirror each other at zero posture");
                messages.error(pair.at, message, "state sign = 1 or -1, or remove the pair");
            }
            1.0
        }
    }
}

/// +1 or −1 if the joints' axes are mirror images at the x-z plane of the root link at zero posture.
pub(crate) fn mirror_sign(robot: &UrdfRobot, frames: &[Frame], left: &str, right: &str) -> Option<f64> {
    let tree = robot.tree.as_ref()?;
    let find = |name: &str| {
        tree.below.iter().flatten().find(|&&(joint, _)| robot.joints[joint].name == name).copied()
    };
    let (left, right) = (find(left)?, find(right)?);
    let kinds = [left, right].map(|(joint, _)| robot.joints[joint].kind == JointKind::Prismatic);
    if kinds[0] != kinds[1] {
        return None;
    }
    let axis = |(joint, child): (usize, usize)| frames[child].direction(robot.joints[joint].axis);
    let [x, y, z] = axis(left);
    // A direction of rotation is a pseudovector: the mirror keeps its y and turns x and z around.
    let mirrored = if kinds[0] { [x, -y, z] } else { [-x, y, -z] };
    let right = axis(right);
    if norm(subtract(right, mirrored)) < AXIS_TOLERANCE {
        Some(1.0)
    } else if norm(subtract(right, mirrored.map(|component| -component))) < AXIS_TOLERANCE {
        Some(-1.0)
    } else {
        None
    }
}
