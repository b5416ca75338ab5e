//! Steps of several phases on their zero dynamics (6.31–6.37): two numbers, φ and φ̇, that know the whole robot.
mod course;
mod cycle;
mod energy;
mod equations;
mod hop;
mod integrated;
mod known;
mod margins;
mod near;
mod phase;
mod pool;
mod refused;
mod steady;
mod step;
mod surface;
mod text;
mod trace;

pub use energy::PhaseEnergy;
pub use hop::{Hop, MidStance};
pub(crate) use margins::light;
pub(in crate::gait) use pool::{Chains, SpeedAndReason};
pub use refused::Refused;
pub use step::{ChainOptions, ChainStep, ChainedPhase};
pub(in crate::gait) use trace::PhaseTrace;

use super::{PhasedBench, PhasedProgramController};
use bipedc_analysis::simulate::phases::{Ending, PhaseSpec, Precision};
use bipedc_compiler::compile::{PhasePrograms, ProgramModel};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{GaveWay, JointCommand, Limit, Observation, Refusal};
use bipedc_runtime::{Argument, Model, State};
use course::Course;
use known::{Courses, Known};
use near::{Near, Recent};
use phase::ChainPhase;
use std::cell::RefCell;
use std::sync::{Arc, Mutex, PoisonError};
use surface::{Surface, SurfacePoint};

/// A robot on the constraint surfaces of its phases, under its controller. Its state is φ and φ̇; where the robot is follows from them,
/// and from where its feet stand and what h_p takes up since the phase began.
pub struct Chain<'b> {
    bench: &'b PhasedBench,
    model: ProgramModel,
    /// By phase of the description.
    phases: Vec<Option<ChainPhase>>,
    /// Position limits of the joints, rad or m.
    stops: Vec<Option<[f64; 2]>>,
    /// Largest speeds of the joints, rad/s or m/s.
    velocity_limits: Vec<Option<f64>>,
    heights: usize,
    relabelled: [usize; 2],
    present: RefCell<Present>,
    /// Of the integration.
    precision: Precision,
    known: Arc<Known>,
    courses: RefCell<Courses>,
    /// Why there is no motion.
    refusal: RefCell<Option<Refused>>,
}

/// What the beginning of a phase settled.
#[derive(Clone)]
struct Present {
    controller: PhasedProgramController,
    /// Coordinates that the ground holds, m.
    held: Vec<f64>,
    /// q and v of the whole robot then.
    begun: Vec<f64>,
    /// The surface.
    course: Arc<Mutex<Course>>,
    /// Where the search for the surface was last.
    near: Near,
    /// By the bits of φ.
    points: Recent<u64, SurfacePoint>,
    /// By the bits of φ and φ̇.
    motions: Recent<[u64; 2], Motion>,
    moving: Moving,
    /// Where the integration was last: which limits hold torques, if that is known.
    mode: Option<Mode>,
    /// They are others than at the step before, which was so often.
    kinked: bool,
    kinks: usize,
    limited: bool,
    /// Outputs had not the accelerations that keep them at zero.
    missed: bool,
    /// The present phase is followed to this φ at most.
    until: Option<f64>,
    /// Of impacts, foot by foot: along the ground and upward, N s.
    impulses: Vec<[f64; 2]>,
}

/// Memory of a motion that is looked at.
#[derive(Clone, Default)]
struct Moving {
    v: Vec<f64>,
    tau: Vec<f64>,
    commands: Vec<JointCommand<f64>>,
    /// Accelerations, then forces of the ground.
    found: Vec<f64>,
}

/// The last limit that torques are held to, how many there are, and what could not be met.
type Mode = (Option<Limit>, usize, GaveWay);

/// The robot at a state (φ, φ̇).
#[derive(Debug, Clone)]
pub(super) struct Motion {
    /// Forces of the ground, N and N m.
    pub forces: Vec<f64>,
    /// φ̈
    pub acceleration: f64,
    /// Which limits hold torques.
    mode: Mode,
    /// Torques were held to a limit.
    pub limited: bool,
    /// Limits let outputs be missed.
    pub missed: bool,
    /// Power of the joints, W: driving less braking, driving and braking.
    pub power: [f64; 2],
    /// Of the joints, N m.
    pub torques: Vec<f64>,
}

impl<'b> Chain<'b> {
    /// `specs` are the phases of the robot's description with their endings.
    ///
    /// # Errors
    /// A function is missing: a fault of the compiler.
    pub fn new(
        bench: &'b PhasedBench,
        specs: &[PhaseSpec],
        controller: PhasedProgramController,
    ) -> Result<Self, Diagnostic> {
        let model = ProgramModel::new(bench.compiled.model.clone());
        let need = |name: &str| {
            let missing = || Diagnostic::error(format!("the gait has no function `{name}`"));
            Model::<f64>::function(&model, name).ok_or_else(missing)
        };
        let mut phases: Vec<Option<ChainPhase>> = specs.iter().map(|_| None).collect();
        for index in 0..bench.gait.phases.len() {
            let layout = bench.compiled.phase(&bench.gait, index)?;
            let spec = specs.get(layout.phase).cloned();
            let spec = spec.ok_or_else(|| Diagnostic::error("the robot lacks a phase of the gait"))?;
            let surface = Surface::new(&model, bench, index, &spec.standing)?;
            surface.checked(&model, &bench.posture()).map_err(|error| error.or_in_file(&bench.file))?;
            phases[layout.phase] = Some(ChainPhase {
                surface,
                dynamics: need(&spec.dynamics)?,
                impact: spec.impact.as_ref().map(|impact| need(&impact.map)).transpose()?,
                feet: layout.feet,
                controlled: layout.controlled,
                outputs: layout.outputs,
                read: Self::read(bench, index),
                spec,
            });
        }
        Ok(Self {
            stops: bench
                .compiled
                .description
                .stops(bench.compiled.model.tree.joints.iter().map(|joint| joint.name.as_str())),
            velocity_limits: bench
                .compiled
                .description
                .velocity_limits(bench.compiled.model.tree.joints.iter().map(|joint| joint.name.as_str())),
            heights: need("contact_distances")?,
            relabelled: [need("relabelled_configuration")?, need("relabelled_velocity")?],
            present: RefCell::new(Present {
                controller,
                held: Vec::new(),
                begun: Vec::new(),
                course: Arc::new(Mutex::new(Course::new([0.0; 2], &[]))),
                near: Near::at(&vec![0.0; Model::<f64>::nq(&model)]),
                points: Recent::new(),
                motions: Recent::new(),
                moving: Moving::default(),
                mode: None,
                kinked: false,
                kinks: 0,
                limited: false,
                missed: false,
                until: None,
                impulses: Vec::new(),
            }),
            precision: hop::PRECISION,
            known: Arc::default(),
            courses: RefCell::default(),
            refusal: RefCell::new(None),
            bench,
            model,
            phases,
        })
    }

    fn phase(&self, phase: usize) -> Result<&ChainPhase, Diagnostic> {
        let found = self.phases.get(phase).and_then(Option::as_ref);
        found.ok_or_else(|| Diagnostic::error("the step leaves the phases of the gait"))
    }

    fn call(&self, function: usize, state: &State<'_, f64>) -> Vec<f64> {
        surface::call(&self.model, function, state)
    }

    /// A phase begins in this state of the whole robot: φ and φ̇ there.
    ///
    /// # Errors
    /// The controller refuses it.
    pub fn begin(&self, phase: usize, q: &[f64], v: &[f64]) -> Result<[f64; 2], Refused> {
        let of = self.phase(phase)?;
        let present = &mut *self.present.borrow_mut();
        let refused = |refusal: Refusal| Refused::of_controller(&of.spec.name, refusal);
        present.controller.begin(phase, q, v).map_err(refused)?;
        present.held = of.surface.held(&self.model, q);
        present.begun = [q, v].concat();
        present.near = Near::at(q);
        (present.points, present.motions) = (Recent::new(), Recent::new());
        (present.mode, present.kinked, present.kinks) = (None, false, 0);
        let status = present.controller.status();
        let parameters = present.controller.arguments().get(3..).unwrap_or(&[]);
        let key = known::key(phase, [&present.begun, &[]], parameters, &of.read.shape);
        present.course = self.courses.borrow_mut().of(key, || Course::new(status.ends, q));
        Ok([status.phase, status.rate])
    }

    /// φ and φ̇ of the whole robot in a phase.
    ///
    /// # Errors
    /// The gait does not have the phase.
    pub fn phase_at(&self, phase: usize, q: &[f64], v: &[f64]) -> Result<[f64; 2], Diagnostic> {
        let of = self.phase(phase)?;
        let found = self.call(of.controlled, &State::new().with(Argument::Q, q).with(Argument::V, v));
        Ok([found[0], found[1 + of.outputs]])
    }

    /// T and T′ at φ in the present phase.
    fn point(&self, phase: usize, phi: f64) -> Result<Arc<SurfacePoint>, Refused> {
        let of = self.phase(phase)?;
        let present = &mut *self.present.borrow_mut();
        if let Some(known) = present.points.get(&phi.to_bits()) {
            return Ok(known);
        }
        let end = present.controller.status().ends[1];
        let find = |phi: f64, near: &[f64]| {
            let mut arguments = present.controller.arguments().to_vec();
            arguments[0] = phi;
            if phi > end {
                let matching = 3 + self.bench.gait.parameters.len();
                arguments[matching..].fill(0.0);
            }
            of.surface.at(&self.model, (&arguments, &present.held), near)
        };
        let known = present.course.lock().unwrap_or_else(PoisonError::into_inner).at(phi, &find);
        let found = match known {
            Some(found) => found,
            None => find(phi, &present.near.guess(phi)).or_else(|_| find(phi, present.near.last()))?,
        };
        let found = Arc::new(found);
        present.near.found(phi, &found);
        present.points.keep(phi.to_bits(), &found);
        Ok(found)
    }

    /// The whole motion at φ and φ̇ in the present phase.
    pub(super) fn motion(&self, phase: usize, x: [f64; 2]) -> Result<Arc<Motion>, Refused> {
        let key = x.map(f64::to_bits);
        if let Some(known) = self.present.borrow().motions.get(&key) {
            return Ok(known);
        }
        let point = self.point(phase, x[0])?;
        let found = Arc::new(self.moved(phase, &point, x[1])?);
        self.present.borrow_mut().motions.keep(key, &found);
        Ok(found)
    }

    /// The same at a point of the surface.
    fn moved(&self, phase: usize, point: &SurfacePoint, rate: f64) -> Result<Motion, Refused> {
        let of = self.phase(phase)?;
        let present = &mut *self.present.borrow_mut();
        let Moving { v, tau, commands, found } = &mut present.moving;
        v.clear();
        v.extend(point.slope.iter().map(|slope| slope * rate));
        commands.clear();
        commands.resize(Model::<f64>::joints(&self.model), JointCommand::Off);
        let observed = Observation::new(0.0, phase, &point.q, v);
        let refused = |refusal: Refusal| Refused::of_controller(&of.spec.name, refusal);
        PhasePrograms::command(&mut present.controller, &observed, commands).map_err(refused)?;
        let status = present.controller.status();
        let missed = matches!(status.gave_way, GaveWay::Outputs | GaveWay::Ground);
        let first = v.len() - commands.len();
        tau.clear();
        tau.resize(first, 0.0);
        tau.extend(commands.iter().map(|command| command.torque(0.0, 0.0)));
        let power = tau.iter().zip(&*v).map(|(tau, v)| tau * v);
        let power = [power.clone().sum::<f64>(), power.map(f64::abs).sum()];
        let state = State::new().with(Argument::Q, &point.q).with(Argument::V, v).with(Argument::Tau, tau);
        surface::call_into(&self.model, of.dynamics, &state, found);
        let (accelerations, forces) = found.split_at(v.len().min(found.len()));
        let acceleration = of.surface.phase_acceleration(&self.model, (point, v), accelerations);
        let (forces, torques) = (forces.to_vec(), tau[first..].to_vec());
        let mode = (status.limit, status.limits, status.gave_way);
        Ok(Motion { forces, acceleration, mode, limited: status.limits > 0, missed, power, torques })
    }

    /// φ where h_p of the present phase has vanished.
    fn end_of_present(&self) -> f64 {
        self.present.borrow().controller.status().ends[1]
    }

    /// Keeps the first refusal.
    fn heard<T>(&self, found: Result<T, Refused>) -> Option<T> {
        match found {
            Ok(found) => Some(found),
            Err(why) => {
                self.refusal.borrow_mut().get_or_insert(why);
                None
            }
        }
    }

    /// What was refused since this was last asked.
    pub(super) fn refusal(&self) -> Option<Refused> {
        self.refusal.take()
    }

    /// Heights of the contact points, m.
    pub(super) fn heights(&self, q: &[f64]) -> Vec<f64> {
        self.call(self.heights, &State::new().with(Argument::Q, q))
    }

    /// Legs exchanged.
    fn relabelled(&self, q: &[f64], v: &[f64]) -> [Vec<f64>; 2] {
        let [configuration, velocity] = self.relabelled;
        [
            self.call(configuration, &State::new().with(Argument::Q, q)),
            self.call(velocity, &State::new().with(Argument::V, v)),
        ]
    }

    fn guarded(&self, phase: usize, x: [f64; 2]) -> Result<f64, Refused> {
        let left = self.present.borrow().until.map_or(f64::INFINITY, |until| until - x[0]);
        Ok(self.before_its_end(phase, x)?.min(left))
    }

    /// Positive until the event that ends a phase.
    fn before_its_end(&self, phase: usize, x: [f64; 2]) -> Result<f64, Refused> {
        let of = self.phase(phase)?;
        match &of.spec.ending {
            Ending::Never => Ok(f64::INFINITY),
            Ending::Touch(points) => {
                let heights = self.heights(&self.point(phase, x[0])?.q);
                Ok(points.iter().map(|&point| heights[point]).fold(f64::INFINITY, f64::min))
            }
            Ending::Release(_) | Ending::Tip(..) => Ok(of.ending_force(&self.motion(phase, x)?.forces)),
        }
    }

    fn changed(&self, phase: usize, x: [f64; 2]) -> Result<(usize, [f64; 2]), Refused> {
        if self.present.borrow().until.is_some() {
            return Ok((phase, x));
        }
        let of = self.phase(phase)?;
        let point = self.point(phase, x[0])?;
        let mut v: Vec<f64> = point.slope.iter().map(|slope| slope * x[1]).collect();
        let mut q = point.q.clone();
        if let Some(impact) = of.impact {
            let size = v.len();
            v = self.call(impact, &State::new().with(Argument::Q, &q).with(Argument::V, &v));
            if let Some(landing) = &of.spec.impact {
                self.note_impulses(&landing.rows, &v[size..]);
            }
            v.truncate(size);
        }
        if of.spec.relabel {
            [q, v] = self.relabelled(&q, &v);
        }
        Ok((of.spec.next, self.begin(of.spec.next, &q, &v)?))
    }
}
