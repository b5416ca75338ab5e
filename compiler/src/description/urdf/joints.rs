//! One joint: its kind, axis and limits.
use super::elements::JointPlaces;
use crate::description::geometry::{norm, scale};
use crate::description::model::{Joint, JointKind};
use crate::description::source::{Messages, Place, short, suggest};
use std::f64::consts::FRAC_PI_2;

const KINDS: [&str; 6] = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar"];

/// How far an axis may be from unit length before it is worth a warning (text has few digits).
const AXIS_TOLERANCE: f64 = 1e-3;

/// The typed joint, checked; what is refused is reported and replaced by something harmless.
pub(super) fn convert_joint(
    places: &JointPlaces,
    typed: &urdf_rs::Joint,
    messages: &mut Messages<'_>,
) -> Joint {
    let kind = joint_kind(places, messages);
    let limited = matches!(kind, JointKind::Revolute | JointKind::Prismatic) && places.has_range;
    let joint = Joint {
        name: places.name.clone(),
        kind,
        parent: places.parent.as_ref().map_or_else(String::new, |(name, _)| name.clone()),
        child: places.child.as_ref().map_or_else(String::new, |(name, _)| name.clone()),
        origin: super::pose(&typed.origin),
        axis: if kind.moves() { unit_axis(places, typed.axis.xyz.0, messages) } else { [1.0, 0.0, 0.0] },
        position_limits: limited.then_some((typed.limit.lower, typed.limit.upper)),
        velocity_limit: Some(typed.limit.velocity).filter(|&limit| limit > 0.0),
        effort_limit: Some(typed.limit.effort).filter(|&limit| limit > 0.0),
    };
    check_limits(&joint, typed, places, messages);
    check_mimic(&joint, places, messages);
    joint
}

fn joint_kind(places: &JointPlaces, messages: &mut Messages<'_>) -> JointKind {
    let (name, written) = (short(&places.name), places.kind.as_str());
    match written {
        "revolute" => return JointKind::Revolute,
        "continuous" => return JointKind::Continuous,
        "prismatic" => return JointKind::Prismatic,
        "fixed" => return JointKind::Fixed,
        "floating" => messages.error(
            places.at,
            format!("joint `{name}`: joints of type `floating` are not supported"),
            "remove the joint (and the link `world` above it) and write `kind = \"floating\"` under [base] in biped.toml",
        ),
        "planar" => messages.error(
            places.at,
            format!("joint `{name}`: joints of type `planar` are not supported"),
            "for a planar robot remove the joint and write `kind = \"planar\"` under [base] in biped.toml; \
             otherwise use two prismatic joints and a revolute one",
        ),
        "" => messages.error(
            places.at,
            format!("joint `{name}` has no type"),
            format!("write type=\"…\": {}", KINDS[..4].join(", ")),
        ),
        _ => messages.error(
            places.at,
            format!("joint `{name}`: unknown type `{}`", short(written)),
            suggest(written, KINDS, "types"),
        ),
    }
    JointKind::Fixed
}

fn unit_axis(places: &JointPlaces, axis: [f64; 3], messages: &mut Messages<'_>) -> [f64; 3] {
    let name = short(&places.name);
    let place = places.axis.or(places.at);
    let largest = axis.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
    if largest == 0.0 {
        messages.error(
            place,
            format!("joint `{name}`: the axis is zero"),
            "write the direction of motion, such as <axis xyz=\"0 1 0\"/>",
        );
        return [1.0, 0.0, 0.0];
    }
    let scaled = axis.map(|x| x / largest);
    let length = norm(scaled) * largest;
    if (length - 1.0).abs() > AXIS_TOLERANCE {
        messages.warning(
            place,
            format!("joint `{name}`: the axis has length {length:.6}, it is normalised"),
            "write a unit vector",
        );
    }
    // Exact axes must stay exact: 1/|a| of a unit vector such as (0.6, 0.8, 0) may round away from 1.
    if (length - 1.0).abs() <= 4.0 * f64::EPSILON { axis } else { scale(scaled, 1.0 / norm(scaled)) }
}

fn check_limits(joint: &Joint, typed: &urdf_rs::Joint, places: &JointPlaces, messages: &mut Messages<'_>) {
    let name = short(&joint.name);
    if let Some((lower, upper)) = joint.position_limits
        && lower > upper
    {
        messages.error(
            places.limit,
            format!("joint `{name}`: the limits are reversed: lower = {lower} is above upper = {upper}"),
            "exchange them",
        );
    }
    for (limit, value) in [("effort", typed.limit.effort), ("velocity", typed.limit.velocity)] {
        if value < 0.0 {
            messages.warning(
                places.limit,
                format!("joint `{name}`: the {limit} limit {value} is negative and ignored"),
                "write a positive number",
            );
        }
    }
    if places.kind == "revolute" && places.limit.is_none() {
        messages.warning(
            places.at,
            format!("joint `{name}` is revolute but has no <limit>; it is taken as unlimited"),
            "add <limit lower=\"…\" upper=\"…\" effort=\"…\" velocity=\"…\"/> or use type=\"continuous\"",
        );
    }
}

fn check_mimic(joint: &Joint, places: &JointPlaces, messages: &mut Messages<'_>) {
    if places.mimic.is_some() && places.kind == "fixed" {
        messages.warning(
            places.mimic,
            format!("joint `{}` is fixed; its <mimic> is ignored", short(&joint.name)),
            "remove the <mimic>",
        );
    }
}

/// A joint that moves as another one does, with its place; the description may lock it.
pub(crate) type Follower = (String, Place);

/// Errors for followers that the description lets move.
pub(crate) fn refuse_followers<'f>(
    followers: impl Iterator<Item = &'f Follower>,
    messages: &mut Messages<'_>,
) {
    for (name, place) in followers {
        let name = short(name);
        messages.error(
            *place,
            format!("joint `{name}`: moving joints that <mimic> another are not supported"),
            format!(
                "lock it in biped.toml (`[joints]`, `locked = [\"{name}\"]`; `bipedc init` writes that), or remove <mimic> and let it move by itself"
            ),
        );
    }
}

/// Smallest deviation from a multiple of π/2 that is not just rounding of eight or more digits.
const ANGLE_ROUNDING: f64 = 1e-8;
/// Largest deviation that looks like a rounded multiple of π/2.
const ANGLE_SUSPECT: f64 = 1e-4;

/// Which of the angles looks like a rounded multiple of π/2, and by how much: a sentence and advice.
pub(super) fn odd_angle(rpy: [f64; 3]) -> Option<(String, String)> {
    ["roll", "pitch", "yaw"].into_iter().zip(rpy).find_map(|(name, angle)| {
        let meant = (angle / FRAC_PI_2).round() * FRAC_PI_2;
        let deviation = (angle - meant).abs();
        // Adding zero turns the -0 of a small negative angle into 0.
        let help = format!("write {:?} if that was meant; the value is used as it stands", meant + 0.0);
        (deviation > ANGLE_ROUNDING && deviation < ANGLE_SUSPECT)
            .then(|| (format!("{name} {angle} is {deviation:.1e} rad away from a multiple of π/2"), help))
    })
}
