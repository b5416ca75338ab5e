//! Gaits that `bipedc gait optimise` found: those that are shipped walk with everything checked, and the command finds one from nothing.
use crate::cli::{bipedc, scratch, text};
use serde_json::Value;

/// Twenty steps of a shipped scenario, all assumptions checked, and the smallest vertical impulse on a foot that an impact holds, N s.
fn twenty_steps(robot: &str, scenario: &str) -> f64 {
    let log = scratch(&format!("optimised-{scenario}")).join("run.csv");
    let scenario = format!("{robot}/scenarios/{scenario}.toml");
    let found =
        bipedc(&["simulate", robot, "--scenario", &scenario, "--out", text(&log), "--json"]).ok().json();
    assert_eq!((&found["verdict"], found["steps"].as_u64()), (&Value::Null, Some(20)), "{found}");
    let changes = found["changes"].as_array().unwrap().iter();
    let impulses = changes.flat_map(|change| change["impulse"].as_array().unwrap());
    impulses.map(|impulse| impulse["z"].as_f64().unwrap()).fold(f64::INFINITY, f64::min)
}

#[test]
#[ignore = "takes long"]
fn a_five_link_gait_found_from_nothing_walks() {
    twenty_steps("robots/five_link", "collocated");
}

#[test]
#[ignore = "takes long"]
fn a_gait_of_four_phases_found_from_nothing_walks() {
    let smallest = twenty_steps("robots/seven_link_v1", "from_nothing");
    assert!(smallest > 0.1, "{smallest} N s");
}

/// Wrong numbers, and the gait itself as the output, are refused before anything is computed.
#[test]
fn wrong_use_is_refused() {
    let gait = "robots/five_link/gaits/optimised.toml";
    let before = std::fs::read_to_string(gait).unwrap();
    let asked = |more: &[&str]| {
        let form = ["gait", "optimise", "robots/five_link", "--gait", "optimised"];
        bipedc(&[&form[..], more].concat()).err
    };
    assert!(asked(&["--speed", "0.7", "--out", gait]).contains("optimised.toml"));
    assert_eq!(std::fs::read_to_string(gait).unwrap(), before);
    let out = scratch("optimised-refused").join("new.toml");
    let told = asked(&["--speed", "0", "--friction", "-1", "--out", text(&out)]);
    assert!(told.contains("--speed: 0 is not possible") && told.contains("--friction: -1"), "{told}");
    assert!(!out.exists());
}

/// A minimum whose own controller walks with the speed that was asked for; then a speed that no such robot reaches, of which nothing is
/// left behind.
#[test]
#[ignore = "takes long"]
fn the_command_finds_a_gait_or_says_what_contradicts_it() {
    let out = scratch("optimised-command").join("new.toml");
    let asked = |speed: &str| {
        let form = ["gait", "optimise", "robots/five_link", "--gait", "optimised"];
        bipedc(&[&form[..], &["--speed", speed, "--out", text(&out), "--json"]].concat())
    };
    let found = asked("0.6").ok().json();
    let gait = &found["gaits"][0];
    let walks = gait["closed_loop"]["walking_speed"].as_f64().unwrap();
    let multiplier = gait["closed_loop"]["multiplier"].as_f64().unwrap();
    assert!(gait["minimum"] == true && (walks - 0.6).abs() < 1e-3 && multiplier < 0.8, "{found}");
    let written = std::fs::read_to_string(&out).unwrap();
    assert!(written.contains("bezier"), "{written}");
    std::fs::remove_file(&out).unwrap();
    let run = asked("9");
    let told = run.json();
    let violation = &told["gaits"][0]["violations"][0];
    assert!(violation["constraint"].is_string() && violation["phase"].is_string(), "{told}");
    assert!(!out.exists(), "nothing is written of what was not found");
}
