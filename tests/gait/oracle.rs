//! Numbers of `oracle/zero_dynamics.py`: the gaits of the thesis derived again, from absolute angles, to thirty digits.
use super::{gait, relative};
use bipedc::gait::{GaitBench, StepOptions, Stepped};
use serde_json::Value;

fn cases() -> Vec<Value> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/gaits/zero_dynamics.json");
    let mut file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    serde_json::from_value(file["cases"].take()).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn options(case: &Value) -> StepOptions {
    let assignments = |key: &str| {
        let table = case[key].as_object().unwrap();
        table.iter().map(|(name, value)| (name.clone(), number(value))).collect()
    };
    StepOptions {
        speed: number(&case["speed"]),
        set: assignments("set"),
        from: assignments("from"),
        ..StepOptions::default()
    }
}

fn folder(case: &Value) -> String {
    format!("robots/{}", case["robot"].as_str().unwrap())
}

fn benches() -> Vec<(String, GaitBench)> {
    ["robots/three_link", "robots/five_link"].map(|folder| (folder.to_owned(), gait(folder, "thesis"))).into()
}

#[test]
fn steps_agree_with_an_independent_derivation() {
    let benches = benches();
    let mut worst = 0.0_f64;
    let mut infeasible = 0;
    for case in cases() {
        let bench = &benches.iter().find(|(name, _)| *name == folder(&case)).unwrap().1;
        let Stepped { step, .. } = bench.step(&options(&case)).unwrap_or_else(|e| panic!("{e}"));
        for (name, found) in [
            ("next_speed", step.next_speed),
            ("limit_speed", step.limit_speed),
            ("delta", step.delta),
            ("eta", step.eta),
            ("p_minus", step.p_minus),
            ("p_max", step.p_max),
            ("phi_m", step.phi_m),
            ("phi_end", step.phi_end),
            ("energy", step.energy),
            ("next_energy", step.next_energy),
            ("this_step/p_minus", step.this_step.p_minus),
            ("this_step/p_max", step.this_step.p_max),
            ("this_step/phi_m", step.this_step.phi_m),
        ] {
            let expected = case.pointer(&format!("/{name}")).unwrap_or_else(|| panic!("no {name}"));
            match (expected.as_f64(), found) {
                // At the beginning of a step there is none.
                (Some(0.0), Some(found)) => assert_eq!(found, 0.0, "{name}"),
                (Some(expected), Some(found)) => worst = worst.max(relative(found, expected)),
                (None, None) => {}
                (expected, found) => panic!("{name}: {expected:?}, here {found:?} in {case}"),
            }
        }
        assert_eq!(step.feasible, case["next_speed"].is_number(), "{case}");
        assert_eq!(step.feasible, step.reason.is_none());
        infeasible += usize::from(!step.feasible);
    }
    println!("steps: {worst:.1e} from the independent derivation");
    assert!(worst < 1e-12, "{worst:e}");
    assert!(infeasible >= 2, "{infeasible}");
}

#[test]
fn zero_dynamics_and_forces_agree_along_the_step() {
    let benches = benches();
    let (mut worst, mut forces) = (0.0_f64, 0.0_f64);
    for case in cases() {
        let bench = &benches.iter().find(|(name, _)| *name == folder(&case)).unwrap().1;
        let stepped = bench.step(&options(&case)).unwrap_or_else(|e| panic!("{e}"));
        let model = bench.model().unwrap();
        let [to, from] = &stepped.values;
        let before = model.steady_course(from).unwrap();
        let course = model.course(to, &before.landing).unwrap();
        for point in case["courses"].as_array().unwrap() {
            let phase = number(&point["phase"]);
            let [alpha, _, gamma] = course.zero_dynamics(phase).unwrap();
            let potential = course.potential(phase).unwrap();
            worst = worst.max(relative(alpha, number(&point["alpha"])));
            worst = worst.max((gamma - number(&point["gamma"])).abs() / 100.0);
            worst = worst.max((potential - number(&point["potential"])).abs() / stepped.step.energy.unwrap());
            if let Some(force) = point["force"].as_array() {
                let efforts = model.efforts(&course, phase, stepped.step.next_energy.unwrap()).unwrap();
                for (found, expected) in efforts.iter().zip(force) {
                    forces = forces.max((found - number(expected)).abs() / 300.0);
                }
            }
        }
    }
    println!("α, γ, P: {worst:.1e}, forces: {forces:.1e} from the independent derivation");
    assert!(worst < 1e-12 && forces < 1e-11, "{worst:e} {forces:e}");
}

/// The figure of the errata: δ is the ratio of the angular momenta, not of the phase velocities alone.
#[test]
fn delta_is_that_of_the_momenta() {
    let step =
        gait("robots/three_link", "thesis").step(&StepOptions { speed: 1.5, ..StepOptions::default() });
    let step = step.unwrap().step;
    assert!((step.delta.unwrap() - 0.79636).abs() < 5e-6, "{:?}", step.delta);
    assert!((step.eta.unwrap().powi(2) - 0.68120).abs() < 5e-6, "{:?}", step.eta);
}
