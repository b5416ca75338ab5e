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
    /// The same as far as it is cheap to know: asked between accepted steps too.
    fn glimpse(&self, _phase: usize, _time: f64, _x: &[f64]) -> Option<Violation> {
        None
    }
    /// At the end of a phase: the state just after, and the phase that follows. Impulses go into `impulse`.
    ///
    /// # Errors
    /// The assumption that does not hold during the change.
    fn change(
        &self,
        phase: usize,
        time: f64,
        x: &mut [f64],
        impulse: &mut Vec<f64>,
    ) -> Result<usize, Violation>;
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
    /// Largest step, s.
    pub largest_step: f64,
    /// Guards are looked at this often at least, s, and four times per step.
    pub largest_look: f64,
}

impl Default for Precision {
    fn default() -> Self {
        Self { relative: 1e-12, absolute: 1e-12, largest_step: 0.02, largest_look: 0.01 }
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
    /// As the system gave them: of a robot, in the order of the impact's rows, N s and N m s.
    pub impulse: Vec<f64>,
}

/// Why a walk ended.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// The time was over.
    Time,
    /// So many changes as were asked for.
    Changes,
    /// Whoever watched had seen enough.
    Stopped,
    /// An assumption did not hold.
    Violated(Violation),
}

/// What a walk cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Effort {
    /// Steps of the integration that were accepted.
    pub steps: usize,
    /// Those that were tried again with a shorter one.
    pub rejected: usize,
    /// Evaluations of the derivative by the integration.
    pub evaluations: usize,
    /// Looks at a guard.
    pub guards: usize,
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
    /// What it cost.
    pub effort: Effort,
}

/// Looks on.
pub trait Watcher {
    /// Is shown every accepted step; `false` ends the walk.
    fn step(&mut self, _time: f64, _phase: usize, _x: &[f64]) -> bool {
        true
    }
    /// When it wants to see the state between steps, s. Asked again after every sample.
    fn next_sample(&self) -> f64 {
        f64::INFINITY
    }
    /// Is shown that state.
    ///
    /// # Errors
    /// Whatever stops the walk: a full disk.
    fn sample(&mut self, _time: f64, _phase: usize, _x: &[f64]) -> Result<(), Diagnostic> {
        Ok(())
    }
    /// Is shown every change of phase; `false` ends the walk ([`End::Changes`]).
    fn change(&mut self, _change: &Change) -> bool {
        true
    }
}

/// Shown the accepted steps alone.
struct Steps<'s>(&'s mut dyn FnMut(f64, usize, &[f64]), usize);

impl Watcher for Steps<'_> {
    fn step(&mut self, time: f64, phase: usize, x: &[f64]) -> bool {
        (self.0)(time, phase, x);
        true
    }
    fn change(&mut self, _: &Change) -> bool {
        self.1 = self.1.saturating_sub(1);
        self.1 > 0
    }
}

/// A guard that began at zero (a foot that has just left the ground) counts once it was above this.
const ARMED: f64 = 1e-9;
/// Places of a step at which the guard is looked at, at least.
const LOOKS: usize = 4;
/// Instants are found to this, s.
const INSTANT: f64 = 1e-13;
/// The first instant of a violation is found to this, s.
const VERDICT: f64 = 1e-9;
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
    walk_watched(system, start, until, precision, &mut Steps(observer, most))
}

/// The same, watched more closely.
///
/// # Errors
/// As [`walk`], and those of the watcher.
pub fn walk_watched(
    system: &dyn Phased,
    start: Start,
    until: f64,
    precision: &Precision,
    watcher: &mut dyn Watcher,
) -> Result<Walk, Diagnostic> {
    let mut walk = Walk { changes: Vec::new(), last: start, end: End::Time, effort: Effort::default() };
    let mut at_once = 0;
    while walk.last.time < until {
        let before = walk.last.time;
        if let Some(violation) = system.violation(walk.last.phase, before, &walk.last.x) {
            walk.end = End::Violated(violation);
            return Ok(walk);
        }
        let found = phase(system, &mut walk, until, precision, watcher)?;
        at_once = if walk.last.time - before > INSTANT { 0 } else { at_once + 1 };
        if at_once > MOST_AT_ONCE {
            return Err(Diagnostic::error(format!("at {before} s phases follow each other without time"))
                .help("check the initial state, and that the phases' order fits to the motion"));
        }
        walk.end = match found {
            Found::Nothing => break,
            Found::Stopped => End::Stopped,
            Found::Violated(violation) => End::Violated(violation),
            Found::Guard => match changed(system, &mut walk, watcher) {
                Ok(true) => continue,
                Ok(false) => End::Changes,
                Err(violation) => End::Violated(violation),
            },
        };
        return Ok(walk);
    }
    walk.end = End::Time;
    Ok(walk)
}

/// The change at the end of a phase; whether to go on.
fn changed(system: &dyn Phased, walk: &mut Walk, watcher: &mut dyn Watcher) -> Result<bool, Violation> {
    let last = &mut walk.last;
    let (from, before, mut impulse) = (last.phase, last.x.clone(), Vec::new());
    let to = system.change(from, last.time, &mut last.x, &mut impulse);
    if to.is_err() {
        last.x.clone_from(&before);
    }
    last.phase = to?;
    let change = Change { time: last.time, from, to: last.phase, before, after: last.x.clone(), impulse };
    let further = watcher.change(&change);
    walk.changes.push(change);
    Ok(further)
}

/// How the integration of one phase ended.
enum Found {
    Nothing,
    Guard,
    Violated(Violation),
    Stopped,
}

fn phase(
    system: &dyn Phased,
    walk: &mut Walk,
    until: f64,
    precision: &Precision,
    watcher: &mut dyn Watcher,
) -> Result<Found, Diagnostic> {
    let Walk { last, effort, .. } = walk;
    let number = last.phase;
    let derivative = Derivative { system, phase: number };
    let mut watch = Watch {
        system,
        phase: number,
        armed: system.guard(number, last.time, &last.x) > ARMED,
        largest_look: precision.largest_look,
        guards: 1,
        time: last.time,
        x: last.x.clone(),
        work: vec![0.0; last.x.len()],
        found: Ok(Found::Nothing),
        watcher,
    };
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
    let result = result.map_err(|error| failed(last.time, &format!("{error:?}")))?;
    effort.steps += result.steps.accepted;
    effort.rejected += result.steps.rejected;
    effort.evaluations += result.evals.ode;
    effort.guards += watch.guards;
    let found = watch.found?;
    if !result.status.is_success() || !watch.x.iter().all(|x| x.is_finite()) {
        return Err(failed(watch.time, &format!("{:?}", result.status)));
    }
    (last.time, last.x) = (watch.time, watch.x);
    Ok(found)
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
    /// Whether the guard was positive in this phase.
    armed: bool,
    largest_look: f64,
    guards: usize,
    time: f64,
    x: Vec<f64>,
    work: Vec<f64>,
    found: Result<Found, Diagnostic>,
    watcher: &'s mut dyn Watcher,
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
        let looks = LOOKS.max(((*to - from) / self.largest_look).ceil() as usize);
        let mut earlier = from;
        for look in 1..=looks {
            let last = look == looks;
            let later = if last { *to } else { from + (*to - from) * look as f64 / looks as f64 };
            if last {
                self.work.copy_from_slice(x);
            } else {
                dense.interpolate(later, &mut self.work);
            }
            self.guards += 1;
            let guard = self.system.guard(self.phase, later, &self.work);
            if self.armed && guard <= 0.0 {
                let instant = self.instant(dense, earlier, later);
                self.found = Ok(Found::Guard);
                return self.arrive(dense, from, instant);
            }
            self.armed |= guard > ARMED;
            if !last && self.system.glimpse(self.phase, later, &self.work).is_some() {
                return self.arrive(dense, from, later);
            }
            earlier = later;
        }
        self.arrive_at_end(dense, from, *to, x)
    }
}

impl Watch<'_> {
    fn guard_at(&mut self, dense: &StepInterpolant<'_>, time: f64) -> f64 {
        dense.interpolate(time, &mut self.work);
        self.guards += 1;
        self.system.guard(self.phase, time, &self.work)
    }

    /// Where the guard falls through zero between two times: regula falsi with halved weights (Illinois), then halving.
    fn instant(&mut self, dense: &StepInterpolant<'_>, mut positive: f64, mut negative: f64) -> f64 {
        let (mut above, mut below) = (self.guard_at(dense, positive), self.guard_at(dense, negative));
        // Which end stayed in the last round: its weight is halved.
        let mut stayed = 0;
        for round in 0..200 {
            if negative - positive <= INSTANT {
                break;
            }
            let middle = 0.5 * (positive + negative);
            let secant = positive + (negative - positive) * above / (above - below);
            let inside = secant > positive && secant < negative;
            let time = if inside && round < 40 { secant } else { middle };
            if time <= positive || time >= negative {
                break;
            }
            let guard = self.guard_at(dense, time);
            if guard > 0.0 {
                (positive, above) = (time, guard);
                if stayed == 1 {
                    below *= 0.5;
                }
                stayed = 1;
            } else {
                (negative, below) = (time, guard);
                if stayed == -1 {
                    above *= 0.5;
                }
                stayed = -1;
                if guard == 0.0 {
                    break;
                }
            }
        }
        negative
    }

    /// To a time within the step.
    fn arrive(&mut self, dense: &StepInterpolant<'_>, from: f64, time: f64) -> ControlFlag {
        let mut x = vec![0.0; self.x.len()];
        dense.interpolate(time, &mut x);
        self.arrive_at_end(dense, from, time, &x)
    }

    /// Takes the samples, shows the state and checks the assumptions there; if one is violated, goes back to where that began.
    fn arrive_at_end(
        &mut self,
        dense: &StepInterpolant<'_>,
        from: f64,
        mut time: f64,
        x: &[f64],
    ) -> ControlFlag {
        self.x.copy_from_slice(x);
        if let Some(violation) = self.system.violation(self.phase, time, x) {
            let (violation, first) = self.first(dense, from, time, violation);
            if first < time {
                dense.interpolate(first, &mut self.x);
            }
            time = first;
            self.found = Ok(Found::Violated(violation));
        }
        self.time = time;
        while self.watcher.next_sample() <= time {
            let at = self.watcher.next_sample();
            dense.interpolate(at, &mut self.work);
            if let Err(error) = self.watcher.sample(at, self.phase, &self.work) {
                self.found = Err(error);
                return ControlFlag::Interrupt;
            }
        }
        if !self.watcher.step(time, self.phase, &self.x) && matches!(self.found, Ok(Found::Nothing)) {
            self.found = Ok(Found::Stopped);
        }
        if matches!(self.found, Ok(Found::Nothing)) { ControlFlag::Continue } else { ControlFlag::Interrupt }
    }

    /// The first instant at which an assumption does not hold, within a step at whose end one does not.
    fn first(
        &mut self,
        dense: &StepInterpolant<'_>,
        mut holds: f64,
        mut broken: f64,
        mut violation: Violation,
    ) -> (Violation, f64) {
        while broken - holds > VERDICT {
            let middle = 0.5 * (holds + broken);
            dense.interpolate(middle, &mut self.work);
            match self.system.violation(self.phase, middle, &self.work) {
                Some(found) => (broken, violation) = (middle, found),
                None => holds = middle,
            }
        }
        (violation, broken)
    }
}
