//! Velocity limits of the URDF: margins, maps, plans, choices and simulations.
use crate::cli::{bipedc, scratch, text};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The three-link robot whose joints may be no faster than this, rad/s.
fn no_faster_than(name: &str, limit: f64) -> PathBuf {
    let (folder, from) = (scratch(name), Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/three_link"));
    std::fs::create_dir_all(folder.join("gaits")).unwrap();
    for file in ["robot.urdf", "biped.toml", "gaits/thesis.toml"] {
        let words = std::fs::read_to_string(from.join(file)).unwrap();
        std::fs::write(folder.join(file), words.replace("velocity=\"10\"", &format!("velocity=\"{limit}\"")))
            .unwrap();
    }
    folder
}

fn json(command: &[&str], robot: &Path, more: &[&str]) -> Value {
    bipedc(&[command, &[text(robot), "--gait", "thesis", "--json"], more].concat()).ok().json()
}

/// A cell breaks the assumption where the margin of its step is below zero, and nowhere else.
#[test]
fn maps_keep_velocity_limits_where_it_is_asked() {
    let robot = no_faster_than("no_faster_in_maps", 2.2);
    let over = ["--over", "step_length=0.3:0.7:3", "--over", "torso_lean=-0.7:-0.3:3", "--speed", "1.5"];
    let map = json(&["gait", "map"], &robot, &[&over[..], &["--assume", "velocity"]].concat());
    let codes: Vec<&str> = map["reasons"].as_array().unwrap().iter().map(|x| x.as_str().unwrap()).collect();
    let mut seen = std::collections::BTreeSet::new();
    for (row, lean) in [-0.7, -0.5, -0.3].into_iter().enumerate() {
        for (column, length) in [0.3, 0.5, 0.7].into_iter().enumerate() {
            let set = [format!("step_length={length}"), format!("torso_lean={lean}")];
            let asked = ["--speed", "1.5", "--set", set[0].as_str(), "--set", set[1].as_str()];
            let step = json(&["gait", "step"], &robot, &asked);
            let margin = step["margins"]["velocity"].as_f64();
            let expected = match (step["feasible"].as_bool().unwrap(), margin.is_some_and(|x| x < 0.0)) {
                (false, _) => "falls_back",
                (true, true) => "velocity",
                (true, false) => "passes",
            };
            let code = codes[map["maps"][0]["reason"][row][column].as_u64().unwrap() as usize];
            assert_eq!(code, expected, "{length} {lean} {margin:?}");
            seen.insert(code);
        }
    }
    assert!(seen.contains("velocity") && seen.contains("passes"), "{seen:?}");
}

/// Steps of a plan that keeps the limits keep them one by one, and it takes more of them.
#[test]
fn plans_keep_velocity_limits_where_it_is_asked() {
    let robot = no_faster_than("no_faster_in_plans", 2.6);
    let fixed = ["--set", "torso_lean=-0.5"];
    let plan = |to: &str, more: &[&str]| {
        json(&["gait", "steps"], &robot, &[&["--from-speed", "1", "--to", to], &fixed[..], more].concat())
    };
    let kept = plan("1.4", &["--assume", "velocity"]);
    let steps = kept["plans"][0]["plan"].as_array().unwrap();
    assert!(steps.len() > 1, "{kept}");
    let mut before = "0.5".to_owned();
    for pair in steps.windows(2) {
        let length = pair[1]["parameters"]["step_length"].to_string();
        let (speed, from) = (pair[0]["speed"].to_string(), pair[0]["parameters"]["step_length"].to_string());
        let names =
            [format!("step_length={length}"), format!("step_length={from}"), format!("step_length={before}")];
        let asked = ["--speed", &speed, "--set", &names[0], "--from", &names[1], "--before", &names[2]];
        let step = json(&["gait", "step"], &robot, &[&asked[..], &fixed].concat());
        assert!(step["margins"]["velocity"].as_f64().unwrap() > -1e-3, "{step}");
        before = from;
    }
    let count = |more: &[&str]| plan("1.8", more)["plans"][0]["steps"].as_u64().unwrap();
    assert!(count(&["--assume", "velocity"]) > count(&[]));
}

/// A velocity at an instant between rows of the log counts.
#[test]
fn simulations_see_velocities_between_rows_of_the_log() {
    let scenario = std::fs::read_to_string("robots/five_link/scenarios/robust.toml").unwrap();
    let folder = scratch("no_faster_between_rows");
    let margin = |step: &str| {
        let (file, log) = (folder.join("walk.toml"), folder.join("run.csv"));
        let lines = scenario.lines().filter(|line| !line.starts_with("log_step"));
        let words = lines.collect::<Vec<_>>().join("\n").replacen(
            "duration",
            &format!("log_step = {step}\nduration"),
            1,
        );
        std::fs::write(&file, words).unwrap();
        let run = ["simulate", "robots/five_link", "--scenario", text(&file), "--out", text(&log), "--json"];
        bipedc(&run).ok().json()["velocity"]["margin"].as_f64().unwrap()
    };
    let (coarse, fine) = (margin("0.5"), margin("0.0005"));
    assert!((coarse - fine).abs() < 0.01, "{coarse} {fine}");
}

/// Who assumes what no joint has is told so.
#[test]
fn velocities_without_limits_are_no_assumption() {
    let robot = no_faster_than("no_velocity_limits", 10.0);
    let urdf = robot.join("robot.urdf");
    let words = std::fs::read_to_string(&urdf).unwrap().replace(" velocity=\"10\"", "");
    std::fs::write(&urdf, words).unwrap();
    let asked = [
        "gait",
        "steps",
        text(&robot),
        "--gait",
        "thesis",
        "--from-speed",
        "1",
        "--to",
        "1.2",
        "--assume",
        "velocity",
    ];
    bipedc(&asked)
        .fails_with(&["no joint of the robot has a limit of its velocity", "leave out --assume velocity"]);
}
