//! States of a robot from a JSON file: one object, or an array of them.
//!
//! ```json
//! {"base": {"position": [0, 0, 0.9], "orientation": [0, 0, 0, 1],
//!           "linear_velocity": [0.4, 0, 0], "angular_velocity": [0, 0, 0],
//!           "linear_acceleration": [0, 0, 0], "angular_acceleration": [0, 0, 0],
//!           "force": [0, 0, 0], "torque": [0, 0, 0]},
//!  "position": {"left_knee": 0.2}, "velocity": {}, "acceleration": {}, "effort": {},
//!  "forces": {"left_foot/toe": [0, 0, 30]}}
//! ```
//!
//! Base rates, force and torque are in the base's axes; the accelerations are the time derivatives of the
//! twist's components. Whatever is missing is zero, the orientation the identity.
mod coordinates;
mod json;

pub use json::read_states;

use bipedc_runtime::{Argument, State};

/// Pose, twist, its rate and the wrench of the base.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseState {
    /// In the world, m.
    pub position: [f64; 3],
    /// Quaternion x y z w, base to world.
    pub orientation: [f64; 4],
    /// Base axes, m/s.
    pub linear_velocity: [f64; 3],
    /// Base axes, rad/s.
    pub angular_velocity: [f64; 3],
    /// Time derivatives of the components of `linear_velocity`, m/s².
    pub linear_acceleration: [f64; 3],
    /// Time derivatives of the components of `angular_velocity`, rad/s².
    pub angular_acceleration: [f64; 3],
    /// On the base, base axes, N.
    pub force: [f64; 3],
    /// On the base about its origin, base axes, N m.
    pub torque: [f64; 3],
}

impl Default for BaseState {
    fn default() -> Self {
        let zero = [0.0; 3];
        Self {
            position: zero,
            orientation: [0.0, 0.0, 0.0, 1.0],
            linear_velocity: zero,
            angular_velocity: zero,
            linear_acceleration: zero,
            angular_acceleration: zero,
            force: zero,
            torque: zero,
        }
    }
}

/// One state in the coordinates of a robot: the arguments of its functions.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinates {
    /// Indexed by [`Argument`]; parameters stay empty.
    pub arguments: [Vec<f64>; Argument::COUNT],
}

impl Coordinates {
    /// As functions take it.
    pub fn state(&self) -> State<'_, f64> {
        State { slices: std::array::from_fn(|k| self.arguments[k].as_slice()) }
    }
}
