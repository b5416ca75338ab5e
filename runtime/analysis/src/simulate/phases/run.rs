//! A whole walk: controllers, phases, log.
use super::fastest::Fastest;
use super::integrate::{Change, Effort, End, Passage, Start, Violation, Walk, Watcher, walk_watched};
use super::mirror::Mirror;
use super::precision::{Order, Precision};
use super::project::Projected;
use super::robot::PhasedRobot;
use super::spec::{LandingGuard, PhaseSpec};
use crate::simulate::control::{JointServos, VirtualConstraints, refused};
use crate::simulate::drives::Drives;
use crate::simulate::plant::Plant;
use crate::simulate::run::Run;
use crate::simulate::scenario::{EventDriven, Scenario};
use crate::simulate::sensing::{Sample, Sensing};
use crate::simulate::turned::Turned;
use crate::simulate::wrench::SoleAxes;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};
use bipedc_runtime::model::Model;
use serde::Serialize;
use std::cell::Cell;

/// Longest step of the integration, s.
const LARGEST_STEP: f64 = 0.1;
/// Steps of the integration in one phase beyond which a motion does not get on.
const MOST_STEPS: usize = 300_000;
/// Guards are looked at this often, s.
const LARGEST_LOOK: f64 = 0.005;

/// A change of phase as it is reported.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhaseChange {
    /// s
    pub time: f64,
    /// Name of the phase that ended.
    pub from: String,
    /// Name of the phase that begins.
    pub to: String,
    /// On the feet of the robot as it is; none where velocities do not jump.
    pub impulse: Vec<FootImpulse>,
    /// It is the change that the order of the phases has there.
    pub planned: bool,
}

/// What an impact did to a foot, world axes, N s.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs, reason = "the names say it")]
pub struct FootImpulse {
    pub foot: String,
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// Why a walk ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WalkEnd {
    /// The time that it was given was over.
    Duration,
    /// It has done its steps.
    Steps,
    /// An assumption of the model did not hold.
    Verdict,
    /// It was stopped.
    Interrupted,
}

/// What a walk reports besides its log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WalkSummary {
    /// Rows of the log.
    pub rows: usize,
    /// Simulated time, s.
    pub time: f64,
    /// Walking steps: landings.
    pub steps: usize,
    /// Why it ended.
    pub end: WalkEnd,
    /// The assumption that did not hold, if one ended the walk.
    pub verdict: Option<Violation>,
    /// In order.
    pub changes: Vec<PhaseChange>,
    /// How many of them were not in the order of the phases: contacts came or went early, late or at once.
    pub unplanned: usize,
    /// How much the initial state was moved onto the contacts of its phase.
    pub projected: Projected,
    /// Steps and evaluations of the integration.
    pub integration: Effort,
    /// At all accepted steps of the integration, at rows of the log and on both sides of impacts; none where no joint has a velocity limit.
    #[serde(skip)]
    pub fastest: Option<Fastest>,
}

/// A robot and what it shall do.
#[derive(Clone, Copy)]
pub struct Walking<'a> {
    /// Constrained dynamics, impacts, contact points.
    pub model: &'a dyn Model<f64>,
    /// The same functions of the robot with its sides exchanged, where that is another one: what the phases walk on while they call
    /// the left leg the right one.
    pub exchanged: Option<&'a dyn Model<f64>>,
    /// As the description has them.
    pub phases: &'a [PhaseSpec],
    /// Further sets of contacts through which the walk may go where phases follow the contacts; none: it may not.
    pub sets: &'a [PhaseSpec],
    /// Names, limits, feet.
    pub plant: &'a Plant,
    /// A scenario with [`Scenario::events`].
    pub scenario: &'a Scenario,
}

/// Names of the log's columns.
///
/// # Errors
/// A step of no length.
pub fn columns(
    model: &dyn Model<f64>,
    plant: &Plant,
    scenario: &Scenario,
) -> Result<Vec<String>, Diagnostic> {
    let turned = Turned::new(plant, &[]);
    let sensing = Sensing::new(plant, scenario, &ideal(plant, scenario)?, &[], turned);
    Ok(sensing.with_moments(SoleAxes::new(model, plant).is_some()).columns())
}

/// Drives without motors of their own: phases have joints alone.
fn ideal(plant: &Plant, scenario: &Scenario) -> Result<Drives, Diagnostic> {
    Drives::new(plant, &[], &[], scenario.step)
}

impl Walking<'_> {
    /// Walks to the end, or until an assumption does not hold, or until stopped. The truth at every row of the log is shown
    /// to `watch`.
    ///
    /// # Errors
    /// A beginning that does not stand; a motion that became infinite; outputs that cannot be driven; a refused row.
    pub fn run(&self, run: &mut Run<'_>, watch: &mut dyn FnMut(&Sample)) -> Result<WalkSummary, Diagnostic> {
        let Some(outputs) = &self.scenario.outputs else {
            let none = |_: &Observation<'_, f64>, _: &mut [JointCommand<f64>]| Ok(());
            return self.run_with(none, run, watch);
        };
        let names: Vec<&str> = self.phases.iter().map(|phase| phase.dynamics.as_str()).collect();
        let outputs = VirtualConstraints::new(self.model, self.plant.layout.base, outputs, &names)?;
        self.run_with(outputs, run, watch)
    }

    /// The same with a controller over the scenario's servos, instead of its outputs; legs have their roles as names. It is asked
    /// at every state that the integration tries, in no order of time: its answer may depend on what it is told alone, and on the last
    /// phase that it was told the beginning of.
    ///
    /// # Errors
    /// As [`Walking::run`]; the controller refuses a state.
    pub fn run_with(
        &self,
        controller: impl Controller<f64>,
        run: &mut Run<'_>,
        watch: &mut dyn FnMut(&Sample),
    ) -> Result<WalkSummary, Diagnostic> {
        self.run_until(controller, None, run, watch)
    }

    /// The same with landings where a function of the configuration falls through zero, whatever the heights of the feet are; legs
    /// have their roles as names.
    ///
    /// # Errors
    /// As [`Walking::run_with`].
    pub fn run_until(
        &self,
        controller: impl Controller<f64>,
        ending: Option<&LandingGuard<'_>>,
        run: &mut Run<'_>,
        watch: &mut dyn FnMut(&Sample),
    ) -> Result<WalkSummary, Diagnostic> {
        let Self { model, exchanged, phases, sets, plant, scenario } = *self;
        let Some(events) = &scenario.events else {
            return Err(Diagnostic::error("the scenario is not of method = \"event_driven\""));
        };
        let base = plant.layout.base;
        let relabels = phases.iter().any(|phase| phase.relabel);
        let mirror = if relabels { Some(Mirror::new(model, base)?) } else { None };
        let swapped = Cell::new(false);
        let controller = OverServos {
            servos: JointServos::new(&scenario.servos, 0.0),
            mirror: mirror.as_ref(),
            swapped: &swapped,
            own: Vec::new(),
            controller,
        };
        let mirrored = mirror.as_ref().map_or(Vec::new(), |mirror| mirror.points().to_vec());
        let stops = if scenario.joint_stops { plant.position_limits.clone() } else { Vec::new() };
        let robot =
            PhasedRobot::new(model, base, &plant.feet, phases.to_vec(), events.assumptions, controller)?
                .following(sets, mirrored)?
                .with_stops(stops)
                .pushed(scenario.pushes.clone())
                .on_steps(scenario.rises.clone())
                .landing_where(ending)
                .exchanging(exchanged)?;
        let (x, projected) = robot.standing(plant, scenario)?;
        robot.begin_phase(scenario.phase, 0.0, &x);
        let mut log = Log::new(self, (&robot, events), (mirror.as_ref(), &swapped), (run, watch))?;
        let precision = precision(events.relative);
        let start = Start { time: 0.0, phase: scenario.phase, x };
        let done = walk_watched(&robot, start, scenario.duration, &precision, &mut log);
        if let Some((phase, time, refusal)) = robot.refusal() {
            return Err(refused(refusal, Some(robot.name(phase)), time));
        }
        Ok(log.summary(done?, projected))
    }
}

/// Errors are relative to each component, and absolute below 1.
fn precision(relative: f64) -> Precision {
    Precision {
        relative,
        absolute: relative,
        largest_step: LARGEST_STEP,
        largest_look: LARGEST_LOOK,
        shortest_look: 0.0,
        most_steps: MOST_STEPS,
        order: Order::Eighth,
    }
}

/// A controller over the servos: these act on the robot as it is, phases speak of legs by their roles.
struct OverServos<'a, C> {
    servos: JointServos<'a>,
    mirror: Option<&'a Mirror<'a>>,
    swapped: &'a Cell<bool>,
    own: Vec<JointCommand<f64>>,
    controller: C,
}

impl<C: Controller<f64>> Controller<f64> for OverServos<'_, C> {
    fn command(
        &mut self,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        self.own.clear();
        self.own.resize(commands.len(), JointCommand::Off);
        self.servos.command(observed, &mut self.own)?;
        let mirror = self.mirror.filter(|_| self.swapped.get());
        for (joint, own) in self.own.iter().enumerate() {
            let (joint, command) = mirror.map_or((joint, *own), |mirror| mirror.command(joint, own));
            commands[joint] = command;
        }
        self.controller.command(observed, commands)
    }

    fn begin_phase(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        self.controller.begin_phase(observed)
    }

    fn before_event(&mut self, observed: &Observation<'_, f64>) -> Option<f64> {
        self.controller.before_event(observed)
    }

    fn at_event(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        self.controller.at_event(observed)
    }
}

/// Writes the log as the walk goes on.
struct Log<'w, 'r, 'a, 'p> {
    walking: &'w Walking<'a>,
    events: &'w EventDriven,
    robot: &'w PhasedRobot<'p>,
    mirror: Option<&'w Mirror<'w>>,
    swapped: &'w Cell<bool>,
    sensing: Sensing<'w>,
    axes: Option<SoleAxes<'w>>,
    drives: Drives,
    run: &'w mut Run<'r>,
    watch: &'w mut dyn FnMut(&Sample),
    sample: Sample,
    row: Vec<f64>,
    rows: usize,
    steps: usize,
    interrupted: bool,
    changes: Vec<PhaseChange>,
    fastest: Option<Fastest>,
    /// v of the robot as it is.
    own_v: Vec<f64>,
}

impl<'w, 'r, 'a, 'p> Log<'w, 'r, 'a, 'p> {
    fn new(
        walking: &'w Walking<'a>,
        (robot, events): (&'w PhasedRobot<'p>, &'w EventDriven),
        (mirror, swapped): (Option<&'w Mirror<'w>>, &'w Cell<bool>),
        (run, watch): (&'w mut Run<'r>, &'w mut dyn FnMut(&Sample)),
    ) -> Result<Self, Diagnostic> {
        let (plant, scenario) = (walking.plant, walking.scenario);
        let effects: Vec<_> = plant.effects.iter().chain(&scenario.effects).collect();
        let (drives, turned) = (ideal(plant, scenario)?, Turned::new(plant, &effects));
        let axes = SoleAxes::new(walking.model, plant);
        Ok(Self {
            walking,
            events,
            robot,
            mirror,
            swapped,
            sensing: Sensing::new(plant, scenario, &drives, &effects, turned).with_moments(axes.is_some()),
            axes,
            drives,
            run,
            watch,
            sample: Sample::default(),
            row: Vec::new(),
            rows: 0,
            steps: 0,
            interrupted: false,
            changes: Vec::new(),
            fastest: None,
            own_v: Vec::new(),
        })
    }

    /// What is reported of a walk that is done.
    fn summary(self, done: Walk, projected: Projected) -> WalkSummary {
        let (end, verdict) = match done.end {
            End::Violated(violation) => (WalkEnd::Verdict, Some(violation)),
            _ if self.interrupted => (WalkEnd::Interrupted, None),
            End::Time => (WalkEnd::Duration, None),
            End::Changes | End::Stopped => (WalkEnd::Steps, None),
        };
        WalkSummary {
            rows: self.rows,
            time: done.last.time,
            steps: self.steps,
            end,
            verdict,
            unplanned: self.changes.iter().filter(|change| !change.planned).count(),
            changes: self.changes,
            projected,
            integration: done.effort,
            fastest: self.fastest,
        }
    }
}

impl Log<'_, '_, '_, '_> {
    /// The robot as it is: `swapped` undone.
    fn own(&self) -> Option<&Mirror<'_>> {
        self.mirror.filter(|_| self.swapped.get())
    }

    /// How near joints are to their velocity limits in this state.
    fn see_speeds(&mut self, time: f64, x: &[f64]) {
        let v = &x[self.walking.model.nq()..];
        let mut own = std::mem::take(&mut self.own_v);
        own.clear();
        own.extend_from_slice(v);
        if let Some(mirror) = self.own() {
            mirror.velocity(v, &mut own);
        }
        Fastest::see(&mut self.fastest, &self.walking.plant.velocity_limits, (time, &own));
        self.own_v = own;
    }

    fn take(&mut self, time: f64, phase: usize, x: &[f64]) {
        let (tau, forces) = self.robot.loads(phase, time, x);
        let (q, v) = x.split_at(self.walking.model.nq());
        let joints = self.walking.plant.layout.joints.len();
        let mut sample = std::mem::take(&mut self.sample);
        sample.time = time;
        sample.q.clear();
        sample.q.extend_from_slice(q);
        sample.v.clear();
        sample.v.extend_from_slice(v);
        sample.effort.clear();
        sample.effort.extend_from_slice(&tau[tau.len() - joints..]);
        sample.forces.clone_from(&forces);
        if let Some(mirror) = self.own() {
            mirror.state(q, v, (&mut sample.q, &mut sample.v));
            let mut own = vec![0.0; tau.len()];
            mirror.velocity(&tau, &mut own);
            sample.effort.copy_from_slice(&own[tau.len() - joints..]);
            for (point, force) in forces.iter().enumerate() {
                sample.forces[mirror.point(point)] = mirror.force(*force);
            }
        }
        if let Some(axes) = &self.axes {
            axes.at(&sample.q, &mut sample.soles);
        }
        sample.reference.clear();
        let servos = self.walking.scenario.servos.iter();
        // Virtual constraints have no reference for a joint.
        let outputs = self.walking.scenario.outputs.as_ref();
        let driven = self.walking.scenario.gait.is_some();
        let wanted = !driven && !outputs.is_some_and(|outputs| outputs.drive(phase));
        sample.reference.extend(servos.map(|s| if wanted { s.reference.at(time)[0] } else { f64::NAN }));
        self.sample = sample;
    }

    /// What an impact did to the feet of the robot as it is.
    fn impulse(&self, change: &Change) -> Vec<FootImpulse> {
        let nq = self.walking.model.nq();
        if change.passage.held.is_empty() {
            return Vec::new();
        }
        // The configuration of before, whose contacts the impulses belong to.
        let (q, before) = change.before.split_at(nq);
        let after = match (self.mirror, change.passage.exchanged) {
            (Some(mirror), true) => {
                let mut back = vec![0.0; before.len()];
                mirror.velocity(&change.after[nq..], &mut back);
                back
            }
            _ => change.after[nq..].to_vec(),
        };
        let impulses = self.robot.impulses(&change.passage, q, before, &after);
        let mut own = vec![[0.0; 3]; impulses.len()];
        let mut struck = vec![false; impulses.len()];
        for &point in &change.passage.held {
            let (to, impulse) = match self.own() {
                Some(mirror) => (mirror.point(point), mirror.force(impulses[point])),
                None => (point, impulses[point]),
            };
            (own[to], struck[to]) = (impulse, true);
        }
        let mut first = 0;
        let mut found = Vec::new();
        for foot in &self.walking.plant.feet {
            let points = first..first + foot.corners.len();
            first = points.end;
            if points.clone().any(|point| struck[point]) {
                let [x, y, z] = [0, 1, 2].map(|axis| points.clone().map(|p| own[p][axis]).sum());
                found.push(FootImpulse { foot: foot.name.clone(), x, y, z });
            }
        }
        found
    }

    /// Whether a change ends a walking step: it exchanges the legs, or, where none does, something lands.
    fn is_step(&self, passage: &Passage) -> bool {
        if self.mirror.is_some() { passage.exchanged } else { !passage.held.is_empty() }
    }
}

impl Watcher for Log<'_, '_, '_, '_> {
    fn step(&mut self, time: f64, _: usize, x: &[f64]) -> bool {
        self.see_speeds(time, x);
        let of_time = time / self.walking.scenario.duration;
        let of_steps = self.events.steps.map_or(0.0, |steps| self.steps as f64 / steps as f64);
        (self.run.progress)(of_time.max(of_steps).min(1.0));
        self.interrupted = (self.run.stop)();
        !self.interrupted
    }

    fn next_sample(&self) -> f64 {
        let time = self.rows as f64 * self.walking.scenario.step;
        // As in time stepping, the end of the run is not a row.
        if time < self.walking.scenario.duration * (1.0 - 1e-12) { time } else { f64::INFINITY }
    }

    fn sample(&mut self, time: f64, phase: usize, x: &[f64]) -> Result<(), Diagnostic> {
        self.see_speeds(time, x);
        self.take(time, phase, x);
        (self.watch)(&self.sample);
        self.sensing.row(&self.sample, &self.drives, &mut self.row);
        (self.run.row)(&self.row)?;
        self.rows += 1;
        Ok(())
    }

    fn change(&mut self, change: &Change) -> bool {
        let name = |phase: usize| self.robot.name(phase).to_owned();
        let impulse = self.impulse(change);
        self.see_speeds(change.time, &change.before);
        self.changes.push(PhaseChange {
            time: change.time,
            from: name(change.from),
            to: name(change.passage.to),
            impulse,
            planned: change.passage.planned,
        });
        if change.passage.exchanged {
            self.swapped.set(!self.swapped.get());
        }
        self.see_speeds(change.time, &change.after);
        self.steps += usize::from(self.is_step(&change.passage));
        self.events.steps.is_none_or(|steps| self.steps < steps)
    }
}
