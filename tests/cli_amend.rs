//! `bipedc amend`, `bipedc history` and `bipedc effects`, what they print, write and refuse.
#[path = "cli_amend/export.rs"]
mod export;
#[path = "cli_amend/library.rs"]
mod library;
#[path = "cli_amend/on_disk.rs"]
mod on_disk;

use crate::cli::{Run, bipedc, piped, scratch, text};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const JOINT: &str = "left_knee_pitch";

/// A copy of a robot that may be amended.
fn robot(name: &str) -> PathBuf {
    let folder = scratch(name);
    for file in ["robot.urdf", "biped.toml"] {
        std::fs::copy(Path::new("robots/tulip").join(file), folder.join(file)).unwrap();
    }
    folder
}

fn read(folder: &Path, file: &str) -> String {
    std::fs::read_to_string(folder.join(file)).unwrap()
}

fn friction(folder: &Path, torque: &str, more: &[&str]) -> Run {
    let set = format!("torque={torque}");
    let mut arguments =
        vec!["amend", text(folder), "--effect", "coulomb_friction", "--joint", JOINT, "--set", &set];
    arguments.extend(more);
    bipedc(&arguments)
}

/// Names of the files in a folder.
fn files(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn an_effect_is_added_and_taken_back_byte_for_byte() {
    let folder = robot("amend_undo");
    let before = read(&folder, "biped.toml");
    let run = friction(&folder, "0.43", &[]).ok();
    assert!(run.out.contains("added Coulomb friction at left_knee_pitch") && run.out.contains("0.43 N m"));
    let after = read(&folder, "biped.toml");
    let added = after.strip_prefix(&before).expect("comments and order stay");
    assert!(added.contains("torque = 0.43  # N m\n") && added.starts_with("\n# bipedc amend, "), "{added}");
    bipedc(&["check", text(&folder)]).ok();
    bipedc(&["amend", text(&folder), "--undo"]).ok();
    assert_eq!(read(&folder, "biped.toml"), before);
    assert_eq!(files(&folder), ["biped.toml", "history.json", "robot.urdf"]);
    bipedc(&["amend", text(&folder), "--undo"]).fails_with(&["nothing to take back", "all 1 steps"]);
    let history = bipedc(&["history", text(&folder)]).ok();
    assert!(history.out.contains("(taken back)"), "{}", history.out);
}

#[test]
fn undo_without_any_step_says_so() {
    let folder = robot("amend_nothing");
    bipedc(&["amend", text(&folder), "--undo"]).fails_with(&["nothing to take back", "never amended"]);
    let run = bipedc(&["history", text(&folder)]).ok();
    assert!(run.out.contains("was never amended"), "{}", run.out);
    assert_eq!(files(&folder), ["biped.toml", "robot.urdf"]);
}

#[test]
fn every_step_is_taken_back_in_turn() {
    let folder = robot("amend_turns");
    let mut texts = vec![read(&folder, "biped.toml")];
    friction(&folder, "0.43", &[]).ok();
    texts.push(read(&folder, "biped.toml"));
    let set = "mass=1.2,x=0.05,y=0,z=0.3";
    bipedc(&["amend", text(&folder), "--effect", "payload", "--link", "torso", "--set", set]).ok();
    texts.push(read(&folder, "biped.toml"));
    let run = friction(&folder, "0.5", &["--set", "smoothing=0.05"]).ok();
    assert!(run.out.contains("replaced") && run.out.contains("0.43 → 0.5 N m"), "{}", run.out);
    texts.push(read(&folder, "biped.toml"));
    assert_eq!(texts[3].matches("[[effect]]").count(), 2);
    let remove = ["amend", text(&folder), "--effect", "payload", "--link", "torso", "--remove"];
    bipedc(&remove).ok();
    assert_eq!(read(&folder, "biped.toml").matches("[[effect]]").count(), 1);
    bipedc(&remove).fails_with(&["the description has no Payload at torso"]);
    while let Some(expected) = texts.pop() {
        bipedc(&["amend", text(&folder), "--undo"]).ok();
        assert_eq!(read(&folder, "biped.toml"), expected);
        if texts.is_empty() {
            break;
        }
    }
    assert_eq!(read(&folder, "biped.toml"), std::fs::read_to_string("robots/tulip/biped.toml").unwrap());
}

#[test]
fn wrong_effects_are_refused_and_nothing_is_written() {
    let folder = robot("amend_wrong");
    let before = read(&folder, "biped.toml");
    let refused = |arguments: &[&str], words: &[&str]| {
        let all: Vec<&str> = ["amend", text(&folder)].iter().chain(arguments).copied().collect();
        bipedc(&all).fails_with(words);
        assert_eq!(files(&folder), ["biped.toml", "robot.urdf"], "{arguments:?}");
        assert_eq!(read(&folder, "biped.toml"), before, "{arguments:?}");
    };
    let coulomb = ["--effect", "coulomb_friction"];
    let at =
        |joint: &'static str, set: &'static str| [&coulomb[..], &["--joint", joint, "--set", set]].concat();
    refused(&["--effect", "coulom_friction", "--joint", JOINT], &["did you mean `coulomb_friction`?"]);
    refused(&at("left_knee_pich", "torque=1"), &["did you mean `left_knee_pitch`?"]);
    refused(&at(JOINT, "torqe=1"), &["torqe", "did you mean `torque`?"]);
    refused(&at(JOINT, "torque=-1"), &["-1 is not possible", "0 N m or more"]);
    refused(&at(JOINT, "torque=nan"), &["expected a finite number", "`nan`"]);
    refused(&at(JOINT, "torque"), &["no NAME=VALUE", "--set torque=0.43"]);
    refused(&at(JOINT, "smoothing=0.1"), &["has no `torque`"]);
    refused(&[&coulomb[..], &["--joint", JOINT]].concat(), &["parameters are needed", "--set torque="]);
    refused(&[&coulomb[..], &["--set", "torque=1"]].concat(), &["has no `joint`"]);
    refused(&[&coulomb[..], &["--joint", JOINT, "log.csv"]].concat(), &["cannot read the file", "log.csv"]);
    refused(&["--formula", "k * sin(", "--joint", JOINT, "--param", "k=1"], &["torque"]);
    refused(&["--formula", "k * x", "--joint", JOINT, "--param", "k=1"], &["`x` is neither"]);
    refused(&["--formula", "k", "--joint", JOINT, "--param", "k=3,max=2"], &["3 is out of its bounds"]);
    refused(&["--from", "nowhere.json"], &["nowhere.json", "bipedc diagnose"]);
    refused(&["--from", "robots/tulip/biped.toml"], &["is no diagnosis", "biped.toml"]);
}

/// A second assignment behind one `--set` was an unexpected argument, or a log that is not there.
#[test]
fn several_values_behind_one_option_are_explained() {
    let folder = robot("amend_several");
    let before = files(&folder);
    for stray in [&["b=2"][..], &["b=2", "c=3"]] {
        let run = friction(&folder, "0.4", stray);
        assert!(run.code != Some(0) && run.err.contains("needs its own --set"), "{}", run.err);
        assert!(run.err.contains("--set a=1,b=2"), "{}", run.err);
    }
    assert_eq!(files(&folder), before);
}

#[test]
fn unusual_values_are_warned_of() {
    let folder = robot("amend_unusual");
    let run = friction(&folder, "430", &[]).ok();
    assert!(run.err.contains("warning") && run.err.contains("430 is unusual"), "{}", run.err);
    let run = friction(&folder, "0.5", &["--add"]);
    run.fails_with(&["stands there twice"]);
    assert_eq!(read(&folder, "biped.toml").matches("[[effect]]").count(), 1);
}

#[test]
fn a_formula_goes_into_the_description() {
    let folder = robot("amend_formula");
    let formula = ["--formula", "k * sin(3 * position)", "--name", "cable", "--joint", JOINT];
    let param = ["--param", "k=0.1,unit=N m,min=0,max=2"];
    bipedc(&[&["amend", text(&folder)], &formula[..], &param[..]].concat()).ok();
    let toml = read(&folder, "biped.toml");
    let line = "parameters.k = { value = 0.1, unit = \"N m\", min = 0.0, max = 2.0 }";
    assert!(toml.contains(line) && toml.contains("torque = \"k * sin(3 * position)\""), "{toml}");
    bipedc(&[&["amend", text(&folder)], &formula[..], &["--param", "k=0.2,unit=N m"]].concat()).ok();
    let toml = read(&folder, "biped.toml");
    assert!(toml.contains("{ value = 0.2, unit = \"N m\" }") && !toml.contains("0.1,"), "{toml}");
    bipedc(&["check", text(&folder)]).ok();
}

#[test]
fn a_urdf_alone_must_get_a_description_first() {
    let folder = robot("amend_bare");
    std::fs::remove_file(folder.join("biped.toml")).unwrap();
    friction(&folder, "1", &[]).fails_with(&["no description", "bipedc init", "robot.urdf"]);
    friction(&folder.join("robot.urdf"), "1", &[]).fails_with(&["no description", "bipedc init"]);
    assert_eq!(files(&folder), ["robot.urdf"]);
}

#[test]
fn a_dry_run_writes_nothing() {
    let folder = robot("amend_dry");
    let run = friction(&folder, "0.43", &["--dry-run"]).ok();
    assert!(run.out.contains("+ torque = 0.43  # N m") && run.out.contains("nothing was written"));
    assert_eq!(files(&folder), ["biped.toml", "robot.urdf"]);
}

/// Two effects as a diagnosis reports them; the second one entered first.
fn diagnosis(folder: &Path) -> PathBuf {
    let viscous = json!({"kind": "viscous_friction", "joint": JOINT, "parameters": {"damping": 0.125},
        "ci95": {"damping": [0.12, 0.13]}, "share": 0.2});
    let coulomb = json!({"kind": "coulomb_friction", "joint": JOINT, "parameters": {"torque": 0.43127},
        "ci95": {"torque": [0.41, 0.45]}, "share": 0.71});
    let source = |file: &str| json!({"file": file, "hash": "00000000deadbeef", "samples": 20000});
    let value = json!({
        "effects": [viscous, coulomb],
        "rms": {"base_force": {"unit": "N", "before": 3.0, "after": 2.0},
            "effort": {"unit": "N m", "before": 0.52, "after": 0.06, "noise": 0.05}},
        "rms_training": {"effort": {"unit": "N m", "before": 0.5, "after": 0.055}},
        "rms_before": 0.52, "rms_after": 0.06,
        "steps": [{"effect": coulomb, "before": 0.52, "after": 0.2}, {"effect": viscous, "before": 0.2, "after": 0.06}],
        "training": source("run.csv"), "validation": source("other.csv"),
    });
    let path = folder.join("diagnosis.json");
    std::fs::write(&path, value.to_string()).unwrap();
    path
}

#[test]
fn a_diagnosis_is_taken_with_its_errors() {
    let folder = robot("amend_from");
    let file = diagnosis(&folder);
    let run = bipedc(&["amend", text(&folder), "--from", text(&file)]).ok();
    for words in ["0.4313 N m  (95 %: 0.41 to 0.45)", "held-out effort 0.52 → 0.06 N m"] {
        assert!(run.out.contains(words), "no `{words}` in {}", run.out);
    }
    let toml = read(&folder, "biped.toml");
    let (coulomb, viscous) =
        (toml.find("torque = 0.43127  # N m, 95 %: 0.41 to 0.45"), toml.find("damping = 0.125"));
    assert!(coulomb.is_some() && coulomb < viscous, "the order of entering: {toml}");
    for words in ["from run.csv (20000 samples)", "judged on other.csv", "held-out effort 0.52 → 0.2 N m"] {
        assert!(toml.contains(words), "no `{words}` in {toml}");
    }
    let history = bipedc(&["history", text(&folder), "--svg", text(&folder.join("stairs.svg"))]).ok();
    for words in [
        "0.52 → 0.2 N m",
        "0.2 → 0.06 N m",
        "held-out effort, N m",
        "████░",
        "noise of the measurement 0.05 N m",
    ] {
        assert!(history.out.contains(words), "no `{words}` in {}", history.out);
    }
    let svg = read(&folder, "stairs.svg");
    let document = roxmltree::Document::parse(&svg).unwrap();
    let paths = document.descendants().filter(|node| node.has_tag_name("path")).count();
    assert!(paths == 3 && svg.contains("Coulomb friction at left_knee_pitch"), "{svg}");
}

/// Before: an answer with which the error of another kind of rows rose by 29 % was written without a word.
#[test]
fn errors_that_rise_with_what_is_written_are_warned_of() {
    let folder = robot("amend_risen");
    let file = diagnosis(&folder);
    let mut value: Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    let amend = |value: &Value| {
        std::fs::write(&file, value.to_string()).unwrap();
        bipedc(&["amend", text(&folder), "--from", text(&file), "--dry-run"]).ok().err.clone()
    };
    assert!(!amend(&value).contains("rises"));
    value["rms"]["base_moment"] = json!({"unit": "N m", "before": 1.833, "after": 2.365, "noise": 1.5465});
    let warned = amend(&value);
    let words = "with what is written the held-out error of the base moment rises from 1.833 to 2.365 N m";
    assert!(warned.contains(words) && warned.contains("--undo"), "{warned}");
}

/// What was fitted beside the effects is written with them, and added to what stands; of a selection only on request.
#[test]
fn corrections_of_inertias_are_written_and_add_up() {
    let folder = robot("amend_corrections");
    let file = diagnosis(&folder);
    let mut value: Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    value["inertial_corrections"] = json!([{"kind": "inertial_correction", "link": "torso",
        "parameters": {"mass": 0.25, "x": 0.002, "y": 0.0, "z": -0.001, "iyy": 0.01},
        "ci95": {"mass": [0.2, 0.3], "x": [null, null]}}]);
    std::fs::write(&file, value.to_string()).unwrap();
    let before = read(&folder, "biped.toml");
    let amend = |more: &[&str]| {
        bipedc(&[&["amend", text(&folder), "--from", text(&file)][..], more].concat()).ok();
        read(&folder, "biped.toml")
    };
    assert!(!amend(&["--only", "1"]).contains("inertial_correction"));
    bipedc(&["amend", text(&folder), "--undo"]).ok();
    assert!(amend(&["--only", "1", "--with-corrections"]).contains("inertial_correction"));
    bipedc(&["amend", text(&folder), "--undo"]).ok();
    let once = amend(&[]);
    for words in
        ["mass = 0.25  # kg, 95 %: 0.2 to 0.3", "x = 0.002  # m, not determined", "iyy = 0.01  # kg m²"]
    {
        assert!(once.contains(words), "no `{words}` in {once}");
    }
    let history = bipedc(&["history", text(&folder), "--json"]).ok().json();
    let stairs = history["stairs"].as_array().unwrap();
    assert_eq!(stairs.len(), 1, "no effect has an error of its own beside corrections: {stairs:?}");
    assert_eq!((&stairs[0]["before"], &stairs[0]["after"]), (&json!(0.52), &json!(0.06)));
    let twice = amend(&[]);
    assert!(twice.contains("mass = 0.5  # kg, 95 %: 0.45 to 0.55"), "{twice}");
    assert_eq!(twice.matches("inertial_correction").count(), 1);
    // What was judged is what stands: the parameters of the link change twice as much, which its shift does not.
    let second = torso_parameters(&folder);
    assert!(!twice.contains("x = 0.004"), "{twice}");
    bipedc(&["amend", text(&folder), "--undo"]).ok();
    let first = torso_parameters(&folder);
    bipedc(&["amend", text(&folder), "--undo"]).ok();
    let described = torso_parameters(&folder);
    for ((second, first), described) in second.into_iter().zip(first).zip(described) {
        assert!((second - 2.0 * first + described).abs() < 1e-12, "{described} {first} {second}");
    }
    for _ in 0..2 {
        amend(&[]);
    }
    for _ in 0..2 {
        bipedc(&["amend", text(&folder), "--undo"]).ok();
    }
    assert_eq!(read(&folder, "biped.toml"), before);
}

/// Mass, first and second moments of the torso as amended, in its own axes.
fn torso_parameters(folder: &std::path::Path) -> Vec<f64> {
    let robot = bipedc_compiler::Robot::read(folder).unwrap();
    let built = bipedc_compiler::tree::as_built(&robot.description);
    let inertial = built.links.iter().find(|link| link.name == "torso").unwrap().inertial.unwrap();
    let (m, c) = (inertial.mass, inertial.origin.xyz);
    let about = bipedc::robot::link_inertias::about_center(&inertial);
    let square: f64 = c.iter().map(|x| x * x).sum();
    let mut all = vec![m, m * c[0], m * c[1], m * c[2]];
    for (r, k) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
        all.push(about[r][k] + m * (if r == k { square } else { 0.0 } - c[r] * c[k]));
    }
    all
}

#[cfg(unix)]
#[test]
fn a_diagnosis_may_come_through_a_pipe_and_a_robot_not() {
    let folder = robot("amend_pipe");
    let diagnosis = std::fs::read(diagnosis(&folder)).unwrap();
    let step = piped(&["amend", text(&folder), "--from", "/dev/stdin", "--json"], &diagnosis).ok().json();
    assert!(step.to_string().contains("/dev/stdin"), "{step}");
    let robot = std::fs::read(folder.join("biped.toml")).unwrap();
    let options = ["--effect", "coulomb_friction", "--joint", JOINT, "--set", "torque=0.1"];
    piped(&[&["amend", "/dev/stdin"][..], &options].concat(), &robot)
        .fails_with(&["/dev/stdin", "cannot be amended"]);
}

/// Where the error fell in another channel than the torques', that channel is spoken of; the training data are, too.
#[test]
fn a_step_has_the_errors_of_the_channel_that_tells() {
    let folder = robot("amend_transmission");
    let backlash = json!({"kind": "backlash", "joint": JOINT, "parameters": {"gap": 0.03}, "ci95": {"gap": [0.029, 0.031]}});
    let fall = |before: f64, after: f64, unit: &str| json!({"unit": unit, "before": before, "after": after});
    let value = json!({
        "effects": [backlash],
        "rms": {"effort": fall(0.07, 0.07, "N m"), "transmission": fall(0.0142, 0.0002, "rad")},
        "rms_training": {"effort": fall(0.08, 0.08, "N m"), "transmission": fall(0.015, 0.0003, "rad")},
        "rms_before": 0.07, "rms_after": 0.07,
        "steps": [{"effect": backlash, "before": 0.07, "after": 0.07}],
        "step_errors": [{"held_out": {"effort": [0.07, 0.07], "transmission": [0.0142, 0.0002]},
            "training": {"effort": [0.08, 0.08], "transmission": [0.015, 0.0003]}}],
    });
    let file = folder.join("diagnosis.json");
    std::fs::write(&file, value.to_string()).unwrap();
    bipedc(&["amend", text(&folder), "--from", text(&file)]).ok();
    let toml = read(&folder, "biped.toml");
    let said = "held-out transmission 0.0142 → 0.0002 rad, on the whole training log 0.015 → 0.0003 rad";
    assert!(toml.contains(said), "{toml}");
    let history = bipedc(&["history", text(&folder)]).ok().out;
    for words in ["0.0142 → 0.0002 rad", "0.015 → 0.0003 rad", "held-out transmission, rad"] {
        assert!(history.contains(words), "no `{words}` in {history}");
    }
    assert!(!history.contains('—'), "{history}");
}

/// What is zero within its error bars is left out, and all logs are named.
#[test]
fn an_identification_writes_what_it_found() {
    let folder = robot("amend_identified");
    let log =
        |file: &str, samples: usize| json!({"file": file, "hash": "00000000deadbeef", "samples": samples});
    let extra = |name: &str, value: f64, error: f64| json!({"name": format!("{JOINT}.{name}"), "unit": "", "value": value, "standard_error": error});
    let value = json!({
        "logs": [log("a.csv", 100), log("b.csv", 200)],
        "validation": log("v.csv", 50),
        "physical": {"links": [], "extras": [extra("coulomb_friction", 0.4, 0.01), extra("viscous_friction", 9.7e-8, 1e-3)]},
    });
    let file = folder.join("identified.json");
    std::fs::write(&file, value.to_string()).unwrap();
    let run = bipedc(&["amend", text(&folder), "--from", text(&file)]).ok();
    assert!(run.out.contains("left out, as zero within 95 % intervals: Viscous friction"), "{}", run.out);
    let toml = read(&folder, "biped.toml");
    assert!(!toml.contains("viscous_friction"), "{toml}");
    let data = "from a.csv (100 samples) and b.csv (200 samples), judged on v.csv (50 samples)";
    assert!(toml.contains(data), "{toml}");
    let step = &bipedc(&["history", text(&folder), "--json"]).ok().json()["steps"][0];
    assert_eq!(step["more_training"][0]["file"], "b.csv");
    assert_eq!(step["validation"]["hash"], "00000000deadbeef");
}

/// The filter that was asked for is that of the errors, and of the comparison that is proposed.
#[test]
fn an_identification_is_judged_behind_its_own_filter() {
    let folder = robot("amend_identified_behind");
    let log = Path::new("tests/data/examples/coulomb/train.csv.gz");
    let found = bipedc(&["identify", text(&folder), text(log), "--cutoff", "7", "--json"]).ok();
    let file = folder.join("identified.json");
    std::fs::write(&file, found.out).unwrap();
    let amended = bipedc(&["amend", text(&folder), "--from", text(&file)]).ok();
    for words in ["N m, behind a filter of 7 Hz", "other.csv --cutoff 7;"] {
        assert!(amended.out.contains(words), "no `{words}` in {}", amended.out);
    }
    let step = &bipedc(&["history", text(&folder), "--json"]).ok().json()["steps"][0];
    let compared = bipedc(&["compare", text(&folder), text(log), "--cutoff", "7", "--json"]).ok().json();
    let [told, counted] =
        [&step["errors"][0]["training"]["after"], &compared["rms"]].map(|x| x.as_f64().unwrap());
    assert!((told / counted - 1.0).abs() < 1e-9, "{told} and {counted}");
    let chosen = bipedc(&["compare", text(&folder), text(log), "--json"]).ok().json();
    assert!(
        chosen["cutoff_hz"] != compared["cutoff_hz"],
        "the filter that compare chooses tells nothing here"
    );
}

#[test]
fn the_history_speaks_json() {
    let folder = robot("amend_json");
    let file = diagnosis(&folder);
    let step = bipedc(&["amend", text(&folder), "--from", text(&file), "--json"]).ok().json();
    assert_eq!(step["step"], 1);
    let value = bipedc(&["history", text(&folder), "--json"]).ok().json();
    assert_eq!(value["state"], "agrees");
    let step = &value["steps"][0];
    assert!(step["previous_text"].is_null(), "the kept text is not for readers");
    assert_eq!(step["changes"][0]["action"], "added");
    assert_eq!(step["changes"][0]["effect"]["parameters"]["torque"], 0.43127);
    assert_eq!(step["training"]["hash"], "00000000deadbeef");
    assert_eq!(step["validation"]["samples"], 20000);
    assert_eq!(step["errors"][0]["channel"], "effort");
    assert_eq!(step["errors"][0]["held_out"], json!({"before": 0.52, "after": 0.06}));
    assert_eq!(step["errors"][0]["training"], json!({"before": 0.5, "after": 0.055}));
    for key in ["date", "tool", "origin", "before", "after"] {
        assert!(!step[key].is_null(), "no `{key}` in {step}");
    }
    let date = step["date"].as_str().unwrap();
    assert!(date.len() == 20 && date.ends_with('Z') && &date[10..11] == "T", "{date}");
    let stairs = value["stairs"].as_array().unwrap();
    assert_eq!(stairs.len(), 2);
    assert_eq!(
        (&stairs[1]["before"], &stairs[1]["after"], &stairs[1]["unit"]),
        (&json!(0.2), &json!(0.06), &json!("N m"))
    );
}

/// Names, values and units of all parameters, whichever way they came.
#[test]
fn the_history_prints_values() {
    let folder = robot("amend_values");
    friction(&folder, "0.43", &[]).ok();
    friction(&folder, "0.5", &[]).ok();
    let spring = ["--effect", "parallel_spring", "--joint", "right_knee_pitch"];
    let values = ["--set", "stiffness=12.5", "--set", "rest_angle=-0.1"];
    bipedc(&[&["amend", text(&folder)], &spring[..], &values[..]].concat()).ok();
    bipedc(&["amend", text(&folder), "--from", text(&diagnosis(&folder)), "--only", "viscous_friction"]).ok();
    let history = bipedc(&["history", text(&folder)]).ok();
    let rows: Vec<&str> = history.out.lines().skip(1).collect();
    for (row, words) in [
        "+ Coulomb friction at left_knee_pitch  torque 0.43 N m ",
        "~ Coulomb friction at left_knee_pitch  torque 0.5 N m ",
        "+ Parallel spring at right_knee_pitch  rest_angle -0.1 rad, stiffness 12.5 N m/rad ",
        "+ Viscous friction at left_knee_pitch  damping 0.125 N m s/rad ",
    ]
    .iter()
    .enumerate()
    {
        assert!(rows[row].starts_with(&format!("{} ", row + 1)), "{}", history.out);
        assert!(rows[row].contains(words), "no `{words}` in {}", history.out);
    }
}

#[test]
fn a_part_of_a_diagnosis_has_only_the_errors_that_are_known() {
    let folder = robot("amend_only");
    let file = diagnosis(&folder);
    let only =
        |which: &str| bipedc(&["amend", text(&folder), "--from", text(&file), "--only", which, "--json"]);
    let first = only("coulomb_friction:left_knee_pitch").ok().json();
    assert_eq!(first["changes"].as_array().unwrap().len(), 1);
    assert_eq!(first["errors"][0]["held_out"], json!({"before": 0.52, "after": 0.2}));
    let second = only("1").ok().json();
    assert_eq!(second["changes"][0]["effect"]["kind"], "viscous_friction");
    assert_eq!(second["errors"], json!([]), "its error without the other effect was never measured");
    assert!(second["note"].as_str().unwrap().contains("compare"));
    only("3").fails_with(&["no effect `3`", "2 coulomb_friction:left_knee_pitch"]);
}

#[test]
fn two_alike_of_a_diagnosis_both_enter() {
    let folder = robot("amend_alike");
    let ripple = |periods: f64| {
        json!({"kind": "torque_ripple", "joint": JOINT,
        "parameters": {"amplitude": 0.5, "periods_per_turn": periods, "phase": 0.0}})
    };
    let file = folder.join("diagnosis.json");
    std::fs::write(&file, json!({"effects": [ripple(12.0), ripple(50.0)]}).to_string()).unwrap();
    bipedc(&["amend", text(&folder), "--from", text(&file)]).ok();
    let toml = read(&folder, "biped.toml");
    assert!(toml.contains("periods_per_turn = 12.0") && toml.contains("periods_per_turn = 50.0"), "{toml}");
    bipedc(&["amend", text(&folder), "--from", text(&file)]).fails_with(&["has several", "--add"]);
}

#[test]
fn a_diagnosis_without_effects_adds_nothing() {
    let folder = robot("amend_null");
    let file = folder.join("diagnosis.json");
    std::fs::write(&file, "{\"effects\": []}").unwrap();
    let run = bipedc(&["amend", text(&folder), "--from", text(&file)]).ok();
    assert!(run.out.contains("no missing effect"), "{}", run.out);
    assert_eq!(files(&folder), ["biped.toml", "diagnosis.json", "robot.urdf"]);
    std::fs::write(&file, "{\"effects\": [{\"kind\": 3}]}").unwrap();
    bipedc(&["amend", text(&folder), "--from", text(&file)])
        .fails_with(&["is no diagnosis", "diagnosis.json:1"]);
}
