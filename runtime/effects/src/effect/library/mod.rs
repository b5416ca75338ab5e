//! All kinds of effects, by family.
mod assumptions;
mod contact;
mod drive;
mod friction;
mod inertia;
mod sensor;

use super::kind::{Confounder, Identified, Kind, Law, Parameter, Place, Role, Size};
use super::relations::Relations;
use super::search::{Columns, Evidence, Parameters, Search, Starts, slope, unit};
use super::simulation::{Dry, Simulation};

/// All kinds by name.
pub mod kinds {
    pub use super::assumptions::*;
    pub use super::contact::*;
    pub use super::drive::*;
    pub use super::friction::*;
    pub use super::inertia::*;
    pub use super::sensor::*;
}

/// All kinds, in the order in which documentation lists them.
pub static KINDS: &[&Kind] = &[
    &friction::VISCOUS_FRICTION,
    &friction::QUADRATIC_DRAG,
    &friction::COULOMB_FRICTION,
    &friction::ASYMMETRIC_COULOMB_FRICTION,
    &friction::STRIBECK_FRICTION,
    &friction::LOAD_DEPENDENT_FRICTION,
    &inertia::ROTOR_INERTIA,
    &inertia::PAYLOAD,
    &inertia::COM_OFFSET,
    &inertia::INERTIA_ERROR,
    &inertia::INERTIAL_CORRECTION,
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

/// The kinds that a search looks for there.
pub fn sought(evidence: Evidence) -> impl Iterator<Item = &'static Kind> {
    KINDS.iter().copied().filter(move |kind| kind.search.sought.contains(&evidence))
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
    let size = Size::NothingAt(0.0);
    Parameter {
        name,
        unit,
        role: Role::Estimated,
        bounds,
        plausible,
        meaning,
        size,
        reach: None,
        sliding: None,
    }
}

impl Parameter {
    const fn of_size(self, size: Size) -> Self {
        Self { size, ..self }
    }
    const fn within(self, reach: (f64, f64)) -> Self {
        Self { reach: Some(reach), ..self }
    }
}

/// A limit is where readings pile up: it does not wander off.
const NEAR: (f64, f64) = (0.7, 1.4);

const MOTION: &[Evidence] = &[Evidence::Motion];
const ON_THE_GROUND: &[Evidence] = &[Evidence::Contact, Evidence::Postures];
const EVERYWHERE: &[Evidence] = &[Evidence::Motion, Evidence::Contact, Evidence::Postures, Evidence::Impacts];

/// The excess over a limit, which is what does not enter linearly, counts once: a factor far from one is another effect.
fn beyond_the_limit(_limit: f64, coefficients: &[f64]) -> Option<String> {
    let fits = coefficients.first().is_some_and(|c| (0.8..1.25).contains(c));
    (!fits).then(|| "what lies beyond the limit does not fit".to_owned())
}

/// The same where the limit is so near to most of what exceeds it that a start beside the truth leaves half of the excess, or twice as much:
/// the exact estimate that follows moves the limit, and is judged.
fn far_beyond_the_limit(_limit: f64, coefficients: &[f64]) -> Option<String> {
    let fits = coefficients.first().is_some_and(|c| (0.4..2.5).contains(c));
    (!fits).then(|| "what lies beyond the limit does not fit".to_owned())
}

/// No sensor's gain is known better than this.
const SAME_GAIN: f64 = 0.005;

/// The coefficient is the relative deviation of a gain from 1.
fn same_gain(_start: f64, coefficients: &[f64]) -> Option<String> {
    let off = coefficients.first()?.abs();
    (off < SAME_GAIN)
        .then(|| format!("a gain that differs by {:.2} % is the sensor's tolerance", 100.0 * off))
}

/// The parameter that does not enter linearly is the only one; its response counts once.
macro_rules! only_start {
    ($name:literal) => {
        Columns::Combined {
            probes: |start| vec![vec![(1.0, vec![($name, start)])]],
            parameters: |start, c| c.iter().map(|_| ($name, start)).collect(),
        }
    };
}
use only_start;

const fn identified(
    option: &'static str,
    unknown: &'static str,
    by_default: bool,
    positive: bool,
) -> Option<Identified> {
    Some(Identified { option, unknown, by_default, positive })
}

/// Speed below which a smoothed sign is not ±1 yet.
const SMOOTHING: Parameter = Parameter {
    name: "smoothing",
    unit: "rad/s",
    role: Role::Setting(0.02),
    bounds: (1e-6, f64::INFINITY),
    plausible: (1e-4, 0.5),
    meaning: "speed over which friction changes its sign",
    size: Size::Place,
    reach: None,
    sliding: None,
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
