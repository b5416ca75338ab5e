//! What the URDF states of damping and friction, as effects that wait to be taken.
use super::quoted;
use crate::description::model::JointKind;
use crate::description::urdf::UrdfRobot;
use bipedc_effects::effect::{Kind, kinds};
use std::fmt::Write as _;

/// Commented out: such numbers are seldom measured (simulators like joints that are damped), and other tools leave them out
/// of the equations of motion too.
pub(super) fn write_friction(robot: &UrdfRobot, out: &mut String) {
    let joints = robot.joints.iter().zip(&robot.joint_places).filter(|(joint, _)| joint.kind.moves());
    let mut effects = String::new();
    for (joint, place) in joints {
        let slides = joint.kind == JointKind::Prismatic;
        let stated = [
            (&kinds::VISCOUS_FRICTION, place.dynamics.damping, if slides { "N s/m" } else { "N m s/rad" }),
            (&kinds::COULOMB_FRICTION, place.dynamics.friction, if slides { "N" } else { "N m" }),
        ];
        for (kind, value, unit) in stated {
            if let Some(value) = value {
                write_effect(kind, &joint.name, value, unit, &mut effects);
            }
        }
    }
    if !effects.is_empty() {
        out.push_str(
            "\n# Damping and friction that the URDF states: no part of the model unless these lines lose their `#`. Were they measured?\n",
        );
        out.push_str(&effects);
    }
}

/// The first parameter of both kinds is the one that a URDF states.
fn write_effect(kind: &Kind, joint: &str, value: f64, unit: &str, out: &mut String) {
    let parameter = kind.parameters[0].name;
    let _ = write!(
        out,
        "# [[effect]]\n# kind = {}\n# joint = {}\n# {parameter} = {value:?}   # {unit}\n",
        quoted(kind.name),
        quoted(joint)
    );
}
