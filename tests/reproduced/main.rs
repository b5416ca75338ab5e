//! The thesis' experiments in simulation: what it says of the robot must hold.
#[path = "../../examples/trials/mod.rs"]
mod trials;

mod assumptions;
#[path = "../../examples/side_steps/findings.rs"]
mod findings;
#[path = "../../examples/static_walking/gait.rs"]
mod gait;
#[path = "../../examples/assumptions/levels.rs"]
#[allow(dead_code)]
mod levels;
#[path = "../../examples/assumptions/rocker.rs"]
#[allow(dead_code)]
mod rocker;
mod side_steps;
#[path = "../../examples/static_walking/findings.rs"]
#[allow(dead_code)]
mod walked;
mod walking;

use bipedc::simulation::filmed_model;
use bipedc_compiler::compile::ProgramModel;
use std::sync::LazyLock;
use trials::{Failure, Trial};

/// In process: emitted code is not optimised in tests.
static TULIP: LazyLock<ProgramModel> =
    LazyLock::new(|| filmed_model(&trials::tulip().unwrap(), &[]).unwrap_or_else(|error| panic!("{error}")));

/// A scenario of TUlip at this step (s) for so long (s), every other step logged.
fn run(scenario: &str, step: f64, duration: f64) -> Trial {
    let run: Result<Trial, Failure> = Trial::run(&trials::tulip().unwrap(), &*TULIP, scenario, |s| {
        (s.step, s.duration, s.log_every) = (step, duration, 2);
    });
    run.unwrap_or_else(|error| panic!("{error}"))
}
