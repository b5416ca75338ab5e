//! Robots with effects in process, random states, and the same law by numbers.
use bipedc_compiler::compile::ProgramModel;
use bipedc_compiler::description::model::RobotDescription;
use bipedc_compiler::{Robot, compile};
use bipedc_effects::effect::formula::Formula;
use bipedc_effects::effect::{Effect, Law, Location, Place, VARIABLES, kinds};
use bipedc_runtime::{Argument, Model, Real, State};
use std::path::Path;

/// Xorshift.
pub struct Random(pub u64);

impl Random {
    /// In [-1, 1).
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    pub fn list(&mut self, n: usize, scale: f64) -> Vec<f64> {
        (0..n).map(|_| scale * self.next()).collect()
    }
    pub fn below(&mut self, n: usize) -> usize {
        ((self.next() + 1.0) / 2.0 * n as f64) as usize
    }
}

pub fn description(robot: &str) -> RobotDescription {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(robot);
    Robot::read(&path).unwrap().description
}

pub fn compiled(description: &RobotDescription, functions: &[&str]) -> ProgramModel {
    let tree = bipedc_compiler::tree::Tree::new(description, &description.base).unwrap();
    let subject =
        |f: &str| (f == "constrained_dynamics" || f == "impact_map").then(|| "single_support".to_owned());
    let request = |f: &&str| compile::FunctionRequest { family: (*f).to_owned(), subject: subject(f) };
    let requests: Vec<compile::FunctionRequest> = functions.iter().map(request).collect();
    ProgramModel::new(compile::compile(description, &tree, &requests).unwrap_or_else(|e| panic!("{e}")))
}

pub fn with(description: &RobotDescription, effects: &[Effect]) -> RobotDescription {
    RobotDescription { effects: effects.to_vec(), ..description.clone() }
}

/// Arguments of a call.
#[derive(Debug, Clone)]
pub struct Values<R = f64> {
    pub q: Vec<R>,
    pub v: Vec<R>,
    pub a: Vec<R>,
    pub tau: Vec<R>,
    pub forces: Vec<R>,
}

impl Values {
    pub fn random(model: &ProgramModel, random: &mut Random) -> Self {
        let n = |argument| Model::<f64>::argument_length(model, argument);
        let mut q = random.list(n(Argument::Q), 1.5);
        if n(Argument::Q) > n(Argument::V) {
            let norm = q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
            q[3..7].iter_mut().for_each(|x| *x /= norm);
        }
        Self {
            q,
            v: random.list(n(Argument::V), 2.0),
            a: random.list(n(Argument::A), 5.0),
            tau: random.list(n(Argument::Tau), 10.0),
            forces: random.list(n(Argument::Forces), 20.0),
        }
    }
}

pub fn call<R: Real>(model: &ProgramModel, name: &str, values: &Values<R>) -> Vec<R>
where
    ProgramModel: Model<R>,
{
    let index = (0..)
        .map_while(|k| Model::<f64>::signature(model, k).map(|s| (k, s)))
        .find(|(_, s)| s.name == name || s.name.starts_with(&format!("{name}_of_")))
        .unwrap_or_else(|| panic!("no {name}"));
    let mut out = vec![R::constant(0.0); index.1.rows * index.1.columns];
    let state = State::new()
        .with(Argument::Q, &values.q)
        .with(Argument::V, &values.v)
        .with(Argument::A, &values.a)
        .with(Argument::Tau, &values.tau)
        .with(Argument::Forces, &values.forces);
    model.evaluate(index.0, &state, &mut out).unwrap();
    out
}

#[track_caller]
pub fn close(got: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(got.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(1.0f64, |m, x| m.max(x.abs()));
    for (k, (x, y)) in got.iter().zip(expected).enumerate() {
        assert!((x - y).abs() <= tolerance * scale, "{what}[{k}]: {x} instead of {y} (of {scale})");
    }
}

/// An effect of every kind that acts in a joint, with usual numbers; of pairs, on the second joint.
pub fn joint_effects(joint: &str, other: &str) -> Vec<Effect> {
    let numbers: &[(&str, &[(&str, f64)])] = &[
        ("viscous_friction", &[("damping", 0.3)]),
        ("quadratic_drag", &[("drag", 0.2)]),
        ("coulomb_friction", &[("torque", 0.43)]),
        ("asymmetric_coulomb_friction", &[("positive", 0.4), ("negative", 0.2), ("smoothing", 0.1)]),
        ("stribeck_friction", &[("coulomb", 0.3), ("static", 0.5), ("stribeck_velocity", 0.4)]),
        ("load_dependent_friction", &[("coefficient", 0.2)]),
        ("rotor_inertia", &[("inertia", 0.15)]),
        ("parallel_spring", &[("stiffness", 3.0), ("rest_angle", 0.2)]),
        ("torque_gain", &[("gain", 0.9)]),
        ("torque_bias", &[("bias", 0.7)]),
        ("torque_ripple", &[("amplitude", 0.2), ("periods_per_turn", 7.0), ("phase", 0.3)]),
        ("coupling", &[("inertia", 0.1), ("damping", 0.2), ("coulomb", 0.3), ("stiffness", 0.4)]),
    ];
    let location = |kind: &str| match bipedc_effects::effect::kind(kind).unwrap().place {
        Place::JointPair => Location::pair(joint, other),
        _ => Location::joint(joint),
    };
    let mut all: Vec<Effect> = numbers
        .iter()
        .map(|(kind, numbers)| {
            Effect::new(bipedc_effects::effect::kind(kind).unwrap(), location(kind), numbers)
        })
        .collect();
    for text in [
        "k * sin(3 * position) * velocity + cos(load * 0.01)",
        "k * min(abs(position), 0.3) - max(velocity, other_velocity) + clip(position, -0.5, 0.2)",
        "exp(-position^2) * sqrt(1 + velocity^2) / (2 + tan(0.3 * other_position)) + pi * position^-2 * k",
        "k * load * sign(velocity) * sin(position) + 0.02 * acceleration * cos(sin(other_position))^2",
    ] {
        let mut formula = Effect::new(&kinds::FORMULA, Location::pair(joint, other), &[("k", 0.4)]);
        formula.torque = Some(text.to_owned());
        all.push(formula);
    }
    all
}

/// Rows of joints in `v`.
pub fn row(model: &ProgramModel, joint: &str) -> usize {
    model.compiled().tree.joints.iter().find(|j| j.name == joint).unwrap().v_index
}

/// The reported torques by plain numbers: laws on the rigid-body model's torques, one effect after the other.
pub fn by_numbers(model: &ProgramModel, effects: &[Effect], values: &Values, loads: &[f64]) -> Vec<f64> {
    let mut out = loads.to_vec();
    let shift = values.q.len() - values.v.len();
    for reading in [false, true] {
        for effect in effects {
            let is_reading = matches!(effect.kind.law, Law::Reading(_) | Law::TrueTorque(_));
            let Some(text) = effect.law_text().filter(|_| is_reading == reading) else { continue };
            let at = row(model, effect.location.joint.as_ref().unwrap());
            let other = effect.location.other_joint.as_ref().map_or(at, |name| row(model, name));
            let mut names: Vec<&str> = VARIABLES.to_vec();
            names.extend(["torque", "reading"]);
            let mut numbers = vec![values.q[at + shift], values.v[at], values.a[at], loads[at]];
            numbers.extend([values.q[other + shift], values.v[other], values.a[other], out[at], out[at]]);
            let formula = Formula::parse(text).unwrap();
            let own: Vec<&str> = formula
                .names()
                .iter()
                .map(String::as_str)
                .filter(|n| {
                    let setting = effect.kind.parameter(n).is_some();
                    effect.parameters.contains_key(*n) || setting || *n == "smoothing"
                })
                .collect();
            // A parameter may be called as a variable of another kind of law (`torque`).
            let (mut list, mut amounts) =
                (own.clone(), own.iter().map(|n| effect.value(n)).collect::<Vec<_>>());
            list.extend(names);
            amounts.extend(numbers);
            let law = formula.bind(&list).unwrap().evaluate(&amounts);
            out[at] = if reading { law } else { out[at] + law };
        }
    }
    out
}
