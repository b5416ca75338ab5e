//! `bipedc compare --free-run`, and efforts from motor currents: exact motions are predicted exactly, friction that is
//! missing shows and goes, and wrong use is told by name.
use crate::cli;
mod currents;
mod leg;

use cli::{Run, bipedc, scratch, text};
use leg::{JOINTS, Torques, log, motion, robot};
use serde_json::Value;
use std::path::Path;

const COULOMB: &str = "tests/data/examples/coulomb/validation.csv.gz";

fn free_run(robot: &Path, log: &Path, more: &[&str]) -> Run {
    bipedc(&[&["compare", text(robot), text(log), "--json", "--free-run"], more].concat())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The motion is a formula and its efforts are from inverse dynamics: nothing was integrated to make the log.
#[test]
fn an_exact_motion_is_predicted() {
    let folder = robot("free_run_exact", |description| description);
    let file = folder.join("log.csv");
    let torques = Torques::new(&folder, "inverse_dynamics");
    log(&file, &[("position", &|j, t| motion(j, t)[0]), ("effort", &|j, t| torques.at(t, &[0.0; 6])[j])]);
    let value = free_run(&folder, &file, &["0.5", "--cutoff", "90"]).ok().json();
    let run = &value["free_run"];
    println!("an exact motion is missed by {} rad", run["rms"]);
    assert!(number(&run["rms"]) < 1e-6, "{run}");
    // 2 s are left of 3 s, and neighbouring windows share a sample.
    assert_eq!((&run["windows"], &run["diverged"], &run["capped"]), (&4.into(), &0.into(), &0.into()));
    assert_eq!((&run["window"], &run["unit"]), (&0.5.into(), &"rad".into()));
    let channels = run["channels"].as_array().unwrap();
    assert_eq!(channels.len(), 6);
    for (channel, joint) in channels.iter().zip(JOINTS) {
        assert_eq!((&channel["name"], &channel["unit"]), (&joint.into(), &"rad".into()));
        assert!(number(&channel["rms_end"]) < 1e-5 && number(&channel["relative"]) < 1e-5, "{channel}");
    }
    // A tenth of a second is predicted far better than a whole one.
    let of = |window| {
        number(&free_run(&folder, &file, &[window, "--cutoff", "90"]).ok().json()["free_run"]["rms"])
    };
    assert!(of("0.1") < of("1"), "{} {}", of("0.1"), of("1"));
}

/// Every effect between the reported torque and the link, in the compiled model or on the way to it.
#[test]
fn effects_of_the_description_act() {
    let effects = [
        ("torque_gain", 0, "gain = 1.2"),
        ("torque_bias", 1, "bias = 0.4"),
        ("actuator_delay", 2, "delay = 0.013"),
        ("encoder_offset", 3, "offset = 0.05"),
        ("rotor_inertia", 4, "inertia = 0.02"),
        ("viscous_friction", 4, "damping = 0.3"),
        ("coulomb_friction", 2, "torque = 0.2"),
    ];
    let more: String = effects
        .iter()
        .map(|(kind, joint, value)| {
            format!("\n[[effect]]\nkind = \"{kind}\"\njoint = \"{}\"\n{value}\n", JOINTS[*joint])
        })
        .collect();
    let folder = robot("free_run_effects", |description| description + &more);
    let nominal = robot("free_run_nominal", |description| description);
    let file = folder.join("log.csv");
    let torques = Torques::new(&folder, "inverse_dynamics");
    let offset = [0.0, 0.0, 0.0, 0.05, 0.0, 0.0];
    let late = [0.0, 0.0, 0.013, 0.0, 0.0, 0.0];
    log(
        &file,
        &[
            ("position", &|j, t| motion(j, t)[0] + offset[j]),
            ("effort", &|j, t| torques.at(t + late[j], &offset)[j]),
        ],
    );
    let of = |folder: &Path| free_run(folder, &file, &["0.5", "--cutoff", "90"]).ok().json();
    let (with, without) = (of(&folder), of(&nominal));
    let rms = |value: &Value| number(&value["free_run"]["rms"]);
    println!("with the effects {} rad, without {} rad", rms(&with), rms(&without));
    assert!(rms(&with) < 1e-6 && rms(&without) > 1e-2, "{} {}", rms(&with), rms(&without));
}

/// An example by another simulator: 0.4 N m of friction in one knee.
#[test]
#[ignore = "takes long"]
fn missing_friction_shows_and_goes() {
    let folder = scratch("free_run_coulomb");
    for file in ["robot.urdf", "biped.toml"] {
        std::fs::copy(Path::new("robots/tulip").join(file), folder.join(file)).unwrap();
    }
    let of = || free_run(&folder, Path::new(COULOMB), &["0.5"]).ok().json()["free_run"].clone();
    let knee = |run: &Value| {
        let channels = run["channels"].as_array().unwrap();
        let knee = channels.iter().find(|c| c["name"] == "left_knee_pitch").unwrap().clone();
        ["rms", "rms_end", "relative"].map(|key| number(&knee[key]))
    };
    let before = of();
    let friction = ["--effect", "coulomb_friction", "--joint", "left_knee_pitch", "--set", "torque=0.4"];
    bipedc(&[&["amend", text(&folder)], &friction[..]].concat()).ok();
    let after = of();
    println!("knee without friction {:?}, with it {:?}", knee(&before), knee(&after));
    println!("all joints without {} rad, with {} rad", before["rms"], after["rms"]);
    assert_eq!(before["windows"], 18);
    assert!(knee(&after)[0] < 0.05 * knee(&before)[0]);
    assert!(number(&after["rms"]) < 0.2 * number(&before["rms"]));
}

#[test]
fn windows_that_run_away_are_counted_and_left_out() {
    let folder = scratch("free_run_away");
    let mapping = folder.join("mapping.toml");
    std::fs::write(&mapping, "\"left_knee_pitch/effort\" = { scale = 1000 }\n").unwrap();
    let words = ["0.5", "--from", "3", "--to", "4.1", "--mapping", text(&mapping)];
    let run = free_run(Path::new("robots/tulip"), Path::new(COULOMB), &words).ok().json()["free_run"].clone();
    assert_eq!((&run["windows"], &run["diverged"], &run["rms"]), (&2.into(), &2.into(), &Value::Null));
    assert_eq!(run["channels"][0]["rms"], Value::Null);
}

#[test]
fn steps_of_stiff_models_are_limited() {
    let more = "\n[[effect]]\nkind = \"coulomb_friction\"\njoint = \"right_ankle_roll\"\ntorque = 2.0\nsmoothing = 1e-6\n";
    let folder = robot("free_run_stiff", |description| description + more);
    let file = folder.join("log.csv");
    let torques = Torques::new(&robot("free_run_soft", |d| d), "inverse_dynamics");
    log(&file, &[("position", &|j, t| motion(j, t)[0]), ("effort", &|j, t| torques.at(t, &[0.0; 6])[j])]);
    let run =
        free_run(&folder, &file, &["0.5", "--from", "1", "--to", "1.6"]).ok().json()["free_run"].clone();
    assert_eq!((&run["windows"], &run["capped"], &run["diverged"]), (&1.into(), &1.into(), &0.into()));
}

#[test]
fn the_table_has_units() {
    let run =
        bipedc(&["compare", "robots/tulip", COULOMB, "--cutoff", "16", "--free-run", "1", "--to", "3"]).ok();
    for words in ["free run", " rad", "2 windows of 1 s", "0 diverged", "assumed: free run"] {
        assert!(run.out.contains(words), "no `{words}` in {}", run.out);
    }
}

#[test]
fn wrong_use_is_told() {
    let tulip = Path::new("robots/tulip");
    let example = |name: &str| format!("tests/data/examples/{name}/validation.csv.gz");
    let of = |log: &str, more: &[&str]| free_run(tulip, Path::new(log), more);
    of(&example("swaying"), &["0.5"]).fails_with(&["the base moves", "--base fixed", "validation.csv.gz"]);
    of(&example("postures"), &["0.5"]).fails_with(&["`posture`", "`time`"]);
    of(&example("impacts"), &["0.5"]).fails_with(&["`impact`", "`time`"]);
    of(COULOMB, &["0.039"]).fails_with(&["shorter than 10 samples", "at least 0.0400 s"]);
    of(COULOMB, &["-1"]).fails_with(&["shorter than 10 samples"]);
    of(COULOMB, &["nan"]).fails_with(&["shorter than 10 samples"]);
    of(COULOMB, &["20"]).fails_with(&["does not fit", "lasts 9.0", "shorter window"]);
    let folder = scratch("free_run_wrong");
    let file = folder.join("log.csv");
    let mut log =
        String::from("time,right_hip_pitch/position,right_hip_pitch/effort,left_hip_pitch/position\n");
    (0..900)
        .for_each(|i| log += &format!("{:.3},{},0,0\n", 0.004 * f64::from(i), (0.01 * f64::from(i)).sin()));
    std::fs::write(&file, log).unwrap();
    free_run(Path::new("robots/three_link"), &file, &["0.5"]).fails_with(&[
        "`left_hip_pitch/effort`",
        "every joint",
        "log.csv",
    ]);
}
