//! What an estimator is told: readings, where the legs say that the soles are, and how good all of it is.
use super::space::{Pose, Vector, zero};
use crate::real::Scalar;

/// Most joints behind the base.
pub const MOST_JOINTS: usize = 42;

/// What sensors say at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensed<'a, R> {
    /// s. In `f32` a step of 1 ms is known to 1 % for two minutes only: let it begin anew while the robot rests.
    pub time: R,
    /// rad; m of prismatic joints
    pub joint_position: &'a [R],
    /// rad/s; `None`: positions are differenced and filtered.
    pub joint_velocity: Option<&'a [R]>,
    /// Of the gyroscope, axes of the base, rad/s.
    pub angular_velocity: [R; 3],
    /// Of the accelerometer, axes of the base: 9.81 upward at rest, m/s².
    pub specific_force: [R; 3],
    /// Normal force on each foot, N: right, left.
    pub load: [R; 2],
    /// Centres of pressure, x and y in the frame of the foot's link, m: right, left; NaN: nothing presses, or nobody measures it. They tell payloads.
    pub center: [[R; 2]; 2],
    /// Angle of each joint's motor as seen at the joint, rad; NaN where nobody measures it; may be empty. Needed where the robot has springs.
    pub motor_position: &'a [R],
}

/// Where the soles are, seen from the base.
pub trait LegKinematics<R> {
    /// How many joints there are.
    fn joints(&self) -> usize;

    /// The pose of a sole (0: right, 1: left) in the frame of the base, axes forward, left, up; into `jacobian`, for every joint, the linear and angular
    /// velocity of its origin per rate of the joint, axes of the base. `None`: there is no such foot.
    fn sole(&self, foot: usize, joint_position: &[R], jacobian: &mut [[R; 6]]) -> Option<Pose<R>>;
}

/// How good sensors, legs and ground are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings<R> {
    /// m/s²
    pub gravity: R,
    /// Place of the inertial unit in the frame of the base, m.
    pub unit: Vector<R>,
    /// Noise of the gyroscope, rad/s/√Hz, and of the accelerometer, m/s²/√Hz.
    pub noise: [R; 2],
    /// Standard deviations of their biases at the beginning, rad/s and m/s².
    pub bias: [R; 2],
    /// How these wander, per √s.
    pub bias_walk: [R; 2],
    /// Standard deviation of a joint's reading, rad.
    pub encoder: R,
    /// What else is wrong with where a leg says that the sole is while it stands: m, rad of its tilt, rad about the vertical.
    pub leg: [R; 3],
    /// How a foot that stands moves, tilts and turns nevertheless: m/√s, rad/√s, rad/√s; what it tips or turns at once is seen.
    pub foot: [R; 3],
    /// Level ground: how far a foot at rest is from its height (m) and from lying flat (rad); infinite: nothing is known of it.
    pub ground: [R; 2],
    /// Tangent of the ground's slope that is expected, and how it changes, per √s. The world's plane is that of the ground.
    pub slope: [R; 2],
    /// Loads (N) below which a foot is lifted, from which on it stands, from which on it counts fully.
    pub loads: [R; 3],
    /// Fastest motion of a joint, rad/s.
    pub joint_speed: R,
    /// Largest readings of gyroscope and accelerometer, rad/s and m/s².
    pub ranges: [R; 2],
    /// Time constant of differenced joint positions, s.
    pub velocity_filter: R,
}

impl<R: Scalar> Settings<R> {
    /// For a robot of so many newtons with sensors of today: noise of a small inertial unit, encoders of 0.1 mrad.
    pub fn of_weight(weight: R) -> Self {
        let x = R::constant;
        Self {
            gravity: x(9.81),
            unit: zero(),
            noise: [x(2e-4), x(1e-2)],
            bias: [x(0.02), x(0.1)],
            bias_walk: [x(1e-5), x(1e-3)],
            encoder: x(1e-4),
            leg: [x(5e-4), x(1e-3), x(3e-5)],
            foot: [x(2e-4), x(5e-4), x(2e-5)],
            ground: [x(2e-3), x(5e-3)],
            slope: [x(0.05), x(2e-3)],
            loads: [x(0.05) * weight, x(0.1) * weight, x(0.4) * weight],
            joint_speed: x(30.0),
            ranges: [x(50.0), x(500.0)],
            velocity_filter: x(5e-3),
        }
    }
}

/// What was not as it should be; the first thing if there were several.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Time did not advance: nothing is done (the tenth time in a row it is another clock); or by more than 0.1 s: so long nothing is integrated, and feet are
    /// anchored anew.
    Time,
    /// There are not as many joints as the legs have, or more than [`MOST_JOINTS`]: nothing was done.
    Length,
    /// A joint's position is not finite or jumped: its leg is not believed.
    JointPosition(usize),
    /// A joint's velocity is not finite: positions are differenced.
    JointVelocity(usize),
    /// Not finite, out of range or frozen: the legs alone tell how the base turns.
    Gyroscope,
    /// Not finite, out of range or frozen: the legs alone tell how the base moves.
    Accelerometer,
    /// The load of a foot is not finite: it is taken to carry what the other one does not; with neither known, feet stand as before.
    Load(usize),
    /// The legs' kinematics gave nothing finite.
    Kinematics(usize),
    /// A foot that stood moved away.
    Slip(usize),
    /// No foot stands.
    Aloft,
    /// Numbers went out of bounds: begun anew where the robot was.
    Restarted,
}
