//! Event-driven simulation: walkers whose gaits are known to many digits, violated assumptions, and time stepping beside it.
mod compass;
mod controllers;
mod endings;
mod five_link;
mod four_phases;
mod outputs;
mod three_link;
mod verdicts;
mod verdicts_feet;
mod wheel;

use bipedc::simulation::{Walker, driven_model, in_world, plant, true_walker, walker};
use bipedc_analysis::simulate::control::PhasedController;
use bipedc_analysis::simulate::phases::{Assumptions, PhasedRobot, WalkSummary};
use bipedc_analysis::simulate::{Mechanics, Run, Sample, Scenario, Simulation};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};
use std::path::Path;

/// A robot below the repository's root.
fn described(folder: &str) -> Robot {
    Robot::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).unwrap_or_else(|e| panic!("{e}"))
}

fn ready(folder: &str) -> Walker {
    walker(&described(folder)).unwrap_or_else(|e| panic!("{e}"))
}

/// With these assumptions and this controller.
fn phased<'a>(
    walker: &'a Walker,
    assumptions: Assumptions,
    controller: impl Controller<f64> + 'a,
) -> PhasedRobot<'a> {
    let Walker { model, phases, feet, base, .. } = walker;
    PhasedRobot::new(model, *base, feet, phases.clone(), assumptions, controller).unwrap()
}

/// No torques at all.
fn passive(_: &Observation<'_, f64>, _: &mut [JointCommand<f64>]) -> Result<(), Refusal> {
    Ok(())
}

/// A scenario file of a robot.
fn scenario_text(file: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap()
}

/// Walks a scenario from event to event; all rows as the truth was.
fn walked(folder: &str, text: &str) -> Result<(WalkSummary, Vec<Sample>), Diagnostic> {
    let robot = described(folder);
    let plant = plant(&robot.description, &robot.tree()?)?;
    let scenario =
        Scenario::parse(Path::new("scenario.toml"), text, &plant).unwrap_or_else(|e| panic!("{e}"));
    let robot = in_world(robot, &scenario.world);
    let walker = true_walker(&robot, &scenario.effects, false)?;
    let walking = walker.walking(&plant, &scenario);
    let mut samples = Vec::new();
    let mut run = Run { row: &mut |_| Ok(()), progress: &|_| (), stop: &|| false };
    let summary = walking.run(&mut run, &mut |sample| samples.push(sample.clone()))?;
    Ok((summary, samples))
}

/// The same by time stepping.
fn time_stepped(folder: &str, text: &str) -> Vec<Sample> {
    let robot = described(folder);
    let plant = plant(&robot.description, &robot.tree().unwrap()).unwrap();
    let scenario =
        Scenario::parse(Path::new("scenario.toml"), text, &plant).unwrap_or_else(|e| panic!("{e}"));
    let (model, phases) = driven_model(&robot, &scenario.effects, false).unwrap();
    let mechanics = Mechanics::new(&model, plant.layout.base).unwrap();
    let outputs = scenario.outputs.as_ref().unwrap();
    let controller = PhasedController::of_outputs(&model, &plant, &phases, outputs, scenario.phase).unwrap();
    let mut samples = Vec::new();
    let simulation = Simulation::new(mechanics, &plant, &scenario).unwrap().phased(controller);
    let mut run = Run { row: &mut |_| Ok(()), progress: &|_| (), stop: &|| false };
    simulation.watched(|sample| samples.push(sample.clone())).run(&mut run).unwrap();
    samples
}
