//! `[joints]`: joints of the URDF that are held where they are, for logs and controllers of a part of the robot; joints whose encoder
//! is the motor's.
use super::table::{Entry, Section};
use super::{Known, Settings};
use crate::description::geometry::{add, axis_quaternion, quaternion_product, quaternion_to_rpy, turn};
use crate::description::model::{Joint, JointDrive, JointKind};
use crate::description::source::{Messages, Place, short, suggest};
use crate::description::urdf::UrdfRobot;

/// A joint to lock: name, position (rad or m), place in the file.
type Locked<'t> = (String, f64, Place);

/// Fixes the joints that `[joints] locked` names at their positions.
pub(super) fn lock(top: &Section<'_, '_>, robot: &mut UrdfRobot, messages: &mut Messages<'_>) {
    let Some(section) = top.section("joints", messages) else { return };
    section.check_keys(&["locked", "motor_encoders"], messages);
    let Some(entry) = section.get("locked") else { return };
    for (name, position, at) in read(&entry, messages) {
        let moving = robot.joints.iter_mut().find(|joint| joint.name == name && joint.kind.moves());
        match moving {
            Some(joint) => {
                check_limits(joint, position, at, messages);
                hold(joint, position);
                robot.locked.push(name);
            }
            None => refuse(robot, &name, at, messages),
        }
    }
}

/// Joints that `[joints] motor_encoders` names, each once.
pub(super) fn read_motor_encoders(
    top: &Section<'_, '_>,
    known: Known<'_>,
    drives: &[JointDrive],
    messages: &mut Messages<'_>,
) -> Vec<String> {
    // A section that is none was told of where joints are locked.
    let section = top.get("joints").filter(Entry::is_table);
    let Some(section) = section.and_then(|entry| entry.section("[joints]".into(), messages)) else {
        return Vec::new();
    };
    let mut joints: Vec<String> = Vec::new();
    for (name, at) in section.strings("motor_encoders", messages).unwrap_or_default() {
        known.check_joint(&name, at, "`motor_encoders` in [joints]", messages);
        let driven = drives.iter().find(|driven| driven.joint == name);
        if driven.is_some_and(|driven| !driven.drive.has_motor()) {
            let message = format!(
                "`motor_encoders` in [joints]: the drive of `{}` is passive, without a motor",
                short(&name)
            );
            messages.error(at, message, "take it out of the list, or give the joint a motor in [drives]");
        }
        if !joints.contains(&name) {
            joints.push(name);
        }
    }
    joints
}

/// Takes what is said of locked joints out of the settings: nothing drives them, and nothing rubs in them.
pub(super) fn leave_out_locked(settings: &mut Settings, locked: &[String], messages: &mut Messages<'_>) {
    let is_locked = |joint: &String| locked.contains(joint);
    settings.actuated_joints.retain(|joint| !is_locked(joint));
    settings.motor_encoders.retain(|joint| !is_locked(joint));
    settings.drives.retain(|driven| !is_locked(&driven.joint));
    settings.effects.retain(|effect| {
        let place = &effect.location;
        !place.joint.iter().chain(&place.other_joint).any(is_locked)
    });
    for pair in &settings.symmetric_joints {
        if is_locked(&pair.left) != is_locked(&pair.right) {
            let message = format!(
                "[symmetry]: of `{}` and `{}` one is locked and the other moves",
                short(&pair.left),
                short(&pair.right)
            );
            messages.error(None, message, "lock both in [joints], or remove the pair");
        }
    }
    settings.symmetric_joints.retain(|pair| !is_locked(&pair.left));
}

/// Names with positions, or names alone, which are held at zero.
fn read<'t>(entry: &Entry<'t, '_>, messages: &mut Messages<'_>) -> Vec<Locked<'t>> {
    if entry.is_table() {
        let Some(table) = entry.section("`locked` in [joints]".into(), messages) else { return Vec::new() };
        let position = |joint: Entry<'_, '_>, messages: &mut Messages<'_>| {
            Some((joint.key.to_owned(), joint.number(messages)?, joint.at))
        };
        return table.entries().into_iter().filter_map(|joint| position(joint, messages)).collect();
    }
    let names = entry.strings(messages).unwrap_or_default();
    names.into_iter().map(|(name, at)| (name, 0.0, at)).collect()
}

fn refuse(robot: &UrdfRobot, name: &str, at: Place, messages: &mut Messages<'_>) {
    let moving: Vec<&str> =
        robot.joints.iter().filter(|joint| joint.kind.moves()).map(|joint| joint.name.as_str()).collect();
    let what = match robot.joints.iter().any(|joint| joint.name == name) {
        true => "does not move, or is locked twice",
        false => "is none of the URDF",
    };
    let message = format!("`locked` in [joints]: the joint `{}` {what}", short(name));
    messages.error(at, message, suggest(name, moving, "joints that move"));
}

fn check_limits(joint: &Joint, position: f64, at: Place, messages: &mut Messages<'_>) {
    let Some((low, high)) = joint.position_limits else { return };
    if !(low..=high).contains(&position) {
        let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
        let name = short(&joint.name);
        let message = format!(
            "`locked` in [joints]: `{name}` is held at {position} {unit}, its limits are {low} to {high} {unit}"
        );
        messages.warning(at, message, "positions are in rad (m at sliding joints)");
    }
}

/// Moves the frame of the joint to where the position leaves it, and fixes it there.
fn hold(joint: &mut Joint, position: f64) {
    if position != 0.0 {
        let origin = joint.origin;
        if joint.kind == JointKind::Prismatic {
            joint.origin.xyz = add(origin.xyz, turn(origin.rpy, joint.axis.map(|x| x * position)));
        } else {
            let [roll, pitch, yaw] = origin.rpy;
            let about = |axis, angle| axis_quaternion(axis, angle);
            let turned =
                [about([0.0, 1.0, 0.0], pitch), about([1.0, 0.0, 0.0], roll), about(joint.axis, position)];
            let all = turned.into_iter().fold(about([0.0, 0.0, 1.0], yaw), quaternion_product);
            joint.origin.rpy = quaternion_to_rpy(all).unwrap_or(origin.rpy);
        }
    }
    joint.kind = JointKind::Fixed;
}
