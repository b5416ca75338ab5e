//! `bipedc diagnose`: the keys of its JSON, what it refuses, and the loop by itself.
use crate::cli;

use cli::{bipedc, scratch, text};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

const TRAIN: &str = "tests/data/examples/coulomb/train.csv.gz";
const OTHER: &str = "tests/data/examples/coulomb/validation.csv.gz";
const JOINT: &str = "left_knee_pitch";

/// The friction that the other simulator put into the knee, N m.
fn truth() -> f64 {
    let file = std::fs::read_to_string("tests/data/examples/coulomb/truth.json").unwrap();
    let truth: Value = serde_json::from_str(&file).unwrap();
    let found = find(&truth, "torque").or_else(|| find(&truth, "coulomb"));
    found.expect("the example states its torque")
}

/// The first number under this key, wherever it is.
fn find(value: &Value, key: &str) -> Option<f64> {
    match value {
        Value::Object(map) => {
            map.get(key).and_then(Value::as_f64).or_else(|| map.values().find_map(|v| find(v, key)))
        }
        Value::Array(list) => list.iter().find_map(|v| find(v, key)),
        _ => None,
    }
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

fn object(value: &Value) -> &Map<String, Value> {
    value.as_object().expect("an object")
}

fn assert_effect(found: &Value) {
    let effect = object(found);
    assert!(effect["kind"].is_string(), "{found}");
    assert!(effect["parameters"].as_object().is_some_and(|p| p.values().all(Value::is_number)), "{found}");
    assert!(
        effect["ci95"].is_object() && effect["share"].as_f64().is_some_and(|s| (0.0..=1.0).contains(&s)),
        "{found}"
    );
    for (name, interval) in object(&effect["ci95"]) {
        let value = effect["parameters"][name].as_f64().unwrap();
        let [low, high] = [0, 1].map(|k| interval[k].as_f64().unwrap());
        assert!(low <= value && value <= high, "{name}: {found}");
    }
}

#[test]
#[ignore = "takes long"]
fn the_answer_has_its_documented_keys() {
    let arguments = [
        "diagnose",
        "robots/tulip",
        TRAIN,
        "--validate",
        OTHER,
        "--json",
        "--cutoff",
        "16",
        "--to",
        "9",
        "--most",
        "1",
    ];
    let answer = bipedc(&arguments).ok().json();
    let page = std::fs::read_to_string("docs/diagnosis.md").unwrap();
    for key in keys(&answer) {
        assert!(page.contains(&format!("`{key}`")), "docs/diagnosis.md does not explain `{key}`");
    }
    for key in [
        "effects",
        "inertial_corrections",
        "indistinguishable",
        "unexplained",
        "suspects",
        "rejected",
        "rms",
        "rms_before",
        "rms_after",
        "warnings",
        "summary",
        "training",
        "validation",
    ] {
        assert!(answer.get(key).is_some(), "no `{key}`");
    }
    let effects = answer["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 1, "{answer:#}");
    assert_eq!((&effects[0]["kind"], &effects[0]["joint"]), (&"coulomb_friction".into(), &JOINT.into()));
    let torque = effects[0]["parameters"]["torque"].as_f64().unwrap();
    assert!((torque / truth() - 1.0).abs() < 0.15, "{torque}");
    for list in ["effects", "inertial_corrections"] {
        answer[list].as_array().unwrap().iter().for_each(assert_effect);
    }
    for group in answer["indistinguishable"].as_array().unwrap() {
        let alternatives = group.as_array().unwrap();
        assert!(alternatives.len() > 1);
        alternatives.iter().flat_map(|a| a.as_array().unwrap()).for_each(assert_effect);
    }
    let rejected = answer["rejected"].as_array().unwrap();
    assert!(!rejected.is_empty());
    for one in rejected {
        assert_eq!(keys(one), ["kind", "place", "why"]);
    }
    assert!(answer["unexplained"].is_boolean() && answer["suspects"].is_array());
    assert_eq!(keys(&answer["rms"]), ["effort"]);
    for key in ["unit", "before", "after"] {
        assert!(answer["rms"]["effort"].get(key).is_some(), "no `{key}`");
    }
    assert_eq!(answer["rms"]["effort"]["unit"], "N m");
    assert_eq!(answer["rms"]["effort"]["after"], answer["rms_after"]);
    assert!(answer["rms_after"].as_f64().unwrap() < 0.5 * answer["rms_before"].as_f64().unwrap());
    errors_mean_the_same(&answer);
}

/// `compare` and `diagnose` of one log at one cut-off: errors with and without the samples at which joints stick.
fn errors_mean_the_same(answer: &Value) {
    let cutoff =
        ["judged_at_hz", "cutoff_hz"].iter().find_map(|key| answer[key].as_f64()).unwrap().to_string();
    let compared = bipedc(&["compare", "robots/tulip", OTHER, "--cutoff", &cutoff, "--json"]).ok().json();
    let same = |one: &Value, other: &Value| {
        let (one, other) = (one.as_f64().unwrap(), other.as_f64().unwrap());
        assert!((one / other - 1.0).abs() < 1e-6, "{one} and {other}");
    };
    let (kind, all) = (&compared["kinds"]["effort"], &answer["rms"]["effort"]);
    same(&kind["rms"], &all["before"]);
    same(&kind["rms_moving"], &all["before_moving"]);
    let sticking = compared["channels"].as_array().unwrap().iter().filter(|c| c.get("sticking").is_some());
    let sticking: Vec<&Value> = sticking.collect();
    assert!(sticking.iter().any(|channel| channel["name"] == JOINT), "{compared:#}");
    for channel in sticking {
        let row = &answer["rows"][channel["name"].as_str().unwrap()];
        same(&channel["rms"], &row["before"]);
        same(&channel["rms_moving"], &row["before_moving"]);
        let part = channel["sticking"].as_f64().unwrap();
        assert!(part > 0.0 && part < 0.5, "{part}");
    }
}

#[test]
fn wrong_use_is_refused_before_the_search() {
    let folder = scratch("diagnose_refused");
    let mapping = folder.join("flipped.toml");
    std::fs::write(&mapping, format!("\"{JOINT}/effort\" = {{ sign = -1 }}\n")).unwrap();
    let flipped = ["diagnose", "robots/tulip", TRAIN, "--cutoff", "16", "--mapping", text(&mapping)];
    bipedc(&flipped).fails_with(&[
        "`left_knee_pitch/effort` has the wrong sign",
        "train.csv.gz",
        "{ sign = -1 }",
        "--anyway",
    ]);
    bipedc(&["diagnose", "robots/tulip", TRAIN, "--validate", TRAIN, "--cutoff", "16"])
        .fails_with(&["the validation log is the training log"]);
}

/// A copy of the robot that may be amended.
fn robot(name: &str) -> PathBuf {
    let folder = scratch(name);
    for file in ["robot.urdf", "biped.toml"] {
        std::fs::copy(Path::new("robots/tulip").join(file), folder.join(file)).unwrap();
    }
    folder
}

#[test]
#[ignore = "takes long"]
fn the_loop_by_itself_ends_with_nothing_missing() {
    let folder = robot("diagnose_loop");
    let arguments = ["--validate", OTHER, "--cutoff", "16", "--to", "9", "--until-explained"];
    let run = bipedc(&[&["diagnose", text(&folder), TRAIN], arguments.as_slice()].concat()).ok();
    assert!(run.out.contains("step 1\n") && run.out.contains("nothing more earns its place"), "{}", run.out);
    assert!(!run.out.contains("step 2\n"), "{}", run.out);
    let description = std::fs::read_to_string(folder.join("biped.toml")).unwrap();
    assert!(description.contains("coulomb_friction") && description.contains(JOINT), "{description}");
    let line = description.lines().find(|line| line.starts_with("torque = ")).expect("a torque");
    let torque: f64 = line.split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!((torque / truth() - 1.0).abs() < 0.02, "{torque}");
    let history = bipedc(&["history", text(&folder)]).ok();
    assert!(history.out.contains("Coulomb friction"), "{}", history.out);
    // The same for programs.
    bipedc(&["amend", text(&folder), "--undo"]).ok();
    let run =
        bipedc(&[&["diagnose", text(&folder), TRAIN, "--json"], arguments.as_slice()].concat()).ok().json();
    assert_eq!((run["complete"].as_bool(), run["searches"].as_u64()), (Some(true), Some(2)), "{run}");
    let steps = run["steps"].as_array().unwrap();
    assert!(steps.len() == 1 && steps[0]["changes"].to_string().contains(JOINT), "{steps:?}");
    assert_eq!(run["last"]["effects"].as_array().map(Vec::len), Some(0));
}

/// A log of 250 Hz holds nothing above 125 Hz; delays of a sampling step were found behind such a filter.
#[test]
fn a_cutoff_that_the_sampling_does_not_have_is_refused_everywhere() {
    let words = ["the cut-off of 500 Hz is not below half the sampling rate of", "choose a cut-off between"];
    for command in ["compare", "diagnose", "identify"] {
        bipedc(&[command, "robots/tulip", TRAIN, "--cutoff", "500"]).fails_with(&words);
    }
    // The judge is a log too.
    bipedc(&["diagnose", "robots/tulip", TRAIN, "--validate", OTHER, "--cutoff", "500"]).fails_with(&words);
}

/// Contacts are no reason to be sure of a second and a half.
#[test]
fn so_little_of_a_log_with_contacts_is_said() {
    let log = "tests/data/examples/swaying/train.csv.gz";
    let answer = bipedc(&["diagnose", "robots/tulip", log, "--to", "2", "--json"]).ok().json();
    let warned = answer["warnings"].as_array().unwrap().iter().any(|warning| {
        let said = warning.as_str().unwrap();
        said.contains("the log has only 1.") && said.contains("estimates from it are hardly supported")
    });
    assert!(warned, "{}", answer["warnings"]);
}
