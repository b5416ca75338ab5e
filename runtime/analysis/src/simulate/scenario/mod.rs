//! What is simulated: how long, from where, under which control, with which hidden effects and sensors.
mod effects;
mod file;
mod footsteps;
mod gait;
mod ground;
mod heights;
mod imu;
mod initial;
mod lenient;
mod motor;
mod outputs;
mod read;
mod reading;
mod sensors;
mod servos;
mod shapes;
mod walk;
mod wishes;

pub use footsteps::FootstepWalk;
pub use gait::{GaitControl, GaitValue};
pub use shapes::Shapes;
pub use wishes::{Choosable, Wishes};

use super::actuation::EffortSensor;
use super::actuator::Actuator;
use super::control::Outputs;
use super::ground::Ground;
use super::heights::Heights;
use super::imu::Imu;
use super::phases::Assumptions;
use super::proximal::Tolerance;
use super::reference::Reference;
use bipedc_effects::effect::Effect;
use std::path::PathBuf;

/// A scenario file, checked against its robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// s
    pub duration: f64,
    /// s
    pub step: f64,
    /// A row of the log every so many steps.
    pub log_every: usize,
    /// Of the noise.
    pub seed: u64,
    /// Of the contact problems.
    pub tolerance: Tolerance,
    /// Where it begins.
    pub initial: Initial,
    /// By joint.
    pub servos: Vec<JointServo>,
    /// The table that references of joints were read from, if any.
    pub trajectory: Option<PathBuf>,
    /// Without what effects do to it.
    pub ground: Ground,
    /// Of the ground, where it is not level.
    pub heights: Option<Heights>,
    /// Links that touch the ground besides the feet.
    pub shapes: Option<Shapes>,
    /// Joints stop at the limits of the URDF.
    pub joint_stops: bool,
    /// See [`Sensors`].
    pub sensors: Sensors,
    /// What the model does not know.
    pub effects: Vec<Effect>,
    /// Pushes on the base.
    pub pushes: Vec<Push>,
    /// Put onto the root link on the way.
    pub payloads: Vec<crate::simulate::PutOn>,
    /// Rise of the ground from each foothold to the next, m, from event to event: heights of the log are above the foot that stands.
    pub rises: Vec<f64>,
    /// How to walk from event to event; `None`: time stepping.
    pub events: Option<EventDriven>,
    /// Virtual constraints, if any.
    pub outputs: Option<Outputs>,
    /// A gait that drives the robot, if any.
    pub gait: Option<GaitControl>,
    /// It walks by footsteps, if it does.
    pub walking: Option<FootstepWalk>,
    /// Index of the phase at time 0.
    pub phase: usize,
    /// Gravity.
    pub world: World,
    /// Motors by joint; none: the torque that is asked for acts at the joint.
    pub actuators: Vec<Option<Actuator>>,
    /// On the base.
    pub imu: Option<Imu>,
    /// Controllers work inside the drives, all the time, not once per step.
    pub inside: bool,
}

/// A horizontal push on the origin of the base: half a sine over its duration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Push {
    /// When it begins, s.
    pub time: f64,
    /// s
    pub duration: f64,
    /// N s
    pub impulse: f64,
    /// Counterclockwise from x, rad; 0 in the plane.
    pub direction: f64,
}

impl Push {
    /// Force at a time, N.
    pub fn force(&self, time: f64) -> f64 {
        let part = (time - self.time) / self.duration;
        if !(0.0..=1.0).contains(&part) {
            return 0.0;
        }
        let pi = std::f64::consts::PI;
        self.impulse * pi / (2.0 * self.duration) * (pi * part).sin()
    }
}

/// What belongs to the event-driven method alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EventDriven {
    /// Walking steps after which the run ends.
    pub steps: Option<usize>,
    /// Error per step of the integration.
    pub relative: f64,
    /// What is checked.
    pub assumptions: Assumptions,
    /// Whether the scenario states the base's linear and angular velocity: else they follow from the standing contacts.
    pub given: [bool; 2],
}

/// Gravity where the robot walks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct World {
    /// m/s²; `None`: that of the description.
    pub gravity: Option<f64>,
    /// Of the ground, downhill along x, rad: gravity is turned instead.
    pub slope: f64,
}

/// The state at time 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Initial {
    /// As the model's, with the height of the base still to be set where `clearance` says so.
    pub q: Vec<f64>,
    /// As the model's.
    pub v: Vec<f64>,
    /// Height of the lowest contact point above the ground, m; `None`: the base's height was given.
    pub clearance: Option<f64>,
    /// Line and column of what was written about it, for messages.
    pub position: (usize, usize),
}

/// A joint's controller: `u = stiffness (r − q) + damping (ṙ − q̇)`, clipped, held over the step.
#[derive(Debug, Clone, PartialEq)]
pub struct JointServo {
    /// N m/rad
    pub stiffness: f64,
    /// N m s/rad
    pub damping: f64,
    /// Largest torque, N m; infinite: none.
    pub limit: f64,
    /// Where to.
    pub reference: Reference,
}

/// What sensors do besides the effects. Standard deviations of white noise.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sensors {
    /// Joint positions are rounded to a turn over this; 0: exact.
    pub encoder_counts: f64,
    /// rad, before rounding
    pub position: f64,
    /// rad/s
    pub velocity: f64,
    /// N m
    pub effort: f64,
    /// N, each component of a corner's force
    pub force: f64,
    /// m
    pub base_position: f64,
    /// rad, about each axis
    pub base_orientation: f64,
    /// m/s and rad/s
    pub base_velocity: f64,
    /// A corner reads at most this, N; 0: no limit.
    pub force_limit: f64,
    /// Whether the log has the joints' velocities.
    pub velocities: bool,
    /// Where efforts are measured.
    pub torque: EffortSensor,
    /// A
    pub current: f64,
    /// Currents are rounded to multiples of this, A; 0: exact.
    pub current_step: f64,
}
