//! Numbers for effects: uniform in their logarithm, in ranges that are usual for robots of 20 kg.
use super::drive::{MOTOR_INERTIA, STOPS};
use super::hanging::STEPS;
use super::model::link_center;
use super::outside;
use super::random::Random;
use super::truth::{Alternative, Part, Plan, Scales, Truth};
use bipedc_compiler::description::model::RobotDescription;
use bipedc_effects::effect::{self, Effect, Location, kinds};

/// Draws all effects of a plan into its truth.
pub fn effects(plan: &Plan, description: &RobotDescription, truth: &mut Truth, random: &mut Random) {
    for part in &plan.parts {
        let joint = part.place.joint.as_deref().unwrap_or_default();
        let scales = truth.scales.get(joint).copied().unwrap_or_default();
        let parameters = if part.place.link.is_some() {
            inertial(part, plan.size, description, random)
        } else {
            joint_or_sensor(part, &scales, truth, random)
        };
        let outside = outside::kind(part.kind);
        // A test sees to it that all others are in the library.
        let Some(kind) = outside.or_else(|| effect::kind(part.kind)) else { continue };
        let effect = Effect::new(kind, part.place.clone(), &parameters);
        if outside.is_some() { &mut truth.outsiders } else { &mut truth.effects }.push(effect);
    }
    for effect in truth.effects.clone() {
        if matches!(effect.kind.name, "series_elasticity" | "backlash") {
            let motor = [("inertia", MOTOR_INERTIA)];
            truth.also_present.push(Effect::new(&kinds::ROTOR_INERTIA, effect.location.clone(), &motor));
        }
        if effect.kind.name == "backlash" {
            let stops = [("stiffness", STOPS)];
            truth.also_present.push(Effect::new(&kinds::SERIES_ELASTICITY, effect.location, &stops));
        }
    }
    truth.alternatives = alternatives(&truth.effects);
}

/// A torque between 20 % and 60 % of the joint's own.
fn torque(scales: &Scales, random: &mut Random) -> f64 {
    (scales.torque * random.log_range(0.2, 0.6)).max(0.03)
}

fn joint_or_sensor(
    part: &Part,
    own: &Scales,
    truth: &Truth,
    random: &mut Random,
) -> Vec<(&'static str, f64)> {
    let size = torque(own, random);
    let r = random;
    match part.kind {
        "viscous_friction" => vec![("damping", (size / own.velocity).clamp(0.01, 5.0))],
        "quadratic_drag" => vec![("drag", (size / own.velocity.powi(2)).clamp(0.01, 5.0))],
        "coulomb_friction" => vec![("torque", size.min(3.0))],
        "asymmetric_coulomb_friction" => {
            let (a, b) = (size, size * r.range(0.35, 0.6));
            let [positive, negative] = if r.unit() < 0.5 { [a, b] } else { [b, a] };
            vec![("positive", positive), ("negative", negative)]
        }
        "stribeck_friction" => vec![
            ("coulomb", size),
            ("static", size * r.range(1.6, 2.5)),
            ("stribeck_velocity", own.velocity * r.log_range(0.3, 0.8)),
        ],
        "load_dependent_friction" => vec![("coefficient", r.log_range(0.15, 0.4))],
        "rotor_inertia" => vec![("inertia", (size / own.acceleration).clamp(0.003, 0.2))],
        "parallel_spring" => {
            let stiffness = size / own.position;
            vec![
                ("stiffness", stiffness),
                ("rest_angle", own.mean_position + r.range(-1.0, 1.0) * own.position),
            ]
        }
        "series_elasticity" => vec![("stiffness", own.torque / r.log_range(0.008, 0.03))],
        "backlash" => vec![("gap", r.log_range(0.008, 0.03))],
        "torque_gain" => vec![("gain", if r.unit() < 0.5 { r.range(0.7, 0.85) } else { r.range(1.2, 1.4) })],
        "torque_bias" => vec![("bias", size * r.sign())],
        "torque_saturation" => vec![("limit", own.peak_torque * r.range(0.65, 0.8))],
        "torque_ripple" => vec![
            ("amplitude", size),
            ("periods_per_turn", r.log_range(12.0, 36.0).round()),
            ("phase", r.range(-3.1, 3.1)),
        ],
        // Whole steps of the simulation, which can do no others.
        "actuator_delay" => vec![("delay", (r.log_range(0.005, 0.02) * STEPS).round() / STEPS)],
        "encoder_offset" => vec![("offset", r.sign() * r.log_range(0.03, 0.12))],
        "gravity_tilt" | "ground_slope" => {
            ["roll", "pitch"].map(|name| (name, r.sign() * r.log_range(0.015, 0.06))).to_vec()
        }
        "coupling" => coupling(part, own, truth, size, r),
        _ => contact(part, own, size, r),
    }
}

/// Cables (damping and dry friction) or a linkage (inertia and stiffness).
fn coupling(
    part: &Part,
    own: &Scales,
    truth: &Truth,
    size: f64,
    random: &mut Random,
) -> Vec<(&'static str, f64)> {
    let other = part.place.other_joint.as_ref().and_then(|name| truth.scales.get(name)).unwrap_or(own);
    let zero = [("inertia", 0.0), ("damping", 0.0), ("coulomb", 0.0), ("stiffness", 0.0)];
    let mut parameters = zero.to_vec();
    if random.unit() < 0.5 {
        parameters[1].1 = 0.6 * size / other.velocity;
        parameters[2].1 = 0.7 * size;
    } else {
        // An inertia of the other joint's motion must not exceed what keeps the mass matrix invertible.
        parameters[0].1 = (0.5 * size / other.acceleration).min(0.02);
        parameters[3].1 = 0.8 * size / other.position.max(other.mean_position.abs());
    }
    parameters
}

fn contact(part: &Part, own: &Scales, size: f64, r: &mut Random) -> Vec<(&'static str, f64)> {
    let at_corner = part.place.sensor.as_deref().is_some_and(|name| name.contains('/'));
    match part.kind {
        "force_sensor_gain" => {
            vec![("gain", if r.unit() < 0.5 { r.range(0.8, 0.93) } else { r.range(1.07, 1.2) })]
        }
        // At one corner only the vertical force is measured.
        "force_sensor_bias" if at_corner => {
            vec![("x", 0.0), ("y", 0.0), ("z", r.sign() * r.log_range(3.0, 12.0))]
        }
        "force_sensor_bias" => ["x", "y", "z"].map(|name| (name, r.sign() * r.log_range(3.0, 12.0))).to_vec(),
        "force_sensor_saturation" => vec![("limit", r.range(20.0, 24.0))],
        "ground_compliance" => {
            vec![("stiffness", r.log_range(8e3, 3e4)), ("damping", r.log_range(20.0, 100.0))]
        }
        "impact_restitution" => vec![("coefficient", r.log_range(0.1, 0.4))],
        "foot_slip" => vec![("friction", r.log_range(0.15, 0.4))],
        "spin_friction" => vec![("radius", r.log_range(0.01, 0.04))],
        "position_friction" => vec![("torque", size), ("depth", 0.9), ("periods", r.range(5.0, 9.0))],
        "warming_friction" => vec![("torque", 0.2 * size), ("growth", 0.16 * size)],
        "cubic_spring" => {
            vec![("stiffness", size / own.position.powi(3)), ("rest_angle", own.mean_position)]
        }
        "cubic_drag" => vec![("drag", 0.7 * size / own.velocity.powi(3))],
        "hidden_oscillator" => {
            let stiffness = 1.5 * size / own.position;
            let omega = r.range(7.0, 12.0);
            vec![
                ("inertia", stiffness / (omega * omega)),
                ("stiffness", stiffness),
                ("damping", 0.15 * stiffness / omega),
            ]
        }
        "velocity_product" => vec![("factor", size / own.velocity.powi(2))],
        _ => Vec::new(),
    }
}

fn inertial(
    part: &Part,
    size: f64,
    description: &RobotDescription,
    r: &mut Random,
) -> Vec<(&'static str, f64)> {
    let name = part.place.link.as_deref().unwrap_or_default();
    let center = link_center(description, name);
    let link = description.links.iter().find(|link| link.name == name);
    let Some(own) = link.and_then(|link| link.inertial.as_ref()) else { return Vec::new() };
    match part.kind {
        "payload" => {
            let mut out = vec![("mass", own.mass * r.log_range(0.15, 0.6).min(1.5 / own.mass))];
            let at = ["x", "y", "z"].into_iter().zip(center);
            out.extend(at.map(|(axis, c)| (axis, c + size * r.sign() * r.log_range(0.03, 0.12))));
            out
        }
        "com_offset" => {
            ["x", "y", "z"].map(|axis| (axis, size * r.sign() * r.log_range(0.008, 0.03))).to_vec()
        }
        _ => {
            let [xx, _, _, yy, _, zz] = own.inertia;
            // Principal moments of a body fulfil the triangle inequality; enlarging all of them by one part does too.
            let part = r.log_range(0.5, 1.5);
            let diagonal = [xx, yy, zz].map(|moment| part * moment);
            let least = diagonal[0].min(diagonal[1]).min(diagonal[2]);
            let product = |r: &mut Random| 0.2 * least * r.sign();
            vec![
                ("ixx", diagonal[0]),
                ("ixy", product(r)),
                ("ixz", product(r)),
                ("iyy", diagonal[1]),
                ("iyz", product(r)),
                ("izz", diagonal[2]),
            ]
        }
    }
}

/// Explanations that are the same by algebra.
fn alternatives(effects: &[Effect]) -> Vec<Alternative> {
    let mut out = Vec::new();
    let find = |kind: &str| effects.iter().find(|effect| effect.kind.name == kind);
    if let (Some(dry), Some(bias)) = (find("coulomb_friction"), find("torque_bias"))
        && dry.location == bias.location
    {
        let (torque, bias) = (dry.value("torque"), bias.value("bias"));
        let parameters = [("positive", torque + bias), ("negative", torque - bias)];
        let same = Effect::new(&kinds::ASYMMETRIC_COULOMB_FRICTION, dry.location.clone(), &parameters);
        out.push(alternative(same, "T sign(v) + b is T + b at positive and −(T − b) at negative velocity"));
    }
    out
}

fn alternative(effect: Effect, reason: &str) -> Alternative {
    Alternative { effects: vec![effect], reason: reason.to_owned() }
}

/// In postures nothing but the soles tells where up is.
pub fn tilt_is_slope(truth: &mut Truth) {
    let Some(slope) = truth.effects.iter().find(|effect| effect.kind.name == "ground_slope") else { return };
    let mut tilt = slope.clone();
    tilt.kind = &kinds::GRAVITY_TILT;
    tilt.location = Location::default();
    truth.alternatives.push(alternative(tilt, "in postures the base follows from the sole"));
}
