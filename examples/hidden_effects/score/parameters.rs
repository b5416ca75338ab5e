//! How far found numbers are from the true ones.
use crate::generator::Scales;
use bipedc_effects::effect::Effect;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// What counts as right.
pub const TOLERANCE: f64 = 0.15;
/// Right positions of payloads are at least this near, m.
const NEAR: f64 = 0.010;

/// Relative error of a found effect: at most [`TOLERANCE`] is right. See the help of the program for the rules.
pub fn error(truth: &Effect, found: &Effect, scales: &BTreeMap<String, Scales>) -> f64 {
    let part = |name: &str| relative(truth.value(name), found.value(name));
    let vector = |names: &[&str]| vector(truth, found, names, &vec![1.0; names.len()]);
    let joint = truth.location.joint.as_ref().and_then(|name| scales.get(name)).copied().unwrap_or_default();
    match truth.kind.name {
        "payload" => {
            let [size, off] = norms(truth, found, &["x", "y", "z"], &[1.0; 3]);
            part("mass").max(off / size.max(NEAR / TOLERANCE))
        }
        "com_offset" | "force_sensor_bias" => vector(&["x", "y", "z"]),
        // Products count twice, as in the matrix.
        "inertia_error" => {
            let root = std::f64::consts::SQRT_2;
            let names = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
            self::vector(truth, found, &names, &[1.0, root, root, 1.0, root, 1.0])
        }
        "gravity_tilt" | "ground_slope" => vector(&["roll", "pitch"]),
        "asymmetric_coulomb_friction" => vector(&["positive", "negative"]),
        "parallel_spring" => {
            let size = truth.value("rest_angle").abs().max(2.0 * joint.position);
            part("stiffness").max((found.value("rest_angle") - truth.value("rest_angle")).abs() / size)
        }
        "torque_gain" | "force_sensor_gain" => {
            (found.value("gain") - truth.value("gain")).abs() / (truth.value("gain") - 1.0).abs()
        }
        "torque_ripple" => {
            let phase = |effect: &Effect| {
                effect.value("periods_per_turn") * joint.mean_position + effect.value("phase")
            };
            let off = (phase(found) - phase(truth)).rem_euclid(TAU);
            part("amplitude").max(part("periods_per_turn")).max(off.min(TAU - off) / PI)
        }
        "coupling" => {
            let other = truth.location.other_joint.as_ref().and_then(|name| scales.get(name));
            let other = other.copied().unwrap_or_default();
            let position = other.position.hypot(other.mean_position);
            let weights = [other.acceleration, other.velocity, 1.0, position];
            self::vector(truth, found, &["inertia", "damping", "coulomb", "stiffness"], &weights)
        }
        // At the speeds of these logs the damping makes less than a hundredth of the force.
        "ground_compliance" => part("stiffness"),
        _ => truth.kind.estimated().map(|p| part(p.name)).fold(0.0, f64::max),
    }
}

fn relative(truth: f64, found: f64) -> f64 {
    (found - truth).abs() / truth.abs().max(1e-12)
}

/// Weighted norms of the truth and of what it differs by.
fn norms(truth: &Effect, found: &Effect, names: &[&str], weights: &[f64]) -> [f64; 2] {
    let norm = |value: &dyn Fn(&str) -> f64| {
        names.iter().zip(weights).map(|(name, w)| (w * value(name)).powi(2)).sum::<f64>().sqrt()
    };
    [norm(&|name| truth.value(name)), norm(&|name| found.value(name) - truth.value(name))]
}

fn vector(truth: &Effect, found: &Effect, names: &[&str], weights: &[f64]) -> f64 {
    let [size, off] = norms(truth, found, names, weights);
    off / size.max(1e-12)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_effects::effect::{Location, kinds};

    #[test]
    fn rules_are_as_the_help_says() {
        let none = BTreeMap::new();
        let payload =
            |mass, x| Effect::new(&kinds::PAYLOAD, Location::link("a"), &[("mass", mass), ("x", x)]);
        assert!((error(&payload(1.0, 0.02), &payload(1.1, 0.02), &none) - 0.1).abs() < 1e-12);
        // 9 mm are right although they are nearly half of the distance.
        assert!(error(&payload(1.0, 0.02), &payload(1.0, 0.029), &none) < TOLERANCE);
        assert!(error(&payload(1.0, 0.02), &payload(1.0, 0.031), &none) > TOLERANCE);
        let gain = |gain| Effect::new(&kinds::TORQUE_GAIN, Location::joint("a"), &[("gain", gain)]);
        assert!((error(&gain(0.8), &gain(1.0), &none) - 1.0).abs() < 1e-12);
        let ripple = |phase| {
            let numbers = [("amplitude", 1.0), ("periods_per_turn", 10.0), ("phase", phase)];
            Effect::new(&kinds::TORQUE_RIPPLE, Location::joint("a"), &numbers)
        };
        assert!(error(&ripple(3.1), &ripple(-3.1), &none) < 0.05);
    }
}
