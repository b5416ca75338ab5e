//! Base parameters as run-time inputs: with the description's values the functions are those with folded
//! numbers, and doubled values double the torques.
use bipedc_compiler::Robot;
use bipedc_compiler::compile::ProgramModel;
use bipedc_runtime::{Argument, Model, State};
use std::path::Path;

fn model(robot: &str, runtime: bool) -> ProgramModel {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(robot);
    let mut robot = Robot::read(&path).unwrap();
    robot.description.generate.runtime_parameters = runtime;
    ProgramModel::new(robot.compile().unwrap())
}

fn call(model: &ProgramModel, name: &str, state: &State<'_, f64>) -> Vec<f64> {
    let index = Model::<f64>::function(model, name).unwrap_or_else(|| panic!("no {name}"));
    let signature = Model::<f64>::signature(model, index).unwrap();
    let mut out = vec![0.0; signature.rows * signature.columns];
    model.evaluate(index, state, &mut out).unwrap();
    out
}

fn check(robot: &str, functions: &[&str]) {
    let (folded, open) = (model(robot, false), model(robot, true));
    let parameters = call(&folded, "base_parameters", &State::new());
    assert_eq!(Model::<f64>::argument_length(&open, Argument::Parameters), parameters.len());
    let vector = |n: usize, seed: f64| (0..n).map(|k| (seed + 1.7 * k as f64).sin()).collect::<Vec<_>>();
    let (nq, nv) = (Model::<f64>::nq(&folded), Model::<f64>::nv(&folded));
    let mut q = vector(nq, 0.3);
    if nq > nv {
        let norm = q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
        q[3..7].iter_mut().for_each(|x| *x /= norm);
    }
    let (v, a, tau) = (vector(nv, 0.7), vector(nv, 1.1), vector(nv, 2.3));
    let state = State::new()
        .with(Argument::Q, &q)
        .with(Argument::V, &v)
        .with(Argument::A, &a)
        .with(Argument::Tau, &tau);
    for name in functions {
        let expected = call(&folded, name, &state);
        let actual = call(&open, name, &state.with(Argument::Parameters, &parameters));
        let scale = expected.iter().fold(1e-3_f64, |m, x| m.max(x.abs()));
        for (x, y) in actual.iter().zip(&expected) {
            assert!((x - y).abs() < 1e-9 * scale, "{robot} {name}: {x} instead of {y}");
        }
    }
    let doubled: Vec<f64> = parameters.iter().map(|x| 2.0 * x).collect();
    let once = call(&folded, "inverse_dynamics", &state);
    let twice = call(&open, "inverse_dynamics", &state.with(Argument::Parameters, &doubled));
    for (x, y) in twice.iter().zip(&once) {
        assert!((x - 2.0 * y).abs() < 1e-9 * (1.0 + y.abs()), "{robot}: {x} is not twice {y}");
    }
}

#[test]
fn floating_base() {
    check(
        "tulip",
        &["inverse_dynamics", "mass_matrix", "bias", "forward_dynamics", "center_of_mass", "momentum"],
    );
}

#[test]
fn fixed_base() {
    check("tulip_v1_leg", &["inverse_dynamics", "mass_matrix", "forward_dynamics", "kinetic_energy"]);
    let open = model("tulip_v1_leg", true);
    assert!(Model::<f64>::function(&open, "center_of_mass").is_none(), "torques do not tell it");
}

#[test]
fn planar_base() {
    check("five_link", &["inverse_dynamics", "mass_matrix", "forward_dynamics"]);
}
