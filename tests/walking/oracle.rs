//! Numbers of `oracle/walking_plan.py`: feet, centre of mass and zero moment point of planned walks, by Pinocchio.
use crate::cli::{bipedc, scratch, text};
use flate2::read::GzDecoder;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::File;

/// A plan as it was written.
struct Written {
    names: BTreeMap<String, usize>,
    rows: Vec<Vec<f64>>,
}

impl Written {
    fn of(name: &str, arguments: &[&str]) -> (Self, Value) {
        let out = scratch(&format!("walking-{name}")).join("plan.csv");
        let all = [&["gait", "plan", "robots/tulip"], arguments, &["--out", text(&out), "--json"]].concat();
        let found = bipedc(&all).ok().json();
        let table = std::fs::read_to_string(out).unwrap();
        let mut lines = table.lines();
        let names = lines.next().unwrap().split(',').enumerate().map(|(k, name)| (name.to_owned(), k));
        let names = names.collect();
        let rows = lines.map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
        (Self { names, rows }, found)
    }

    fn row(&self, time: f64) -> &[f64] {
        let near = |row: &&Vec<f64>| (row[0] - time).abs() < 1e-9;
        self.rows.iter().find(near).unwrap_or_else(|| panic!("no row at {time} s"))
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Feet, centre of mass and balance within the stated distances of Pinocchio's, for the motion that Pinocchio was given.
fn agrees(name: &str, arguments: &[&str]) {
    let file =
        File::open(format!("{}/tests/data/walking/{name}.json.gz", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let reference: Value = serde_json::from_reader(GzDecoder::new(file)).unwrap();
    let (written, found) = Written::of(name, arguments);
    assert_eq!(found["holds"], true);
    let cases = reference["cases"].as_array().unwrap();
    assert!(cases.len() >= 20, "{}", cases.len());
    for case in cases {
        let time = case["time"].as_f64().unwrap();
        let row = written.row(time);
        let near = |column: &str, wished: f64, within: f64| {
            let here = row[written.names[column]];
            assert!((here - wished).abs() < within, "{name}, {column} at {time} s: {here} but {wished}");
        };
        let joints = reference["joints"].as_array().unwrap();
        for (joint, angle) in joints.iter().zip(&numbers(&case["q"])[7..]) {
            near(&format!("{}/position", joint.as_str().unwrap()), *angle, 1e-6);
        }
        for (foot, place) in ["right_foot", "left_foot"].iter().zip(case["soles"].as_array().unwrap()) {
            for (axis, wished) in ["x", "y", "z"].iter().zip(numbers(place)) {
                near(&format!("{foot}/sole/{axis}"), wished, 1e-6);
            }
        }
        for (axis, wished) in ["x", "y", "z"].iter().zip(numbers(&case["center"])) {
            near(&format!("center_of_mass/{axis}"), wished, 1e-6);
        }
        for (axis, wished) in ["x", "y"].iter().zip(numbers(&case["zmp"])) {
            near(&format!("zero_moment_point/{axis}"), wished, 1e-5);
        }
        near("zero_moment_point/margin", case["margin"].as_f64().unwrap(), 1e-4);
    }
    // The margin that is stated holds in the oracle's own polygons.
    assert!(reference["least_margin"].as_f64().unwrap() >= found["settings"]["margin"].as_f64().unwrap());
}

#[test]
fn static_walks_forward_are_pinocchios() {
    agrees("forward", &["--gait", "forward", "--count", "2"]);
}

#[test]
fn static_walks_to_the_side_are_pinocchios() {
    agrees("side", &["--gait", "side", "--count", "2"]);
}

#[test]
fn turns_on_the_spot_are_pinocchios() {
    agrees("turn", &["--gait", "turn", "--count", "2"]);
}

/// The zero moment point of the whole robot is on its reference, not that of a pendulum.
#[test]
fn dynamic_walks_are_pinocchios() {
    agrees("dynamic", &["--gait", "dynamic", "--speed", "0.3", "--count", "3", "--set", "sample=0.01"]);
}

#[test]
#[ignore = "takes long"]
fn curves_of_changing_speed_are_pinocchios() {
    let path = ["--speed", "0.15,0.25", "--sideways", "0.02", "--turning", "0.2", "--count", "4"];
    agrees("curve", &[&["--gait", "dynamic"], &path[..], &["--set", "sample=0.01"]].concat());
}
