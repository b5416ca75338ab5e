//! Parameters of a gait of four phases chosen at mid-stance for wished speeds, on the whole robot.
use crate::cli::{Run, bipedc, scratch, text};
use serde_json::Value;

const ROBOT: &str = "robots/seven_link_v1";

fn run(name: &str, scenario: &str) -> Run {
    let folder = scratch(name);
    let (file, log) = (folder.join("scenario.toml"), folder.join("run.csv"));
    std::fs::write(&file, scenario).unwrap();
    bipedc(&["simulate", ROBOT, "--scenario", text(&file), "--out", text(&log), "--json"])
}

fn shipped(name: &str) -> String {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(ROBOT).join("scenarios");
    std::fs::read_to_string(folder.join(name)).unwrap()
}

fn number(step: &Value, key: &str) -> f64 {
    step[key].as_f64().unwrap_or_else(|| panic!("no {key} in {step}"))
}

/// Everything is checked while the whole robot walks; what was foreseen at mid-stance comes true.
fn holds(found: &Value, wished: u64) {
    let speeds = &found["speeds"];
    println!("{} of {} met, {} off at most", speeds["met"], speeds["wished"], speeds["largest_surprise"]);
    assert_eq!((&found["verdict"], &found["end"]), (&Value::Null, &Value::from("steps")), "{found}");
    assert_eq!(speeds["wished"].as_u64(), Some(wished));
    assert!(number(speeds, "largest_surprise") < 1e-6);
}

#[test]
fn wished_speeds_are_met_in_four_phases() {
    let speeds = "speeds = [0.44, 0.42]\nchoice = { values = 5, parameters = { push_off = true } }";
    let scenario = shipped("thousand.toml");
    let line = scenario.lines().find(|line| line.starts_with("speeds")).unwrap();
    let found = run("phased_choice", &scenario.replace(line, speeds)).ok().json();
    holds(&found, 2);
    let steps = found["speeds"]["steps"].as_array().unwrap();
    for (step, wished) in steps[1..].iter().zip([0.44, 0.42]) {
        assert!((number(step, "reached") - wished).abs() < 1e-6, "{step}");
        assert_eq!(step["choice"], "meets");
    }
}

#[test]
#[ignore = "takes long"]
fn a_thousand_random_speeds_do_not_make_it_fall() {
    holds(&run("phased_choice_thousand", &shipped("thousand.toml")).ok().json(), 1000);
}

#[test]
fn what_cannot_be_chosen_is_refused_with_its_place() {
    let scenario = shipped("thousand.toml");
    run("phased_choice_kept", &format!("{scenario}\n[control.choice]\nkeep = [\"friction\"]"))
        .fails_with(&["keep all that the scenario assumes", "[assumptions]"]);
    run("phased_choice_unknown", &format!("{scenario}\n[control.choice.parameters]\npush_of = true"))
        .fails_with(&["no parameter `push_of`", "push_off"]);
}
