//! Walks on flat feet, planned: footsteps to joint motions that keep the balance and every limit (thesis 6.3.1, 8.4).
mod check;
mod emitted;
mod kinematics;
mod legs;
mod motion;
mod onboard;
mod page;
mod picture;
mod soles;
mod table;
mod text;
mod track;

pub use check::{Limit, Measured, Quantity};
pub use emitted::controller_crate;
pub use legs::Legs;
pub use onboard::FootstepWalker;

use crate::progress::Run;
use bipedc_analysis::walking::{
    Advance, Footstep, LEGS, Rest, Schedule, Sequence, Settings, Stance, Stated, Timing, distance,
    read_footsteps, read_settings,
};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use motion::{Motion, Row};
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

/// Angles of the knees that are tried one after the other where nothing else is stated, rad: long steps want bent knees, ankles that give way little straight ones.
const BENDS: [f64; 5] = [0.7, 0.6, 0.5, 0.85, 1.0];

/// Plans a walk.
///
/// # Errors
/// A robot that does not walk, footsteps that cross, postures that no joints reach: with step, joint and time. Limits that do not hold are in
/// the plan.
pub fn plan(robot: &Robot, options: &Options, run: &Run<'_>) -> Result<Plan, Diagnostics> {
    let mut legs = run.progress.stage("deriving", || Legs::new(robot, &options.stated))?;
    let free = !options.stated.states("knee_bend") && !options.stated.states("com_height");
    let mut first = None;
    for bend in if free { &BENDS[..] } else { &BENDS[..1] } {
        if free {
            legs.bend(*bend, &options.stated);
        }
        let asked = Asked::new(&legs, options)?;
        match legs.follow(options.method, &asked.schedule, &asked.settings, run) {
            Ok(motion) => return Ok(checked(legs, options.method, asked, motion)),
            Err(lost) => {
                let line = asked.schedule.phases[lost.phase].step.and_then(|step| asked.footsteps[step].line);
                let told = legs.lost(&lost, &asked.schedule, &asked.footsteps);
                first.get_or_insert(options.place(told, line));
            }
        }
    }
    Err(Diagnostics(first.into_iter().collect()))
}

/// A motion against its limits.
fn checked(legs: Legs, method: Method, asked: Asked, motion: Motion) -> Plan {
    let Asked { settings, start, footsteps, schedule } = asked;
    let checked = legs.check(&motion.rows, &schedule, (method, &settings));
    Plan {
        method,
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
    }
}

/// What options mean for a robot.
struct Asked {
    settings: Settings,
    start: Stance,
    footsteps: Vec<Footstep>,
    schedule: Schedule,
}

impl Asked {
    fn new(legs: &Legs, options: &Options) -> Result<Self, Diagnostics> {
        let mut settings = legs.settings;
        if options.method == Method::Static && !options.stated.states("sample") {
            settings.sample = 0.01;
        }
        if let (Path::AtSpeed(advances, _), false) = (&options.path, options.stated.states("step_time")) {
            settings.step_time = cadence(legs, advances, settings.step_time);
        }
        let start = Stance::about(Default::default(), settings.stance_width);
        let ways = |advances: &[Advance], count: usize| repeated(legs, start, advances, count, &settings);
        let footsteps = match &options.path {
            Path::Table(file) => read_footsteps(file)?,
            Path::Forward(stride, count) => {
                let forward = stride.unwrap_or(settings.com_height / 12.0);
                ways(&[Advance { forward, ..Advance::default() }], *count)
            }
            Path::Sideways(side, count) => {
                let sideways = 0.5 * side.unwrap_or(settings.com_height / 15.0);
                ways(&[Advance { sideways, ..Advance::default() }], *count)
            }
            Path::Repeated(advances, count) => ways(advances, *count),
            Path::AtSpeed(advances, count) => {
                let time = settings.step_time;
                let step = |a: &Advance| Advance {
                    forward: a.forward * time,
                    sideways: a.sideways * time,
                    turn: a.turn * time,
                };
                ways(&advances.iter().map(step).collect::<Vec<_>>(), *count)
            }
        };
        let crossed = crossing(legs, start, &footsteps, &settings);
        crossed.map_err(|(wrong, line)| options.place(wrong, line))?;
        let schedule = schedule(options.method, start, &footsteps, &settings);
        Ok(Self { settings, start, footsteps, schedule })
    }
}

impl Options {
    /// With the line of the table of footsteps.
    fn place(&self, wrong: Diagnostic, line: Option<usize>) -> Diagnostic {
        match (&self.path, line) {
            (Path::Table(file), Some(line)) => wrong.in_file(file).at(line, 1),
            _ => wrong,
        }
    }
}

/// Longest step on flat feet, as a part of the leg, that default step times aim at.
const LONGEST_STEP: f64 = 0.27;

/// The time of a step: shorter where its speed would make it long.
fn cadence(legs: &Legs, advances: &[Advance], usual: f64) -> f64 {
    let fastest = advances.iter().map(|a| a.forward.abs()).fold(0.0, f64::max);
    let time = if fastest > 0.0 { LONGEST_STEP * legs.leg_length() / fastest } else { usual };
    time.clamp(0.5 * usual, usual)
}

/// Equal shares of the steps for each advance; where soles would come too near to one another, on the ground or on the way, feet step farther out.
fn repeated(
    legs: &Legs,
    start: Stance,
    advances: &[Advance],
    count: usize,
    settings: &Settings,
) -> Vec<Footstep> {
    let of = |k: usize| advances[(k * advances.len() / count.max(1)).min(advances.len() - 1)];
    let steps: Vec<Advance> = (0..count).map(of).collect();
    let even = steps.iter().all(|step| step.forward.abs() > 0.5 * legs.sole_arm());
    let mut footsteps = Sequence { steps, width: settings.stance_width, even }.footsteps();
    let mut stance = start;
    for step in &mut footsteps {
        let meant = step.sole;
        let (sine, cosine) = meant.yaw.sin_cos();
        let side = if step.foot == 0 { -1.0 } else { 1.0 };
        for tenths in 0..200 {
            let out = side * 0.0025 * settings.stance_width * f64::from(tenths);
            step.sole.place = [meant.place[0] - out * sine, meant.place[1] + out * cosine];
            if legs.nearest_on_way(&stance, step) >= 1.2 * settings.feet_distance {
                break;
            }
        }
        stance.soles[step.foot] = step.sole;
    }
    footsteps
}

impl Legs {
    /// Least distance of the soles, seen from above, while one of them steps, m.
    fn nearest_on_way(&self, stance: &Stance, step: &Footstep) -> f64 {
        let other = stance.soles[1 - step.foot];
        let standing = self.footprint(1 - step.foot, other.place, other.yaw);
        let from = stance.soles[step.foot];
        let at = |k: usize| {
            let part = k as f64 / 24.0;
            let between = |a: f64, b: f64| a + part * (b - a);
            let place = [0, 1].map(|i| between(from.place[i], step.sole.place[i]));
            distance(&standing, &self.footprint(step.foot, place, between(from.yaw, step.sole.yaw)))
        };
        // Where it leaves from was its own step's care.
        (1..=24).map(at).fold(f64::INFINITY, f64::min)
    }
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
        Method::Pendulum => {
            Schedule::dynamically(start, steps, &timing(of.stand_time, 0.0, of.step_time), sample)
        }
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
        return Err((
            Diagnostic::error(message).help("state a larger `stance_width` or a smaller `feet_distance`"),
            None,
        ));
    }
    for (k, step) in steps.iter().enumerate() {
        stance.soles[step.foot] = step.sole;
        let [right, left] = stance.soles;
        let (sine, cosine) = stance.soles[1 - step.foot].yaw.sin_cos();
        let between = [0, 1].map(|i| left.place[i] - right.place[i]);
        let across = cosine * between[1] - sine * between[0];
        let name = format!("step {} ({} foot)", k + 1, LEGS[step.foot]);
        if across <= 0.0 {
            let message = format!(
                "{name}: the feet cross: the left one would stand {:.4} m to the right of the right one",
                -across
            );
            return Err((
                Diagnostic::error(message)
                    .help("let the left foot lead to the left and the right one to the right"),
                step.line,
            ));
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
