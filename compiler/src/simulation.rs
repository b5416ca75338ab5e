//! Robots ready for [`bipedc_runtime::simulate`]: what is built into the true model, and what a simulation knows beside it.
use crate::compile::{Wish, feet};
use crate::description::model::RobotDescription;
use crate::program::ProgramModel;
use crate::robot::Robot;
use crate::tree::{BaseKind, Tree};
use bipedc_runtime::compare::{self, Joint, Subject};
use bipedc_runtime::diagnostic::Diagnostic;
use bipedc_runtime::effect::{Effect, Law};
use bipedc_runtime::simulate::{FUNCTIONS, Plant};

/// Names, places and limits of a robot.
///
/// # Errors
/// A base that cannot be simulated.
pub fn plant(description: &RobotDescription, tree: &Tree) -> Result<Plant, Diagnostic> {
    let base = match tree.base {
        BaseKind::Floating => compare::BaseKind::Floating,
        BaseKind::Planar => compare::BaseKind::Planar,
        BaseKind::Fixed => compare::BaseKind::Fixed,
        BaseKind::Pivot => {
            return Err(Diagnostic::error(
                "a robot on a pivot is not simulated: its contact could not let go",
            )
            .help("choose another base with --base floating|planar|fixed"));
        }
    };
    let joints = tree.joints.iter();
    let joints = joints.map(|joint| Joint { name: joint.name.clone(), prismatic: joint.prismatic }).collect();
    let of_urdf = |name: &str| description.joints.iter().find(|joint| joint.name == name);
    let limits =
        |name: &str| of_urdf(name).and_then(|joint| joint.position_limits).map(|(low, high)| [low, high]);
    Ok(Plant {
        feet: feet(description),
        links: description.links.iter().map(|link| link.name.clone()).collect(),
        position_limits: tree.joints.iter().map(|joint| limits(&joint.name)).collect(),
        effort_limits: tree
            .joints
            .iter()
            .map(|j| of_urdf(&j.name).and_then(|joint| joint.effort_limit))
            .collect(),
        effects: description.effects.clone(),
        subject: Subject { joints, base },
    })
}

/// The rigid-body functions of the robot as it truly is: with those effects, of the description and hidden ones, that make
/// it another body. The simulation itself adds the others.
///
/// # Errors
/// Functions that cannot be derived.
pub fn true_model(robot: &Robot, hidden: &[Effect]) -> Result<ProgramModel, Diagnostic> {
    let mut robot = robot.clone();
    robot.description.effects.extend_from_slice(hidden);
    robot.description.effects.retain(|effect| {
        let law = effect.definition().map(|kind| kind.law);
        matches!(law, Some(Law::Payload | Law::CenterOfMassOffset | Law::InertiaError | Law::GravityTilt))
    });
    let touches = !robot.description.feet.is_empty() && robot.tree()?.base != BaseKind::Fixed;
    let functions = if touches { &FUNCTIONS[..] } else { &FUNCTIONS[..2] };
    let wish = |family: &&str| Wish { family: (*family).to_owned(), subject: None };
    let wishes: Vec<Wish> = functions.iter().map(wish).collect();
    Ok(ProgramModel::new(robot.compile_only(&wishes)?))
}
