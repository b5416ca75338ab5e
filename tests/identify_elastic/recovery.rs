//! Truth that is known is found again.
use crate::identify_elastic::cli::{scratch, text};
use crate::identify_elastic::leg::{Leg, Noise, Recorded, Sensors, example, identify, parameter};
use serde_json::Value;
use std::path::Path;

const ELASTIC: [&str; 3] = ["right_hip_pitch", "right_knee_pitch", "right_ankle_pitch"];
const STIFF: [&str; 2] = ["right_hip_yaw", "right_hip_roll"];

fn leg() -> Leg {
    Leg::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/tulip_v1_leg"))
}

/// Joints and parameters that have a true value.
fn known() -> Vec<(&'static str, &'static str)> {
    let of = |joints: &[&'static str], names: &[&'static str]| -> Vec<(&'static str, &'static str)> {
        joints.iter().flat_map(|j| names.iter().map(|n| (*j, *n))).collect()
    };
    let friction = ["viscous_friction", "coulomb_friction"];
    [of(&ELASTIC, &["spring_stiffness", "joint_stiffness"]), of(&ELASTIC, &friction), of(&STIFF, &friction)]
        .concat()
}

/// Largest relative error of the drives, and of the base parameters by the largest of their unit.
fn worst(answer: &Value, leg: &Leg) -> [f64; 2] {
    let drives = known().into_iter().map(|(joint, name)| {
        let found = parameter(answer, joint, name)["value"].as_f64().unwrap();
        (found / leg.truth(joint, name) - 1.0).abs()
    });
    let parameters = answer["parameters"].as_array().unwrap();
    let inertial = parameters.iter().filter(|p| p["unit"].as_str().unwrap().starts_with("kg"));
    let bodies = inertial.clone().map(|p| {
        let largest = inertial
            .clone()
            .filter(|other| other["unit"] == p["unit"])
            .map(|other| other["nominal"].as_f64().unwrap().abs())
            .fold(0.0, f64::max);
        (p["value"].as_f64().unwrap() - p["nominal"].as_f64().unwrap()).abs() / largest
    });
    [drives.fold(0.0, f64::max), bodies.fold(0.0, f64::max)]
}

/// Without noise nothing but differentiation is left: a motion below 0.5 Hz, 1 kHz, filtered at 120 Hz.
#[test]
#[ignore = "takes long"]
fn a_log_without_noise_gives_back_drives_and_bodies() {
    let folder = scratch("elastic_identity");
    let mut noise = Noise(5);
    let leg = leg().with(&mut || 0.8 + 0.45 * noise.even());
    let log = folder.join("log.csv");
    let recorded = Recorded { seconds: 12.0, rate: 1000.0, seed: 3, slowest: 0.1, fastest: 0.5 };
    leg.record(&log, recorded, Sensors::default());
    for more in [&["--steps", "two"][..], &["--steps", "one"], &["--estimator", "instrumental"]] {
        let options = [&["--cutoff", "120", "--slow", "0"], more].concat();
        let answer = identify("robots/tulip_v1_leg", &log, &options).ok().json();
        let [drives, bodies] = worst(&answer, &leg);
        println!("{more:?}: drives {drives:.1e}, bodies {bodies:.1e}");
        assert!(drives < 1e-7, "{drives:e}");
        assert!(bodies < 1e-7, "{bodies:e}");
    }
}

/// Random gears, pulleys, rotors and springs; the motor may turn the other way.
#[test]
#[ignore = "takes long"]
fn any_drive_is_found_again() {
    let mut noise = Noise(11);
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/tulip_v1_leg");
    let settings = std::fs::read_to_string(project.join("biped.toml")).unwrap();
    for case in 0..2 {
        let folder = scratch(&format!("elastic_random_{case}"));
        std::fs::copy(project.join("robot.urdf"), folder.join("robot.urdf")).unwrap();
        let mut text_of_drives = String::new();
        for line in settings.lines() {
            let key = line.split_once(" = ").map_or("", |(key, _)| key);
            let line = match key {
                "gear_ratio" => format!(
                    "gear_ratio = {}",
                    (30.0 + 120.0 * noise.even()) * if noise.even() < 0.4 { -1.0 } else { 1.0 }
                ),
                "motor_pulley_radius" | "load_pulley_radius" => {
                    format!("{key} = {}", 0.015 + 0.03 * noise.even())
                }
                "spring_stiffness" => format!("{key} = {}", 4e4 + 8e4 * noise.even()),
                "rotor_inertia" => format!("{key} = {}", 1e-6 + 5e-6 * noise.even()),
                "torque_constant" => format!("{key} = {}", 0.01 + 0.05 * noise.even()),
                _ => line.to_owned(),
            };
            text_of_drives += &(line + "\n");
        }
        std::fs::write(folder.join("biped.toml"), text_of_drives).unwrap();
        let leg = Leg::read(&folder).with(&mut || 0.8 + 0.45 * noise.even());
        let log = folder.join("log.csv");
        let recorded = Recorded { seconds: 8.0, rate: 500.0, seed: 70 + case, slowest: 0.2, fastest: 0.8 };
        leg.record(&log, recorded, Sensors::default());
        let answer = identify(text(&folder), &log, &["--cutoff", "80", "--slow", "0"]).ok().json();
        let [drives, bodies] = worst(&answer, &leg);
        println!("case {case}: drives {drives:.1e}, bodies {bodies:.1e}");
        assert!(drives < 1e-5 && bodies < 1e-5, "case {case}: {drives:e} {bodies:e}");
    }
}

/// The experiment of another simulator: real encoders, noise, stiction, friction and springs off by up to 25 %.
#[test]
fn the_simulated_experiment_is_explained() {
    let truth: Value =
        serde_json::from_str(&std::fs::read_to_string(example("truth.json")).unwrap()).unwrap();
    for steps in ["two", "one"] {
        let more = ["--steps", steps, "--validate", text(&example("validation.csv.gz"))].map(str::to_owned);
        let more: Vec<&str> = more.iter().map(String::as_str).collect();
        let answer = identify("robots/tulip_v1_leg", &example("train.csv.gz"), &more).ok().json();
        for effect in truth["effects"].as_array().unwrap() {
            let joint = effect["joint"].as_str().unwrap();
            for (name, value) in effect["parameters"].as_object().unwrap() {
                let found = parameter(&answer, joint, name);
                let number = |key: &str| found[key].as_f64().unwrap();
                let away = number("value") / value.as_f64().unwrap() - 1.0;
                let bound = if name == "spring_stiffness" { 0.01 } else { 0.05 };
                println!(
                    "{steps} {joint} {name}: {:+.2} %, ± {:.2} %",
                    100.0 * away,
                    number("relative_error_percent")
                );
                assert!(away.abs() < bound, "{joint} {name}: {away}");
                assert!(number("standard_error") > 0.0 && number("relative_error_percent") < 5.0);
            }
        }
        let total = &answer["validation"]["total"];
        let [described, fitted] = ["description", "least_squares"].map(|key| total[key].as_f64().unwrap());
        println!(
            "{steps}: held-out motion missed {:.2} %, by the description {:.2} %",
            100.0 * fitted,
            100.0 * described
        );
        assert!(fitted < 0.01 && fitted < 0.2 * described);
        for joint in ELASTIC {
            let drives = answer["drives"]["joints"].as_array().unwrap();
            let errors = &drives.iter().find(|d| d["joint"] == joint).unwrap()["validation"];
            let [measured, estimated] = ["measured", "estimated"].map(|key| errors[key].as_f64().unwrap());
            assert!(estimated < 0.02 * measured, "{joint}: {errors}");
        }
    }
}
