//! Causes that the library does not have.
use super::drive::Moving;
use bipedc_effects::effect::Effect;

/// A cause outside of the library.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outsider {
    /// Dry friction that varies along the way: an eccentric seal. N m; depth; periods per turn.
    PositionFriction([f64; 3]),
    /// Dry friction that grows with time: N m at the start, and after one second of it so much more.
    WarmingFriction([f64; 2]),
    /// stiffness (N m/rad³), rest angle (rad)
    CubicSpring([f64; 2]),
    /// N m s²/rad²
    QuadraticDrag(f64),
    /// A loose part on a spring: inertia (kg m²), stiffness (N m/rad), damping (N m s/rad).
    Oscillator([f64; 3]),
    /// N m s²/rad² times the product of two joints' velocities.
    VelocityProduct(f64, usize),
}

/// Names of all outsiders.
pub const NAMES: [&str; 6] = [
    "position_friction",
    "warming_friction",
    "cubic_spring",
    "quadratic_drag",
    "hidden_oscillator",
    "velocity_product",
];

/// The outsider that an effect of this name means.
pub fn outsider(effect: &Effect, other: Option<usize>) -> Option<Outsider> {
    let value = |name: &str| effect.value(name);
    Some(match effect.kind.as_str() {
        "position_friction" => Outsider::PositionFriction(["torque", "depth", "periods"].map(value)),
        "warming_friction" => Outsider::WarmingFriction(["torque", "growth"].map(value)),
        "cubic_spring" => Outsider::CubicSpring(["stiffness", "rest_angle"].map(value)),
        "quadratic_drag" => Outsider::QuadraticDrag(value("drag")),
        "hidden_oscillator" => Outsider::Oscillator(["inertia", "stiffness", "damping"].map(value)),
        "velocity_product" => Outsider::VelocityProduct(value("factor"), other?),
        _ => return None,
    })
}

impl Outsider {
    /// Smooth torque, added to the inverse dynamics.
    pub fn torque(self, joint: usize, state: &Moving<'_>) -> f64 {
        let (q, v) = (state.q[joint], state.v[joint]);
        match self {
            Self::CubicSpring([stiffness, rest]) => stiffness * (q - rest).powi(3),
            Self::QuadraticDrag(drag) => drag * v * v.abs(),
            Self::VelocityProduct(factor, other) => factor * v * state.v[other],
            Self::PositionFriction(_) | Self::WarmingFriction(_) | Self::Oscillator(_) => 0.0,
        }
    }

    /// Largest dry friction, N m, at an angle and a time.
    pub fn dry(self, q: f64, time: f64) -> f64 {
        match self {
            Self::PositionFriction([torque, depth, periods]) => torque * (1.0 + depth * (periods * q).sin()),
            Self::WarmingFriction([torque, growth]) => torque + growth * time.max(0.0),
            _ => 0.0,
        }
    }
}
