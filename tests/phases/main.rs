//! Event-driven simulation: walkers whose gaits are known to many digits, violated assumptions, and time stepping beside it.
mod compass;
mod endings;
mod wheel;

use bipedc_compiler::Robot;
use bipedc_compiler::simulation::{Walker, walker};
use bipedc_runtime::simulate::phases::{Assumptions, PhasedRobot, Torque};
use std::path::Path;

/// A robot below the repository's root.
fn described(folder: &str) -> Robot {
    Robot::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).unwrap_or_else(|e| panic!("{e}"))
}

fn ready(folder: &str) -> Walker {
    walker(&described(folder)).unwrap_or_else(|e| panic!("{e}"))
}

/// With these assumptions and torques.
fn phased<'a>(walker: &'a Walker, assumptions: Assumptions, torque: Torque<'a>) -> PhasedRobot<'a> {
    let Walker { model, phases, feet, base } = walker;
    PhasedRobot::new(model, *base, feet, phases.clone(), assumptions, torque).unwrap()
}

/// No torques at all.
fn passive(_: usize, _: f64, _: &[f64], _: &[f64], _: &mut [f64]) {}
