//! `bipedc export --mjcf`: MuJoCo reads it, and computes what we do (`oracle/mjcf.py` made the numbers).
use crate::cli::{self, scratch, text};
use crate::support::{Inputs, assert_close, evaluate, numbers, project};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_runtime::Argument;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

fn case(robot: &str) -> Value {
    let path = project().join("tests/data/mjcf").join(robot).with_extension("json");
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// A copy of a robot, with effects, in a folder of this name.
fn folder(name: &str, robot: &str, effects: &str) -> PathBuf {
    let folder = scratch(name);
    for file in ["robot.urdf", "biped.toml"] {
        fs::copy(project().join("robots").join(robot).join(file), folder.join(file)).unwrap();
    }
    let described = fs::read_to_string(folder.join("biped.toml")).unwrap() + effects;
    fs::write(folder.join("biped.toml"), described).unwrap();
    folder
}

#[test]
fn mujoco_has_our_masses_and_forces() {
    for name in ["tulip", "tulip_v1_leg", "seven_link", "five_link"] {
        let case = case(name);
        let robot =
            Robot::read(&folder(&format!("mjcf_{name}"), name, case["effects"].as_str().unwrap())).unwrap();
        let exported = ::bipedc::export::mjcf(&robot).unwrap();
        assert_eq!(exported.left_out, [], "{name}");
        // The numbers are of this text and no other.
        assert!(case["mjcf"] == exported.mjcf.as_str(), "{name}: run tests/oracle/mjcf.py again");
        let requests = ["mass_matrix", "bias"].map(FunctionRequest::of_robot);
        let model = ProgramModel::new(robot.compile_only(&requests).unwrap());
        let joints: Vec<&str> =
            model.compiled().tree.joints.iter().map(|joint| joint.name.as_str()).collect();
        let theirs: Vec<&str> =
            case["joints"].as_array().unwrap().iter().map(|j| j.as_str().unwrap()).collect();
        assert!(theirs.ends_with(&joints), "{theirs:?}");
        for state in case["states"].as_array().unwrap() {
            let inputs = Inputs::default()
                .with(Argument::Q, numbers(&state["q"]))
                .with(Argument::V, numbers(&state["v"]));
            for function in ["mass_matrix", "bias"] {
                let ours = evaluate(&model, function, &inputs);
                assert_close(&format!("{name}: {function}"), &ours, &numbers(&state[function]), 1e-11);
            }
        }
    }
}

#[test]
fn the_command_writes_it_and_says_what_is_missing() {
    let folder = folder(
        "mjcf_command",
        "five_link",
        "\n[[effect]]\nkind = \"torque_gain\"\njoint = \"left_knee_pitch\"\ngain = 0.9\n",
    );
    let file = folder.join("five_link.xml");
    let run = cli::bipedc(&["export", text(&folder), "--mjcf", text(&file)]).ok();
    assert!(run.err.contains("MJCF has no words for: Gain of the torque signal"), "{}", run.err);
    let written = fs::read_to_string(&file).unwrap();
    let document = roxmltree::Document::parse(&written).unwrap();
    let named = |tag: &str| document.descendants().filter(|node| node.has_tag_name(tag)).count();
    assert_eq!((named("body"), named("joint"), named("motor"), named("geom")), (5, 7, 4, 3));
    let nothing = cli::bipedc(&["export", text(&folder)]);
    assert!(nothing.err.contains("--urdf") && nothing.err.contains("required"), "{}", nothing.err);
    cli::bipedc(&["export", text(&folder), "--mjcf", text(&folder.join("robot.urdf"))])
        .fails_with(&["would overwrite", "the robot's URDF"]);
}

#[test]
fn bases_away_from_the_root_are_refused() {
    let folder = folder("mjcf_base", "seven_link", "");
    let described = fs::read_to_string(folder.join("biped.toml")).unwrap();
    let start = described.find("[base]").unwrap();
    let end = described[start + 1..].find("\n[").map_or(described.len(), |at| start + 1 + at);
    let pivot = "[base]\nkind = \"pivot\"\nabout = \"right_foot/toe\"\n";
    fs::write(folder.join("biped.toml"), described.replace(&described[start..end], pivot)).unwrap();
    let out = folder.join("out.xml");
    cli::bipedc(&["export", text(&folder), "--mjcf", text(&out)])
        .fails_with(&["the base turns about `right_foot/toe`", "`floating`, `planar` or `fixed`"]);
    assert!(!out.exists());
}
