//! Scenarios that walk by a gait: its file, its controller, where the robot begins.
use super::in_world;
use crate::gait::{Assignment, GaitBench, ProgramController};
use crate::progress::Silent;
use bipedc_analysis::simulate::{GaitControl, Scenario, World};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::files::Ledger;
use std::path::Path;

/// The gait of a scenario.
#[derive(Debug, Clone)]
pub(super) struct Walker {
    bench: GaitBench,
    /// No step has begun.
    pub controller: ProgramController,
    /// Its parameters.
    values: Vec<f64>,
    /// Steps end where the gait's guard vanishes.
    guarded: bool,
}

impl Walker {
    /// Opens the gait of a scenario, if it names one, and puts the robot where its step begins, if the scenario says a speed. Where
    /// the scenario says nothing of gravity, that of the gait holds.
    ///
    /// # Errors
    /// No such gait, parameters or speeds; everything in its file that has no meaning.
    pub fn open(robot: &Robot, scenario: &mut Scenario, file: &Path) -> Result<Option<Self>, Diagnostics> {
        let Some(control) = scenario.gait.clone() else { return Ok(None) };
        // The gait knows how strong gravity is, but not that the ground slopes.
        let level = World { slope: 0.0, ..scenario.world };
        let robot = in_world(robot.clone(), &level);
        let bench = GaitBench::open(&robot, &control.name, &Silent)
            .map_err(|errors| placed(errors, file, control.position))?;
        if scenario.world.gravity.is_none() {
            scenario.world.gravity = bench.gait.gravity;
        }
        let set = known(&bench, &control, file)?;
        let values = bench.values(&set)?;
        let controller = bench.controller(control.feedback, &set)?;
        let controller = if control.limited { controller } else { controller.unlimited() };
        if let Some((speed, place)) = control.speed {
            let state = bench.beginning(&values, speed);
            let [q, v] = state.map_err(|error| error.in_file(file).at(place.0, place.1))?;
            (scenario.initial.q, scenario.initial.v, scenario.initial.clearance) = (q, v, None);
            scenario.initial.position = place;
            if let Some(events) = &mut scenario.events {
                events.given = [true; 2];
            }
        }
        Ok(Some(Self { guarded: control.guarded, bench, controller, values }))
    }

    /// Notes the gait's file.
    pub fn note(&self, ledger: &mut Ledger) {
        self.bench.note(ledger);
    }

    /// What is odd about the gait's file and about the parameters.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        self.bench.warnings.iter().cloned().chain(self.bench.beyond(&self.values, "")).collect()
    }

    /// Positive until a step ends, if the gait's guard ends it.
    pub fn ending(&self) -> Option<impl Fn(&[f64]) -> f64> {
        let guard = self.guarded.then(|| self.bench.guard(&self.values))?;
        let negative = self.controller.clone().guard_before().is_some_and(|guard| guard < 0.0);
        Some(move |q: &[f64]| if negative { -guard(q) } else { guard(q) })
    }
}

/// Errors without a place are about what the scenario says there.
fn placed(Diagnostics(errors): Diagnostics, file: &Path, (line, column): (usize, usize)) -> Diagnostics {
    let place = |error: Diagnostic| match error.file {
        Some(_) => error,
        None => error.in_file(file).at(line, column),
    };
    Diagnostics(errors.into_iter().map(place).collect())
}

/// The parameters that the scenario sets, each known to the gait.
fn known(bench: &GaitBench, control: &GaitControl, file: &Path) -> Result<Vec<Assignment>, Diagnostics> {
    let (mut found, mut wrong) = (Vec::new(), Vec::new());
    for parameter in &control.parameters {
        let one = [(parameter.name.clone(), parameter.value)];
        match bench.values(&one) {
            Ok(_) => found.extend(one),
            Err(errors) => wrong.extend(placed(errors, file, parameter.position).0),
        }
    }
    if wrong.is_empty() { Ok(found) } else { Err(Diagnostics(wrong)) }
}
