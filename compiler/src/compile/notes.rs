//! What a function does with the effects of a description, for its documentation.
use super::catalogue::entry;
use crate::derive::effects::JointLaws;
use crate::description::model::RobotDescription;
use bipedc_effects::effect::{Acts, Effect};

/// Where an effect shows in the equations of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum EquationPart {
    /// In a joint's torque.
    Joint,
    /// In the masses or the direction of gravity.
    Body,
    /// In the positions.
    Position,
    /// In time, in sensors or at the ground.
    Elsewhere,
}

fn part(effect: &Effect) -> EquationPart {
    match effect.kind.law.acts() {
        Acts::Torque | Acts::Reading => EquationPart::Joint,
        Acts::Body | Acts::Gravity => EquationPart::Body,
        Acts::Position => EquationPart::Position,
        Acts::Time | Acts::Transmission | Acts::Ground | Acts::Sensor | Acts::Assumption => {
            EquationPart::Elsewhere
        }
    }
}

/// Sentences; none without effects.
pub(super) fn of(description: &RobotDescription, laws: &JointLaws, function: &str) -> Vec<String> {
    let list = |parts: &[EquationPart]| {
        let chosen = description.effects.iter().filter(|effect| parts.contains(&part(effect)));
        chosen.map(ToString::to_string).collect::<Vec<_>>().join("; ")
    };
    let mut notes = Vec::new();
    let rigid = list(&[EquationPart::Body, EquationPart::Position]);
    let joints = list(&[EquationPart::Joint]);
    let mut say = |text: String| notes.push(text);
    match role(function) {
        Role::Dynamics if !(rigid.is_empty() && joints.is_empty()) => {
            let both: Vec<&str> =
                [joints.as_str(), rigid.as_str()].into_iter().filter(|x| !x.is_empty()).collect();
            say(format!("Contains the effects: {}.", both.join("; ")));
        }
        Role::Inertia if !laws.is_empty() || !rigid.is_empty() => {
            say(format!(
                "Contains the inertias of the effects, not their friction: {}.",
                list(&[EquationPart::Joint, EquationPart::Body, EquationPart::Position])
            ));
        }
        Role::Rigid => {
            if !rigid.is_empty() {
                say(format!("Contains the effects: {rigid}."));
            }
            if !joints.is_empty() && entry(function).is_ok_and(|entry| speaks_of_forces(entry.name)) {
                say(format!("Of the rigid-body model alone, without: {joints}."));
            }
        }
        _ => {}
    }
    let elsewhere = list(&[EquationPart::Elsewhere]);
    if role(function) != Role::Rigid && !elsewhere.is_empty() {
        say(format!("Not part of the instantaneous model, and not contained: {elsewhere}."));
    }
    notes
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// Every effect counts.
    Dynamics,
    /// Inertias count.
    Inertia,
    /// What acts in a joint does not count.
    Rigid,
}

fn role(function: &str) -> Role {
    match function {
        "bias" | "gravity" | "constrained_dynamics" => Role::Dynamics,
        "mass_matrix" | "mass_matrix_upper" | "impact_map" => Role::Inertia,
        name if name.contains("regressor") || name.contains("drive") => Role::Rigid,
        name if name.starts_with("inverse_dynamics") || name.starts_with("forward_dynamics") => {
            Role::Dynamics
        }
        _ => Role::Rigid,
    }
}

/// Whether somebody could expect the torques of effects in it.
fn speaks_of_forces(function: &str) -> bool {
    const FORCES: [&str; 5] = ["regressor", "coriolis", "energy", "drive", "base_parameters"];
    FORCES.iter().any(|word| function.contains(word))
}
