//! Lie derivatives: numbers of `oracle/lie_derivatives.py`, which derives them again, and differences along the flow.
use super::gait;
use bipedc::gait::GaitBench;
use bipedc_compiler::compile::ProgramModel;
use bipedc_runtime::{Argument, Model, State};
use serde_json::Value;

/// Functions of a gait by name.
struct Functions {
    model: ProgramModel,
    bench: GaitBench,
}

impl Functions {
    fn new(folder: &str, name: &str) -> Self {
        let bench = gait(folder, name);
        Self { model: ProgramModel::new(bench.compiled().model.clone()), bench }
    }

    fn outputs(&self) -> usize {
        self.bench.gait.phase.outputs.len()
    }

    fn call(&self, family: &str, state: &State<'_, f64>) -> Vec<f64> {
        let functions = &self.model.compiled().functions;
        let index = functions.iter().position(|function| function.family == family).unwrap();
        let mut out = vec![f64::NAN; functions[index].rows.len() * functions[index].columns.len()];
        self.model.evaluate(index, state, &mut out).unwrap();
        out
    }

    /// φ any, φ₊, φ₋, the parameters, h_p.
    fn arguments(&self, ends: [f64; 2], values: &[f64], matching: &[[f64; 2]]) -> Vec<f64> {
        let mut all = vec![f64::NAN, ends[0], ends[1]];
        all.extend(values);
        all.extend(matching.iter().flatten());
        all
    }

    /// The base moves so that the foot that stands does not.
    fn standing(&self, q: &[f64], v: &mut [f64], arguments: &[f64]) {
        let state = State::new().with(Argument::Q, q).with(Argument::Parameters, arguments);
        let jacobian = self.call("virtual_constraints_jacobian", &state);
        let n = q.len();
        for row in 0..2 {
            v[row] = -(2..n).map(|column| jacobian[column * n + row] * v[column]).sum::<f64>();
        }
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn cases() -> Vec<Value> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/gaits/lie_derivatives.json");
    let mut file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    serde_json::from_value(file["cases"].take()).unwrap()
}

#[test]
fn they_agree_with_an_independent_derivation() {
    let (mut worst, mut seen) = ([0.0_f64; 4], 0);
    for case in cases() {
        let folder = format!("robots/{}", case["robot"].as_str().unwrap());
        let functions = Functions::new(&folder, case["gait"].as_str().unwrap());
        let set = case["set"].as_object().unwrap();
        let set: Vec<_> = set.iter().map(|(name, x)| (name.clone(), x.as_f64().unwrap())).collect();
        let values = functions.bench.values(&set).unwrap();
        let matching: Vec<[f64; 2]> = case["matching"]
            .as_array()
            .unwrap()
            .iter()
            .map(|pair| numbers(pair).try_into().unwrap())
            .collect();
        let ends = numbers(&case["ends"]).try_into().unwrap();
        let mut arguments = functions.arguments(ends, &values, &matching);
        let [q, mut v] = ["q", "v"].map(|key| [&[0.3, -0.2][..], &numbers(&case[key])].concat());
        arguments[0] = 0.0;
        functions.standing(&q, &mut v, &arguments);
        // The phase is that of q, whatever stands in its place.
        arguments[0] = f64::NAN;
        let state = State::new().with(Argument::Q, &q).with(Argument::V, &v);
        let found = functions.call("lie_derivatives", &state.with(Argument::Parameters, &arguments));
        let outputs = functions.outputs();
        for (row, expected) in case["lie_derivatives"].as_array().unwrap().iter().enumerate() {
            for (column, expected) in numbers(expected).iter().enumerate() {
                let found = found[column * outputs + row];
                let off = (found - expected).abs() / expected.abs().max(1.0);
                worst[column.min(3)] = worst[column.min(3)].max(off);
                seen += 1;
            }
        }
    }
    println!("h, L_f h, L_f² h, L_g L_f h: {worst:?} from the independent derivation ({seen} numbers)");
    assert!(seen > 600 && worst.iter().all(|worst| *worst < 1e-12), "{worst:?}");
}

/// Central differences along the flow: of h they are L_f h, of L_f h they are L_f² h + L_g L_f h τ.
#[test]
fn they_are_slopes_along_the_flow() {
    let gaits = [
        ("robots/three_link", "thesis"),
        ("robots/three_link", "published"),
        ("robots/five_link", "thesis"),
        ("robots/five_link", "optimised"),
    ];
    for (folder, name) in gaits {
        let functions = Functions::new(folder, name);
        let outputs = functions.outputs();
        let values = functions.bench.values(&[]).unwrap();
        let matching: Vec<[f64; 2]> = (0..outputs).map(|k| [0.1 - 0.05 * k as f64, 0.3]).collect();
        let arguments = functions.arguments([-0.2, 0.3], &values, &matching);
        let (mut first, mut second) = (0.0_f64, 0.0_f64);
        for state in 0..5 {
            let [a, b] = differences(&functions, &arguments, f64::from(state));
            (first, second) = (first.max(a), second.max(b));
        }
        println!("{folder} {name}: L_f h {first:.1e}, L_f² h + L_g L_f h τ {second:.1e} from differences");
        assert!(first < 1e-4 && second < 1e-4, "{folder} {name}: {first:e} {second:e}");
    }
}

/// How far L_f h, and L_f² h + L_g L_f h τ, are from differences along the flow in one state.
fn differences(functions: &Functions, arguments: &[f64], state: f64) -> [f64; 2] {
    let (outputs, n) = (functions.outputs(), functions.outputs() + 3);
    let spread = |k: usize, by: f64| by * (1.7 * k as f64 + 0.9 * state + 0.3).sin();
    let q: Vec<f64> = (0..n).map(|k| spread(k, 0.4)).collect();
    let mut v: Vec<f64> = (0..n).map(|k| spread(k + 7, 1.5)).collect();
    functions.standing(&q, &mut v, &[&[0.0], &arguments[1..]].concat());
    let tau: Vec<f64> = (0..n).map(|k| if k < 3 { 0.0 } else { spread(k + 3, 20.0) }).collect();
    let lie = |q: &[f64], v: &[f64]| {
        let state = State::new().with(Argument::Q, q).with(Argument::V, v);
        functions.call("lie_derivatives", &state.with(Argument::Parameters, arguments))
    };
    let state = State::new().with(Argument::Q, &q).with(Argument::V, &v).with(Argument::Tau, &tau);
    let a = functions.call("constrained_dynamics", &state);
    let (here, h) = (lie(&q, &v), 1e-4);
    let along = |s: f64| {
        let q: Vec<f64> = (0..n).map(|k| q[k] + s * v[k] + 0.5 * s * s * a[k]).collect();
        let v: Vec<f64> = (0..n).map(|k| v[k] + s * a[k]).collect();
        lie(&q, &v)
    };
    let [before, after] = [along(-h), along(h)];
    let slope = |k: usize| (after[k] - before[k]) / (2.0 * h);
    let mut worst = [0.0_f64; 2];
    for output in 0..outputs {
        worst[0] = worst[0].max((slope(output) - here[outputs + output]).abs());
        let driven = |joint: usize| here[(3 + joint) * outputs + output] * tau[3 + joint];
        let wanted = here[2 * outputs + output] + (0..outputs).map(driven).sum::<f64>();
        worst[1] = worst[1].max((slope(outputs + output) - wanted).abs() / wanted.abs().max(1.0));
    }
    worst
}
