//! What is asked of a joint again and again, in one piece each: the trajectory has state after state.
use super::experiment::MotionExperiment;
use crate::experiments::noise::root_mean_square;
use std::sync::OnceLock;

/// Of one joint; formed when first asked for.
#[derive(Debug, Default)]
pub(super) struct Columns {
    /// Angle, velocity, acceleration of its motor.
    motor: [OnceLock<Vec<f64>>; 3],
    /// Of its link, where the motor's were measured beside them.
    link: [OnceLock<Vec<f64>>; 3],
    /// What the rigid model needs, N m (N).
    load: OnceLock<Vec<f64>>,
    usual_torque: OnceLock<f64>,
}

impl MotionExperiment<'_> {
    /// Angles (0), velocities (1) or accelerations (2) of a joint's motor as seen from the joint, where they were measured; else those of the joint.
    pub(super) fn of_motor(&self, joint: usize, order: usize) -> &[f64] {
        let at = |i: usize| self.motor_at(i, joint)[order];
        self.columns[joint].motor[order].get_or_init(|| (0..self.recording.samples()).map(at).collect())
    }

    /// The same of its link, as logged.
    pub(super) fn of_link(&self, joint: usize, order: usize) -> &[f64] {
        if !matches!(self.recording.motors.get(joint), Some(Some(_))) {
            return self.of_motor(joint, order);
        }
        let motion = &self.recording.trajectory;
        let at = |i: usize| motion.joint_at(i, joint)[order];
        self.columns[joint].link[order].get_or_init(|| (0..self.recording.samples()).map(at).collect())
    }

    /// What the rigid model needs at a joint, N m (N).
    pub(super) fn of_load(&self, joint: usize) -> &[f64] {
        self.columns[joint].load.get_or_init(|| self.strided(&self.load, joint).collect())
    }

    /// What was measured at a joint, or what its rigid model needs, whichever is larger; root mean square, N m (N).
    pub(super) fn usual_torque(&self, joint: usize) -> f64 {
        *self.columns[joint].usual_torque.get_or_init(|| {
            let measured = self.recording.effort[joint].as_deref().map_or(0.0, root_mean_square);
            measured.max(root_mean_square(self.of_load(joint)))
        })
    }
}
