//! Integration of one phase after the other, to the instants at which they end.
use crate::diagnostic::Diagnostic;
use ivp::dense::StepInterpolant;
use ivp::methods::{DOP853, Tolerance};
use ivp::prelude::{ControlFlag, FirstOrderSystem};
use ivp::solout::SolOut;
use serde::Serialize;

/// A system whose phases follow each other, each until its guard falls through zero (4.19), (4.23).
pub trait Phased {
    /// `dx/dt` in a phase.
    fn derivative(&self, phase: usize, time: f64, x: &[f64], out: &mut [f64]);
    /// Positive while the phase lasts.
    fn guard(&self, phase: usize, time: f64, x: &[f64]) -> f64;
    /// The first assumption of the phase that does not hold.
    fn violation(&self, phase: usize, time: f64, x: &[f64]) -> Option<Violation>;
    /// At the end of a phase: the state just after, and the phase that follows.
    ///
    /// # Errors
    /// The assumption that does not hold during the change.
    fn change(&self, phase: usize, time: f64, x: &mut [f64]) -> Result<usize, Violation>;
}

/// An assumption that did not hold: the model says nothing about what follows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Violation {
    /// Name of the phase.
    pub phase: String,
    /// s
    pub time: f64,
    /// Such as `normal force of right_foot`.
    pub quantity: String,
    /// What it was.
    pub value: f64,
    /// What it may be at most or at least.
    pub limit: f64,
    /// Of both.
    pub unit: &'static str,
    /// What that means: the foot pulls, slips, tips or scuffs.
    pub meaning: &'static str,
}

/// How exactly to integrate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Precision {
    /// Error per step relative to each component.
    pub relative: f64,
    /// Error per step below which nothing is relative.
    pub absolute: f64,
    /// Largest step, s: guards are looked at four times per step.
    pub largest_step: f64,
}

impl Default for Precision {
    fn default() -> Self {
        Self { relative: 1e-12, absolute: 1e-12, largest_step: 0.02 }
    }
}

/// The state at the beginning of a walk.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// s
    pub time: f64,
    /// Index.
    pub phase: usize,
    /// As the system's.
    pub x: Vec<f64>,
}

/// The end of a phase.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// s
    pub time: f64,
    /// The phase that ended.
    pub from: usize,
    /// The phase that begins.
    pub to: usize,
    /// x⁻
    pub before: Vec<f64>,
    /// x⁺
    pub after: Vec<f64>,
}

/// Why a walk ended.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// The time was over.
    Time,
    /// So many changes as were asked for.
    Changes,
    /// An assumption did not hold.
    Violated(Violation),
}

/// What happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Walk {
    /// In order.
    pub changes: Vec<Change>,
    /// The last state.
    pub last: Start,
    /// Why it is the last.
    pub end: End,
}

/// A guard that began at zero (a foot that has just left the ground) counts once it was above this.
const ARMED: f64 = 1e-9;
/// Places of a step at which the guard is looked at.
const LOOKS: usize = 4;
/// Instants are found to this, s.
const INSTANT: f64 = 1e-13;
/// Changes at one instant that are still a walk, not a loop.
const MOST_AT_ONCE: usize = 16;

/// Integrates until `until` (s), or `most` changes of phase, or a violated assumption. `observer` is shown every accepted
/// step: time, phase and state.
///
/// # Errors
/// The integration fails (a step too small, numbers that are not finite), or phases change without end.
pub fn walk(
    system: &dyn Phased,
    start: Start,
    until: f64,
    most: usize,
    precision: &Precision,
    observer: &mut dyn FnMut(f64, usize, &[f64]),
) -> Result<Walk, Diagnostic> {
    let mut walk = Walk { changes: Vec::new(), last: start, end: End::Time };
    let mut at_once = 0;
    while walk.last.time < until {
        if walk.changes.len() >= most {
            walk.end = End::Changes;
            return Ok(walk);
        }
        let before = walk.last.time;
        let found = phase(system, &mut walk.last, until, precision, observer)?;
        at_once = if walk.last.time - before > INSTANT { 0 } else { at_once + 1 };
        if at_once > MOST_AT_ONCE {
            return Err(Diagnostic::error(format!("at {before} s phases follow each other without time"))
                .help("check the initial state, and that the phases' order fits to the motion"));
        }
        match found {
            Found::Nothing => break,
            Found::Violated(violation) => {
                walk.end = End::Violated(violation);
                return Ok(walk);
            }
            Found::Guard => {
                let last = &mut walk.last;
                let (from, earlier) = (last.phase, last.x.clone());
                match system.change(from, last.time, &mut last.x) {
                    Ok(to) => last.phase = to,
                    Err(violation) => {
                        walk.end = End::Violated(violation);
                        return Ok(walk);
                    }
                }
                let change =
                    Change { time: last.time, from, to: last.phase, before: earlier, after: last.x.clone() };
                walk.changes.push(change);
            }
        }
    }
    if walk.changes.len() >= most && walk.last.time < until {
        walk.end = End::Changes;
    }
    Ok(walk)
}

/// How the integration of one phase ended.
#[derive(Debug, Clone, PartialEq)]
enum Found {
    Nothing,
    Guard,
    Violated(Violation),
}

fn phase(
    system: &dyn Phased,
    last: &mut Start,
    until: f64,
    precision: &Precision,
    observer: &mut dyn FnMut(f64, usize, &[f64]),
) -> Result<Found, Diagnostic> {
    let number = last.phase;
    let derivative = Derivative { system, phase: number };
    let mut watch = Watch {
        system,
        phase: number,
        guard: system.guard(number, last.time, &last.x),
        armed: false,
        time: last.time,
        x: last.x.clone(),
        work: vec![0.0; last.x.len()],
        found: Found::Nothing,
        observer,
    };
    watch.armed = watch.guard > ARMED;
    let method =
        DOP853 { max_step: Some(precision.largest_step), max_steps: 10_000_000, ..DOP853::default() };
    let result = method.solve(
        &derivative,
        last.time,
        &last.x,
        until,
        Tolerance::Scalar(precision.relative),
        Tolerance::Scalar(precision.absolute),
        Some(&mut watch),
    );
    let status = result.map_err(|error| failed(last.time, &format!("{error:?}")))?.status;
    if !status.is_success() || !watch.x.iter().all(|x| x.is_finite()) {
        return Err(failed(watch.time, &format!("{status:?}")));
    }
    (last.time, last.x) = (watch.time, watch.x);
    Ok(watch.found)
}

fn failed(time: f64, why: &str) -> Diagnostic {
    Diagnostic::error(format!("the integration stopped at {time} s: {why}"))
        .help("the motion is stiff or not finite: check controller gains, masses and the initial state")
}

struct Derivative<'s> {
    system: &'s dyn Phased,
    phase: usize,
}

impl FirstOrderSystem for Derivative<'_> {
    fn derivative(&self, time: f64, x: &[f64], out: &mut [f64]) {
        self.system.derivative(self.phase, time, x, out);
    }
}

/// Looks at every accepted step.
struct Watch<'s> {
    system: &'s dyn Phased,
    phase: usize,
    /// At `time`.
    guard: f64,
    /// Whether the guard was positive in this phase.
    armed: bool,
    time: f64,
    x: Vec<f64>,
    work: Vec<f64>,
    found: Found,
    observer: &'s mut dyn FnMut(f64, usize, &[f64]),
}

impl SolOut for Watch<'_> {
    fn solout(
        &mut self,
        from: f64,
        to: &mut f64,
        x: &mut [f64],
        interpolant: Option<&StepInterpolant<'_>>,
    ) -> ControlFlag {
        let Some(dense) = interpolant.filter(|_| *to > from) else { return ControlFlag::Continue };
        let mut earlier = from;
        for look in 1..=LOOKS {
            let later = if look == LOOKS { *to } else { from + (*to - from) * look as f64 / LOOKS as f64 };
            let guard = self.guard_at(dense, later);
            if self.armed && guard <= 0.0 {
                let instant = self.instant(dense, earlier, later);
                self.arrive(dense, instant);
                self.found = Found::Guard;
                return self.judge();
            }
            self.armed |= guard > ARMED;
            (self.guard, earlier) = (guard, later);
        }
        self.time = *to;
        self.x.copy_from_slice(x);
        self.judge()
    }
}

impl Watch<'_> {
    fn guard_at(&mut self, dense: &StepInterpolant<'_>, time: f64) -> f64 {
        dense.interpolate(time, &mut self.work);
        self.system.guard(self.phase, time, &self.work)
    }

    /// Where the guard falls through zero between two times, by halving.
    fn instant(&mut self, dense: &StepInterpolant<'_>, mut positive: f64, mut negative: f64) -> f64 {
        while negative - positive > INSTANT {
            let middle = 0.5 * (positive + negative);
            if middle <= positive || middle >= negative {
                break;
            }
            if self.guard_at(dense, middle) > 0.0 { positive = middle } else { negative = middle }
        }
        negative
    }

    fn arrive(&mut self, dense: &StepInterpolant<'_>, time: f64) {
        self.time = time;
        dense.interpolate(time, &mut self.x);
    }

    /// Shows the state and checks the assumptions there.
    fn judge(&mut self) -> ControlFlag {
        (self.observer)(self.time, self.phase, &self.x);
        if let Some(violation) = self.system.violation(self.phase, self.time, &self.x) {
            self.found = Found::Violated(violation);
        }
        if self.found == Found::Nothing { ControlFlag::Continue } else { ControlFlag::Interrupt }
    }
}
