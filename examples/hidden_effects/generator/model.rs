//! Rigid-body models of robots with changed numbers, run in process.
use super::{Failure, failure, inertia};
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::description::model::RobotDescription;
use bipedc_compiler::robot::Robot;
use bipedc_effects::effect::Effect;
use bipedc_runtime::{Argument, Model, State};
use std::path::Path;

/// The compiled functions of one robot.
pub struct Rigid {
    model: ProgramModel,
    /// Joints in the order of the coordinates.
    pub joints: Vec<String>,
}

/// A function of [`Rigid`].
#[derive(Debug, Clone, Copy)]
pub struct Function {
    index: usize,
    /// Numbers that it writes.
    pub size: usize,
}

impl Rigid {
    /// Compiles functions, written `family` or `family:subject`.
    ///
    /// # Errors
    /// Unknown functions.
    pub fn new(robot: &Robot, functions: &[&str]) -> Result<Self, Failure> {
        let requests: Vec<FunctionRequest> = functions
            .iter()
            .map(|text| match text.split_once(':') {
                Some((family, subject)) => {
                    FunctionRequest { family: family.into(), subject: Some(subject.into()) }
                }
                None => FunctionRequest { family: (*text).into(), subject: None },
            })
            .collect();
        let compiled = robot.compile_only(&requests).map_err(|e| failure(e.to_string()))?;
        let tree = &compiled.tree;
        let joints: Vec<String> = tree.joints.iter().map(|joint| joint.name.clone()).collect();
        Ok(Self { model: ProgramModel::new(compiled), joints })
    }

    /// The function of this name, such as `mass_matrix` or `rotation_of_left_foot`.
    ///
    /// # Errors
    /// It was not compiled.
    pub fn function(&self, name: &str) -> Result<Function, Failure> {
        let model: &dyn Model<f64> = &self.model;
        let index = model.function(name).ok_or_else(|| failure(format!("`{name}` was not compiled")))?;
        let size = model.signature(index).map_or(0, |s| s.rows * s.columns);
        Ok(Function { index, size })
    }

    /// Columns one after the other. Arguments that the function does not take are ignored.
    pub fn run(&self, function: Function, arguments: &[(Argument, &[f64])]) -> Vec<f64> {
        let state = arguments.iter().fold(State::new(), |state, (which, values)| state.with(*which, values));
        let mut output = vec![0.0; function.size];
        let evaluator = &self.model.evaluator(function.index);
        if let Some(evaluator) = evaluator {
            evaluator.run(&state, &mut evaluator.workspace(), &mut output);
        }
        output
    }
}

/// Reads a robot of `robots/`, or of any other folder, and bolts its torso down or leaves it free.
///
/// # Errors
/// It cannot be read.
pub fn read(folder: &Path, hanging: bool) -> Result<Robot, Failure> {
    let mut robot = Robot::read(folder).map_err(|e| failure(e.to_string()))?;
    robot.description.drives.clear();
    if hanging {
        robot = robot.with_base("fixed", None).map_err(|e| failure(e.to_string()))?;
    }
    Ok(robot)
}

/// The robot with those effects that are numbers of its description.
///
/// # Errors
/// Links that do not exist.
pub fn with_effects(robot: &Robot, effects: &[Effect]) -> Result<Robot, Failure> {
    let mut changed = robot.clone();
    for effect in effects {
        inertia::apply(&mut changed.description, effect)?;
    }
    Ok(changed)
}

/// Centre of mass of a link, in its frame.
pub fn link_center(description: &RobotDescription, name: &str) -> [f64; 3] {
    let link = description.links.iter().find(|link| link.name == name);
    link.and_then(|link| link.inertial.as_ref()).map_or([0.0; 3], |inertial| inertial.origin.xyz)
}
