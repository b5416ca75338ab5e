//! Walks on flat feet, planned: footsteps to joint motions that keep the balance and every limit (thesis 6.3.1, 8.4).
mod check;
mod kinematics;
mod legs;
mod motion;
mod page;
mod picture;
mod soles;
mod table;
mod text;
mod track;

pub use check::{Limit, Measured, Quantity};
pub use legs::Legs;

use crate::progress::Run;
use bipedc_analysis::walking::{
    Advance, Footstep, LEGS, Rest, Schedule, Sequence, Settings, Stance, Stated, Timing, distance, read_footsteps,
    read_settings,
};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use motion::Row;
use serde::Serialize;
use std::path::PathBuf;

/// How a robot keeps its balance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The centre of mass stays above the support polygon (6.43), (6.44).
    Static,
    /// The zero moment point of the whole robot follows its reference, by a bounded divergent component of motion.
    Dynamic,
    /// The linear inverted pendulum of each step alone, without double support (6.45), (6.46).
    Pendulum,
}

/// Where the robot walks.
#[derive(Debug, Clone, PartialEq)]
pub enum Path {
    /// Straight ahead: m beyond the other foot, or a part of the robot's size; so many steps.
    Forward(Option<f64>, usize),
    /// To the left: m of each pair of steps, or a part of the robot's size.
    Sideways(Option<f64>, usize),
    /// Each advance has an equal share of so many steps.
    Repeated(Vec<Advance>, usize),
    /// The same, advances per second.
    AtSpeed(Vec<Advance>, usize),
    /// A table of footsteps.
    Table(PathBuf),
}

/// What walk is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// How it keeps its balance.
    pub method: Method,
    /// Where it goes.
    pub path: Path,
    /// Numbers that are not the robot's own.
    pub stated: Stated,
}

/// A walk. As text and as JSON it is what `bipedc gait plan` prints.
pub struct Plan {
    /// The robot as it walks.
    pub legs: Legs,
    /// How it keeps its balance.
    pub method: Method,
    /// All numbers.
    pub settings: Settings,
    /// Where feet step to.
    pub footsteps: Vec<Footstep>,
    /// What happens when.
    pub schedule: Schedule,
    /// How feet stand at the beginning.
    pub start: Stance,
    /// All samples.
    rows: Vec<Row>,
    /// The nearest that each quantity comes to its limit.
    pub nearest: Vec<Measured>,
    /// The first limit that does not hold.
    pub violation: Option<Measured>,
    /// Samples at which some limit does not hold.
    pub violations: usize,
    /// Rounds in which the multi-body zero moment point was fed back.
    pub rounds: usize,
    /// Largest distance of the multi-body zero moment point from its reference, m; none of static walks.
    pub zmp_error: Option<f64>,
    /// An interruption ended it early.
    pub complete: bool,
}

/// Reads what a robot's own `walking.toml` says, beside its description; nothing if there is none.
///
/// # Errors
/// Everything in it that has no meaning.
pub fn robots_own(robot: &Robot) -> Result<(Stated, Option<PathBuf>), Diagnostics> {
    let file = robot.sources.toml_path.with_file_name("walking.toml");
    if !file.is_file() {
        return Ok((Stated::default(), None));
    }
    Ok((read_settings(&file)?, Some(file)))
}

/// Plans a walk.
///
/// # Errors
/// A robot that does not walk, footsteps that cross, postures that no joints reach: with step, joint and time. Limits that do not hold are in
/// the plan.
pub fn plan(robot: &Robot, options: &Options, run: &Run<'_>) -> Result<Plan, Diagnostics> {
    let legs = run.progress.stage("deriving", || Legs::new(robot, &options.stated))?;
    let mut settings = legs.settings;
    if options.method == Method::Static && !options.stated.states("sample") {
        settings.sample = 0.01;
    }
    let start = Stance::about(Default::default(), settings.stance_width);
    let footsteps = match &options.path {
        Path::Table(file) => read_footsteps(file)?,
        Path::Forward(stride, count) => {
            let forward = stride.unwrap_or(settings.com_height / 8.0);
            repeated(&[Advance { forward, ..Advance::default() }], *count, settings.stance_width)
        }
        Path::Sideways(side, count) => {
            let sideways = 0.5 * side.unwrap_or(settings.com_height / 10.0);
            repeated(&[Advance { sideways, ..Advance::default() }], *count, settings.stance_width)
        }
        Path::Repeated(advances, count) => repeated(advances, *count, settings.stance_width),
        Path::AtSpeed(advances, count) => {
            let time = settings.step_time;
            let step = |a: &Advance| Advance { forward: a.forward * time, sideways: a.sideways * time, turn: a.turn * time };
            repeated(&advances.iter().map(step).collect::<Vec<_>>(), *count, settings.stance_width)
        }
    };
    let place = |wrong: Diagnostic, line: Option<usize>| match (&options.path, line) {
        (Path::Table(file), Some(line)) => wrong.in_file(file).at(line, 1),
        _ => wrong,
    };
    crossing(&legs, start, &footsteps, &settings).map_err(|(wrong, line)| place(wrong, line))?;
    let schedule = schedule(options.method, start, &footsteps, &settings);
    let found = legs.follow(options.method, &schedule, &settings, run);
    let motion = found.map_err(|lost| {
        let line = schedule.phases[lost.phase].step.and_then(|step| footsteps[step].line);
        place(legs.lost(&lost, &schedule, &footsteps), line)
    })?;
    let checked = legs.check(&motion.rows, &schedule, (options.method, &settings));
    Ok(Plan {
        method: options.method,
        rows: motion.rows,
        rounds: motion.rounds,
        zmp_error: motion.zmp_error,
        complete: motion.complete,
        nearest: checked.nearest,
        violation: checked.first,
        violations: checked.count,
        legs,
        settings,
        footsteps,
        schedule,
        start,
    })
}

/// Equal shares of the steps for each advance.
fn repeated(advances: &[Advance], count: usize, width: f64) -> Vec<Footstep> {
    let of = |k: usize| advances[(k * advances.len() / count.max(1)).min(advances.len() - 1)];
    Sequence { steps: (0..count).map(of).collect(), width }.footsteps()
}

fn schedule(method: Method, start: Stance, steps: &[Footstep], of: &Settings) -> Schedule {
    let timing = |stand, shift, swing| Timing { stand, shift, swing, step_height: of.step_height };
    let sample = of.sample;
    match method {
        Method::Static => {
            let timing = timing(of.static_stand_time, of.static_shift_time, of.static_swing_time);
            Schedule::statically(start, steps, &timing, sample)
        }
        Method::Dynamic => {
            let shift = of.double_support * of.step_time;
            Schedule::dynamically(start, steps, &timing(of.stand_time, shift, of.step_time - shift), sample)
        }
        // Two samples for the change of feet, which has no duration in the thesis.
        Method::Pendulum => Schedule::dynamically(start, steps, &timing(of.stand_time, 0.0, of.step_time), sample),
    }
}

/// Samples within which a walk leaves rest and comes back to it.
fn rest(schedule: &Schedule) -> Rest {
    let samples = |phase: Option<&bipedc_analysis::walking::Phase>| {
        phase.map_or(0, |phase| (phase.duration / schedule.sample).round() as usize)
    };
    Rest { start: samples(schedule.phases.first()), end: samples(schedule.phases.last()) }
}

/// Refuses feet that are put onto or across one another.
fn crossing(
    legs: &Legs,
    start: Stance,
    steps: &[Footstep],
    settings: &Settings,
) -> Result<(), (Diagnostic, Option<usize>)> {
    let mut stance = start;
    let apart = |stance: &Stance| {
        let prints = [0, 1].map(|k| legs.footprint(k, stance.soles[k].place, stance.soles[k].yaw));
        distance(&prints[0], &prints[1])
    };
    if apart(&stance) < settings.feet_distance {
        let message = format!(
            "standing, the soles are {:.4} m apart, less than feet_distance = {:.4} m",
            apart(&stance),
            settings.feet_distance
        );
        return Err((Diagnostic::error(message).help("state a larger `stance_width` or a smaller `feet_distance`"), None));
    }
    for (k, step) in steps.iter().enumerate() {
        stance.soles[step.foot] = step.sole;
        let [right, left] = stance.soles;
        let (sine, cosine) = stance.soles[1 - step.foot].yaw.sin_cos();
        let between = [0, 1].map(|i| left.place[i] - right.place[i]);
        let across = cosine * between[1] - sine * between[0];
        let name = format!("step {} ({} foot)", k + 1, LEGS[step.foot]);
        if across <= 0.0 {
            let message = format!("{name}: the feet cross: the left one would stand {:.4} m to the right of the right one", -across);
            return Err((Diagnostic::error(message).help("let the left foot lead to the left and the right one to the right"), step.line));
        }
        let gap = apart(&stance);
        if gap < settings.feet_distance {
            let message = format!(
                "{name}: the soles would be {gap:.4} m apart, the limit `feet_distance` is {:.4} m",
                settings.feet_distance
            );
            return Err((Diagnostic::error(message).help("step less inwards, or turn less"), step.line));
        }
    }
    Ok(())
}
