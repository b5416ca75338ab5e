//! A robot with the phases of its description.
use super::assumptions::Assumptions;
use super::integrate::Passage;
use super::points::PointForces;
use super::spec::{LandingGuard, PhaseSpec};
use super::support::Load;
use crate::robot::{BaseKind, Foot};
use crate::simulate::scenario::Push;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};
use bipedc_runtime::model::{Argument, Model, State};
use std::cell::{Cell, RefCell};

/// A robot that walks through its phases (4.23).
pub struct PhasedRobot<'a> {
    pub(super) model: &'a dyn Model<f64>,
    exchanged: Option<&'a dyn Model<f64>>,
    /// Left and right have exchanged their roles.
    pub(super) swapped: Cell<bool>,
    pub(super) base: BaseKind,
    pub(super) feet: &'a [Foot],
    /// Those of the description, then further sets of contacts.
    pub(super) phases: Vec<(PhaseSpec, Functions)>,
    /// How many the description has.
    pub(super) described: usize,
    /// By contact point: the one in its place on the other side; empty where sides are not exchanged.
    pub(super) mirrored: Vec<usize>,
    /// The last phase whose beginning the controller was told.
    driven: Cell<usize>,
    /// N
    pub(super) weight: f64,
    pub(super) distances: usize,
    positions: usize,
    pub(super) normals: usize,
    spread: PointForces,
    pub(super) relabelled: Option<[usize; 2]>,
    pub(super) assumptions: Assumptions,
    pub(super) stops: Vec<Option<[f64; 2]>>,
    pub(super) pushes: Vec<Push>,
    /// Rise of the ground from each foothold to the next, m; flat behind the last.
    pub(super) rises: Vec<f64>,
    /// Footholds that were reached.
    pub(super) reached: Cell<usize>,
    /// Positive until a foot is taken to land, of a configuration.
    pub(super) ending: Option<&'a LandingGuard<'a>>,
    pub(super) controller: RefCell<Box<dyn Controller<f64> + 'a>>,
    /// Phase and time of the first state for which the controller had no command, and why.
    pub(super) refusal: Cell<Option<(usize, f64, Refusal)>>,
    pub(super) work: RefCell<Work>,
    pub(super) memory: RefCell<Memory>,
}

/// Indices of a phase's functions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Functions {
    pub dynamics: usize,
    pub impact: Option<usize>,
}

#[derive(Debug, Default)]
pub(super) struct Work {
    pub commands: Vec<JointCommand<f64>>,
    pub tau: Vec<f64>,
    pub out: Vec<f64>,
    pub points: Vec<f64>,
}

/// The last evaluations: a state is asked for by the integrator, then by the guard, then by the assumptions.
#[derive(Debug, Default)]
pub(super) struct Memory {
    entries: [Entry; 5],
    next: usize,
}

#[derive(Debug, Default)]
struct Entry {
    phase: usize,
    time: f64,
    x: Vec<f64>,
    tau: Vec<f64>,
    out: Vec<f64>,
}

impl<'a> PhasedRobot<'a> {
    /// Looks the functions up. `controller` acts all the time, on the robot as the phases name it.
    ///
    /// # Errors
    /// The model lacks one of them, or there is no phase.
    pub fn new(
        model: &'a dyn Model<f64>,
        base: BaseKind,
        feet: &'a [Foot],
        phases: Vec<PhaseSpec>,
        assumptions: Assumptions,
        controller: impl Controller<f64> + 'a,
    ) -> Result<Self, Diagnostic> {
        let find = |name: &str| {
            model.function(name).ok_or_else(|| {
                Diagnostic::error(format!("the model has no function `{name}`"))
                    .help("add it to what is generated from the description")
            })
        };
        if phases.is_empty() {
            return Err(
                Diagnostic::error("the robot has no phases").help("add [[phase]] tables to biped.toml")
            );
        }
        let relabelled = if phases.iter().any(|phase| phase.relabel) {
            Some([find("relabelled_configuration")?, find("relabelled_velocity")?])
        } else {
            None
        };
        let spread = PointForces::new(model)?;
        Ok(Self {
            described: phases.len(),
            mirrored: Vec::new(),
            driven: Cell::new(0),
            weight: weight(&spread, model, base),
            model,
            exchanged: None,
            swapped: Cell::new(false),
            base,
            feet,
            distances: find("contact_distances")?,
            positions: find("contact_positions")?,
            normals: find("contact_normal_directions")?,
            spread,
            relabelled,
            phases: phases.into_iter().map(|phase| known(model, phase)).collect::<Result<_, Diagnostic>>()?,
            assumptions,
            stops: Vec::new(),
            pushes: Vec::new(),
            rises: Vec::new(),
            reached: Cell::new(0),
            ending: None,
            controller: RefCell::new(Box::new(controller)),
            refusal: Cell::new(None),
            work: RefCell::new(Work::default()),
            memory: RefCell::new(Memory::default()),
        })
    }

    /// The same where phases follow the contacts: `sets` are sets of contacts that no phase has, but a walk may pass, and those of the phases
    /// themselves as what an impact holds; `mirrored` is for each contact point the one in its place on the other side, none where sides
    /// are not exchanged.
    ///
    /// # Errors
    /// The model lacks a function of theirs.
    pub fn following(mut self, sets: &[PhaseSpec], mirrored: Vec<usize>) -> Result<Self, Diagnostic> {
        for set in sets {
            self.phases.push(known(self.model, set.clone())?);
        }
        Ok(Self { mirrored, ..self })
    }

    /// The same with joints that may not pass these positions (rad or m, by joint).
    #[must_use]
    pub fn with_stops(self, stops: Vec<Option<[f64; 2]>>) -> Self {
        Self { stops, ..self }
    }

    /// The same with pushes on its base.
    #[must_use]
    pub fn pushed(self, pushes: Vec<Push>) -> Self {
        Self { pushes, ..self }
    }

    /// The same on ground that rises by so much (m) from each foothold to the next: in the plane. The world's origin moves up with the
    /// foot that stands.
    #[must_use]
    pub fn on_steps(self, rises: Vec<f64>) -> Self {
        Self { rises, ..self }
    }

    /// Height of the ground behind the foot that stands and ahead of it, m.
    pub(super) fn ground(&self) -> [f64; 2] {
        let rise =
            |foothold: Option<usize>| foothold.and_then(|at| self.rises.get(at)).copied().unwrap_or(0.0);
        let reached = self.reached.get();
        [-rise(reached.checked_sub(1)), rise(Some(reached))]
    }

    /// The same with landings where this function of the configuration falls through zero, whatever the heights of the feet are.
    #[must_use]
    pub fn landing_where(self, ending: Option<&'a LandingGuard<'a>>) -> Self {
        Self { ending, ..self }
    }

    /// The same robot whose sides are not each other's image: `exchanged` has the same functions of it with its sides exchanged.
    ///
    /// # Errors
    /// They are not the same functions.
    pub fn exchanging(self, exchanged: Option<&'a dyn Model<f64>>) -> Result<Self, Diagnostic> {
        let functions = |model: &dyn Model<f64>| {
            (0..).map_while(|f| model.signature(f).map(|s| format!("{s:?}"))).collect()
        };
        let own: Vec<String> = functions(self.model);
        let differs = |other: &dyn Model<f64>| own != functions(other);
        if exchanged.is_some_and(differs) {
            return Err(Diagnostic::error("the robot with its sides exchanged has other functions"));
        }
        Ok(Self { exchanged, ..self })
    }

    /// The robot as the phases see it.
    fn here(&self) -> &'a dyn Model<f64> {
        self.on(self.swapped.get())
    }

    fn on(&self, swapped: bool) -> &'a dyn Model<f64> {
        self.exchanged.filter(|_| swapped).unwrap_or(self.model)
    }

    /// Phase, time (s) and reason of the first state for which the controller had no command, since this was last asked.
    pub fn refusal(&self) -> Option<(usize, f64, Refusal)> {
        self.refusal.take()
    }

    /// The phases of the description.
    pub fn phases(&self) -> impl Iterator<Item = &PhaseSpec> {
        self.phases.iter().take(self.described).map(|(spec, _)| spec)
    }

    /// The phase that the controller is in.
    pub(super) fn driven(&self) -> usize {
        self.driven.get()
    }

    /// Name of a phase, or of a set of contacts.
    pub(super) fn name(&self, phase: usize) -> &str {
        &self.phases[phase].0.name
    }

    pub(super) fn split<'x>(&self, x: &'x [f64]) -> (&'x [f64], &'x [f64]) {
        x.split_at(self.model.nq())
    }

    pub(super) fn call(&self, function: usize, state: &State<'_, f64>, out: &mut Vec<f64>) {
        let size = self.model.signature(function).map_or(0, |s| s.rows * s.columns);
        out.clear();
        out.resize(size, 0.0);
        // Lengths come from the model itself; a refusal would be a fault of this crate, seen in the numbers.
        if self.here().evaluate(function, state, out).is_err() {
            out.fill(f64::NAN);
        }
    }

    /// Accelerations, then the forces of the rows, into `work.out`; torques into `work.tau`.
    pub(super) fn dynamics(&self, phase: usize, time: f64, x: &[f64], work: &mut Work) {
        let memory = &mut *self.memory.borrow_mut();
        let known = |entry: &&Entry| entry.time == time && entry.phase == phase && entry.x == x;
        if let Some(entry) = memory.entries.iter().find(known) {
            work.tau.clone_from(&entry.tau);
            work.out.clone_from(&entry.out);
            return;
        }
        let (q, v) = self.split(x);
        self.command(&Observation::new(time, self.driven(), q, v), work);
        let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::Tau, &work.tau);
        self.call(self.phases[phase].1.dynamics, &state, &mut work.out);
        let entry = &mut memory.entries[memory.next];
        (entry.phase, entry.time) = (phase, time);
        entry.x.clear();
        entry.x.extend_from_slice(x);
        entry.tau.clone_from(&work.tau);
        entry.out.clone_from(&work.out);
        memory.next = (memory.next + 1) % memory.entries.len();
    }

    /// What the controller gives, into `work.tau`; NaN where it gives nothing.
    fn command(&self, observed: &Observation<'_, f64>, work: &mut Work) {
        let joints = self.model.joints();
        work.commands.clear();
        work.commands.resize(joints, JointCommand::Off);
        work.tau.clear();
        work.tau.resize(observed.v.len(), 0.0);
        let given = self.controller.borrow_mut().command(observed, &mut work.commands);
        let (q, v) = observed.joints(joints);
        let first = work.tau.len() - joints;
        for ((tau, command), (q, v)) in work.tau[first..].iter_mut().zip(&work.commands).zip(q.iter().zip(v))
        {
            *tau = if given.is_ok() { command.torque(*q, *v) } else { f64::NAN };
        }
        if first > 0 {
            work.tau[0] += self.pushes.iter().map(|push| push.force(observed.time)).sum::<f64>();
        }
        if let (Err(refusal), None) = (given, self.refusal.get()) {
            self.refusal.set(Some((observed.phase, observed.time, refusal)));
        }
    }

    /// Tells the controller that a phase begins in this state, just after any impact.
    pub fn begin_phase(&self, phase: usize, time: f64, x: &[f64]) {
        let (q, v) = self.split(x);
        // Commands of before are no longer the controller's.
        *self.memory.borrow_mut() = Memory::default();
        self.driven.set(phase);
        let begun = self.controller.borrow_mut().begin_phase(&Observation::new(time, phase, q, v));
        if let (Err(refusal), None) = (begun, self.refusal.get()) {
            self.refusal.set(Some((phase, time, refusal)));
        }
    }

    /// Heights of the contact points, m.
    pub fn heights(&self, q: &[f64]) -> Vec<f64> {
        let mut out = Vec::new();
        self.call(self.distances, &State::new().with(Argument::Q, q), &mut out);
        out
    }

    /// Forces of a phase's rows, N and N m.
    pub fn forces(&self, phase: usize, time: f64, x: &[f64]) -> Vec<f64> {
        let mut work = Work::default();
        self.dynamics(phase, time, x, &mut work);
        work.out.split_off(self.model.nv())
    }

    /// Torques (in the order of `v`) and the forces on the contact points (world axes, N) in a state.
    pub fn loads(&self, phase: usize, time: f64, x: &[f64]) -> (Vec<f64>, Vec<[f64; 3]>) {
        let work = &mut *self.work.borrow_mut();
        self.dynamics(phase, time, x, work);
        let (q, v) = self.split(x);
        let forces = self.point_forces_of(&self.phases[phase].0, q, v, work);
        (work.tau.clone(), forces)
    }

    /// Forces on the contact points, from the accelerations and torques in `work`.
    pub(super) fn point_forces_of(
        &self,
        spec: &PhaseSpec,
        q: &[f64],
        v: &[f64],
        work: &Work,
    ) -> Vec<[f64; 3]> {
        let sum = self.spread.generalised(self.here(), [q, v, &work.out[..v.len()], &work.tau]);
        self.spread.spread(self.model, q, (&spec.standing, self.assumptions.friction), &sum)
    }

    /// Impulses on the contact points (world axes, N s) of the jump from `before` to `after`, two states of one configuration, at the
    /// change of phase that was made last.
    pub fn impulses(&self, passage: &Passage, q: &[f64], before: &[f64], after: &[f64]) -> Vec<[f64; 3]> {
        let jump: Vec<f64> = after.iter().zip(before).map(|(after, before)| after - before).collect();
        // The sides are exchanged after the impact.
        let swapped = self.swapped.get() != passage.exchanged;
        let sum = self.spread.impulse(self.on(swapped), q, &jump);
        self.spread.spread(self.model, q, (&passage.held, self.assumptions.friction), &sum)
    }

    /// Derivatives of the positions of these points with respect to `v`, row by row, three (planar: two) for each: z, x, y.
    pub(super) fn directions(&self, q: &[f64], points: &[usize]) -> nalgebra::DMatrix<f64> {
        self.spread.directions(self.model, q, points).transpose()
    }

    /// Horizontal places of the points of a foot, m.
    pub(super) fn places(&self, q: &[f64], points: &[usize], work: &mut Work) -> Vec<[f64; 2]> {
        self.call(self.positions, &State::new().with(Argument::Q, q), &mut work.points);
        let planar = self.base == BaseKind::Planar;
        let place = |&i: &usize| {
            if planar { [work.points[i], 0.0] } else { [work.points[2 * i], work.points[2 * i + 1]] }
        };
        points.iter().map(place).collect()
    }

    /// How far the foremost of some points is ahead of the foremost of others, m.
    pub(super) fn ahead(&self, q: &[f64], landing: &[usize], standing: &[usize], work: &mut Work) -> f64 {
        let mut foremost = |points: &[usize]| {
            let places = self.places(q, points, work);
            places.iter().map(|place| place[0]).fold(f64::NEG_INFINITY, f64::max)
        };
        foremost(landing) - foremost(standing)
    }

    /// Positive until these points land, m.
    pub(super) fn above(&self, spec: &PhaseSpec, q: &[f64], points: &[usize], work: &mut Work) -> f64 {
        if let Some(ending) = self.ending {
            return ending(q);
        }
        let Assumptions { shortest_step, step_length, .. } = self.assumptions;
        if let Some(length) = step_length {
            return length - self.ahead(q, points, &spec.standing, work);
        }
        self.call(self.distances, &State::new().with(Argument::Q, q), &mut work.points);
        let height = points.iter().map(|&point| work.points[point]).fold(f64::INFINITY, f64::min);
        if !self.rises.is_empty() && !self.stands_already(&spec.standing, points) {
            // A foothold is ahead.
            let ahead = self.ahead(q, points, &spec.standing, work);
            return (height - self.ground()[1]).max(shortest_step.max(0.0) - ahead);
        }
        if shortest_step == f64::NEG_INFINITY {
            return height;
        }
        height.max(shortest_step - self.ahead(q, points, &spec.standing, work))
    }

    /// Whether a foot of these points stands on another of its points.
    pub(super) fn stands_already(&self, standing: &[usize], points: &[usize]) -> bool {
        let of = |point: usize| (0..self.feet.len()).find(|&foot| self.sole(foot, &[point]).contains(&point));
        points.iter().any(|&point| standing.iter().any(|&other| of(other) == of(point)))
    }

    /// Points of a foot that stand.
    pub(super) fn sole(&self, foot: usize, standing: &[usize]) -> Vec<usize> {
        let first: usize = self.feet[..foot].iter().map(|f| f.corners.len()).sum();
        let own = first..first + self.feet[foot].corners.len();
        standing.iter().copied().filter(|point| own.contains(point)).collect()
    }

    /// Centre of pressure of a flat foot, its points and their middle.
    pub(super) fn pressure(
        &self,
        q: &[f64],
        load: &Load,
        sole: &[usize],
        work: &mut Work,
    ) -> ([f64; 2], Vec<[f64; 2]>, [f64; 2]) {
        let points = self.places(q, sole, work);
        let count = points.len().max(1) as f64;
        let middle = [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / count);
        let relative = load.pressure();
        ([middle[0] + relative[0], middle[1] + relative[1]], points, middle)
    }
}

/// A phase with its functions.
fn known(model: &dyn Model<f64>, phase: PhaseSpec) -> Result<(PhaseSpec, Functions), Diagnostic> {
    let find = |name: &str| {
        model.function(name).ok_or_else(|| {
            Diagnostic::error(format!("the model has no function `{name}`"))
                .help("add it to what is generated from the description")
        })
    };
    let impact = phase.impact.as_ref().map(|landing| find(&landing.map)).transpose()?;
    let found = Functions { dynamics: find(&phase.dynamics)?, impact };
    Ok((phase, found))
}

/// What holds the robot at rest, N: nothing where the base is fixed.
fn weight(spread: &PointForces, model: &dyn Model<f64>, base: BaseKind) -> f64 {
    let (mut q, still) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
    let linear = match base {
        BaseKind::Fixed | BaseKind::Pivot => return 0.0,
        BaseKind::Planar => 2,
        BaseKind::Floating => {
            q[6] = 1.0;
            3
        }
    };
    let forces = spread.generalised(model, [&q, &still, &still, &still]);
    forces[..linear].iter().map(|x| x * x).sum::<f64>().sqrt()
}
