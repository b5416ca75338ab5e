//! Integration of one phase after the other, to the instants at which they end.
use super::precision::{Order, Precision};
use super::watch::{ARMED, Derivative, INSTANT, PhaseEnd, Watch};
use bipedc_effects::diagnostic::Diagnostic;
use ivp::error::Error;
use ivp::methods::{DOP853, DOPRI5, IntegrationResult, Tolerance};
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
    /// Positive until something happens within a phase that changes the dynamics, not the state; `None`: nothing will.
    fn before_event(&self, _phase: usize, _time: f64, _x: &[f64]) -> Option<f64> {
        None
    }
    /// It happens: the dynamics may be others from here on.
    fn at_event(&self, _phase: usize, _time: f64, _x: &[f64]) {}
    /// Whether the dynamics had a kink within the accepted step at whose end [`Phased::violation`] was asked for last: the integration begins anew behind
    /// it, with steps as long as the tolerance lets them be.
    fn has_kink_behind(&self) -> bool {
        false
    }
    /// Name of a phase, for messages.
    fn name(&self, phase: usize) -> String {
        format!("{phase}")
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
    ) -> Result<Passage, Violation>;
    /// Where an assumption of the phase does not hold: the same, if the motion goes on in another phase than the next one.
    ///
    /// # Errors
    /// `violation`, or another assumption that does not hold during the change.
    fn goes_on(
        &self,
        _phase: usize,
        _time: f64,
        _x: &mut [f64],
        _impulse: &mut Vec<f64>,
        violation: Violation,
    ) -> Result<Passage, Violation> {
        Err(violation)
    }
}

/// From one phase to another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Passage {
    /// The phase that begins.
    pub to: usize,
    /// Left and right have exchanged their roles.
    pub exchanged: bool,
    /// Contact points (roles of before) that an impact holds; none: velocities do not jump.
    pub held: Vec<usize>,
    /// It is the one that the order of the phases has there.
    pub planned: bool,
}

impl From<usize> for Passage {
    /// To a phase, as planned, without an impact.
    fn from(to: usize) -> Self {
        Self { to, exchanged: false, held: Vec::new(), planned: true }
    }
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
    /// The phase that begins, and how.
    pub passage: Passage,
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
    let begun = walk.last.time;
    let mut at_once = 0;
    while walk.last.time < until {
        let before = walk.last.time;
        let found = match system.violation(walk.last.phase, before, &walk.last.x) {
            Some(violation) => PhaseEnd::Violated(violation),
            None => phase(system, &mut walk, until, precision, watcher)?,
        };
        at_once = if walk.last.time - before > INSTANT { 0 } else { at_once + 1 };
        if at_once > MOST_AT_ONCE && before - begun > INSTANT {
            walk.end = End::Violated(chatters(system, &walk.last, at_once));
            return Ok(walk);
        }
        if at_once > MOST_AT_ONCE {
            return Err(Diagnostic::error(format!("at {before} s phases follow each other without time"))
                .help("check the initial state, and that the phases' order fits to the motion"));
        }
        walk.end = match found {
            PhaseEnd::Nothing => break,
            PhaseEnd::Stopped => End::Stopped,
            PhaseEnd::Violated(violation) => match changed(system, &mut walk, watcher, Some(violation)) {
                Ok(true) => continue,
                Ok(false) => End::Changes,
                Err(violation) => End::Violated(violation),
            },
            PhaseEnd::Event => {
                let Start { time, phase, x } = &walk.last;
                system.at_event(*phase, *time, x);
                continue;
            }
            PhaseEnd::Kink => continue,
            PhaseEnd::Guard => match changed(system, &mut walk, watcher, None) {
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

/// What is said of a motion that cannot stay in any phase: each lets go or tips in the instant in which it begins.
fn chatters(system: &dyn Phased, last: &Start, at_once: usize) -> Violation {
    Violation {
        phase: system.name(last.phase),
        time: last.time,
        quantity: "changes of phase without time between them".to_owned(),
        value: at_once as f64,
        limit: MOST_AT_ONCE as f64,
        unit: "1",
        meaning: "no phase holds: what stands lets go or tips as soon as it stands",
    }
}

/// The change at the end of a phase, or where it cannot go on; whether to go on.
fn changed(
    system: &dyn Phased,
    walk: &mut Walk,
    watcher: &mut dyn Watcher,
    violated: Option<Violation>,
) -> Result<bool, Violation> {
    let last = &mut walk.last;
    let (from, before, mut impulse) = (last.phase, last.x.clone(), Vec::new());
    let found = match violated {
        None => system.change(from, last.time, &mut last.x, &mut impulse),
        Some(violation) => system.goes_on(from, last.time, &mut last.x, &mut impulse, violation),
    };
    if found.is_err() {
        last.x.clone_from(&before);
    }
    let passage = found?;
    last.phase = passage.to;
    let change = Change { time: last.time, from, passage, before, after: last.x.clone(), impulse };
    let further = watcher.change(&change);
    walk.changes.push(change);
    Ok(further)
}

fn phase(
    system: &dyn Phased,
    walk: &mut Walk,
    until: f64,
    precision: &Precision,
    watcher: &mut dyn Watcher,
) -> Result<PhaseEnd, Diagnostic> {
    let Walk { last, effort, .. } = walk;
    let number = last.phase;
    let derivative = Derivative { system, phase: number };
    let mut watch = Watch {
        system,
        phase: number,
        armed: system.guard(number, last.time, &last.x) > ARMED,
        awaits: system.before_event(number, last.time, &last.x).is_some_and(|before| before > 0.0),
        largest_look: precision.largest_look,
        shortest_look: precision.shortest_look,
        guards: 1,
        time: last.time,
        x: last.x.clone(),
        work: vec![0.0; last.x.len()],
        found: Ok(PhaseEnd::Nothing),
        watcher,
    };
    let result = integrated(&derivative, last, until, precision, &mut watch);
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

fn integrated(
    derivative: &Derivative<'_>,
    Start { time, x, .. }: &Start,
    until: f64,
    precision: &Precision,
    watch: &mut Watch<'_>,
) -> Result<IntegrationResult, Error> {
    let Precision { relative, absolute, largest_step, most_steps: max_steps, .. } = *precision;
    let max_step = Some(largest_step);
    let [relative, absolute] = [relative, absolute].map(Tolerance::Scalar);
    match precision.order {
        Order::Fifth => DOPRI5 { max_step, max_steps, ..DOPRI5::default() }.solve(
            derivative,
            *time,
            x,
            until,
            relative,
            absolute,
            Some(watch),
        ),
        Order::Eighth => DOP853 { max_step, max_steps, ..DOP853::default() }.solve(
            derivative,
            *time,
            x,
            until,
            relative,
            absolute,
            Some(watch),
        ),
    }
}

fn failed(time: f64, why: &str) -> Diagnostic {
    Diagnostic::error(format!("the integration stopped at {time} s: {why}"))
        .help("the motion is stiff or not finite: check controller gains, masses and the initial state")
}
