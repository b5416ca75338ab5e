//! Scenarios that walk by a gait: its file, its controller, where the robot begins.
use super::footsteps::known_robot;
use super::{in_world, true_walker, walker};
use crate::gait::choice::{ChoiceOptions, PhasedChoices, Present};
use crate::gait::{
    AnyBench, Assignment, Chain, GaitBench, Parametrised, PhasedBench, PhasedProgramController,
    ProgramController, StepOptions,
};
use crate::progress::Silent;
use bipedc_analysis::gait::ChoiceSettings;
use bipedc_analysis::simulate::{GaitControl, Scenario, Wishes, World};
use bipedc_compiler::Robot;
use bipedc_compiler::description::gait::gait_path;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::files::Ledger;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};
use std::path::Path;

/// That the foot in the air keeps off the ground along a step, which in time stepping holds it.
///
/// # Errors
/// It does not.
fn clears_the_ground(bench: &GaitBench, set: &[Assignment]) -> Result<(), Diagnostics> {
    // Heights along a step are the same at any speed.
    let options = StepOptions { speed: 1.0, set: set.to_vec(), ..StepOptions::default() };
    let Some(below) = bench.step(&options)?.step.margins.clearance.filter(|clearance| *clearance < 0.0)
    else {
        return Ok(());
    };
    let message = format!(
        "in a step of gait `{}` the foot in the air is {:.4} m below the ground: in time stepping it is held there",
        bench.gait_name(),
        -below
    );
    let help = "write method = \"event_driven\", and scuffing = false under [assumptions]; or take a gait that lifts the foot";
    Err(Diagnostic::error(message).help(help).into())
}

/// The gait of a scenario.
#[derive(Debug, Clone)]
pub(super) struct Walker {
    bench: AnyBench,
    /// No step has begun.
    pub controller: GaitDriver,
    /// Its parameters.
    values: Vec<f64>,
    /// Steps end where the gait's guard vanishes.
    guarded: bool,
    /// What is chosen for each step, and the speeds that it is chosen for.
    pub wishes: Option<Wished>,
}

/// What parameters are chosen from.
#[derive(Debug, Clone)]
pub(super) enum ChosenFrom {
    OnePhase(ChoiceSettings),
    /// With the robot as the gait knows it, in which steps are followed.
    Phased(PhasedChoices, Box<super::Walker>),
}

/// Speeds of steps, and what may be chosen to meet them.
#[derive(Debug, Clone)]
pub(super) struct Wished {
    pub from: ChosenFrom,
    /// Of the second step, the third, …, per s.
    pub speeds: Vec<f64>,
}

/// The controller of a gait of one phase or of several.
#[derive(Debug, Clone)]
pub(super) enum GaitDriver {
    OnePhase(Box<ProgramController>),
    Phased(Box<PhasedProgramController>),
}

impl Controller<f64> for GaitDriver {
    fn command(
        &mut self,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        match self {
            Self::OnePhase(controller) => controller.command(observed, commands),
            Self::Phased(controller) => controller.command(observed, commands),
        }
    }

    fn begin_phase(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        match self {
            Self::OnePhase(controller) => controller.begin_phase(observed),
            Self::Phased(controller) => controller.begin_phase(observed),
        }
    }
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
        let at = |errors: Diagnostics| placed(errors, file, control.position);
        let model =
            control.model.as_ref().map(|folder| known_robot(folder, robot)).transpose().map_err(at)?;
        // Gaits stand beside the robot, whatever its controller knows of it.
        let gait = gait_path(&robot.sources, &control.name).map_err(|error| at(error.into()))?;
        let robot = in_world(model.unwrap_or_else(|| robot.clone()), &level);
        let bench = AnyBench::open(&robot, &gait.to_string_lossy(), &Silent).map_err(at)?;
        match bench {
            AnyBench::OnePhase(bench) => Self::of_one_phase(*bench, scenario, &control, file).map(Some),
            AnyBench::Phased(bench) => Self::of_phases(&robot, *bench, scenario, (&control, file)).map(Some),
        }
    }

    fn of_one_phase(
        bench: GaitBench,
        scenario: &mut Scenario,
        control: &GaitControl,
        file: &Path,
    ) -> Result<Self, Diagnostics> {
        if scenario.world.gravity.is_none() {
            scenario.world.gravity = bench.gait.gravity;
        }
        let set = known(|one| bench.values(one).map(|_| ()), control, file)?;
        let values = bench.values(&set)?;
        if scenario.events.is_none() {
            clears_the_ground(&bench, &set).map_err(|error| placed(error, file, control.position))?;
        }
        let controller = bench.controller(control.feedback.unwrap_or_default(), &set)?;
        let controller = if control.limited { controller } else { controller.unlimited() };
        let checked = checked(scenario);
        let wished = |wishes: &Wishes| {
            bench.choosable().map_err(|error| placed(error.into(), file, wishes.position))?;
            let from =
                |options: &ChoiceOptions| bench.choice_settings(&values, options).map(ChosenFrom::OnePhase);
            wished(&bench, from, (wishes, file, checked))
        };
        let wishes = control.wishes.as_ref().map(wished).transpose()?;
        if let Some((speed, place)) = control.speed {
            let state = bench.beginning(&values, speed);
            begin_at(scenario, state.map_err(|error| error.in_file(file).at(place.0, place.1))?, place);
        }
        ends_with_wishes(scenario, wishes.as_ref());
        let controller = GaitDriver::OnePhase(Box::new(controller));
        let bench = AnyBench::OnePhase(Box::new(bench));
        Ok(Self { guarded: control.guarded.is_some(), bench, controller, values, wishes })
    }

    /// Phases end by the events of the description.
    fn of_phases(
        robot: &Robot,
        bench: PhasedBench,
        scenario: &mut Scenario,
        (control, file): (&GaitControl, &Path),
    ) -> Result<Self, Diagnostics> {
        if let Some((line, column)) = control.guarded {
            let message = "a gait of several phases has no guard: its phases end by the events of biped.toml";
            let help = "leave `step_length` out";
            return Err(Diagnostic::error(message).in_file(file).at(line, column).help(help).into());
        }
        if scenario.world.gravity.is_none() {
            scenario.world.gravity = bench.gait.gravity;
        }
        if let Some(events) = &mut scenario.events {
            events.assumptions.follows.get_or_insert(true);
        }
        let set = known(|one| bench.values(one).map(|_| ()), control, file)?;
        let values = bench.values(&set)?;
        let controller = bench.controller(control.feedback, &set)?;
        if let Some((speed, place)) = control.speed {
            let at = |error: Diagnostic| error.in_file(file).at(place.0, place.1);
            let phases = walker(robot).map_err(at)?.phases;
            let chain = Chain::new(&bench, &phases, controller.clone()).map_err(at)?;
            let state = chain.beginning(&values, speed).map_err(|refused| at(refused.into()))?;
            begin_at(scenario, state, place);
            scenario.phase = chain.first().map_err(at)?;
        }
        let checked = checked(scenario);
        let wished = |wishes: &Wishes| {
            let from = |options: &ChoiceOptions| {
                let settings = bench.choice_settings(&values, options)?;
                Ok(ChosenFrom::Phased(settings, Box::new(true_walker(robot, &[], false)?)))
            };
            wished(&bench, from, (wishes, file, checked))
        };
        let wishes = control.wishes.as_ref().map(wished).transpose()?;
        ends_with_wishes(scenario, wishes.as_ref());
        let controller = if control.limited { controller } else { controller.unlimited() };
        let controller = GaitDriver::Phased(Box::new(controller));
        let bench = AnyBench::Phased(Box::new(bench));
        Ok(Self { guarded: false, bench, controller, values, wishes })
    }

    /// Notes the gait's file.
    pub fn note(&self, ledger: &mut Ledger) {
        match &self.bench {
            AnyBench::OnePhase(bench) => bench.note(ledger),
            AnyBench::Phased(bench) => bench.note(ledger),
        }
    }

    /// What is odd about the gait's file and about the parameters.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let (warnings, beyond) = match &self.bench {
            AnyBench::OnePhase(bench) => (&bench.warnings, bench.beyond(&self.values, "")),
            AnyBench::Phased(bench) => (&bench.warnings, bench.outside(&self.values, "")),
        };
        warnings.iter().cloned().chain(beyond).collect()
    }

    /// The gait and its controller, if it has one phase.
    pub fn one_phase(&self) -> Option<(&GaitBench, &ProgramController)> {
        match (&self.bench, &self.controller) {
            (AnyBench::OnePhase(bench), GaitDriver::OnePhase(controller)) => Some((bench, controller)),
            _ => None,
        }
    }

    /// The gait and its controller, if it has several phases.
    pub fn phased(&self) -> Option<(&PhasedBench, &PhasedProgramController)> {
        match (&self.bench, &self.controller) {
            (AnyBench::Phased(bench), GaitDriver::Phased(controller)) => Some((bench, controller)),
            _ => None,
        }
    }

    /// Names of the gait's parameters.
    pub fn names(&self) -> Vec<String> {
        let parameters = match &self.bench {
            AnyBench::OnePhase(bench) => bench.parameters(),
            AnyBench::Phased(bench) => bench.parameters(),
        };
        parameters.iter().map(|parameter| parameter.name.clone()).collect()
    }

    /// Unit of its speeds.
    pub fn speed_unit(&self) -> String {
        match &self.bench {
            AnyBench::OnePhase(bench) => bench.speed_unit(),
            AnyBench::Phased(bench) => bench.speed_unit(),
        }
    }

    /// What choices keep, by name; none where they keep all that the scenario assumes, or there are none.
    pub fn kept(&self) -> Option<Vec<&'static str>> {
        let ChosenFrom::OnePhase(settings) = &self.wishes.as_ref()?.from else { return None };
        let named = settings.kept.assumptions.named();
        Some(named.into_iter().filter_map(|(name, kept)| kept.then_some(name)).collect())
    }

    /// Whether steps end where the gait's guard vanishes.
    pub fn ends_by_guard(&self) -> bool {
        self.guarded
    }

    /// Parameters at the beginning.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Positive until a step ends with the parameters that hold then, if the gait's guard ends it.
    pub fn ending(&self, present: Present) -> Option<impl Fn(&[f64]) -> f64> {
        let (bench, controller) = self.one_phase()?;
        let guard = self.guarded.then(|| bench.guard())?;
        let negative = controller.clone().guard_before().is_some_and(|guard| guard < 0.0);
        Some(move |q: &[f64]| {
            let value = guard(q, &present.borrow());
            if negative { -value } else { value }
        })
    }
}

/// Whether a walk ends where a joint meets its stop, and where a foot in the air scuffs.
fn checked(scenario: &Scenario) -> [bool; 2] {
    let scuffing = scenario.events.as_ref().is_some_and(|events| events.assumptions.scuffing.is_finite());
    [scenario.joint_stops, scuffing]
}

/// What a scenario wishes of a gait, each part of it known to the gait.
fn wished(
    gait: &impl Parametrised,
    from: impl FnOnce(&ChoiceOptions) -> Result<ChosenFrom, Diagnostics>,
    (wishes, file, [stops, scuffing]): (&Wishes, &Path, [bool; 2]),
) -> Result<Wished, Diagnostics> {
    // One by one, so that each has its place.
    let unknown = wishes.parameters.iter().filter(|found| gait.index(&found.name).is_none());
    let wrong: Vec<Diagnostic> =
        unknown.flat_map(|found| placed(gait.unknown(&found.name).into(), file, found.position).0).collect();
    if !wrong.is_empty() {
        return Err(Diagnostics(wrong));
    }
    let options = ChoiceOptions {
        parameters: wishes.parameters.iter().map(|found| (found.name.clone(), found.between)).collect(),
        keep: wishes.keep.clone(),
        stops,
        scuffing,
        friction: wishes.friction,
        reserve: wishes.reserve,
        values: wishes.values,
    };
    let from = from(&options).map_err(|errors| placed(errors, file, wishes.position))?;
    Ok(Wished { from, speeds: wishes.speeds.clone() })
}

/// A walk that says no number of steps goes on until the last one that is wished has passed its mid-stance and has landed.
fn ends_with_wishes(scenario: &mut Scenario, wishes: Option<&Wished>) {
    if let (Some(wishes), Some(events)) = (wishes, &mut scenario.events) {
        events.steps = events.steps.or(Some(wishes.speeds.len() + 1));
    }
}

/// A scenario begins in this state; `place` is where that is said.
pub(super) fn begin_at(scenario: &mut Scenario, [q, v]: [Vec<f64>; 2], place: (usize, usize)) {
    (scenario.initial.q, scenario.initial.v, scenario.initial.clearance) = (q, v, None);
    scenario.initial.position = place;
    if let Some(events) = &mut scenario.events {
        events.given = [true; 2];
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
fn known(
    allowed: impl Fn(&[Assignment]) -> Result<(), Diagnostics>,
    control: &GaitControl,
    file: &Path,
) -> Result<Vec<Assignment>, Diagnostics> {
    let (mut found, mut wrong) = (Vec::new(), Vec::new());
    for parameter in &control.parameters {
        let one = [(parameter.name.clone(), parameter.value)];
        match allowed(&one) {
            Ok(()) => found.extend(one),
            Err(errors) => wrong.extend(placed(errors, file, parameter.position).0),
        }
    }
    if wrong.is_empty() { Ok(found) } else { Err(Diagnostics(wrong)) }
}
