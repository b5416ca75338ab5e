//! Actuated joints and what drives them.
use super::Known;
use super::table::Section;
use crate::description::model::JointDrive;
use crate::description::source::{Messages, short, suggest};
use bipedc_effects::drive::{Drive, Transmission};
use std::collections::HashSet;

const KINDS: [&str; 3] = ["stiff", "series_elastic", "passive"];
/// Keys of every motor.
const MOTOR: [&str; 8] = [
    "kind",
    "gear_ratio",
    "rotor_inertia",
    "torque_constant",
    "viscous_friction",
    "coulomb_friction",
    "motor_encoder_counts",
    "joint_encoder_counts",
];
const SERIES_ELASTIC: [&str; 3] = ["motor_pulley_radius", "load_pulley_radius", "spring_stiffness"];
const PASSIVE: [&str; 4] = ["kind", "stiffness", "damping", "joint_encoder_counts"];

pub(super) fn read_drives(
    top: &Section<'_, '_>,
    known: Known<'_>,
    messages: &mut Messages<'_>,
) -> Vec<JointDrive> {
    let Some(section) = top.section("drives", messages) else { return Vec::new() };
    let mut drives = Vec::new();
    for entry in section.entries() {
        known.check_joint(entry.key, entry.at, "[drives]", messages);
        if let Some(section) = entry.section(format!("[drives.{}]", short(entry.key)), messages) {
            let joint = entry.key.to_string();
            drives.extend(read_drive(&section, messages).map(|drive| JointDrive { joint, drive }));
        }
    }
    drives
}

fn read_drive(section: &Section<'_, '_>, messages: &mut Messages<'_>) -> Option<Drive> {
    let transmission = read_transmission(section, messages)?;
    let gear_ratio = read_gear_ratio(section, messages);
    let mut optional = |key| not_negative(section, key, messages);
    // A constant or a number of counts of zero says as much as none.
    let positive = |value: &f64| *value > 0.0;
    Some(Drive {
        transmission,
        gear_ratio,
        rotor_inertia: optional("rotor_inertia").unwrap_or(0.0),
        torque_constant: optional("torque_constant").filter(positive),
        viscous_friction: optional("viscous_friction").unwrap_or(0.0),
        coulomb_friction: optional("coulomb_friction").unwrap_or(0.0),
        motor_encoder_counts: optional("motor_encoder_counts").filter(positive),
        joint_encoder_counts: optional("joint_encoder_counts").filter(positive),
    })
}

/// The transmission; also checks that the keys belong to it.
fn read_transmission(section: &Section<'_, '_>, messages: &mut Messages<'_>) -> Option<Transmission> {
    let kind = section.string("kind", messages);
    let (kind, at) = kind.as_ref().map_or(("stiff", section.at), |(kind, at)| (kind.as_str(), *at));
    match kind {
        "stiff" => {
            section.check_keys(&MOTOR, messages);
            Some(Transmission::Stiff)
        }
        "series_elastic" => {
            section.check_keys(&[&MOTOR[..], &SERIES_ELASTIC].concat(), messages);
            let mut needed = |key| required(section, key, messages);
            Some(Transmission::SeriesElastic {
                motor_pulley_radius: needed("motor_pulley_radius"),
                load_pulley_radius: needed("load_pulley_radius"),
                spring_stiffness: needed("spring_stiffness"),
            })
        }
        "passive" => {
            section.check_keys(&PASSIVE, messages);
            let mut optional = |key| not_negative(section, key, messages).unwrap_or(0.0);
            Some(Transmission::Passive { stiffness: optional("stiffness"), damping: optional("damping") })
        }
        other => {
            let message = format!("`kind` in {}: unknown drive \"{}\"", section.title, short(other));
            messages.error(at, message, suggest(other, KINDS, "drives"));
            None
        }
    }
}

/// Negative ratios turn the motor the other way; zero has no meaning.
fn read_gear_ratio(section: &Section<'_, '_>, messages: &mut Messages<'_>) -> f64 {
    let Some(entry) = section.get("gear_ratio") else { return 1.0 };
    match entry.number(messages) {
        Some(0.0) => {
            messages.error(
                entry.at,
                format!("{} is zero", entry.name()),
                "write motor turns per output turn",
            );
            1.0
        }
        Some(ratio) => ratio,
        None => 1.0,
    }
}

fn not_negative(section: &Section<'_, '_>, key: &'static str, messages: &mut Messages<'_>) -> Option<f64> {
    let entry = section.get(key)?;
    let value = entry.number(messages)?;
    if value < 0.0 {
        messages.error(entry.at, format!("{} is negative: {value}", entry.name()), "write zero or more");
        return None;
    }
    Some(value)
}

fn required(section: &Section<'_, '_>, key: &'static str, messages: &mut Messages<'_>) -> f64 {
    if !section.has(key) {
        let message = format!("{} is series elastic but has no `{key}`", section.title);
        messages.error(section.at, message, format!("add `{key} = …` (radii in m, stiffness in N/m)"));
        return 1.0;
    }
    match not_negative(section, key, messages) {
        Some(0.0) => {
            let entry = section.get(key);
            let message = format!("`{key}` in {} is zero", section.title);
            messages.error(entry.and_then(|entry| entry.at), message, "write a positive number");
            1.0
        }
        value => value.unwrap_or(1.0),
    }
}

/// The joints with an actuator: as stated, else all that move and have no passive drive.
pub(super) fn read_actuation(
    top: &Section<'_, '_>,
    known: Known<'_>,
    drives: &[JointDrive],
    messages: &mut Messages<'_>,
) -> Vec<String> {
    let passive =
        |joint: &str| drives.iter().any(|driven| driven.joint == joint && !driven.drive.has_motor());
    let stated = top.section("actuation", messages).and_then(|section| {
        section.check_keys(&["joints"], messages);
        section.strings("joints", messages)
    });
    let Some(stated) = stated else {
        let joints = known.robot.map_or(&[][..], |robot| &robot.joints[..]).iter();
        let moving = joints.filter(|joint| joint.kind.moves() && !passive(&joint.name));
        return moving.map(|joint| joint.name.clone()).collect();
    };
    let mut seen = HashSet::new();
    for (name, at) in &stated {
        known.check_joint(name, *at, "[actuation]", messages);
        if !seen.insert(name) {
            let message = format!("[actuation]: joint `{}` stands there twice", short(name));
            messages.error(*at, message, "remove one");
        }
        if passive(name) {
            let message = format!("[actuation]: joint `{}` has a passive drive", short(name));
            messages.error(*at, message, "remove it here, or change `kind` under [drives]");
        }
    }
    stated.into_iter().map(|(name, _)| name).collect()
}
