//! The controllers of a scenario's joints.
use crate::simulate::scenario::JointServo;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal, Servo};

/// A servo at every joint, each along its reference.
#[derive(Debug, Clone, Copy)]
pub struct JointServos<'a> {
    servos: &'a [JointServo],
    /// References count for this time after the command, s.
    ahead: f64,
}

impl<'a> JointServos<'a> {
    /// By joint. Where drives work the feedback out all the time, references are wanted for the middle of what follows:
    /// `ahead`, s.
    pub fn new(servos: &'a [JointServo], ahead: f64) -> Self {
        Self { servos, ahead }
    }
}

impl Controller<f64> for JointServos<'_> {
    fn command(
        &mut self,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        for (command, servo) in commands.iter_mut().zip(self.servos) {
            let [position, velocity] = servo.reference.at(observed.time + self.ahead);
            *command = JointCommand::Servo(Servo {
                position,
                velocity,
                stiffness: servo.stiffness,
                damping: servo.damping,
                torque: 0.0,
                limit: servo.limit,
            });
        }
        Ok(())
    }
}
