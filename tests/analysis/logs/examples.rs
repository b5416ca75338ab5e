//! The example logs, against what is known to be true about them (`truth.json`).
use crate::logs::support::{layout, repository, rnea::Robot, tulip};
use bipedc_analysis::compare::{Comparison, compare_file};
use bipedc_analysis::log::Log;
use bipedc_analysis::measure::{FIRST, Options};
use bipedc_analysis::robot::BaseKind;
use serde_json::Value;

fn compare_example(name: &str, robot: &mut Robot) -> Comparison {
    let log = Log::open(repository(&format!("tests/data/examples/{name}/validation.csv.gz"))).unwrap();
    let layout = layout(robot);
    // The truth was computed at the best of these.
    let options = Options { candidates: FIRST.to_vec(), ..Options::default() };
    compare_file(robot, &layout, &log, &options).unwrap()
}

fn assert_nominal(name: &str) {
    let text =
        std::fs::read_to_string(repository(&format!("tests/data/examples/{name}/truth.json"))).unwrap();
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
    let log = Log::open(repository("tests/data/examples/null/validation.csv.gz")).unwrap();
    let urdf = std::fs::read_to_string(repository("robots/tulip/robot.urdf")).unwrap();
    let options = Options { cutoff_hz: Some(16.0), from_s: Some(2.0), to_s: Some(3.0), ..Options::default() };
    let [fixed, floating] = [BaseKind::Fixed, BaseKind::Floating].map(|base| {
        let mut robot = Robot::parse(&urdf, base);
        let layout = layout(&robot);
        compare_file(&mut robot, &layout, &log, &options).unwrap()
    });
    assert!(floating.assumptions.iter().any(|a| a.contains("fixed, upright and at rest")));
    assert_eq!((fixed.from_s, fixed.to_s, fixed.samples), (2.0, 3.0, 251));
    for (a, b) in fixed.channels.iter().zip(&floating.channels) {
        assert!((a.rms - b.rms).abs() < 1e-9 * a.rms, "{a:?} {b:?}");
    }
}

#[test]
fn json_has_the_documented_keys() {
    let comparison = compare_example("null", &mut tulip());
    let json = serde_json::to_value(&comparison).unwrap();
    for key in ["rms", "unit", "cutoff_hz", "cutoffs", "trim_s", "from_s", "to_s", "samples", "sampling_hz"] {
        assert!(!json[key].is_null(), "{key}");
    }
    for key in ["missing", "assumptions", "warnings", "channels"] {
        assert!(json[key].is_array(), "{key}");
    }
    for key in ["name", "unit", "rms", "max", "relative", "samples"] {
        assert!(!json["channels"][0][key].is_null(), "{key}");
    }
    assert_eq!(json["channels"][0]["unit"], "N m");
    assert!(json["assumptions"][0].as_str().unwrap().contains("fixed, upright and at rest"));
}
