//! The diagnosis on real machines whose answers are known: the wanted figures that are reached. Those that are not
//! stand in `docs/real-data.md`.
//!
//! The data are read in place; without them a test says so and passes.
#[path = "../examples/real_data/humanoid.rs"]
mod humanoid;
#[path = "../examples/real_data/pendulum.rs"]
mod pendulum;
// Its words are for the page of the example.
#[allow(dead_code)]
#[path = "../examples/real_data/run.rs"]
pub mod run;
#[path = "../examples/real_data/servo.rs"]
pub mod servo;
#[path = "../examples/real_data/table.rs"]
pub mod table;
#[path = "../examples/real_data/wrist.rs"]
mod wrist;

use run::{Machine, Part, Program, Scratch};
use std::path::{Path, PathBuf};

/// Where the data are; nothing, and that is said, where they are not.
pub fn measurements() -> Option<PathBuf> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    if !data.is_dir() {
        println!("skipped: {} is not there", data.display());
        return None;
    }
    Some(data)
}

/// The answers about a machine; none where the data are not there.
fn answers(name: &str, machine: Machine) -> Vec<Part> {
    let Some(data) = measurements() else { return Vec::new() };
    let scratch = Scratch::new(&format!("bipedc-real-data-{name}")).unwrap();
    let program = Program(env!("CARGO_BIN_EXE_bipedc").into());
    let parts = machine(&data, &scratch.folder(name).unwrap(), &program).unwrap();
    parts.iter().for_each(|part| println!("{}: {}", part.title, part.answer["summary"].as_str().unwrap()));
    parts
}

fn after(part: &Part, row: &str) -> f64 {
    part.answer["rows"][row]["after"].as_f64().unwrap()
}

/// The rows that a page states are what a comparison with the amended robot measures on the log that judged.
fn stated_is_measured(part: &Part) {
    for row in &part.measured {
        let (stated, measured) = (after(part, &row.name), row.errors[1]);
        assert!((stated - measured).abs() <= 1e-3 * measured, "{}: {stated} {measured}", row.name);
    }
    assert!(!part.measured.is_empty());
}

fn warned(part: &Part) -> bool {
    let warnings = part.answer["warnings"].as_array().unwrap();
    warnings.iter().any(|w| w.as_str().unwrap().contains("free swings"))
}

#[test]
#[ignore = "takes long"]
fn the_wrist_of_an_arm_is_coupled() {
    for part in answers("wrist", wrist::run) {
        let first = &part.answer["effects"][0];
        assert_eq!(first["kind"], "coupling");
        let mut pair = [first["joint"].as_str().unwrap(), first["other_joint"].as_str().unwrap()];
        pair.sort_unstable();
        assert_eq!(pair, ["joint_5", "joint_6"]);
        assert!(after(&part, "joint_5") <= 1.55 && after(&part, "joint_6") <= 0.95);
        stated_is_measured(&part);
    }
}

#[test]
#[ignore = "takes long"]
fn a_swing_up_shows_friction_and_free_swings_are_warned_of() {
    let parts = answers("pendulum", pendulum::run);
    for part in &parts {
        assert_eq!(warned(part), part.title.contains("free swings"), "{}", part.title);
    }
    for part in parts.iter().take(1) {
        for joint in ["Joint1", "Joint2"] {
            let found = part.answer["effects"].as_array().unwrap();
            let rubs = |e: &serde_json::Value| {
                e["joint"] == joint && e["kind"].as_str().unwrap().contains("friction")
            };
            assert!(found.iter().any(rubs), "no friction at {joint}");
        }
    }
}

#[test]
fn friction_of_a_servo_depends_on_its_load_and_has_no_stribeck_part() {
    for part in answers("servo", servo::run) {
        let found = part.answer["effects"].as_array().unwrap();
        assert!(found.iter().all(|e| e["kind"] != "stribeck_friction"));
        let rejected = part.answer["rejected"].as_array().unwrap();
        assert!(rejected.iter().any(|r| r["kind"] == "stribeck_friction"));
        let friction = found.iter().find(|e| e["kind"] == "load_dependent_friction").unwrap();
        let low = friction["ci95"]["coefficient"][0].as_f64().unwrap();
        assert!(low > 0.0, "the coefficient may be zero: {friction}");
        // Without it and the rest 0.0720 N m.
        assert!(after(&part, "joint") < 0.035, "{}", part.answer["rms"]);
        let readme = std::fs::read_to_string("README.md").unwrap();
        let figure = format!("held-out error falls to {:.3} N m", after(&part, "joint"));
        assert!(readme.contains(&figure), "not in README: {figure}");
        stated_is_measured(&part);
    }
}

/// Kinds of every alternative in every group.
fn alternatives(part: &Part) -> Vec<Vec<Vec<String>>> {
    let list = |value: &serde_json::Value| value.as_array().cloned().unwrap_or_default();
    let kinds = |alternative: &serde_json::Value| {
        list(alternative).iter().map(|e| e["kind"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let groups = list(&part.answer["indistinguishable"]);
    groups.iter().map(|group| list(group).iter().map(kinds).collect()).collect()
}

#[test]
#[ignore = "takes long"]
fn the_forces_of_a_walking_humanoid_have_explanations_that_cannot_be_told_apart() {
    for part in answers("humanoid", humanoid::run) {
        let suspects = part.answer["suspects"].as_array().unwrap();
        assert!(suspects.iter().any(|s| s == "base/force/y"), "{suspects:?}");
        // Horizontal force: a bias or a tilt. Vertical force: the sensors' gain or a mass.
        let groups = alternatives(&part);
        let has = |group: &[Vec<String>], kind: &str| group.iter().flatten().any(|k| k == kind);
        let whole = ["force_sensor_bias", "gravity_tilt", "force_sensor_gain", "payload"];
        assert!(groups.iter().any(|group| whole.iter().all(|kind| has(group, kind))), "{groups:?}");
        let vertical = after(&part, "base/force/z");
        assert!(vertical < 3.3, "vertical force {vertical} N");
    }
}
