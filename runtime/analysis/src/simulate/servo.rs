//! Servos inside the drives: their torque is found together with the motion of the step.
use super::implicit::{ImplicitSpring, Relaxed};

/// A position controller that works all the time, not only once per step:
/// `u = bias + stiffness (r − q) + damping (ṙ − q̇)`, between two limits. Stable for any gains.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveServo {
    /// Which axis: joints in their order, then motors of their own.
    pub axis: usize,
    /// N m/rad
    pub stiffness: f64,
    /// N m s/rad
    pub damping: f64,
    /// Wanted position (rad) and velocity (rad/s) in the middle of the step.
    pub wanted: [f64; 2],
    /// N m
    pub bias: f64,
    /// Smallest and largest torque, N m.
    pub limits: [f64; 2],
}

impl DriveServo {
    /// Its row; `mobility`: velocity per impulse of the axis, about. `None`: no gains.
    pub(super) fn relaxed(&self, [q, v]: [f64; 2], mobility: f64, time: f64) -> Option<Relaxed> {
        let held = ImplicitSpring::new(self.stiffness, self.damping, mobility, time);
        // Stretch and its velocity count from what is wanted, which moves on within the step.
        let relaxed = held.relaxed(q - self.wanted[0], v - self.wanted[1])?;
        let offset = relaxed.offset - self.wanted[1] - time * relaxed.softness * self.bias;
        Some(Relaxed { offset, ..relaxed })
    }
}
