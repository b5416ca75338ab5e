//! A gait that was found, tried under its own controller, and what it lacks then.
use super::Workbench;
use crate::gait::Parametrised as _;
use crate::gait::optimise::Optimum;
use crate::gait::{
    AnyBench, Chain, ChainOptions, ChainedPhase, CycleOptions, GaitBench, PhasedBench, StepOptions,
};
use crate::progress::Silent;
use crate::simulation::{Trial, WalkedMargins};
use bipedc_analysis::gait::Margins;
use bipedc_compiler::compile::Collocation;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use serde::Serialize;
use std::path::Path;

/// A written gait under its own controller.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ClosedLoop {
    /// Whether steps repeat themselves, deviations shrink, and the ground holds what a walk of the whole robot asks of it.
    pub walks: bool,
    /// Why not.
    pub reason: Option<String>,
    /// φ̇ at the dead centre of every step, per s.
    pub speed: Option<f64>,
    /// Unit of that speed, for people.
    #[serde(skip)]
    pub speed_unit: String,
    /// What is left of a small deviation after a step.
    pub multiplier: Option<f64>,
    /// Mean walking speed, m/s.
    pub walking_speed: Option<f64>,
    /// Of a step, s.
    pub duration: Option<f64>,
    /// ∫ Σ \|τ q̇\| dt of a step over weight and distance, 1.
    pub cost_of_transport: Option<f64>,
    /// Of each phase, what the motion says and what the step under the controller does; empty where a step is one phase, or none repeats itself.
    pub phases: Vec<PhaseCourses>,
    /// Of the walk of the whole robot; none where steps do not repeat themselves.
    pub margins: Option<WalkedMargins>,
}

/// A phase of a step that repeats itself.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhaseCourses {
    /// As the gait calls it.
    pub name: String,
    /// At the nodes.
    pub motion: PhaseCourse,
    /// Under the controller.
    pub walked: PhaseCourse,
}

/// How φ goes through a phase.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PhaseCourse {
    /// s
    pub duration: f64,
    /// φ where the phase begins.
    pub phi_start: f64,
    /// φ where it ends.
    pub phi_end: f64,
    /// φ̇ where it begins, per s.
    pub speed_start: f64,
    /// φ̇ where it ends, per s.
    pub speed_end: f64,
}

impl PhaseCourses {
    /// Of a phase of the motion, by index, and the same phase walked.
    fn new((of, optimum): (&Collocation, &Optimum), p: usize, walked: &ChainedPhase) -> Self {
        let [phi_start, phi_end] = optimum.ends(p);
        let motion = PhaseCourse {
            duration: optimum.durations()[p],
            phi_start,
            phi_end,
            speed_start: optimum.rate(of, p, 0),
            speed_end: optimum.last_rate(of, p),
        };
        let walked = PhaseCourse {
            duration: walked.duration,
            phi_start: walked.phi_start,
            phi_end: walked.phi_end,
            speed_start: walked.speed_start,
            speed_end: walked.speed_end,
        };
        Self { name: of.phases[p].name.clone(), motion, walked }
    }
}

/// What is tried.
pub(super) struct Tried<'a> {
    /// Of the form.
    pub file: &'a Path,
    /// Of the gait file.
    pub text: &'a str,
    pub of: &'a Collocation,
    pub optimum: &'a Optimum,
    /// Coulomb's coefficient of the ground.
    pub friction: f64,
}

/// A step that repeats itself.
struct Repeated {
    speed: f64,
    multiplier: f64,
    duration: f64,
    cost_of_transport: Option<f64>,
    /// Of a step of several phases.
    phases: Vec<ChainedPhase>,
    /// Of such a step, at all instants of its integration and its phases' ends; and the coefficient of friction that it was held against.
    margins: Option<(Margins, Option<f64>)>,
}

/// Steps until they repeat themselves.
const STEPS: usize = 14;

impl Workbench {
    /// What the written gait does: steps on its zero dynamics until they repeat themselves, then a walk of the whole robot.
    pub(super) fn tried(&self, trial: &Trial, it: &Tried<'_>) -> ClosedLoop {
        let failed = |why: &Diagnostics| {
            why.0.first().map_or_else(|| "it is not known why".to_owned(), |first| first.message.clone())
        };
        let file = it.file.with_file_name("found.toml");
        let mut found = ClosedLoop::default();
        let read = AnyBench::parse(&self.robot, &file, it.text, &Silent);
        let repeated = read.and_then(|bench| {
            let step = match &bench {
                AnyBench::OnePhase(bench) => self.cycle(bench)?,
                AnyBench::Phased(bench) => repeating(bench, trial, it.optimum.slowest_rate(it.of, 0))?,
            };
            Ok((step, bench))
        });
        let (step, bench) = match repeated {
            Ok(found) => found,
            Err(why) => {
                found.reason = Some(failed(&why));
                return found;
            }
        };
        found.speed_unit = match &bench {
            AnyBench::OnePhase(bench) => bench.speed_unit(),
            AnyBench::Phased(bench) => bench.speed_unit(),
        };
        (found.speed, found.multiplier) = (Some(step.speed), Some(step.multiplier));
        (found.duration, found.cost_of_transport) = (Some(step.duration), step.cost_of_transport);
        let courses = |(p, phase)| PhaseCourses::new((it.of, it.optimum), p, phase);
        found.phases = step.phases.iter().enumerate().map(courses).collect();
        if step.multiplier.abs() >= 1.0 {
            found.reason = Some("deviations grow from step to step".to_owned());
            return found;
        }
        match trial.walk((&bench, it.of), (step.speed, step.duration), (it.friction, &file)) {
            Ok(mut margins) => {
                // What rises until a phase ends lies between the walk's samples.
                if let Some((of_step, friction)) = &step.margins {
                    margins.no_better_than(of_step, *friction);
                }
                found.reason.clone_from(&margins.verdict);
                found.walks = margins.verdict.is_none();
                found.walking_speed = margins.walking_speed;
                found.margins = Some(margins);
            }
            Err(why) => found.reason = Some(failed(&why)),
        }
        found
    }

    fn cycle(&self, bench: &GaitBench) -> Result<Repeated, Diagnostics> {
        let cycles = bench.cycles(&CycleOptions::default(), &self.run())?;
        let of = cycles.cycles.first().ok_or_else(|| Diagnostic::error("no cycle was computed"))?;
        let Some(cycle) = of.cycle else {
            return Err(Diagnostic::error(of.reason.clone().unwrap_or_default()).into());
        };
        let step = bench.step(&StepOptions { speed: cycle.speed, ..StepOptions::default() })?;
        if let Some(reason) = step.step.reason {
            return Err(Diagnostic::error(reason.to_string()).into());
        }
        Ok(Repeated {
            speed: cycle.speed,
            multiplier: cycle.multiplier,
            duration: cycle.duration,
            cost_of_transport: Some(cycle.cost_of_transport),
            phases: Vec::new(),
            margins: None,
        })
    }
}

/// Steps that repeat themselves, with the speed, the multiplier and the cost of `bipedc gait cycle`: from posture to posture, or where these do not settle, each from the posture
/// of a step at its speed.
fn repeating(bench: &PhasedBench, trial: &Trial, near: f64) -> Result<Repeated, Diagnostics> {
    let chain = Chain::new(bench, &trial.walker().phases, bench.controller(None, &[])?)?;
    let values = bench.values(&[])?;
    let (start, multiplier) = match chain.repeating(&values, Some(near)) {
        Ok(found) => found,
        Err(_) => {
            let found = repeated_near(bench, trial, near)?;
            let Ok(settled) = chain.repeating(&values, Some(found.speed)) else { return Ok(found) };
            settled
        }
    };
    let cost_of_transport = chain.cost_of_transport(&start, &values).ok();
    Ok(Repeated { multiplier, cost_of_transport, ..step_at(bench, trial, start.speed)? })
}

/// Parts of the motion's speed that steps are begun with, one after the other: where they repeat themselves is not known before.
const BEGINNINGS: [f64; 4] = [1.0, 1.1, 1.25, 0.9];

/// Steps that repeat themselves, begun near a speed.
fn repeated_near(bench: &PhasedBench, trial: &Trial, speed: f64) -> Result<Repeated, Diagnostics> {
    let found = repeated(bench, trial, BEGINNINGS[0] * speed);
    BEGINNINGS[1..].iter().fold(found, |found, part| {
        found.or_else(|first| {
            // What the motion's own speed came to is told, if none does.
            repeated(bench, trial, part * speed).map_err(|_| first)
        })
    })
}

/// The fixed point of the map from the speed of a step to that of the next, by the secant method.
fn repeated(bench: &PhasedBench, trial: &Trial, begin: f64) -> Result<Repeated, Diagnostics> {
    let chain = Chain::new(bench, &trial.walker().phases, bench.controller(None, &[])?)?;
    let values = bench.values(&[])?;
    // As a step has it: what else a step has takes many times as long, and is asked of the last one alone.
    let after = |speed: f64| -> Result<f64, Diagnostics> {
        let next = chain.hop(&chain.mid_stance(&values, speed)?, &values).next;
        next.map(|next| next.speed).map_err(|why| Diagnostic::error(why.to_string()).into())
    };
    let mut speed = begin;
    let mut next = after(speed)?;
    let mut slope: Option<f64> = None;
    for _ in 0..STEPS {
        let off = next - speed;
        if off.abs() < 1e-7 * speed && slope.is_some() {
            break;
        }
        // Where nothing is known of the slope: a step further, as the robot itself would go on.
        let by = match slope {
            Some(slope) if slope < 0.98 => off / (1.0 - slope),
            _ if off.abs() > 1e-5 * speed => off,
            _ => 1e-4 * speed,
        };
        let to = speed + by.clamp(-0.2 * speed, 0.2 * speed);
        let found = after(to)?;
        slope = Some((found - next) / (to - speed));
        (speed, next) = (to, found);
    }
    let multiplier = slope.unwrap_or(f64::NAN);
    if (next - speed).abs() > 1e-4 * speed {
        return Err(Diagnostic::error(format!("steps do not repeat themselves within {STEPS}")).into());
    }
    Ok(Repeated { multiplier, ..step_at(bench, trial, speed)? })
}

/// A step at the speed that repeats itself, with everything that it comes close to.
fn step_at(bench: &PhasedBench, trial: &Trial, speed: f64) -> Result<Repeated, Diagnostics> {
    let last = bench.step(&trial.walker().phases, &ChainOptions { speed, ..ChainOptions::default() })?;
    if let Some(reason) = last.reason.filter(|_| !last.feasible) {
        return Err(Diagnostic::error(format!("a step that repeats itself is not possible: {reason}")).into());
    }
    let duration = last.duration.unwrap_or(f64::NAN);
    let margins = Some((last.margins, bench.gait.limits.friction));
    Ok(Repeated {
        speed,
        multiplier: f64::NAN,
        duration,
        cost_of_transport: None,
        phases: last.phases,
        margins,
    })
}
