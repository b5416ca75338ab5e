//! Emitted code with effects: the torques by hand, there and back, single precision and lanes.
use super::models::{FiveLinkWithEffects, TulipWithEffects};
use super::states::{Arguments, Random};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_runtime::lanes::F64x4;
use bipedc_runtime::{Argument, Model, Real};
use std::path::Path;

fn call<R: Real>(model: &impl Model<R>, name: &str, arguments: &Arguments<R>) -> Vec<R> {
    let index = model.function(name).unwrap();
    let signature = model.signature(index).unwrap();
    let mut out = vec![R::constant(0.0); signature.rows * signature.columns];
    model.evaluate(index, &arguments.state(), &mut out).unwrap();
    out
}

fn close(got: &[f64], expected: &[f64], tolerance: f64) {
    let scale = expected.iter().fold(1.0f64, |m, x| m.max(x.abs()));
    for (k, (x, y)) in got.iter().zip(expected).enumerate() {
        assert!((x - y).abs() <= tolerance * scale, "[{k}]: {x} instead of {y}");
    }
}

/// The same robot without its effects.
fn rigid() -> ProgramModel {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/effects/five_link");
    let robot = Robot::read(&path).unwrap_or_else(|e| panic!("{e}")).without_effects();
    let request = FunctionRequest::of_robot("inverse_dynamics");
    ProgramModel::new(robot.compile_only(&[request]).unwrap())
}

/// What the description of `tests/data/effects/five_link` says, written out; joints in the order of the URDF.
fn reported(q: &[f64], v: &[f64], a: &[f64], load: &[f64]) -> Vec<f64> {
    let [right_hip, right_knee, left_hip, left_knee] = [3, 4, 5, 6];
    let sign = |x: f64| (x / 0.02).tanh();
    let mut u = load.to_vec();
    u[left_knee] += 0.43 * sign(v[left_knee]) + 0.2 * v[left_knee];
    u[left_knee] += 0.1 * v[left_hip] + 0.2 * sign(v[left_hip]) + 0.5 * q[left_hip];
    u[left_knee] += 0.1 * (3.0 * q[left_knee]).sin() * v[left_knee];
    u[left_knee] += q[left_knee].sin().cos() * v[left_knee].abs().min(1.5);
    let s = sign(v[right_knee]);
    u[right_knee] += 0.3 * s + 0.1 * s.abs();
    u[right_knee] = (u[right_knee] / 0.95 + 0.3).clamp(-90.0, 90.0);
    let excess = 0.2 * (-(v[left_hip] / 0.4).powi(2)).exp();
    u[left_hip] += (0.3 + excess) * sign(v[left_hip]);
    u[left_hip] += 0.15 * load[left_hip].abs() * sign(v[left_hip]) + 0.12 * a[left_hip];
    u[right_hip] += 12.0 * (q[right_hip] + 0.3) + 0.2 * (14.0 * q[right_hip] + 0.4).sin();
    u
}

#[test]
fn torques_are_those_by_hand() {
    let (rigid, mut random) = (rigid(), Random(11));
    for _ in 0..200 {
        let arguments = Arguments::<f64>::random(&FiveLinkWithEffects, &mut random);
        let state = arguments.state();
        let load = call(&rigid, "inverse_dynamics", &arguments);
        let [q, v, a] = [Argument::Q, Argument::V, Argument::A].map(|x| state.get(x));
        close(&call(&FiveLinkWithEffects, "inverse_dynamics", &arguments), &reported(q, v, a, &load), 1e-13);
    }
}

#[test]
fn forward_dynamics_takes_the_torques_back() {
    let mut random = Random(13);
    for _ in 0..100 {
        let there = Arguments::<f64>::random(&FiveLinkWithEffects, &mut random);
        let tau = call(&FiveLinkWithEffects, "inverse_dynamics", &there);
        // Where the drive saturates, no torque gives the acceleration.
        if tau[4].abs() < 90.0 {
            let back = there.with(Argument::Tau, tau);
            let a = call(&FiveLinkWithEffects, "forward_dynamics", &back);
            close(&a, there.state().get(Argument::A), 1e-9);
        }
        let there = Arguments::<f64>::random(&TulipWithEffects, &mut random);
        let back = there.with(Argument::Tau, call(&TulipWithEffects, "inverse_dynamics", &there));
        let a = call(&TulipWithEffects, "forward_dynamics", &back);
        close(&a, there.state().get(Argument::A), 1e-9);
    }
}

#[test]
fn lanes_have_the_bits_of_scalars_and_floats_are_near() {
    let mut random = Random(17);
    for _ in 0..20 {
        let seed = Random(random.0);
        let one = Arguments::<f64>::random(&TulipWithEffects, &mut random);
        let wide = Arguments::<F64x4>::random(&TulipWithEffects, &mut Random(seed.0));
        let short = Arguments::<f32>::random(&TulipWithEffects, &mut Random(seed.0));
        for name in ["inverse_dynamics", "forward_dynamics"] {
            let expected = call(&TulipWithEffects, name, &one);
            let lanes = call(&TulipWithEffects, name, &wide);
            for (x, y) in lanes.iter().zip(&expected) {
                assert!(x.to_array().iter().all(|lane| lane.to_bits() == y.to_bits()), "{name}");
            }
            let floats = call(&TulipWithEffects, name, &short);
            close(&floats.into_iter().map(f64::from).collect::<Vec<_>>(), &expected, 1e-3);
        }
    }
}

#[test]
fn the_documentation_names_the_effects() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/effects/five_link");
    let robot = Robot::read(&path).unwrap_or_else(|e| panic!("{e}"));
    let package = robot.package("five_link", "version = \"0.1\"").unwrap();
    let text = |name: &str| package.files[&format!("src/{name}.rs")].as_str();
    for words in [
        "Contains the effects: Coulomb friction at left_knee_pitch",
        "cable at left_knee_pitch",
        "Not part of the instantaneous model, and not contained: Delay of the torque at left_knee_pitch",
    ] {
        assert!(text("inverse_dynamics").contains(words), "{words}");
    }
    assert!(text("coriolis_matrix").contains("Of the rigid-body model alone, without:"));
    let rigid = robot.without_effects().package("five_link", "version = \"0.1\"").unwrap();
    assert!(!rigid.files["src/inverse_dynamics.rs"].contains("effect"));
    assert_ne!(package.files["src/lib.rs"], rigid.files["src/lib.rs"]);
}
