//! What comes of the parameters that a step takes at mid-stance: the whole robot as its model has it, under its controller, followed to
//! the next mid-stance with everything checked that the walk assumes.
use super::stance::{Event, Stance};
use crate::gait::{Chain, PhasedBench, PhasedProgramController};
use bipedc_analysis::robot::{BaseKind, Foot};
use bipedc_analysis::simulate::phases::{
    Assumptions, Change, End, Order, PhaseSpec, PhasedRobot, Precision, Start, Watcher, walk_watched,
};
use bipedc_compiler::compile::{PhasePrograms, ProgramModel};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};
use std::cell::RefCell;
use std::sync::{Mutex, PoisonError};

/// A step that takes longer than this does not come to its end, s.
const LONGEST: f64 = 10.0;
/// Of steps whose speed counts.
const CLOSE: Precision = precision(1e-10);
/// Of those that only say where to look, or whether a step is made.
const ROUGH: Precision = precision(1e-7);

const fn precision(tolerance: f64) -> Precision {
    Precision {
        relative: tolerance,
        absolute: tolerance,
        largest_step: 0.1,
        largest_look: 0.005,
        shortest_look: 0.0,
        most_steps: 10_000,
        order: Order::Eighth,
    }
}

/// The robot as the one who chooses knows it, and what has to hold while it walks.
#[derive(Clone)]
#[allow(missing_docs, reason = "the names say it")]
pub struct KnownRobot<'f> {
    pub model: &'f ProgramModel,
    pub base: BaseKind,
    pub feet: &'f [Foot],
    pub phases: &'f [PhaseSpec],
    /// Positions that joints may not pass, rad or m.
    pub stops: Vec<Option<[f64; 2]>>,
    pub assumptions: Assumptions,
}

/// The whole robot where it passes a dead centre.
#[derive(Debug, Clone, PartialEq)]
pub struct Passed {
    /// Legs named by their roles.
    pub q: Vec<f64>,
    /// Of q.
    pub v: Vec<f64>,
    /// φ̇_m, per s.
    pub speed: f64,
}

/// Follows steps; asked from several threads, each has its own controller.
pub struct Foresight<'f> {
    known: KnownRobot<'f>,
    bench: &'f PhasedBench,
    controller: PhasedProgramController,
    idle: Mutex<Vec<Follower<'f>>>,
}

struct Follower<'f> {
    chain: Chain<'f>,
    controller: RefCell<PhasedProgramController>,
}

impl<'f> Foresight<'f> {
    /// `controller` is that of the walk.
    pub fn new(bench: &'f PhasedBench, known: KnownRobot<'f>, controller: PhasedProgramController) -> Self {
        Self { known, bench, controller, idle: Mutex::new(Vec::new()) }
    }

    /// The zero dynamics, for whoever looks for dead centres.
    ///
    /// # Errors
    /// A function is missing: a fault of the compiler.
    pub fn chain(&self) -> Result<Chain<'f>, Diagnostic> {
        Chain::new(self.bench, self.known.phases, self.controller.clone())
    }

    fn follower(&self) -> Result<Follower<'f>, Diagnostic> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let controller = RefCell::new(self.controller.clone());
        idle.map_or_else(|| Ok(Follower { chain: self.chain()?, controller }), Ok)
    }

    /// The next mid-stance, of a robot that takes these parameters at one.
    ///
    /// # Errors
    /// Why it is not reached.
    pub fn ahead(&self, q: &[f64], v: &[f64], values: &[f64]) -> Result<Passed, String> {
        self.ahead_within(&CLOSE, [q, v], values)
    }

    /// The same a thousand times less closely, for a third of the work.
    ///
    /// # Errors
    /// Why it is not reached.
    pub fn roughly_ahead(&self, q: &[f64], v: &[f64], values: &[f64]) -> Result<Passed, String> {
        self.ahead_within(&ROUGH, [q, v], values)
    }

    fn ahead_within(
        &self,
        precision: &Precision,
        state: [&[f64]; 2],
        values: &[f64],
    ) -> Result<Passed, String> {
        let follower = self.follower().map_err(|error| error.message)?;
        let found = self.followed(&follower, precision, state, values);
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(follower);
        found
    }

    fn followed(
        &self,
        by: &Follower<'f>,
        precision: &Precision,
        [q, v]: [&[f64]; 2],
        values: &[f64],
    ) -> Result<Passed, String> {
        let stance = Stance::new(&by.chain).map_err(|why| why.to_string())?;
        let phase = by.chain.first().map_err(|error| error.message)?;
        {
            let controller = &mut *by.controller.borrow_mut();
            let mut values = values.iter().enumerate();
            let begun = values.try_for_each(|(index, &value)| controller.ask(index, value));
            begun.and_then(|()| controller.begin(phase, q, v)).map_err(|refusal| refusal.to_string())?;
        }
        let seen = RefCell::new(None);
        let controller = ToMidStance { inner: &by.controller, stance, values, seen: &seen };
        let KnownRobot { model, base, feet, phases, stops, assumptions } = &self.known;
        let robot = PhasedRobot::new(*model, *base, feet, phases.to_vec(), *assumptions, controller)
            .map_err(|error| error.message)?
            .with_stops(stops.clone());
        let start = Start { time: 0.0, phase, x: [q, v].concat() };
        let mut until = UntilSeen(&seen);
        let walked = walk_watched(&robot, start, LONGEST, precision, &mut until);
        if let Some((.., refusal)) = robot.refusal() {
            return Err(refusal.to_string());
        }
        let end = walked.map_err(|error| error.message)?.end;
        drop(robot);
        match (seen.into_inner(), end) {
            (Some(seen), _) => seen,
            (None, End::Violated(violation)) => Err(violation.meaning.to_owned()),
            (None, _) => Err("the step does not come to its end".to_owned()),
        }
    }
}

/// What was seen of the next mid-stance.
type Seen = RefCell<Option<Result<Passed, String>>>;

/// A gait's controller on its way to the next mid-stance.
struct ToMidStance<'h> {
    inner: &'h RefCell<PhasedProgramController>,
    stance: Stance<'h>,
    values: &'h [f64],
    seen: &'h Seen,
}

impl ToMidStance<'_> {
    fn saw(&self, observed: &Observation<'_, f64>, event: Event) {
        let found = match event {
            Event::Passed(speed) => Ok(Passed { q: observed.q.to_vec(), v: observed.v.to_vec(), speed }),
            Event::Rests(_) => Err("the step falls back".to_owned()),
        };
        self.seen.borrow_mut().get_or_insert(found);
    }
}

impl Controller<f64> for ToMidStance<'_> {
    fn command(
        &mut self,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        PhasePrograms::command(&mut self.inner.borrow_mut(), observed, commands)
    }

    fn begin_phase(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        PhasePrograms::begin_phase(&mut self.inner.borrow_mut(), observed)?;
        if self.stance.begins_step(observed.phase) {
            match self.stance.begin(self.values, observed) {
                Ok(Some(rate)) => self.saw(observed, Event::Passed(rate)),
                Ok(None) => {}
                Err(why) => *self.seen.borrow_mut() = Some(Err(why.to_string())),
            }
        }
        Ok(())
    }

    fn before_event(&mut self, observed: &Observation<'_, f64>) -> Option<f64> {
        self.stance.before(observed)
    }

    fn at_event(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        if let Some(event) = self.stance.event(observed) {
            self.saw(observed, event);
        }
        Ok(())
    }
}

/// Ends a walk when enough is seen.
struct UntilSeen<'h>(&'h Seen);

impl Watcher for UntilSeen<'_> {
    fn step(&mut self, _: f64, _: usize, _: &[f64]) -> bool {
        self.0.borrow().is_none()
    }
    fn change(&mut self, _: &Change) -> bool {
        self.0.borrow().is_none()
    }
}
