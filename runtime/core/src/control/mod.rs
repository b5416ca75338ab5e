//! What stands between a measured state and the drives, on the robot and in a simulation alike.
//!
//! A [`Controller`] is told the state and answers with a [`JointCommand`] for every joint. It neither allocates nor knows who
//! calls it: a loop on the robot, or one of the simulators. [`GaitController`] is the one that walks by a gait, [`PhasedController`] that of a gait of
//! several phases.
pub(crate) mod elimination;
mod feedback;
mod gait;
mod gait_controller;
mod ground_limits;
pub(crate) mod least_change;
mod phase_surface;
mod phased;
mod phased_controller;
mod phased_torques;
pub(crate) mod slices;
mod step_end;
mod surface;
mod zero;

pub use feedback::Feedback;
pub use gait::{Gait, GaitLayout, GaitParameter, StepEnd};
pub use gait_controller::{GaitController, GaitStatus, PhasePlace};
pub use ground_limits::Limit;
pub use phase_surface::{PhaseSurfaceLayout, SurfacePoint, held_contacts, phase_surface, surface_memory};
pub use phased::{MOST_FEET, MOST_JOINTS, PhaseLayout, PhasedGait, PhasedLayout, StandingFoot};
pub use phased_controller::{PhasedController, PhasedStatus};
pub use phased_torques::GaveWay;

use crate::real::Real;
use core::fmt;

/// What a controller is told.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Observation<'a, T> {
    /// s
    pub time: T,
    /// Index of the phase that the robot is in; 0 where there are none.
    pub phase: usize,
    /// Configuration as the model takes it: pose of the base, then joints; m, rad.
    pub q: &'a [T],
    /// Velocity as the model takes it: twist of the base, then joints; m/s, rad/s.
    pub v: &'a [T],
    /// Normal force on each foot (N), in the order of the description; empty where nobody measures it.
    pub loads: &'a [T],
    /// Centre of pressure of each foot, x and y in the frame of its link (m), in the order of the description; NaN where nothing presses; empty where
    /// nobody measures it.
    pub centers: &'a [[T; 2]],
    /// What an inertial unit on the base measures, in axes of the base: specific force (m/s²; 9.81 upward at rest), angular velocity (rad/s).
    pub inertial: Option<[[T; 3]; 2]>,
    /// Angle of each joint's motor as seen at the joint (rad; m of a prismatic joint), where a spring or play lies between them; NaN where motor and joint
    /// are one; empty where nobody measures it.
    pub motors: &'a [T],
}

impl<'a, T> Observation<'a, T> {
    /// Of a state (`q`: nq, `v`: nv) in a phase, at a time (s).
    pub fn new(time: T, phase: usize, q: &'a [T], v: &'a [T]) -> Self {
        Self { time, phase, q, v, loads: &[], centers: &[], inertial: None, motors: &[] }
    }

    /// The same with the normal force on each foot, N.
    #[must_use]
    pub fn with_loads(self, loads: &'a [T]) -> Self {
        Self { loads, ..self }
    }

    /// The same with the centre of pressure of each foot, x and y in the frame of its link, m.
    #[must_use]
    pub fn with_centers(self, centers: &'a [[T; 2]]) -> Self {
        Self { centers, ..self }
    }

    /// The same with what an inertial unit on the base measures, in axes of the base: specific force (m/s²), angular velocity (rad/s).
    #[must_use]
    pub fn with_inertial(self, inertial: [[T; 3]; 2]) -> Self {
        Self { inertial: Some(inertial), ..self }
    }

    /// The same with the angle of each joint's motor as seen at the joint, rad.
    #[must_use]
    pub fn with_motors(self, motors: &'a [T]) -> Self {
        Self { motors, ..self }
    }

    /// Positions (rad or m) and velocities of the last joints of the model, as many as are asked for.
    pub fn joints(&self, count: usize) -> (&'a [T], &'a [T]) {
        let last = |all: &'a [T]| all.split_at(all.len().saturating_sub(count)).1;
        (last(self.q), last(self.v))
    }
}

/// What the drive of a joint is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum JointCommand<T> {
    /// Nothing: the motor is without current.
    #[default]
    Off,
    /// This torque (N m; N of a prismatic joint), until the next command.
    Torque(T),
    /// A feedback that the drive itself works out, all the time or once per command; a simulation solves it within its step.
    Servo(Servo<T>),
}

/// `torque + stiffness (position − q) + damping (velocity − v)`, between ∓`limit`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Servo<T> {
    /// Wanted, rad (m of a prismatic joint).
    pub position: T,
    /// Wanted, rad/s.
    pub velocity: T,
    /// N m/rad
    pub stiffness: T,
    /// N m s/rad
    pub damping: T,
    /// Feed-forward, N m.
    pub torque: T,
    /// Largest torque, N m; infinite: none.
    pub limit: T,
}

impl<T: Real> Servo<T> {
    /// What it asks for at a position and velocity, before the limit.
    pub fn unlimited(&self, position: T, velocity: T) -> T {
        self.stiffness * (self.position - position) + self.damping * (self.velocity - velocity) + self.torque
    }
}

impl<T: Real> JointCommand<T> {
    /// The torque (N m) that it asks for at a position (rad) and velocity (rad/s) of the joint.
    pub fn torque(&self, position: T, velocity: T) -> T {
        match self {
            Self::Off => T::constant(0.0),
            Self::Torque(torque) => *torque,
            Self::Servo(servo) => {
                let asked = servo.unlimited(position, velocity);
                // The smaller of the two is the larger of the negated ones.
                -(-asked.larger(-servo.limit)).larger(-servo.limit)
            }
        }
    }
}

/// Why a controller gives no commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refusal {
    /// The decoupling matrix L_g L_f h of the outputs is singular: they depend on each other, or no actuator moves one.
    SingularOutputs,
    /// No step has begun: the gait's controller has to be told when one does.
    NoStep,
    /// Where a step begins the phase variable stands still or turns back.
    PhaseTurnsBack,
    /// The step would begin where it ends, or behind that.
    NoPhaseLeft,
    /// No phase ends a step with these parameters.
    NoEnd,
    /// The state or what follows from it is infinite or no number.
    NotFinite,
    /// Something does not have the length that the model needs.
    WrongLength,
    /// Something else, in words.
    Because(&'static str),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SingularOutputs => "the decoupling matrix L_g L_f h of the outputs is singular",
            Self::NoStep => "no step of the gait has begun",
            Self::PhaseTurnsBack => "the phase variable does not grow where the step begins",
            Self::NoPhaseLeft => "the step would begin at or behind the phase where it ends",
            Self::NoEnd => "the guard of the gait vanishes at no phase: the step cannot end",
            Self::NotFinite => "the state or what follows from it is not finite",
            Self::WrongLength => "the state or a parameter is not of the length that the model needs",
            Self::Because(words) => words,
        })
    }
}

impl core::error::Error for Refusal {}

/// From a state to commands. Functions and closures of this form are controllers too.
///
/// ```
/// use bipedc_runtime::control::{Controller, JointCommand, Observation};
///
/// // Holds two joints with springs of 40 N m/rad and dampers of 2 N m s/rad.
/// let mut hold = |observed: &Observation<'_, f64>, commands: &mut [JointCommand<f64>]| {
///     let (q, v) = observed.joints(commands.len());
///     for (command, (q, v)) in commands.iter_mut().zip(q.iter().zip(v)) {
///         *command = JointCommand::Torque(-40.0 * q - 2.0 * v);
///     }
///     Ok(())
/// };
/// let mut commands = [JointCommand::Off; 2];
/// hold.command(&Observation::new(0.0, 0, &[0.1, 0.0], &[0.0, 1.0]), &mut commands)?;
/// assert_eq!(commands, [JointCommand::Torque(-4.0), JointCommand::Torque(-2.0)]);
/// # Ok::<(), bipedc_runtime::control::Refusal>(())
/// ```
pub trait Controller<T> {
    /// Commands for the joints, in their order. One that is left as it is stays what a controller before this one made of it,
    /// or [`JointCommand::Off`] where there was none.
    ///
    /// # Errors
    /// There is no command for this state; what was written to `commands` means nothing then.
    fn command(
        &mut self,
        observed: &Observation<'_, T>,
        commands: &mut [JointCommand<T>],
    ) -> Result<(), Refusal>;

    /// A phase begins in this state: the first one of a motion, or, where phases are followed, the one after an impact, with legs
    /// exchanged where they are. In between [`Controller::command`] may be asked in any order of time.
    ///
    /// # Errors
    /// There will be no commands in this phase.
    fn begin_phase(&mut self, _observed: &Observation<'_, T>) -> Result<(), Refusal> {
        Ok(())
    }

    /// Positive until something happens within a phase that the controller wants to be told of, such as mid-stance: where this falls
    /// through zero [`Controller::at_event`] is called once. `None`: there is nothing.
    fn before_event(&mut self, _observed: &Observation<'_, T>) -> Option<T> {
        None
    }

    /// What [`Controller::before_event`] waited for happens in this state. From here on commands may be others.
    ///
    /// # Errors
    /// There will be no commands in the rest of this phase.
    fn at_event(&mut self, _observed: &Observation<'_, T>) -> Result<(), Refusal> {
        Ok(())
    }
}

impl<T, F> Controller<T> for F
where
    F: FnMut(&Observation<'_, T>, &mut [JointCommand<T>]) -> Result<(), Refusal>,
{
    fn command(
        &mut self,
        observed: &Observation<'_, T>,
        commands: &mut [JointCommand<T>],
    ) -> Result<(), Refusal> {
        self(observed, commands)
    }
}

/// Somebody else's controller, for whoever takes one of his own.
pub struct Borrowed<'a, T>(pub &'a mut dyn Controller<T>);

impl<T> Controller<T> for Borrowed<'_, T> {
    fn command(
        &mut self,
        observed: &Observation<'_, T>,
        commands: &mut [JointCommand<T>],
    ) -> Result<(), Refusal> {
        self.0.command(observed, commands)
    }

    fn begin_phase(&mut self, observed: &Observation<'_, T>) -> Result<(), Refusal> {
        self.0.begin_phase(observed)
    }

    fn before_event(&mut self, observed: &Observation<'_, T>) -> Option<T> {
        self.0.before_event(observed)
    }

    fn at_event(&mut self, observed: &Observation<'_, T>) -> Result<(), Refusal> {
        self.0.at_event(observed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn servos_pull_back_up_to_their_limit() {
        let servo =
            Servo { position: 0.5, velocity: 1.0, stiffness: 10.0, damping: 2.0, torque: 0.25, limit: 4.0 };
        let command = JointCommand::Servo(servo);
        assert_eq!(command.torque(0.25, 0.5), 3.75);
        assert_eq!(command.torque(-1.0, 0.0), 4.0);
        assert_eq!(command.torque(2.0, 0.0), -4.0);
        let free = JointCommand::Servo(Servo { limit: f32::INFINITY, ..to_f32(servo) });
        assert_eq!(free.torque(-1.0, 0.0), 17.25);
        assert_eq!(JointCommand::Off.torque(1.0, 1.0), 0.0);
    }

    fn to_f32(servo: Servo<f64>) -> Servo<f32> {
        Servo {
            position: servo.position as f32,
            velocity: servo.velocity as f32,
            stiffness: servo.stiffness as f32,
            damping: servo.damping as f32,
            torque: servo.torque as f32,
            limit: servo.limit as f32,
        }
    }

    #[test]
    fn joints_are_the_last_coordinates() {
        let (q, v) = ([1.0, 2.0, 3.0], [4.0, 5.0]);
        let observed = Observation::new(0.0, 0, &q, &v);
        assert_eq!(observed.joints(1), (&q[2..], &v[1..]));
        assert_eq!(observed.joints(9), (&q[..], &v[..]));
    }

    /// A controller that refuses, behind a pointer as simulators hold it.
    #[test]
    fn refusals_have_words() {
        let mut never = |_: &Observation<'_, f64>, _: &mut [JointCommand<f64>]| Err(Refusal::SingularOutputs);
        let boxed: &mut dyn Controller<f64> = &mut never;
        let refused = boxed.command(&Observation::new(0.0, 0, &[], &[]), &mut []);
        assert!(refused.is_err_and(|e| e.to_string().contains("singular")));
    }
}
