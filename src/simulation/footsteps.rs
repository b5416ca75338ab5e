//! Robots that walk by footsteps in time stepping: their controller, the velocities that it is told, what became of the walk.
use super::estimated::EstimateErrors;
use super::late::Late;
use super::told::ToldLog;
use crate::walking::{FootstepWalker, Legs, robots_own};
use bipedc_analysis::simulate::{FootstepWalk, Plant, Scenario, Sensors};
use bipedc_analysis::walking::read_settings;
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::files::Ledger;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};
use bipedc_runtime::in_process::{self, AnyModel};
use bipedc_runtime::walking::estimator::{Fault, Sensed};
use bipedc_runtime::walking::steps::{Phase, Steps, Velocity};
use bipedc_runtime::walking::{OnBoardWalker, Payload, Stepped, Walked, WalkingController};
use serde::Serialize;
use std::cell::RefCell;
use std::f64::consts::TAU;
use std::fmt;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// A place known to so much (m) is known.
const KNOWN: f64 = 0.1;
/// Part of the height of the centre of mass below which a robot has fallen.
const FALLEN: f64 = 0.6;

/// A robot that walks by footsteps, with what its scenario says of it.
#[derive(Debug, Clone)]
pub(super) struct Footsteps {
    walker: FootstepWalker,
    walk: FootstepWalk,
    settings: Option<PathBuf>,
    /// Of the inertial unit.
    unit: Unit,
    /// Standard deviation of a joint's reading, rad.
    encoder: f64,
}

/// What the estimator is told of the inertial unit: its place (m), standard deviations of a sample (rad/s, m/s²), s between samples.
#[derive(Debug, Clone, Copy, Default)]
struct Unit {
    place: [f64; 3],
    noise: [f64; 2],
    step: f64,
}

/// What drives the robot.
enum Driver<'a> {
    /// It is told the true state.
    True(Box<WalkingController<AnyModel<'a>, f64>>),
    /// It is told what sensors measure.
    Measured(Box<OnBoardWalker<AnyModel<'a>, f64>>),
}

impl<'a> Driver<'a> {
    fn controller(&self) -> &WalkingController<AnyModel<'a>, f64> {
        match self {
            Self::True(controller) => controller,
            Self::Measured(walker) => walker.controller(),
        }
    }

    fn estimate(&self) -> Option<[f64; 7]> {
        match self {
            Self::True(_) => None,
            Self::Measured(walker) => walker.estimator().q().first_chunk().copied(),
        }
    }

    fn walk(&mut self, velocity: Velocity<f64>) {
        match self {
            Self::True(controller) => controller.walk(velocity),
            Self::Measured(walker) => walker.walk(velocity),
        }
    }

    fn learn_payload(&mut self, learns: bool) {
        match self {
            Self::True(controller) => controller.learn_payload(learns),
            Self::Measured(walker) => walker.learn_payload(learns),
        }
    }

    /// `told`: where what it is told is written down.
    fn command(
        &mut self,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
        (told, wanted): (Option<&mut ToldLog>, Velocity<f64>),
    ) -> Result<Option<Stepped<f64>>, Refusal> {
        let walker = match self {
            Self::True(controller) => {
                return in_process::command(controller, observed, commands).map(|()| None);
            }
            Self::Measured(walker) => walker,
        };
        let (position, velocity) = observed.joints(commands.len());
        let [specific_force, angular_velocity] = observed.inertial.unwrap_or([[f64::NAN; 3]; 2]);
        let robot = walker.controller().parts().1;
        let load = |k: usize| observed.loads.get(robot.legs[k].foot).copied().unwrap_or(f64::NAN);
        let center = |k: usize| observed.centers.get(robot.legs[k].foot).copied().unwrap_or([f64::NAN; 2]);
        let sensed = Sensed {
            time: observed.time,
            joint_position: position,
            joint_velocity: velocity.iter().all(|v| !v.is_nan()).then_some(velocity),
            angular_velocity,
            specific_force,
            load: [load(0), load(1)],
            center: [center(0), center(1)],
            motor_position: observed.motors,
        };
        let stepped = in_process::step(walker, &sensed, commands);
        if let Some(told) = told {
            told.note(&sensed, wanted, commands);
        }
        stepped.refusal.map_or(Ok(Some(stepped)), Err)
    }
}

/// How a walk by footsteps went.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct FootstepSummary {
    /// Steps that landed.
    pub steps: usize,
    /// Of the centre of mass over the ground, as the controller sees it, m.
    pub distance: f64,
    /// Farthest that the divergent component was from where it was wished, m.
    pub divergent_error: f64,
    /// Part of the time in which the zero moment point was at the edge of what the soles allow.
    pub limited: f64,
    /// When the robot fell, s.
    pub fell: Option<f64>,
    /// What the controller found that its root link carries.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub payload: Option<FoundPayload>,
    /// How far off the estimator was, where one tells the controller.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated: Option<EstimateErrors>,
    /// Why the controller gave up, if it did not just fall.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
}

/// How a walk goes.
#[derive(Debug, Default)]
pub(super) struct Record {
    pub summary: FootstepSummary,
    pub live: Live,
    /// Where what the controller is told is written down.
    pub told: Option<ToldLog>,
}

/// What the controller knows just now.
#[derive(Debug, Clone, Default)]
pub(super) struct Live {
    /// Where it believes its root link to be: place (m) and quaternion x y z w; none where it is told.
    pub estimate: Option<[f64; 7]>,
    pub walked: Option<Walked<f64>>,
    pub steps: Option<Steps<f64>>,
    /// What was wrong with its sensors.
    pub fault: Option<Fault>,
    pub braked: bool,
}

/// What a controller found that the root link carries.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FoundPayload {
    /// kg
    pub mass: f64,
    /// From the root's origin in its axes, m; none where the motion does not tell.
    pub place: [Option<f64>; 3],
}

impl FoundPayload {
    /// Known to so much (standard deviations, kg, kg m).
    fn new(payload: &Payload<f64>, (mass, moment): (f64, [f64; 3])) -> Self {
        let place = payload.place();
        let known = |k: usize| payload.mass.abs() > 2.0 * mass && moment[k] < KNOWN * payload.mass.abs();
        Self { mass: payload.mass, place: [0, 1, 2].map(|k| known(k).then_some(place[k])) }
    }
}

impl fmt::Display for FootstepSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "walked {} steps, {:.3} m; divergent component at most {:.1} mm from its wish; zero moment point at its limit {:.1} % of the time",
            self.steps,
            self.distance,
            1e3 * self.divergent_error,
            100.0 * self.limited
        )?;
        if let Some(FoundPayload { mass, place }) = self.payload {
            let [x, y, z] = place.map(|x| x.map_or("?".to_owned(), |x| format!("{x:.3}")));
            writeln!(
                f,
                "found to be carried: {mass:.3} kg at x {x}, y {y}, z {z} m from the origin of the root link, in its axes"
            )?;
        }
        match (&self.fell, &self.refused) {
            (Some(time), Some(why)) => writeln!(f, "the controller gave up at {time:.3} s: {why}"),
            (Some(time), None) => writeln!(f, "the robot fell at {time:.3} s"),
            _ => Ok(()),
        }
    }
}

impl Footsteps {
    /// Opens what the scenario says of a walk by footsteps, and puts the robot where it stands, if nothing else is said.
    ///
    /// # Errors
    /// A robot that does not walk; settings without meaning.
    pub fn open(robot: &Robot, scenario: &mut Scenario, file: &Path) -> Result<Option<Self>, Diagnostics> {
        let Some(walk) = scenario.walking.clone() else { return Ok(None) };
        let (line, column) = walk.position;
        let placed = |error: Diagnostic| error.or_in_file(file).at(line, column);
        let known = walk.model.as_ref().map(|folder| known_robot(folder, robot)).transpose()?;
        let known = known.as_ref().unwrap_or(robot);
        let (stated, settings) = match &walk.settings {
            Some(own) => (read_settings(own)?, Some(own.clone())),
            None => robots_own(known)?,
        };
        let legs = Legs::new(known, &stated).map_err(placed)?;
        let walker = FootstepWalker::new(&legs).map_err(placed)?;
        if walk.begins_standing {
            let initial = &mut scenario.initial;
            let joints = initial.q.len() - 7;
            let from = walker.posture.len() - joints;
            initial.q[7..].copy_from_slice(&walker.posture[from..]);
            if initial.q[3..7] == [0.0, 0.0, 0.0, 1.0] {
                initial.q[3..7].copy_from_slice(&walker.posture[3..7]);
            }
        }
        let unit = match (walk.measured, &scenario.imu) {
            (true, Some(imu)) => Unit {
                place: imu.position,
                noise: [imu.angular_velocity_noise, imu.acceleration_noise],
                step: scenario.step,
            },
            (true, None) => {
                let message = "a controller that is told what sensors measure needs an inertial unit";
                return Err(
                    placed(Diagnostic::error(message).help("add [imu], or write state = \"true\"")).into()
                );
            }
            (false, _) => Unit::default(),
        };
        let encoder = joint_reading(&scenario.sensors);
        Ok(Some(Self { walker, walk, settings, unit, encoder }))
    }

    /// Files that were read.
    pub fn note(&self, ledger: &mut Ledger) {
        if let Some(file) = &self.settings {
            ledger.reads("the numbers of the walk", file);
        }
    }

    fn driver(&self) -> Driver<'_> {
        if !self.walk.measured {
            return Driver::True(Box::new(self.walker.controller()));
        }
        let Unit { place, noise, step } = self.unit;
        let mut settings = self.walker.estimator();
        settings.unit = place;
        settings.encoder = settings.encoder.max(self.encoder);
        let density = |own: f64, sample: f64| own.max(sample * step.sqrt());
        settings.noise = [density(settings.noise[0], noise[0]), density(settings.noise[1], noise[1])];
        Driver::Measured(Box::new(self.walker.on_board(settings)))
    }

    /// The file of what the controller will be told and asked for; `velocities`: of joints are measured.
    ///
    /// # Errors
    /// A controller that is told the truth; the file cannot be written.
    pub fn told(&self, path: &Path, plant: &Plant, velocities: bool) -> Result<ToldLog, Diagnostic> {
        if !self.walk.measured {
            let message = "the controller is told the true state: there is nothing that its sensors tell";
            return Err(Diagnostic::error(message).help("write state = \"measured\" under [walking]"));
        }
        let joints: Vec<String> = plant.joint_names().map(str::to_owned).collect();
        let (_, robot, _) = self.walker.parts();
        let feet = robot.legs.each_ref().map(|leg| plant.feet[leg.foot].name.as_str());
        let springs = robot.stiffness.iter().take(joints.len());
        let motors = springs.enumerate().filter(|(_, k)| k.is_finite()).map(|(joint, _)| joint).collect();
        ToldLog::begin(path, (&joints, velocities), motors, feet)
    }

    /// The controller, and what it writes down.
    pub fn controller(&self, told: Option<ToldLog>) -> (Scheduled<'_>, Rc<RefCell<Record>>) {
        let record = Rc::new(RefCell::new(Record { told, ..Record::default() }));
        let mut driver = self.driver();
        driver.learn_payload(self.walk.learns_payload);
        let controller = Scheduled {
            driver,
            walk: &self.walk,
            least: FALLEN * self.walker.height(),
            record: Rc::clone(&record),
            begin: None,
            calls: 0,
            late: Late::default(),
            limited: 0,
            phase: Phase::Stand,
        };
        (controller, record)
    }
}

/// Standard deviation of a joint's reading: noise, and counts, within one of which any angle is as likely; rad.
fn joint_reading(sensors: &Sensors) -> f64 {
    let count = if sensors.encoder_counts > 0.0 { TAU / sensors.encoder_counts } else { 0.0 };
    sensors.position.hypot(count / 12.0_f64.sqrt())
}

/// The robot as its controller knows it: its joints have to be those of the robot.
pub(super) fn known_robot(folder: &Path, robot: &Robot) -> Result<Robot, Diagnostics> {
    let known = Robot::read(folder)?;
    let names = |robot: &Robot| -> Result<Vec<String>, Diagnostic> {
        Ok(robot.tree()?.joints.into_iter().map(|joint| joint.name).collect())
    };
    if names(&known)? != names(robot)? {
        let message = "the controller's model has other joints than the robot, or in another order";
        return Err(Diagnostic::error(message)
            .in_file(folder)
            .help("name a folder of the same robot")
            .into());
    }
    Ok(known)
}

/// The controller, told velocities by a clock; a robot that has fallen is left without torque.
pub(super) struct Scheduled<'a> {
    driver: Driver<'a>,
    walk: &'a FootstepWalk,
    least: f64,
    record: Rc<RefCell<Record>>,
    begin: Option<[f64; 2]>,
    calls: usize,
    late: Late,
    limited: usize,
    phase: Phase,
}

impl Scheduled<'_> {
    fn note(&mut self, observed: &Observation<'_, f64>, stepped: Option<Stepped<f64>>) {
        let mut record = self.record.borrow_mut();
        let Record { summary: record, live, .. } = &mut *record;
        let controller = self.driver.controller();
        *live = Live {
            estimate: self.driver.estimate(),
            walked: controller.walked().copied(),
            steps: controller.steps().copied(),
            fault: stepped.and_then(|stepped| stepped.estimated.fault),
            braked: stepped.is_some_and(|stepped| stepped.braked),
        };
        if let Some([x, y]) = controller.walked().map(|walked| walked.center) {
            let begin = *self.begin.get_or_insert([x, y]);
            record.distance = (x - begin[0]).hypot(y - begin[1]);
        }
        if self.walk.learns_payload {
            record.payload =
                controller.payload_deviations().map(|off| FoundPayload::new(controller.payload(), off));
        }
        self.calls += 1;
        if let Some(walked) = controller.walked() {
            let [[x, y], [a, b]] = walked.divergent;
            record.divergent_error = record.divergent_error.max((x - a).hypot(y - b));
            self.limited += usize::from(walked.limited);
        }
        record.limited = self.limited as f64 / self.calls as f64;
        if let Some(steps) = controller.steps() {
            record.steps += usize::from(self.phase == Phase::Swing && steps.phase != Phase::Swing);
            self.phase = steps.phase;
        }
        if controller.height().is_some_and(|height| height < self.least) {
            record.fell = Some(observed.time);
        }
    }
}

impl Controller<f64> for Scheduled<'_> {
    fn command(
        &mut self,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        if self.record.borrow().summary.fell.is_some() {
            commands.fill(JointCommand::Off);
            return Ok(());
        }
        let [forward, left, turning] = self.walk.velocity(observed.time);
        let velocity = Velocity { forward, left, turning };
        self.driver.walk(velocity);
        let mut record = self.record.borrow_mut();
        let noted = (record.told.as_mut(), velocity);
        let told = match self.walk.delay {
            0 => self.driver.command(observed, commands, noted),
            steps => self.driver.command(&self.late.after(steps, observed).observed(), commands, noted),
        };
        drop(record);
        match told {
            Ok(stepped) => self.note(observed, stepped),
            Err(refusal) => {
                let record = &mut self.record.borrow_mut().summary;
                record.fell = Some(observed.time);
                record.refused = Some(refusal.to_string());
                commands.fill(JointCommand::Off);
            }
        }
        Ok(())
    }
}
