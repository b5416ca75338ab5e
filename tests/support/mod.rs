//! Oracle numbers, in the order of a model's coordinates.
#![allow(dead_code, missing_docs)]
pub mod lagrange;
pub mod measured;
pub mod oracle;

use bipedc_compiler::Robot;
use bipedc_compiler::description::model::Foot;
use bipedc_runtime::{Argument, Model, State};
use flate2::read::GzDecoder;
use serde_json::Value;
use std::fs::File;
use std::path::{Path, PathBuf};

/// A file below `tests/data`, uncompressed.
pub fn read_json(name: &str) -> Value {
    let path = project().join("tests/data").join(name);
    let file = File::open(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_reader(GzDecoder::new(file)).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

pub fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
}

pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// Rows of a matrix.
pub fn matrix(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().expect("an array").iter().map(numbers).collect()
}

/// How an oracle orders its coordinates, against a model.
pub struct Order {
    /// For each element of the model's `q` (`v`) the element of the oracle's.
    q: Vec<usize>,
    v: Vec<usize>,
}

impl Order {
    pub fn new<M: Model<f64>>(model: &M, joints: &Value) -> Self {
        let names: Vec<&str> = joints.as_array().unwrap().iter().map(|x| x.as_str().unwrap()).collect();
        let at = |k: usize| {
            let joint = model.joint_name(k).unwrap();
            names.iter().position(|name| *name == joint).unwrap_or_else(|| panic!("no joint {joint}"))
        };
        let joints: Vec<usize> = (0..model.joints()).map(at).collect();
        let ordered = |n: usize| {
            let base = n - joints.len();
            (0..base).chain(joints.iter().map(|j| base + j)).collect()
        };
        Self { q: ordered(model.nq()), v: ordered(model.nv()) }
    }
    pub fn q(&self, value: &Value) -> Vec<f64> {
        let x = numbers(value);
        self.q.iter().map(|&k| x[k]).collect()
    }
    pub fn v(&self, value: &Value) -> Vec<f64> {
        let x = numbers(value);
        self.v.iter().map(|&k| x[k]).collect()
    }
    /// nv × nv, column by column.
    pub fn square(&self, value: &Value) -> Vec<f64> {
        let m = matrix(value);
        self.v.iter().flat_map(|&c| self.v.iter().map(|&r| m[r][c]).collect::<Vec<_>>()).collect()
    }
    /// rows × nv, column by column.
    pub fn wide(&self, value: &Value) -> Vec<f64> {
        let m = matrix(value);
        self.v.iter().flat_map(|&c| m.iter().map(|row| row[c]).collect::<Vec<_>>()).collect()
    }
}

/// Arguments of one call, owned.
#[derive(Default, Clone)]
pub struct Inputs(Vec<(Argument, Vec<f64>)>);

impl Inputs {
    pub fn with(mut self, argument: Argument, values: Vec<f64>) -> Self {
        self.0.retain(|(a, _)| *a != argument);
        self.0.push((argument, values));
        self
    }
    pub fn state(&self) -> State<'_, f64> {
        self.0.iter().fold(State::new(), |state, (argument, values)| state.with(*argument, values))
    }
}

/// One function of a model by name.
pub fn evaluate<M: Model<f64>>(model: &M, function: &str, inputs: &Inputs) -> Vec<f64> {
    let index = model.function(function).unwrap_or_else(|| panic!("no function {function}"));
    let signature = model.signature(index).unwrap();
    let mut out = vec![f64::NAN; signature.rows * signature.columns];
    model.evaluate(index, &inputs.state(), &mut out).unwrap_or_else(|e| panic!("{function}: {e:?}"));
    out
}

/// Fails unless `actual` equals `expected` within `tolerance` of the largest element.
pub fn assert_close(what: &str, actual: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(actual.len(), expected.len(), "{what}: shapes");
    let scale = expected.iter().fold(1e-3_f64, |m, x| m.max(x.abs()));
    for (k, (a, e)) in actual.iter().zip(expected).enumerate() {
        let error = (a - e).abs() / scale;
        assert!(error <= tolerance, "{what}[{k}]: {a} instead of {e}: {error:.1e} relative");
    }
}

pub const ROBOTS: [&str; 6] = ["three_link", "five_link", "seven_link", "biped_3d", "tulip", "tulip_v1_leg"];

/// Every quantity of `tests/data/reference` that all models have.
pub fn check_reference<M: Model<f64>>(model: &M, robot: &str) {
    let file = read_json(&format!("reference/{robot}.json.gz"));
    let order = Order::new(model, &file["joints"]);
    for case in file["cases"].as_array().unwrap() {
        let (q, v, a) = (order.q(&case["q"]), order.v(&case["v"]), order.v(&case["a"]));
        let tau = order.v(&case["inverse_dynamics"]);
        let inputs = Inputs::default()
            .with(Argument::Q, q)
            .with(Argument::V, v)
            .with(Argument::A, a)
            .with(Argument::Tau, tau.clone());
        let check = |function: &str, expected: &[f64]| {
            assert_close(
                &format!("{robot} {function}"),
                &evaluate(model, function, &inputs),
                expected,
                1e-11,
            );
        };
        check("inverse_dynamics", &tau);
        check("mass_matrix", &order.square(&case["mass_matrix_rows"]));
        check("bias", &order.v(&case["bias"]));
        check("gravity", &order.v(&case["gravity"]));
        check("forward_dynamics", &order.v(&case["forward_dynamics_of_that_torque"]));
        for (function, key) in [
            ("center_of_mass", "center_of_mass"),
            ("center_of_mass_velocity", "center_of_mass_velocity"),
            ("center_of_mass_acceleration", "center_of_mass_acceleration"),
            ("centroidal_momentum", "centroidal_momentum_linear_angular"),
            ("centroidal_momentum_rate", "centroidal_momentum_rate"),
        ] {
            // A fixed base: the file counts moving links; see the reference's README.
            check(function, &numbers(&case[key]));
        }
        check("kinetic_energy", &[case["kinetic_energy"].as_f64().unwrap()]);
        check("potential_energy", &[case["potential_energy"].as_f64().unwrap()]);
        for (foot, numbers_of) in case["feet"].as_object().unwrap() {
            let suffix = format!("_of_{foot}");
            check(&format!("position{suffix}"), &numbers(&numbers_of["position"]));
            let rotation = matrix(&numbers_of["rotation_rows"]);
            let columns: Vec<f64> =
                (0..3).flat_map(|c| (0..3).map(|r| rotation[r][c]).collect::<Vec<_>>()).collect();
            check(&format!("rotation{suffix}"), &columns);
            check(&format!("jacobian{suffix}"), &order.wide(&numbers_of["jacobian_world_aligned_rows"]));
        }
    }
}

pub fn read_robot(name: &str) -> Robot {
    Robot::read(&project().join("robots").join(name)).unwrap_or_else(|e| panic!("{e}"))
}

/// Contact points as the oracle names them: `link/point`, in the order of the description.
pub fn contact_points(robot: &str) -> Vec<String> {
    let feet = read_robot(robot).description.feet;
    let of = |f: &Foot| f.points.iter().map(|p| format!("{}/{}", f.link, p.name)).collect::<Vec<_>>();
    feet.iter().flat_map(of).collect()
}
