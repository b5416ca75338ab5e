//! An inertial measurement unit on the base: angular velocity, and acceleration less gravity.
use super::mechanics::rotate;
use super::stepper::MotionState;
use crate::robot::BaseKind;
use bipedc_effects::random::Random;
use nalgebra::{UnitQuaternion, Vector3};

/// Where it sits and how well it measures.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Imu {
    /// In the frame of the root link, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw of its axes against those of the root link, rad.
    pub rotation: [f64; 3],
    /// Standard deviation, m/s².
    pub acceleration_noise: f64,
    /// Standard deviation, rad/s.
    pub angular_velocity_noise: f64,
    /// Measured minus true, own axes, m/s².
    pub acceleration_bias: [f64; 3],
    /// Measured minus true, own axes, rad/s.
    pub angular_velocity_bias: [f64; 3],
}

/// Base at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Moment {
    /// Quaternion x y z w.
    orientation: [f64; 4],
    /// Own axes.
    angular: [f64; 3],
    /// Of the unit's place, in the axes of the ground.
    velocity: [f64; 3],
}

/// The unit on a moving base.
#[derive(Debug, Clone)]
pub(super) struct Inertial {
    imu: Imu,
    base: BaseKind,
    /// In the axes of the ground, m/s².
    gravity: [f64; 3],
    before: Option<Moment>,
    now: Moment,
}

/// Names of its columns.
pub(super) fn columns(base: BaseKind) -> Vec<String> {
    let (linear, angular) = base.axes();
    let name = |quantity: &str, axis: &usize| format!("imu/{quantity}/{}", ["x", "y", "z"][*axis]);
    let linear = linear.iter().map(|axis| name("linear_acceleration", axis));
    linear.chain(angular.iter().map(|axis| name("angular_velocity", axis))).collect()
}

impl Inertial {
    pub fn new(imu: Imu, base: BaseKind, gravity: [f64; 3]) -> Self {
        Self { imu, base, gravity, before: None, now: Moment::default() }
    }

    /// The state at the beginning of a step.
    pub fn see(&mut self, motion: &MotionState) {
        let first = self.now != Moment::default();
        self.before = first.then_some(self.now);
        self.now = self.moment(motion);
    }

    fn moment(&self, motion: &MotionState) -> Moment {
        let (q, v) = (&motion.q, &motion.v);
        let (orientation, linear, angular, own) = match self.base {
            BaseKind::Fixed | BaseKind::Pivot => ([0.0, 0.0, 0.0, 1.0], [0.0; 3], [0.0; 3], true),
            BaseKind::Planar => {
                let (sine, cosine) = (0.5 * q[2]).sin_cos();
                ([0.0, sine, 0.0, cosine], [v[0], 0.0, v[1]], [0.0, v[2], 0.0], false)
            }
            BaseKind::Floating => ([q[3], q[4], q[5], q[6]], [v[0], v[1], v[2]], [v[3], v[4], v[5]], true),
        };
        let turning = Vector3::from(angular).cross(&Vector3::from(self.imu.position));
        let base = if own { rotate(orientation, linear) } else { linear };
        let around = rotate(orientation, turning.into());
        Moment { orientation, angular, velocity: std::array::from_fn(|i| base[i] + around[i]) }
    }

    /// What it measures at the beginning of the step that ended with this motion: its acceleration is the mean over
    /// both steps around.
    pub fn measure(&self, after: &MotionState, step: f64, random: &mut Random, row: &mut Vec<f64>) {
        let next = self.moment(after);
        match self.before {
            Some(before) => self.between(before, next, 2.0 * step, random, row),
            None => self.between(self.now, next, step, random, row),
        }
    }

    /// What it says before a step: its acceleration is that of the last step, none before the first one.
    pub fn say(&self, step: f64, random: &mut Random) -> Vec<f64> {
        let mut row = Vec::with_capacity(6);
        self.between(self.before.unwrap_or(self.now), self.now, step, random, &mut row);
        row
    }

    fn between(&self, from: Moment, next: Moment, time: f64, random: &mut Random, row: &mut Vec<f64>) {
        let now = self.now;
        let [x, y, z, w] = now.orientation;
        let specific: [f64; 3] =
            std::array::from_fn(|i| (next.velocity[i] - from.velocity[i]) / time - self.gravity[i]);
        let [roll, pitch, yaw] = self.imu.rotation;
        let mounted = UnitQuaternion::from_euler_angles(roll, pitch, yaw).inverse();
        let acceleration = mounted * Vector3::from(rotate([-x, -y, -z, w], specific));
        let angular = mounted * Vector3::from(now.angular);
        let (linear_axes, angular_axes) = self.base.axes();
        let imu = &self.imu;
        for &i in linear_axes {
            row.push(acceleration[i] + imu.acceleration_bias[i] + imu.acceleration_noise * random.normal());
        }
        for &i in angular_axes {
            row.push(
                angular[i] + imu.angular_velocity_bias[i] + imu.angular_velocity_noise * random.normal(),
            );
        }
    }
}
