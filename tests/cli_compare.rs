//! `bipedc compare`: the example logs against what is known of them.
#[path = "support/cli.rs"]
#[allow(dead_code)]
mod cli;

use cli::{bipedc, scratch, text};
use serde_json::Value;

const LOG: &str = "tests/data/examples/null/validation.csv.gz";

/// Show 7 on one example; the library's own tests do the others.
#[test]
fn errors_are_those_of_an_ideal_model() {
    let truth = std::fs::read_to_string("tests/data/examples/null/truth.json").unwrap();
    let nominal = serde_json::from_str::<Value>(&truth).unwrap()["nominal"].clone();
    let value = bipedc(&["compare", "robots/tulip", LOG, "--cutoff", "10,16", "--json"]).ok().json();
    let near = |found: &Value, expected: &Value| {
        let ratio = found.as_f64().unwrap() / expected.as_f64().unwrap();
        assert!((ratio - 1.0).abs() < 0.05, "{found} {expected}");
    };
    near(&value["rms"], &nominal["rms"]);
    assert_eq!(value["cutoff_hz"], nominal["cutoff_hz"]);
    let channels = value["channels"].as_array().unwrap();
    assert_eq!(channels.len(), 12);
    for channel in channels {
        near(&channel["rms"], &nominal["rms_by_joint"][channel["name"].as_str().unwrap()]);
        assert_eq!(channel["unit"], "N m");
        assert!(channel["max"].is_f64() && channel["relative"].is_f64() && channel["samples"].is_u64());
    }
}

#[test]
fn the_table_says_what_was_done() {
    let run = bipedc(&["compare", "robots/tulip", LOG, "--cutoff", "16", "--from", "2", "--to", "3"]).ok();
    for words in [
        "right_knee_pitch",
        "N m",
        "cut-off 16 Hz",
        "251 from 2.000 s to 3.000 s",
        "0.5 s left out",
        "assumed:",
    ] {
        assert!(run.out.contains(words), "no `{words}` in {}", run.out);
    }
}

#[test]
fn bad_logs_are_refused() {
    let compare = |log: &str| bipedc(&["compare", "robots/tulip", log]);
    compare("nowhere.csv").fails_with(&["nowhere.csv"]);
    let file = scratch("compare").join("log.csv");
    std::fs::write(&file, "").unwrap();
    compare(text(&file)).fails_with(&["empty", "log.csv"]);
    let head =
        "time,left_hip_pitch/position,left_hip_pitch/effort,right_hip_pitch/position,right_hip_pitch/effort";
    std::fs::write(&file, format!("{head}\n0,0,0,0,0\n0.1,x,0,0,0\n")).unwrap();
    bipedc(&["compare", "robots/three_link", text(&file)]).fails_with(&["log.csv:3"]);
    bipedc(&["compare", "robots/tulip", LOG, "--mapping", "nowhere.toml"]).fails_with(&["nowhere.toml"]);
}

#[test]
fn reports_are_written() {
    let folder = scratch("compare_report");
    let (page, pictures) = (folder.join("out.html"), folder.join("svg"));
    bipedc(&["compare", "robots/tulip", LOG, "--report", text(&page), "--svg", text(&pictures)]).ok();
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.starts_with("<!DOCTYPE html>") && html.len() < 5_000_000, "{} bytes", html.len());
    // The robot, and each of the twelve joints over time and against four signals.
    assert_eq!(std::fs::read_dir(&pictures).unwrap().count(), 1 + 12 * 5);
    bipedc(&["compare", "robots/tulip", LOG, "--report", "/proc/nowhere/out.html"]).fails_with(&["nowhere"]);
}

/// Tables and logs with foot forces; a clean log has no structure.
#[test]
fn everything_measured_is_compared() {
    let compare = |name: &str| {
        let file = format!("tests/data/examples/{name}/validation.csv.gz");
        bipedc(&["compare", "robots/tulip", &file, "--where", "--json"]).ok().json()
    };
    let rms = |value: &Value, kind: &str| value["kinds"][kind]["rms"].as_f64().unwrap();
    let postures = compare("postures");
    assert_eq!((&postures["abscissa"], &postures["unit"]), (&Value::from("posture"), &Value::from("m")));
    assert!((postures["rms"].as_f64().unwrap() / 0.0075647 - 1.0).abs() < 0.01);
    // The reference values were computed at 10 Hz.
    let file = "tests/data/examples/swaying/validation.csv.gz";
    let swaying =
        bipedc(&["compare", "robots/tulip", file, "--where", "--cutoff", "10", "--json"]).ok().json();
    assert!((rms(&swaying, "base_force") / 5.29581 - 1.0).abs() < 0.02);
    assert!((rms(&swaying, "base_moment") / 0.54569 - 1.0).abs() < 0.02);
    // The payload is on the torso, so the legs' joints are predicted down to the noise of the feet's sensors.
    assert!(rms(&swaying, "effort") < 0.09, "{}", rms(&swaying, "effort"));
    let rows = swaying["where"].as_array().unwrap();
    let phases = rows[0]["phases"].as_array().unwrap();
    assert!(phases.iter().any(|phase| phase["name"] == "double support"));
    assert_eq!(rows.iter().filter(|row| row["kind"] == "effort").count(), 10);
    let null = compare("null");
    for row in null["where"].as_array().unwrap() {
        assert_eq!(row["signature"].as_array().unwrap().len(), 0, "{row}");
        assert!(row["noise"].as_f64().unwrap() > 0.0);
    }
}
