//! Outputs on the constrained dynamics of each phase: numbers of `oracle/phased_lie_derivatives.py`, which derives them again, and
//! differences along the flow.
use super::{WALKER, phased};
use bipedc_compiler::compile::ProgramModel;
use bipedc_runtime::{Argument, Model, State};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn cases() -> Vec<Value> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/gaits/phased_lie_derivatives.json");
    let mut file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    serde_json::from_value(file["cases"].take()).unwrap()
}

fn call(model: &ProgramModel, function: &str, state: &State<'_, f64>) -> Vec<f64> {
    let index = Model::<f64>::function(model, function).unwrap_or_else(|| panic!("no `{function}`"));
    let of = &model.compiled().functions[index];
    let mut out = vec![f64::NAN; of.rows.len() * of.columns.len()];
    model.evaluate(index, state, &mut out).unwrap();
    out
}

/// The oracle's case with what the gait's functions take.
struct Case {
    phase: String,
    q: Vec<f64>,
    v: Vec<f64>,
    arguments: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

impl Case {
    fn new(of: &Value, length: usize) -> Self {
        let mut arguments = numbers(&of["arguments"]);
        arguments.resize(length, 0.0);
        Self {
            phase: of["phase"].as_str().unwrap().to_owned(),
            q: numbers(&of["q"]),
            v: numbers(&of["v"]),
            rows: of["rows"].as_array().unwrap().iter().map(numbers).collect(),
            arguments,
        }
    }

    fn lie(&self, model: &ProgramModel, q: &[f64], v: &[f64]) -> Vec<f64> {
        let state = State::new().with(Argument::Q, q).with(Argument::V, v);
        let state = state.with(Argument::Parameters, &self.arguments);
        call(model, &format!("lie_derivatives_of_{}", self.phase), &state)
    }
}

#[test]
fn all_phases_agree_with_an_independent_derivation() {
    let bench = phased(WALKER, "collocated");
    let model = ProgramModel::new(bench.compiled().model.clone());
    let (mut worst, mut count) = (0.0_f64, 0);
    for case in cases().iter().map(|case| Case::new(case, bench.compiled().arguments.len())) {
        let found = case.lie(&model, &case.q, &case.v);
        let height = case.rows.len();
        assert_eq!(found.len(), height * 9, "{}", case.phase);
        for (row, expected) in case.rows.iter().enumerate() {
            // Accelerations of one output are sums of large numbers: each against the largest of its kind.
            let size = expected[2..].iter().fold(1.0_f64, |m, x| m.max(x.abs()));
            for (column, expected) in expected.iter().enumerate() {
                let size = if column < 2 { expected.abs().max(1.0) } else { size };
                worst = worst.max((found[column * height + row] - expected).abs() / size);
                count += 1;
            }
        }
    }
    println!("{count} numbers, at most {worst:e} apart");
    assert!(count > 1000 && worst < 1e-12, "{count} {worst:e}");
}

/// Along the flow of the constrained dynamics the outputs' second differences are L_f² h + L_g L_f h τ.
#[test]
fn outputs_move_as_their_lie_derivatives_say() {
    let bench = phased(WALKER, "collocated");
    let model = ProgramModel::new(bench.compiled().model.clone());
    let mut worst = 0.0_f64;
    for case in cases().iter().map(|case| Case::new(case, bench.compiled().arguments.len())) {
        let tau: Vec<f64> = (0..9).map(|k| if k < 3 { 0.0 } else { 4.0 - k as f64 }).collect();
        let state = State::new().with(Argument::Q, &case.q).with(Argument::V, &case.v);
        let state = state.with(Argument::Tau, &tau);
        let a = call(&model, &format!("constrained_dynamics_of_{}", case.phase), &state);
        let height = case.rows.len();
        let now = case.lie(&model, &case.q, &case.v);
        let outputs = bench.gait.phases.iter().find(|p| p.name == case.phase).unwrap().outputs.len();
        let rate = |h: f64| {
            let q: Vec<f64> = (0..9).map(|k| case.q[k] + h * case.v[k] + 0.5 * h * h * a[k]).collect();
            let v: Vec<f64> = (0..9).map(|k| case.v[k] + h * a[k]).collect();
            case.lie(&model, &q, &v)[height..height + outputs].to_vec()
        };
        let h = 1e-6;
        for (row, (after, before)) in rate(h).iter().zip(rate(-h)).enumerate() {
            let difference = (after - before) / (2.0 * h);
            let said = now[2 * height + row]
                + (0..6).map(|joint| now[(3 + joint) * height + row] * tau[3 + joint]).sum::<f64>();
            worst = worst.max((difference - said).abs() / said.abs().max(10.0));
        }
        // The forces of the ground are those of the constrained dynamics.
        for (row, force) in a[9..].iter().enumerate().map(|(k, force)| (outputs + k, force)) {
            let said = now[2 * height + row]
                + (0..6).map(|joint| now[(3 + joint) * height + row] * tau[3 + joint]).sum::<f64>();
            assert!((force - said).abs() < 1e-9 * force.abs().max(100.0), "{}: {force} {said}", case.phase);
        }
    }
    assert!(worst < 1e-6, "{worst:e}");
}

/// Along a surface on which contacts hold, α φ̈ + β φ̇² + γ is what torques do there, and ½ α φ̇² the kinetic energy: with T′ the velocity (φ̇ = 1) and any φ̈.
#[test]
fn zero_dynamics_of_all_phases_balance_the_power() {
    let bench = phased(WALKER, "collocated");
    let model = ProgramModel::new(bench.compiled().model.clone());
    let (mut worst, mut count) = (0.0_f64, 0);
    for case in cases().iter().map(|case| Case::new(case, bench.compiled().arguments.len())) {
        // A velocity that the contacts let pass: what one step of their dynamics leaves of none at all.
        let moved = |tau: &[f64], v: &[f64]| {
            let state = State::new().with(Argument::Q, &case.q).with(Argument::V, v);
            let function = format!("constrained_dynamics_of_{}", case.phase);
            call(&model, &function, &state.with(Argument::Tau, tau))[..9].to_vec()
        };
        let torques = |size: f64| {
            (0..9).map(|k| if k < 3 { 0.0 } else { size * (4.5 - k as f64) }).collect::<Vec<f64>>()
        };
        let rest = [0.0; 9];
        let (pushed, free) = (moved(&torques(3.0), &rest), moved(&torques(0.0), &rest));
        let v: Vec<f64> = pushed.iter().zip(free).map(|(pushed, free)| 0.1 * (pushed - free)).collect();
        let tau = torques(-2.0);
        let acceleration = moved(&tau, &v);
        let along = 0.7;
        let curvature: Vec<f64> = acceleration.iter().zip(&v).map(|(a, slope)| a - along * slope).collect();
        let state =
            State::new().with(Argument::Q, &case.q).with(Argument::V, &v).with(Argument::A, &curvature);
        let found = call(&model, &format!("zero_dynamics_of_{}", case.phase), &state);
        let [alpha, beta, gamma] = found[..3] else { panic!("{} numbers", found.len()) };
        let driven: f64 = found[3..].iter().zip(&tau[3..]).map(|(part, torque)| part * torque).sum();
        let size =
            [alpha * along, beta, gamma, driven].iter().fold(0.0_f64, |most, part| most.max(part.abs()));
        worst = worst.max((alpha * along + beta + gamma - driven).abs() / size);
        // D T′ is inverse dynamics of that acceleration, at rest and less what holds the robot up.
        let inverse = |a: &[f64]| {
            let state = State::new().with(Argument::Q, &case.q).with(Argument::V, &rest).with(Argument::A, a);
            call(&model, "inverse_dynamics", &state)
        };
        let weight = inverse(&rest);
        let twice: f64 =
            inverse(&v).iter().zip(weight).zip(&v).map(|((force, weight), v)| (force - weight) * v).sum();
        worst = worst.max((twice - alpha).abs() / alpha);
        assert!(alpha > 0.0);
        count += 1;
    }
    println!("{count} states, at most {worst:e}");
    assert!(count > 3 && worst < 1e-11, "{count} {worst:e}");
}
