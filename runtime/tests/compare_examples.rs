//! The example logs, against what is known to be true about them (`truth.json`).
mod support;

use bipedc_runtime::compare::{BaseKind, Comparison, Options, compare_file};
use bipedc_runtime::log::Mapping;
use serde_json::Value;
use support::{rnea::Robot, repository, subject, tulip};

fn compare_example(name: &str, robot: &mut Robot) -> Comparison {
    let log = repository(&format!("tests/data/examples/{name}/validation.csv.gz"));
    let subject = subject(robot);
    compare_file(robot, &subject, &log, &Mapping::default(), &Options::default()).unwrap()
}

fn assert_nominal(name: &str) {
    let text = std::fs::read_to_string(repository(&format!("tests/data/examples/{name}/truth.json"))).unwrap();
    let truth: Value = serde_json::from_str(&text).unwrap();
    let nominal = &truth["nominal"];
    let comparison = compare_example(name, &mut tulip());
    println!("{name}: nominal {} at {} Hz\n{comparison}", nominal["rms"], nominal["cutoff_hz"]);
    let near = |found: f64, expected: &Value, what: &str| {
        let expected = expected.as_f64().unwrap();
        assert!((found / expected - 1.0).abs() < 0.05, "{name}, {what}: {found}, expected {expected}");
    };
    near(comparison.rms, &nominal["rms"], "total");
    assert_eq!(comparison.channels.len(), 12);
    for channel in &comparison.channels {
        near(channel.rms, &nominal["rms_by_joint"][&channel.name], &channel.name);
    }
    assert_eq!(Some(comparison.cutoff_hz), nominal["cutoff_hz"].as_f64());
    assert!(comparison.warnings.is_empty(), "{:?}", comparison.warnings);
}

#[test]
fn null() {
    assert_nominal("null");
}

#[test]
fn coulomb() {
    assert_nominal("coulomb");
}

#[test]
fn rotor_inertia() {
    assert_nominal("rotor_inertia");
}

#[test]
fn backlash() {
    assert_nominal("backlash");
}

#[test]
fn a_floating_model_of_a_hanging_robot_gives_the_same_joint_efforts() {
    let fixed = compare_example("null", &mut tulip());
    let urdf = std::fs::read_to_string(repository("robots/tulip/robot.urdf")).unwrap();
    let floating = compare_example("null", &mut Robot::parse(&urdf, BaseKind::Floating));
    assert!(floating.assumptions.iter().any(|a| a.contains("fixed, upright and at rest")));
    for (a, b) in fixed.channels.iter().zip(&floating.channels) {
        assert!((a.rms - b.rms).abs() < 1e-9 * a.rms, "{a:?} {b:?}");
    }
}
