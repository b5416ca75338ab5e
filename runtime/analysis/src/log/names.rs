//! Names of columns: what they may be called and what is meant by a misspelt one.
pub use bipedc_effects::diagnostic::{list, shorten};

/// What a joint's column can hold: the part of its name after the joint's name.
///
/// rad, rad/s, rad/s², N m, rad, rad (motor shaft), A; metres and newtons for prismatic joints.
pub const JOINT_QUANTITIES: [&str; 7] =
    ["position", "velocity", "acceleration", "effort", "reference", "motor_position", "motor_current"];

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
    if matches!(column, "time" | "posture" | "impact")
        || matches!(column, "base/orientation/roll" | "base/orientation/pitch" | "base/orientation/yaw")
        || joint_of(column).is_some()
    {
        return true;
    }
    let name = column.strip_suffix("/before").or_else(|| column.strip_suffix("/after")).unwrap_or(column);
    let Some((vector, axis)) = name.rsplit_once('/') else { return false };
    let of_axis = matches!(axis, "x" | "y" | "z");
    match vector {
        "base/orientation" => of_axis || axis == "w",
        "base/position" | "base/linear_velocity" | "base/angular_velocity" => of_axis,
        "imu/linear_acceleration" | "imu/angular_velocity" => of_axis,
        _ => {
            let quantity = vector.rsplit_once('/').map_or(vector, |(_, last)| last);
            matches!(quantity, "force" | "torque") && vector.contains('/') && of_axis
                || quantity == "cop" && matches!(axis, "x" | "y")
        }
    }
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
    }
}
