//! All kinds of effects, by family.
mod assumptions;
mod contact;
mod drive;
mod friction;
mod inertia;
mod sensor;

use super::kind::{Confounder, Kind, Law, Parameter, Place, Role};

/// All kinds, in the order in which documentation lists them.
pub const KINDS: &[&Kind] = &[
    &friction::VISCOUS_FRICTION,
    &friction::COULOMB_FRICTION,
    &friction::ASYMMETRIC_COULOMB_FRICTION,
    &friction::STRIBECK_FRICTION,
    &friction::LOAD_DEPENDENT_FRICTION,
    &inertia::ROTOR_INERTIA,
    &inertia::PAYLOAD,
    &inertia::COM_OFFSET,
    &inertia::INERTIA_ERROR,
    &drive::PARALLEL_SPRING,
    &drive::SERIES_ELASTICITY,
    &drive::BACKLASH,
    &drive::TORQUE_GAIN,
    &drive::TORQUE_BIAS,
    &drive::TORQUE_SATURATION,
    &drive::TORQUE_RIPPLE,
    &drive::ACTUATOR_DELAY,
    &sensor::ENCODER_OFFSET,
    &sensor::GRAVITY_TILT,
    &contact::GROUND_SLOPE,
    &sensor::FORCE_SENSOR_GAIN,
    &sensor::FORCE_SENSOR_BIAS,
    &sensor::FORCE_SENSOR_SATURATION,
    &contact::GROUND_COMPLIANCE,
    &contact::IMPACT_RESTITUTION,
    &contact::FOOT_SLIP,
    &contact::SPIN_FRICTION,
    &drive::COUPLING,
    &assumptions::POINT_FEET,
    &assumptions::NO_IMPACT,
    &assumptions::SINGLE_MASS,
    &assumptions::DECOUPLED_PLANES,
    &drive::FORMULA,
];

/// The kind of this name.
pub fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.iter().copied().find(|kind| kind.name == name)
}

/// What a torque law may depend on, besides its parameters.
pub const VARIABLES: [&str; 7] = [
    "position",
    "velocity",
    "acceleration",
    "load",
    "other_position",
    "other_velocity",
    "other_acceleration",
];

const INFINITE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
const POSITIVE: (f64, f64) = (0.0, f64::INFINITY);

/// A parameter that data decide.
const fn estimated(
    name: &'static str,
    unit: &'static str,
    bounds: (f64, f64),
    plausible: (f64, f64),
    meaning: &'static str,
) -> Parameter {
    Parameter { name, unit, role: Role::Estimated, bounds, plausible, meaning }
}

/// Speed below which a smoothed sign is not ±1 yet.
const SMOOTHING: Parameter = Parameter {
    name: "smoothing",
    unit: "rad/s",
    role: Role::Setting(0.02),
    bounds: (1e-6, f64::INFINITY),
    plausible: (1e-4, 0.5),
    meaning: "speed over which friction changes its sign",
};

const fn confounder(kind: &'static str, experiment: &'static str) -> Confounder {
    Confounder { kind, experiment }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_confounders_exist() {
        for (i, a) in KINDS.iter().enumerate() {
            assert!(KINDS[..i].iter().all(|b| b.name != a.name), "{} is defined twice", a.name);
            for confounder in a.confounders {
                assert!(kind(confounder.kind).is_some(), "{}: no kind `{}`", a.name, confounder.kind);
            }
            for p in a.parameters {
                assert!(p.bounds.0 <= p.plausible.0 && p.plausible.1 <= p.bounds.1, "{}.{}", a.name, p.name);
            }
        }
    }

    #[test]
    fn laws_are_formulas_in_known_names() {
        for kind in KINDS {
            let (text, variables): (_, &[&str]) = match kind.law {
                Law::Torque(text) => (text, &VARIABLES),
                Law::Reading(text) => (text, &["torque"]),
                Law::TrueTorque(text) => (text, &["reading"]),
                _ => continue,
            };
            let formula = crate::effect::formula::Formula::parse(text).unwrap();
            let names: Vec<&str> =
                variables.iter().copied().chain(kind.parameters.iter().map(|p| p.name)).collect();
            assert!(formula.bind(&names).is_ok(), "{}: {text}", kind.name);
            for parameter in kind.parameters {
                assert!(
                    formula.names().iter().any(|n| n == parameter.name),
                    "{}.{}",
                    kind.name,
                    parameter.name
                );
            }
        }
    }
}
