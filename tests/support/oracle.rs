//! Every quantity of `tests/data/oracle` that a model has a function for.
use super::{Inputs, Order, assert_close, evaluate, matrix, numbers, read_json};
use bipedc_runtime::{Argument, Model};
use serde_json::Value;

const TOLERANCE: f64 = 1e-11;

struct Check<'a, M> {
    model: &'a M,
    file: &'a str,
    order: &'a Order,
    inputs: Inputs,
    checked: usize,
}

impl<M: Model<f64>> Check<'_, M> {
    fn compare(&mut self, function: &str, expected: &[f64]) {
        // A file for a free base says nothing about functions that this base does not have.
        if self.model.function(function).is_some() {
            let what = format!("{} {function}", self.file);
            assert_close(&what, &evaluate(self.model, function, &self.inputs), expected, TOLERANCE);
            self.checked += 1;
        }
    }

    /// Three blocks side by side; each is compared relative to its own largest element.
    fn derivatives(&mut self, function: &str, parts: [&str; 3], case: &Value) {
        let function = format!("{function}_derivatives");
        if self.model.function(&function).is_none() {
            return;
        }
        let actual = evaluate(self.model, &function, &self.inputs);
        for (block, part) in actual.chunks(actual.len() / 3).zip(parts) {
            assert_close(&format!("{} {part}", self.file), block, &self.order.square(&case[part]), TOLERANCE);
            self.checked += 1;
        }
    }

    fn frame(&mut self, name: &str, frame: &Value) {
        let of = name.replace('/', "_");
        self.compare(&format!("position_of_{of}"), &numbers(&frame["position"]));
        let rotation = matrix(&frame["rotation"]);
        let columns: Vec<f64> = (0..9).map(|k| rotation[k % 3][k / 3]).collect();
        self.compare(&format!("rotation_of_{of}"), &columns);
        self.compare(&format!("jacobian_of_{of}"), &self.order.wide(&frame["jacobian"]));
        let rate = numbers(&frame["jacobian_rate_times_velocity"]);
        self.compare(&format!("jacobian_rate_times_velocity_of_{of}"), &rate);
    }
}

/// External forces in the order of the model's contact points, which is that of the description.
fn forces(points: &[String], case: &Value) -> Vec<f64> {
    points.iter().flat_map(|point| numbers(&case["contact_forces"][point])).collect()
}

/// Compares all functions; returns how many comparisons were made.
pub fn check_oracle<M: Model<f64>>(model: &M, file: &str, points: &[String]) -> usize {
    let json = read_json(&format!("oracle/{file}.json.gz"));
    let order = Order::new(model, &json["joints"]);
    let mut checked = 0;
    for case in json["cases"].as_array().unwrap() {
        let inputs = Inputs::default()
            .with(Argument::Q, order.q(&case["q"]))
            .with(Argument::V, order.v(&case["v"]))
            .with(Argument::A, order.v(&case["a"]))
            .with(Argument::Tau, order.v(&case["tau"]))
            .with(Argument::Forces, forces(points, case));
        let mut check = Check { model, file, order: &order, inputs, checked: 0 };
        for name in [
            "inverse_dynamics",
            "forward_dynamics",
            "bias",
            "gravity",
            "inverse_dynamics_with_forces",
            "forward_dynamics_with_forces",
        ] {
            check.compare(name, &order.v(&case[name]));
        }
        for name in [
            "mass_matrix",
            "inverse_dynamics_dq",
            "inverse_dynamics_dv",
            "forward_dynamics_dq",
            "forward_dynamics_dv",
            "forward_dynamics_dtau",
        ] {
            check.compare(name, &order.square(&case[name]));
        }
        for name in [
            "center_of_mass",
            "center_of_mass_velocity",
            "center_of_mass_acceleration",
            "centroidal_momentum",
            "centroidal_momentum_rate",
            "momentum",
            "momentum_rate",
        ] {
            check.compare(name, &numbers(&case[name]));
        }
        check.compare("center_of_mass_jacobian", &order.wide(&case["center_of_mass_jacobian"]));
        // Where hardly any load remains the quotient amplifies rounding, in the oracle as here.
        if !case["zero_moment_point"].is_null() {
            check.compare("zero_moment_point", &numbers(&case["zero_moment_point"]));
        }
        for name in ["kinetic_energy", "potential_energy"] {
            check.compare(name, &[case[name].as_f64().unwrap()]);
        }
        for (name, frame) in case["frames"].as_object().unwrap() {
            check.frame(name, frame);
        }
        checked += check.checked;
    }
    checked
}
