//! A whole run: control, effects, steps, sensors, log.
use super::actuation::Command;
use super::beginning::{begin, stepper};
use super::control::PhasedController;
use super::drives::Drives;
use super::energy::{EnergyBalance, EnergyFlow};
use super::fall::{Fall, FallWatch};
use super::imu::{self, Inertial};
use super::instability::InstabilityDetector;
use super::mean_forces::MeanForces;
use super::mechanics::Mechanics;
use super::plant::Plant;
use super::scenario::Scenario;
use super::sensed::Sensed;
use super::sensing::{Sample, Sensing};
use super::servo::DriveServo;
use super::stepper::{MotionState, Stepper};
use super::turned::Turned;
use super::wrench::SoleAxes;
use crate::robot::BaseKind;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::Effect;
use bipedc_runtime::control::{Controller, JointCommand};
use serde::Serialize;

/// Penetration of hard ground at which a run ends, m: a tenth of that is what a foot at 10 m/s reaches with steps of 1 ms.
const DEEPEST: f64 = 0.05;

/// What a run reports besides its log.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Summary {
    /// Steps done.
    pub steps: usize,
    /// Rows of the log.
    pub rows: usize,
    /// Simulated time, s.
    pub time: f64,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
    /// Why the controller had no command any more: the log ends there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
    /// Worst residual of a contact problem.
    pub worst_residual: f64,
    /// Contact problems that did not reach the tolerance.
    pub not_converged: usize,
    /// Largest number of closed contact points.
    pub contacts: usize,
    /// Deepest penetration of a contact point, m.
    pub penetration: f64,
    /// Largest energy that the law of impact made in one step, J; 0 unless restitution is given.
    pub energy_made: f64,
    /// Steps in which a torque was clipped, by joint; those without are left out.
    pub clipped: Vec<(String, usize)>,
    /// That the robot fell, and how that was seen.
    pub fall: Option<Fall>,
    /// Where the energy went; only of a run [`Simulation::with_energy`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<EnergyBalance>,
}

/// Where a run's rows go, who is told how far it is (0 to 1), and who may stop it.
pub struct Run<'a> {
    /// Takes the names of the columns once, then every row.
    pub row: &'a mut dyn FnMut(&[f64]) -> Result<(), Diagnostic>,
    /// Is told the fraction that is done.
    pub progress: &'a dyn Fn(f64),
    /// Asked now and then; true ends the run early.
    pub stop: &'a dyn Fn() -> bool,
}

/// The row of the log that is begun and, until the time that it stands for is over, not written.
struct Rows {
    begun: bool,
    sample: Sample,
    row: Vec<f64>,
    /// Forces on the contact points in the steps before and after the row's time, N.
    earlier: Vec<[f64; 3]>,
    later: Vec<[f64; 3]>,
    forces: MeanForces,
    /// With the motion at the end of the row's first step.
    inertial: Option<(Inertial, MotionState)>,
}

impl Rows {
    fn new(every: usize, points: usize) -> Self {
        Self {
            begun: false,
            sample: Sample::default(),
            row: Vec::new(),
            earlier: Vec::new(),
            later: Vec::new(),
            forces: MeanForces::new(every, points),
            inertial: None,
        }
    }
}

/// A scenario of a robot, ready to run.
pub struct Simulation<'a> {
    pub(super) plant: &'a Plant,
    pub(super) scenario: &'a Scenario,
    pub(super) stepper: Stepper<'a>,
    pub(super) drives: Drives,
    pub(super) sensing: Sensing<'a>,
    axes: Option<SoleAxes<'a>>,
    pub(super) inertial: Option<Inertial>,
    /// What a controller is told instead of the truth.
    pub(super) sensed: Option<Box<Sensed<'a>>>,
    pub(super) motion: MotionState,
    pub(super) force: Vec<f64>,
    /// Servos inside the drives in this step.
    pub(super) inside: Vec<DriveServo>,
    /// By joint, of this step.
    pub(super) commands: Vec<Command>,
    pub(super) instability: Vec<InstabilityDetector>,
    /// Torques that were reported of the last step and of the one before.
    pub(super) effort: [Vec<f64>; 2],
    /// Currents of the same steps, A; NaN without a motor.
    pub(super) current: [Vec<f64>; 2],
    /// Torques from motors on links in the last step.
    pub(super) transmitted: Vec<f64>,
    /// Of the joints in the last step, rad/s².
    pub(super) acceleration: Vec<f64>,
    /// Of the joints, rad/s.
    pub(super) joint_speed: Vec<f64>,
    pub(super) reference: Vec<f64>,
    pub(super) clipped: Vec<usize>,
    pub(super) summary: Summary,
    pub(super) keeps_refused: bool,
    falls: FallWatch,
    watch: Option<Watch<'a>>,
    pub(super) controller: Option<Box<dyn Controller<f64> + 'a>>,
    pub(super) phased: Option<PhasedController<'a>>,
    /// Of the controllers, for the present step, by joint.
    pub(super) asked: Vec<JointCommand<f64>>,
    /// Of the last step on each foot, N.
    pub(super) loads: Vec<f64>,
    pub(super) centers: Vec<[f64; 2]>,
    /// Of each joint, as seen there, rad; NaN where motor and joint are one.
    pub(super) motors: Vec<f64>,
    pub(super) energy_flow: Option<EnergyFlow>,
}

/// Is shown the truth.
type Watch<'a> = Box<dyn FnMut(&Sample) + 'a>;

impl<'a> Simulation<'a> {
    /// Puts the robot where the scenario says. `mechanics` is of the true robot: effects that change masses are in it,
    /// effects in joints, sensors and ground are not.
    ///
    /// # Errors
    /// Contact points below the ground; effects that cannot be simulated.
    pub fn new(
        mechanics: Mechanics<'a>,
        plant: &'a Plant,
        scenario: &'a Scenario,
    ) -> Result<Self, Diagnostic> {
        let effects: Vec<&Effect> = plant.effects.iter().chain(&scenario.effects).collect();
        // A robot on a stand hangs in the air, whatever the height of its feet is.
        let hangs = plant.layout.base == BaseKind::Fixed;
        let mechanics = if hangs { mechanics.without_contact() } else { mechanics };
        let turned = Turned::new(plant, &effects);
        let motion = begin(&mechanics, plant, &scenario.initial, turned)?;
        let falls = FallWatch::new(&mechanics, plant, &motion);
        let drives = Drives::new(plant, &scenario.actuators, &effects, scenario.step)?;
        let stepper = stepper((mechanics, plant, scenario), &effects, &drives, &motion)?;
        let joints = mechanics.joints();
        let zeros = || vec![0.0; joints];
        let axes = SoleAxes::new(mechanics.model(), plant);
        let measured = scenario.walking.as_ref().is_some_and(|walk| walk.measured);
        let sensed = measured.then(|| {
            let names: Vec<String> = plant.feet.iter().map(|foot| foot.name.clone()).collect();
            let sensing = Sensing::new(plant, scenario, &drives, &effects, turned).seeded(!scenario.seed);
            Box::new(Sensed::new(sensing, scenario.imu, &names))
        });
        Ok(Self {
            sensed,
            plant,
            scenario,
            sensing: Sensing::new(plant, scenario, &drives, &effects, turned).with_moments(axes.is_some()),
            axes,
            inertial: scenario.imu.map(|imu| {
                let all: Vec<Effect> = effects.iter().map(|effect| (*effect).clone()).collect();
                Inertial::new(imu, plant.layout.base, plant.gravity_on_ground(&all))
            }),
            force: vec![0.0; stepper.size()],
            inside: Vec::with_capacity(joints),
            commands: vec![Command::default(); joints],
            instability: vec![InstabilityDetector::default(); joints],
            joint_speed: motion.v[motion.v.len() - joints..].to_vec(),
            stepper,
            drives,
            motion,
            effort: [zeros(), zeros()],
            current: [zeros(), zeros()],
            transmitted: zeros(),
            acceleration: zeros(),
            reference: zeros(),
            clipped: vec![0; joints],
            summary: Summary::default(),
            keeps_refused: false,
            falls,
            watch: None,
            controller: None,
            phased: None,
            asked: vec![JointCommand::Off; joints],
            loads: vec![0.0; plant.feet.len()],
            centers: vec![[f64::NAN; 2]; plant.feet.len()],
            motors: vec![f64::NAN; plant.layout.joints.len()],
            energy_flow: None,
        })
    }

    /// The same, and the truth at every row of the log is shown to `watch`: no noise, no effects of sensors.
    #[must_use]
    pub fn watched(mut self, watch: impl FnMut(&Sample) + 'a) -> Self {
        self.watch = Some(Box::new(watch));
        self
    }

    /// The same with a controller over the scenario's servos: joints that it leaves alone stay with them. It is told the true
    /// state once per step, always in phase 0.
    #[must_use]
    pub fn controlled(mut self, controller: impl Controller<f64> + 'a) -> Self {
        self.controller = Some(Box::new(controller));
        self
    }

    /// The same with a controller that is told the phase of the robot, such as virtual constraints.
    #[must_use]
    pub fn phased(mut self, controller: PhasedController<'a>) -> Self {
        self.phased = Some(controller);
        self
    }

    /// The same, but a controller that refuses a later state ends the run with what happened until then ([`Summary::refused`]) instead of
    /// an error.
    #[must_use]
    pub fn until_refused(self) -> Self {
        Self { keeps_refused: true, ..self }
    }

    /// The same, and its summary says where the energy went.
    ///
    /// # Errors
    /// The model has no energies; motors that turn on their own, coupled joints and soles that turn are not in the accounting.
    pub fn with_energy(mut self) -> Result<Self, Diagnostic> {
        let pushed = (!self.scenario.pushes.is_empty()).then_some("pushes");
        let loaded = (!self.scenario.payloads.is_empty()).then_some("payloads that are put on");
        if let Some(what) = self.stepper.beyond_account().or(pushed).or(loaded) {
            return Err(Diagnostic::error(format!("the energy balance does not know {what}"))
                .help("leave --energy out, or what brings them in out of the scenario"));
        }
        self.stepper = self.stepper.accounted();
        self.energy_flow = Some(EnergyFlow::new(&self.stepper, &self.motion)?);
        Ok(self)
    }

    /// Names of the log's columns.
    pub fn columns(&self) -> Vec<String> {
        let mut names = self.sensing.columns();
        if self.inertial.is_some() {
            names.extend(imu::columns(self.plant.layout.base));
        }
        names
    }

    /// The present state.
    pub fn motion(&self) -> &MotionState {
        &self.motion
    }

    /// Runs to the end, or until stopped.
    ///
    /// # Errors
    /// The motion became infinite, or `run.row` refused a row.
    pub fn run(mut self, run: &mut Run<'_>) -> Result<Summary, Diagnostic> {
        let (h, every) = (self.scenario.step, self.scenario.log_every);
        let steps = (self.scenario.duration / h).round() as usize;
        let mut rows = Rows::new(every, self.stepper.mechanics().points());
        for step in 0..steps {
            let logged = step % every == 0;
            if step % 256 == 0 {
                (run.progress)(step as f64 / steps as f64);
                if (run.stop)() {
                    self.summary.interrupted = true;
                    break;
                }
            }
            if let Some(inertial) = &mut self.inertial {
                inertial.see(&self.motion);
            }
            self.control(step as f64 * h)?;
            if self.summary.refused.is_some() {
                break;
            }
            if logged {
                self.take(&mut rows.sample, step as f64 * h);
                self.measured(&mut rows.earlier);
            }
            self.step(h)?;
            self.report();
            self.measured(&mut rows.later);
            if logged {
                self.begin_row(&mut rows, step);
            }
            if rows.forces.add(step, &rows.later, &mut rows.sample.forces) {
                self.write_row(&mut rows, run)?;
            }
        }
        if rows.begun {
            rows.forces.close(&mut rows.sample.forces);
            self.write_row(&mut rows, run)?;
        }
        self.summary.time = self.summary.steps as f64 * h;
        if let Some(energy_flow) = self.energy_flow.take() {
            self.summary.energy = Some(energy_flow.close(&self.stepper, &self.motion)?);
        }
        self.summary.fall = self.falls.fall;
        let names = self.plant.joint_names().map(str::to_owned);
        self.summary.clipped = names.zip(self.clipped).filter(|(_, count)| *count > 0).collect();
        Ok(self.summary)
    }

    /// Notes what a row has of the step that begins at its time, and shows the truth then.
    fn begin_row(&mut self, rows: &mut Rows, step: usize) {
        let sample = &mut rows.sample;
        self.report_sample(sample);
        if let Some(axes) = &self.axes {
            axes.at(&sample.q, &mut sample.soles);
        }
        if step == 0 {
            rows.earlier.clone_from(&rows.later);
        }
        for (force, (a, b)) in sample.forces.iter_mut().zip(rows.earlier.iter().zip(&rows.later)) {
            *force = std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
        }
        if let Some(watch) = &mut self.watch {
            watch(sample);
        }
        rows.inertial = self.inertial.as_ref().map(|inertial| (inertial.clone(), self.motion.clone()));
        rows.begun = true;
    }

    /// Writes the row that was begun, with noise, once its forces are known.
    fn write_row(&mut self, rows: &mut Rows, run: &mut Run<'_>) -> Result<(), Diagnostic> {
        self.sensing.row(&rows.sample, &self.drives, &mut rows.row);
        if let Some((inertial, after)) = rows.inertial.take() {
            inertial.measure(&after, self.scenario.step, self.sensing.random(), &mut rows.row);
        }
        (run.row)(&rows.row)?;
        self.summary.rows += 1;
        rows.begun = false;
        Ok(())
    }

    /// The state now.
    pub(super) fn take(&self, sample: &mut Sample, time: f64) {
        sample.time = time;
        sample.q.clone_from(&self.motion.q);
        sample.v.clone_from(&self.motion.v);
        sample.motor.clear();
        let joints = self.commands.len();
        sample
            .motor
            .extend((0..joints).map(|j| self.drives.motor(j).map_or(f64::NAN, |k| self.stepper.motor(k)[0])));
        sample.reference.clone_from(&self.reference);
        sample.forces.resize(self.stepper.mechanics().points(), [0.0; 3]);
    }

    /// What the motors reported: the mean of the steps before and after the sample; one of them alone would be half a
    /// step late or early.
    fn report_sample(&self, sample: &mut Sample) {
        let first = self.summary.steps == 1;
        let mean = |[now, last]: &[Vec<f64>; 2], mean: &mut Vec<f64>| {
            mean.clear();
            mean.extend(
                now.iter().zip(last).map(|(now, last)| if first { *now } else { 0.5 * (now + last) }),
            );
        };
        mean(&self.effort, &mut sample.effort);
        mean(&self.current, &mut sample.current);
    }

    /// Forces of the last step on the contact points, N.
    pub(super) fn measured(&self, forces: &mut Vec<[f64; 3]>) {
        forces.clear();
        let points = self.stepper.mechanics().points();
        forces.extend((0..points).map(|i| self.stepper.impulse(i).map(|x| x / self.scenario.step)));
    }

    fn step(&mut self, h: f64) -> Result<(), Diagnostic> {
        if let Some(energy_flow) = &mut self.energy_flow {
            energy_flow.begin(&self.motion);
        }
        let stepped = self.stepper.step(&mut self.motion, &self.force, h)?;
        if let Some(energy_flow) = &mut self.energy_flow {
            energy_flow.end(&self.motion, h);
        }
        let summary = &mut self.summary;
        summary.steps += 1;
        summary.worst_residual = summary.worst_residual.max(stepped.solved.residual);
        summary.not_converged += usize::from(stepped.solved.residual > self.scenario.tolerance.relative);
        summary.contacts = summary.contacts.max(stepped.contacts);
        let deepest = self.stepper.gaps().iter().fold(0.0, |deep: f64, gap| deep.max(-gap));
        summary.penetration = summary.penetration.max(deepest);
        self.falls.see(self.plant, &self.motion, &self.stepper);
        if deepest > DEEPEST && self.stepper.ground().compliance.is_none() {
            return Err(self.sunk(deepest, h));
        }
        // Without restitution impacts make none: what servos in the same step push against would look like it.
        if self.stepper.ground().restores() {
            let summary = &mut self.summary;
            summary.energy_made = summary.energy_made.max(stepped.made);
        }
        Ok(())
    }
}

impl Simulation<'_> {
    /// A point so deep in hard ground that a step took it there.
    fn sunk(&self, depth: f64, step: f64) -> Diagnostic {
        let gaps = self.stepper.gaps().iter().enumerate();
        let point = gaps.min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(point, _)| point);
        Diagnostic::error(format!(
            "at {:.6} s `{}` is {depth:.3} m below hard ground: the step of {step} s is too long for this motion",
            self.motion.time,
            self.plant.point_name(point)
        ))
        .help("take a shorter `step`; if the robot flies apart, lower the controllers' gains")
    }
}
