//! Causes that the library does not have.
use super::drive::Moving;
use bipedc_effects::effect::{Effect, Kind, Law, Place, Relations, Search, Simulation};

/// A cause outside of the library.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outsider {
    /// Dry friction that varies along the way: an eccentric seal. N m; depth; periods per turn.
    PositionFriction([f64; 3]),
    /// Dry friction that grows with time: N m at the start, and after one second of it so much more.
    WarmingFriction([f64; 2]),
    /// stiffness (N m/rad³), rest angle (rad)
    CubicSpring([f64; 2]),
    /// N m s³/rad³
    CubicDrag(f64),
    /// A loose part on a spring: inertia (kg m²), stiffness (N m/rad), damping (N m s/rad).
    Oscillator([f64; 3]),
    /// N m s²/rad² times the product of two joints' velocities.
    VelocityProduct(f64, usize),
}

/// All outsiders, as the truth names them.
static KINDS: [Kind; 6] = [
    named("position_friction"),
    named("warming_friction"),
    named("cubic_spring"),
    named("cubic_drag"),
    named("hidden_oscillator"),
    named("velocity_product"),
];

/// A kind of which no tool knows anything.
const fn named(name: &'static str) -> Kind {
    Kind {
        name,
        title: name,
        place: Place::Joint,
        parameters: &[],
        law: Law::Formula,
        simulation: Simulation::Law,
        search: Search::none(),
        relations: Relations::NONE,
        identified: None,
        meaning: "",
        symptom: "",
        confounders: &[],
        experiment: "",
    }
}

/// The outsider of this name.
pub fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}

/// The outsider that an effect of this name means.
pub fn outsider(effect: &Effect, other: Option<usize>) -> Option<Outsider> {
    let value = |name: &str| effect.value(name);
    Some(match effect.kind.name {
        "position_friction" => Outsider::PositionFriction(["torque", "depth", "periods"].map(value)),
        "warming_friction" => Outsider::WarmingFriction(["torque", "growth"].map(value)),
        "cubic_spring" => Outsider::CubicSpring(["stiffness", "rest_angle"].map(value)),
        "cubic_drag" => Outsider::CubicDrag(value("drag")),
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
            Self::CubicDrag(drag) => drag * v.powi(3),
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
