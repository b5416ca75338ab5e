//! A robot as logs name it, and what a log has of it.
use super::ColumnFound;
use bipedc_analysis::log::names::{JOINT_QUANTITIES, joint_of};
use bipedc_effects::diagnostic::Diagnostics;
use bipedc_effects::spelling::did_you_mean;
use serde::Serialize;

/// Names that a robot's log has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Robot {
    pub(super) name: String,
    pub(super) joints: Vec<Joint>,
    /// Places of the joints with an actuator, in the order of the torques.
    pub(super) actuated: Vec<usize>,
    feet: Vec<String>,
    /// Joints that the description holds: fixed or locked ones.
    held: Vec<String>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Joint {
    pub name: String,
    pub slides: bool,
}

impl Robot {
    /// Of a description.
    ///
    /// # Errors
    /// A robot without a tree.
    pub fn of(robot: &bipedc_compiler::Robot) -> Result<Self, Diagnostics> {
        let tree = robot.tree()?;
        let joints: Vec<Joint> = tree
            .joints
            .iter()
            .map(|joint| Joint { name: joint.name.clone(), slides: joint.prismatic })
            .collect();
        let description = &robot.description;
        let place = |name: &String| joints.iter().position(|joint| joint.name == *name);
        let actuated = description.actuated_joints.iter().filter_map(place).collect();
        let feet = description.feet.iter().map(|foot| foot.name.clone()).collect();
        let held = description.joints.iter().filter(|joint| !joint.kind.moves());
        let held = held.map(|joint| joint.name.clone()).collect();
        Ok(Self { name: description.name.clone(), joints, actuated, feet, held })
    }

    pub(super) fn names(&self) -> Vec<&str> {
        self.joints.iter().map(|joint| joint.name.as_str()).collect()
    }

    pub(super) fn slides(&self, name: &str) -> bool {
        self.joints.iter().any(|joint| joint.name == name && joint.slides)
    }
}

/// What a log has of a robot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RobotChannels {
    /// Its name.
    pub robot: String,
    /// In the order of the model.
    pub joints: Vec<JointChannels>,
    /// Joints of which the log has nothing, neither by its names nor by what is proposed.
    pub missing: Vec<String>,
    /// Joints and feet in the log that the robot does not have.
    pub unknown: Vec<Unknown>,
}

/// What a log has of a joint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct JointChannels {
    /// Its name.
    pub name: String,
    /// Quantities that stand under our names or are mapped: `position`, `effort`, …
    pub has: Vec<&'static str>,
    /// Quantities that it would have with the proposed mapping.
    pub proposed: Vec<&'static str>,
}

/// A joint or foot that the robot does not have.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Unknown {
    /// As in the log.
    pub name: String,
    /// The one that it resembles.
    pub meant: Option<String>,
    /// It is a joint of the description that does not move.
    pub held: bool,
}

impl RobotChannels {
    pub(super) fn of(robot: &Robot, columns: &[ColumnFound]) -> Self {
        let quantities = |joint: &str, name: fn(&ColumnFound) -> Option<&String>| -> Vec<&'static str> {
            let has = |quantity: &str| {
                columns.iter().filter_map(name).any(|column| {
                    column.strip_prefix(joint).and_then(|rest| rest.strip_prefix('/')) == Some(quantity)
                })
            };
            JOINT_QUANTITIES.into_iter().filter(|quantity| has(quantity)).collect()
        };
        let joints: Vec<JointChannels> = robot
            .joints
            .iter()
            .map(|joint| JointChannels {
                name: joint.name.clone(),
                has: quantities(&joint.name, |column| column.taken_as.as_ref()),
                proposed: quantities(&joint.name, |column| column.proposed.as_ref()),
            })
            .collect();
        let nothing = |joint: &&JointChannels| joint.has.is_empty() && joint.proposed.is_empty();
        let missing = joints.iter().filter(nothing).map(|joint| joint.name.clone()).collect();
        Self { robot: robot.name.clone(), missing, unknown: unknown(robot, columns), joints }
    }
}

/// Joints and feet that only the log knows.
fn unknown(robot: &Robot, columns: &[ColumnFound]) -> Vec<Unknown> {
    let mut found: Vec<Unknown> = Vec::new();
    let of_log = columns.iter().filter(|column| column.proposed.is_none());
    for name in of_log.filter_map(|column| column.taken_as.as_deref()) {
        let (owner, known): (&str, Vec<&str>) = match (joint_of(name), foot_of(name)) {
            (Some(joint), _) => (joint, robot.names()),
            (None, Some(foot)) => (foot, robot.feet.iter().map(String::as_str).collect()),
            (None, None) => continue,
        };
        if !known.contains(&owner) && !found.iter().any(|unknown| unknown.name == owner) {
            let held = robot.held.iter().any(|name| name == owner);
            let meant = if held { None } else { did_you_mean(owner, known).map(str::to_owned) };
            found.push(Unknown { name: owner.to_owned(), meant, held });
        }
    }
    found
}

/// `left_foot` in `left_foot/force/z` and `left_foot/heel/force/z`.
fn foot_of(column: &str) -> Option<&str> {
    let (vector, _) = column.rsplit_once('/')?;
    let (owner, quantity) = vector.rsplit_once('/')?;
    let foot = owner.split('/').next()?;
    (matches!(quantity, "force" | "torque" | "cop") && foot != "base").then_some(foot)
}
