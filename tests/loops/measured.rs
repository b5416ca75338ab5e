//! The loop on an example by another simulator: compare, amend, compare again, look back, take back; through the
//! command line, on a copy of a robot.
use crate::loops::cli::{bipedc, scratch, text};
use crate::loops::support::measured::{Subjects, example};
use bipedc_analysis::experiments::{Experiment, MotionExperiment};
use bipedc_analysis::log::Log;
use bipedc_analysis::measure::{Options, Recording};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_runtime::{Argument, Model, State};
use serde_json::Value;
use std::path::{Path, PathBuf};

const JOINT: &str = "left_knee_pitch";
const TRAIN: &str = "tests/data/examples/coulomb/train.csv.gz";
const JUDGE: &str = "tests/data/examples/coulomb/validation.csv.gz";

/// A copy of a robot that may be amended.
fn robot(name: &str) -> PathBuf {
    let folder = scratch(name);
    for file in ["robot.urdf", "biped.toml"] {
        std::fs::copy(Path::new("robots/tulip").join(file), folder.join(file)).unwrap();
    }
    folder
}

fn error(folder: &Path) -> f64 {
    bipedc(&["compare", text(folder), JUDGE, "--json"]).ok().json()["rms"].as_f64().unwrap()
}

fn oracle() -> f64 {
    let truth = std::fs::read_to_string(example("coulomb").join("truth.json")).unwrap();
    serde_json::from_str::<Value>(&truth).unwrap()["oracle"]["rms"].as_f64().unwrap()
}

/// Inverse dynamics of a folder's robot, compiled.
fn compiled(folder: &Path, effects: bool) -> ProgramModel {
    let robot = Robot::read(folder).unwrap();
    let robot = if effects { robot } else { robot.without_effects() };
    let request = FunctionRequest::of_robot("inverse_dynamics");
    ProgramModel::new(robot.compile_only(&[request]).unwrap())
}

fn torques(model: &ProgramModel, q: &[f64], v: &[f64], a: &[f64]) -> [f64; 18] {
    let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::A, a);
    let mut tau = [0.0; 18];
    model.evaluate(0, &state, &mut tau).unwrap();
    tau
}

/// What the description's effects add to the torques at one state in motion.
fn added(folder: &Path, v: &[f64; 18]) -> Vec<f64> {
    let mut q = [0.0; 19];
    q[6] = 1.0;
    (0..12).for_each(|j| q[7 + j] = 0.3 * (1.7 * j as f64).sin());
    let a: [f64; 18] = std::array::from_fn(|i| (0.9 * i as f64).cos());
    let (with, without) =
        (torques(&compiled(folder, true), &q, v, &a), torques(&compiled(folder, false), &q, v, &a));
    with.iter().zip(without).map(|(with, without)| with - without).collect()
}

/// Row of the joint in `v`.
fn row(folder: &Path) -> usize {
    let tree = Robot::read(folder).unwrap().tree().unwrap();
    6 + tree.joints.iter().position(|joint| joint.name == JOINT).unwrap()
}

/// The parameter of the only effect in a description.
fn parameter(folder: &Path, name: &str) -> f64 {
    Robot::read(folder).unwrap().description.effects[0].value(name)
}

#[test]
#[ignore = "takes long"]
fn friction_is_seen_added_compensated_and_taken_back() {
    let folder = robot("loop_coulomb");
    let original = std::fs::read_to_string(folder.join("biped.toml")).unwrap();
    let before = error(&folder);

    let seen = bipedc(&["compare", text(&folder), JUDGE, "--where", "--json"]).ok().json();
    let places = seen["where"].as_array().unwrap();
    assert_eq!(places.len(), 12);
    for place in places {
        let strongest = &place["signature"][0];
        if place["name"] == JOINT {
            assert_eq!(strongest["name"], "sign of velocity");
            assert!(strongest["correlation"].as_f64().unwrap() > 0.95, "{strongest}");
            assert_eq!(place["windows"].as_array().unwrap().len(), 8);
        } else {
            assert!(strongest.is_null(), "{place}");
        }
    }

    let words = ["amend", text(&folder), "--effect", "coulomb_friction", "--joint", JOINT];
    bipedc(&[&words[..], &[TRAIN, "--validate", JUDGE]].concat()).ok();
    let after = error(&folder);
    println!("held-out rms {before} -> {after} N m; with the true effect {} N m", oracle());
    assert!(after < 0.5 * before && after <= 1.1 * oracle(), "{before} {after}");
    assert!((parameter(&folder, "torque") / 0.4 - 1.0).abs() < 0.05);

    let history = bipedc(&["history", text(&folder), "--json"]).ok().json();
    let stair = &history["stairs"][0];
    assert_eq!(history["stairs"].as_array().unwrap().len(), 1);
    let (high, low) = (stair["before"].as_f64().unwrap(), stair["after"].as_f64().unwrap());
    assert!(
        (high / before - 1.0).abs() < 0.05 && (low / after - 1.0).abs() < 0.05,
        "{stair} {before} {after}"
    );

    the_law_is_in_the_code(&folder);

    bipedc(&["amend", text(&folder), "--undo"]).ok();
    assert_eq!(std::fs::read_to_string(folder.join("biped.toml")).unwrap(), original);
    assert_eq!(error(&folder), before);
}

/// A wrong number in the description is estimated again, written back, and taken back.
#[test]
#[ignore = "takes long"]
fn refitted_effects_are_written_back() {
    let folder = robot("loop_refit");
    let wrong = ["amend", text(&folder), "--effect", "coulomb_friction", "--joint", JOINT];
    bipedc(&[&wrong[..], &["--set", "torque=0.1"]].concat()).ok();
    let original = std::fs::read_to_string(folder.join("biped.toml")).unwrap();
    let before = error(&folder);

    let answer = bipedc(&["diagnose", text(&folder), TRAIN, "--validate", JUDGE, "--refit", "--json"]).ok();
    let file = folder.join("diagnosis.json");
    std::fs::write(&file, &answer.out).unwrap();
    let said = answer.json()["summary"].as_str().unwrap().to_owned();
    assert!(said.contains("of the description, estimated again: torque 0.1000 → 0.4"), "{said}");
    let fall = answer.json()["rms"]["effort"].clone();
    let [was, is] = ["before", "after"].map(|key| fall[key].as_f64().unwrap());
    assert!((was / before - 1.0).abs() < 1e-3, "as described {was}, compared {before}");
    assert!(is < 0.5 * was && !said.contains(&format!("error of {was:.4}")), "{said}");
    let standing = answer.json()["standing"][0].clone();
    let (torque, interval) = (&standing["parameters"]["torque"], &standing["ci95"]["torque"]);
    assert!((torque.as_f64().unwrap() / 0.4 - 1.0).abs() < 0.05, "{standing}");
    assert!(interval[0].as_f64() < torque.as_f64() && torque.as_f64() < interval[1].as_f64(), "{standing}");

    bipedc(&["amend", text(&folder), "--from", text(&file)]).ok();
    assert_eq!(standing["parameters"]["torque"].as_f64(), Some(parameter(&folder, "torque")));
    assert!(error(&folder) < 0.5 * before && error(&folder) <= 1.1 * oracle());
    bipedc(&["amend", text(&folder), "--undo"]).ok();
    assert_eq!(std::fs::read_to_string(folder.join("biped.toml")).unwrap(), original);
}

/// Inverse dynamics differs by the law, in this joint alone; `generate` writes that program.
fn the_law_is_in_the_code(folder: &Path) {
    let row = row(folder);
    let (torque, smoothing) = (parameter(folder, "torque"), parameter(folder, "smoothing"));
    for velocity in [1.3, -0.4, 0.01] {
        let mut v: [f64; 18] = std::array::from_fn(|i| (0.7 * i as f64).sin());
        v[row] = velocity;
        for (i, added) in added(folder, &v).iter().enumerate() {
            let law = if i == row { torque * (velocity / smoothing).tanh() } else { 0.0 };
            assert!((added - law).abs() < 1e-12, "{i}: {added} {law}");
        }
    }
    let out = folder.join("generated");
    bipedc(&["generate", text(folder), "--out", text(&out)]).ok();
    assert!(
        everything(&out).contains("Contains the effects: Coulomb friction at left_knee_pitch"),
        "the code says what it contains"
    );
    bipedc(&["generate", text(folder), "--out", text(&out), "--check"]).ok();
}

/// All Rust files of a folder.
fn everything(folder: &Path) -> String {
    let mut out = String::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            out += &everything(&path);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out += &std::fs::read_to_string(path).unwrap();
        }
    }
    out
}

#[test]
#[ignore = "takes long"]
fn a_users_formula_goes_the_whole_way() {
    let folder = robot("loop_formula");
    let original = std::fs::read_to_string(folder.join("biped.toml")).unwrap();
    let before = error(&folder);
    let words = ["amend", text(&folder), "--formula", "k * velocity / sqrt(velocity * velocity + 0.0004)"];
    let more = ["--name", "rounded", "--joint", JOINT, "--param", "k=0.1,unit=N m,min=0,max=5"];
    let run = bipedc(&[&words[..], &more, &[TRAIN, "--validate", JUDGE, "--json"]].concat()).ok();
    let step = run.json();
    let ci = &step["changes"][0]["ci95"]["k"];
    let (low, high) = (ci[0].as_f64().unwrap(), ci[1].as_f64().unwrap());
    let k = parameter(&folder, "k");
    println!("k = {k} N m (95 %: {low} to {high})");
    assert!((k / 0.4 - 1.0).abs() < 0.08 && low < k && k < high && high - low < 0.1 * k);
    let after = error(&folder);
    println!("held-out rms {before} -> {after} N m");
    assert!(after < 0.5 * before && after < 1.1 * oracle());

    let row = row(&folder);
    let mut v = [0.2; 18];
    v[row] = 0.03;
    let law = k * 0.03 / (0.03_f64 * 0.03 + 0.0004).sqrt();
    assert!((added(&folder, &v)[row] - law).abs() < 1e-12);

    let page = folder.join("report.html");
    bipedc(&["compare", text(&folder), JUDGE, "--report", text(&page)]).ok();
    assert!(std::fs::read_to_string(&page).unwrap().contains("rounded"), "the history of the page names it");
    bipedc(&["amend", text(&folder), "--undo"]).ok();
    assert_eq!(std::fs::read_to_string(folder.join("biped.toml")).unwrap(), original);
}

/// The compiled model and the experiment that applies effects to whole logs say the same.
#[test]
fn compiled_and_applied_effects_agree() {
    let folder = robot("loop_agree");
    for (kind, place, set) in [
        ("coulomb_friction", ["--joint", JOINT], "torque=0.4"),
        ("load_dependent_friction", ["--joint", JOINT], "coefficient=0.05"),
        ("rotor_inertia", ["--joint", "right_hip_pitch"], "inertia=0.02"),
        ("torque_gain", ["--joint", "right_hip_pitch"], "gain=1.1"),
        ("torque_bias", ["--joint", "right_hip_roll"], "bias=0.3"),
        ("payload", ["--link", "left_lower_leg"], "mass=0.3,x=0.01,y=0.02,z=-0.1"),
    ] {
        bipedc(&[&["amend", text(&folder), "--effect", kind, "--set", set], &place[..]].concat()).ok();
    }
    let robot = Robot::read(&folder).unwrap();
    let rigid = robot.clone().without_effects();
    let requests = ["inverse_dynamics", "inverse_dynamics_regressor"].map(FunctionRequest::of_robot);
    let model = ProgramModel::new(rigid.compile_only(&requests).unwrap());
    let subjects = Subjects::of(&rigid);
    let options = Options { cutoff_hz: Some(16.0), ..Options::default() };
    let recording = Recording::read(&Log::open(JUDGE).unwrap(), &subjects.layout, &options).unwrap();
    let (q, v, a) =
        (recording.trajectory.q.clone(), recording.trajectory.v.clone(), recording.trajectory.a.clone());
    let effects = &robot.description.effects;
    let experiment =
        MotionExperiment::new(&model, &subjects.layout, &subjects.link_inertias, recording, effects).unwrap();
    let count = experiment.time().len();
    let with = compiled(&folder, true);
    let predicted: Vec<[f64; 18]> = (0..count)
        .map(|i| torques(&with, &q[19 * i..][..19], &v[18 * i..][..18], &a[18 * i..][..18]))
        .collect();
    let mut worst = 0.0_f64;
    for (index, _) in experiment.rows().iter().enumerate() {
        let measured = experiment.measured(index).unwrap();
        for (i, (measured, residual)) in measured.iter().zip(experiment.residual(index)).enumerate() {
            worst = worst.max((measured - residual - predicted[i][6 + index]).abs());
        }
    }
    println!("largest difference {worst:e} N m");
    assert!(worst < 1e-9, "{worst}");
}
