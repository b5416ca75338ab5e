//! Names of columns: what they may be called and what is meant by a misspelt one.
pub use bipedc_effects::diagnostic::{list, shorten};

/// What a joint's column can hold: the part of its name after the joint's name.
///
/// rad, rad/s, rad/s², N m, rad, rad (motor shaft), A; metres and newtons for prismatic joints.
pub const JOINT_QUANTITIES: [&str; 7] =
    ["position", "velocity", "acceleration", "effort", "reference", "motor_position", "motor_current"];

/// Their units for joints that turn, in this order.
const JOINT_UNITS: [&str; 7] = ["rad", "rad/s", "rad/s²", "N m", "rad", "rad", "A"];

/// A vector of the format: its name, the names of its axes, its unit.
pub type Vector = (&'static str, &'static [&'static str], &'static str);

const XYZ: &[&str] = &["x", "y", "z"];

/// Vectors of the base and of the inertial sensor; of the orientation either the quaternion or three angles.
pub const BASE_VECTORS: [Vector; 7] = [
    ("base/position", XYZ, "m"),
    ("base/orientation", &["x", "y", "z", "w"], "1"),
    ("base/orientation", &["roll", "pitch", "yaw"], "rad"),
    ("base/linear_velocity", XYZ, "m/s"),
    ("base/angular_velocity", XYZ, "rad/s"),
    ("imu/linear_acceleration", XYZ, "m/s²"),
    ("imu/angular_velocity", XYZ, "rad/s"),
];

/// Vectors of a foot or of a corner of its sole, behind its name; a centre of pressure also stands alone.
pub const FOOT_VECTORS: [Vector; 3] =
    [("force", XYZ, "N"), ("torque", XYZ, "N m"), ("cop", &["x", "y"], "m")];

/// The part of a column's name that says what it is of: `left_knee` in `left_knee/position`.
///
/// `None` for columns of the base, the inertial sensor, feet, and names that are not of this format.
/// `/before` and `/after` of an impact table are allowed for.
pub fn joint_of(column: &str) -> Option<&str> {
    let name = column.strip_suffix("/before").or_else(|| column.strip_suffix("/after")).unwrap_or(column);
    let (joint, quantity) = name.rsplit_once('/')?;
    let foreign =
        joint.is_empty() || joint.starts_with("base") && joint.len() == 4 || joint.starts_with("imu");
    (JOINT_QUANTITIES.contains(&quantity) && !foreign).then_some(joint)
}

/// Whether the name has one of the forms of the format.
pub fn is_known_form(column: &str) -> bool {
    unit(column).is_some()
}

/// The SI unit of a column, of a joint that turns; `None` if the name has no form of the format. Numbers of postures and
/// impacts have none, the parts of a quaternion have `1`.
pub fn unit(column: &str) -> Option<&'static str> {
    match column {
        "time" => return Some("s"),
        "posture" | "impact" => return Some(""),
        _ => {}
    }
    let name = column.strip_suffix("/before").or_else(|| column.strip_suffix("/after")).unwrap_or(column);
    let (vector, axis) = name.rsplit_once('/')?;
    if joint_of(column).is_some() {
        return JOINT_QUANTITIES.iter().position(|quantity| *quantity == axis).map(|k| JOINT_UNITS[k]);
    }
    let of_base = BASE_VECTORS.iter().find(|(name, axes, _)| *name == vector && axes.contains(&axis));
    if let Some((_, _, unit)) = of_base {
        // Impacts have quaternions.
        return (*unit != "rad" || name == column).then_some(*unit);
    }
    let (foot, quantity) = vector.rsplit_once('/').unwrap_or(("", vector));
    let of_foot = FOOT_VECTORS.iter().find(|(name, axes, _)| *name == quantity && axes.contains(&axis));
    let (name, _, unit) = of_foot?;
    // Without a foot a centre of pressure is that of the robot; a force without one is of nothing.
    (*name == "cop" || !foot.is_empty()).then_some(*unit)
}

/// Whether a sample may be empty or NaN: a centre of pressure does not exist without load.
pub fn may_be_absent(column: &str) -> bool {
    column.starts_with("cop/") || column.contains("/cop/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms() {
        assert_eq!(joint_of("left_knee/position"), Some("left_knee"));
        assert_eq!(joint_of("left_knee/velocity/before"), Some("left_knee"));
        assert_eq!(joint_of("base/position/x"), None);
        assert_eq!(joint_of("left_foot/force/x"), None);
        for name in ["base/orientation/w", "left_foot/heel/force/z", "cop/x", "f/cop/y", "f/torque/z"] {
            assert!(is_known_form(name), "{name}");
        }
        for name in ["left_knee/positon", "force/x", "f/cop/z", "base/orientation/v", "x"] {
            assert!(!is_known_form(name), "{name}");
        }
        for (name, expected) in [
            ("left_knee/effort", "N m"),
            ("knee/velocity/after", "rad/s"),
            ("base/orientation/yaw", "rad"),
            ("base/orientation/w", "1"),
            ("heel/torque/x", "N m"),
            ("cop/y", "m"),
        ] {
            assert_eq!(unit(name), Some(expected), "{name}");
        }
    }
}
