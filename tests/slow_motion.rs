//! Slow motions measured by ordinary encoders: behind a fast filter accelerations are noise, which makes torques through the masses, in every log alike.
use crate::cli::{bipedc, scratch, text};
use bipedc_effects::random::Random;
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const URDF: &str = r#"<robot name="two"><link name="bench"/>
<link name="upper"><inertial><origin xyz="0 0 -0.2"/><mass value="6"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.01"/></inertial></link>
<link name="lower"><inertial><origin xyz="0 0 -0.15"/><mass value="4"/><inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.005"/></inertial></link>
<joint name="hip" type="revolute"><parent link="bench"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="20"/></joint>
<joint name="knee" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 -0.4"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="20"/></joint></robot>"#;
const GRAVITY: f64 = 9.81;
/// Of both links: mass (kg), distance of its centre from the joint (m), inertia about it (kg m²); m between the joints.
const LINKS: [[f64; 3]; 2] = [[6.0, 0.2, 0.1], [4.0, 0.15, 0.05]];
const THIGH: f64 = 0.4;

/// Torques of the double pendulum.
fn torques([q1, q2]: [f64; 2], [v1, v2]: [f64; 2], [a1, a2]: [f64; 2]) -> [f64; 2] {
    let [[m1, l1, i1], [m2, l2, i2]] = LINKS;
    let own = i1 + m1 * l1 * l1 + i2 + m2 * (THIGH * THIGH + l2 * l2);
    let (between, shank) = (m2 * THIGH * l2, i2 + m2 * l2 * l2);
    let (sin, cos) = q2.sin_cos();
    let weights = [(m1 * l1 + m2 * THIGH) * GRAVITY * q1.sin(), m2 * l2 * GRAVITY * (q1 + q2).sin()];
    let both = shank + between * cos;
    [
        (own + 2.0 * between * cos) * a1 + both * a2 - between * sin * (2.0 * v1 * v2 + v2 * v2)
            + weights[0]
            + weights[1],
        both * a1 + shank * a2 + between * sin * v1 * v1 + weights[1],
    ]
}

/// Thirty seconds of two sines a joint at 100 Hz: encoders of 4096 counts, torques with 0.1 N m of noise, `friction` (N m) in the knee.
fn log(path: &Path, sines: [[[f64; 2]; 2]; 2], told: (u64, f64)) {
    write(path, sines.map(|of| of.to_vec()), told, 4096.0);
}

/// The same with any sines, and encoders of so many counts.
fn write(path: &Path, sines: [Vec<[f64; 2]>; 2], (seed, friction): (u64, f64), counts: f64) {
    let mut random = Random::new(seed);
    let mut csv = "time,hip/position,knee/position,hip/effort,knee/effort\n".to_owned();
    let count = TAU / counts;
    for sample in 0..3000 {
        let time = f64::from(sample) * 0.01;
        let motion = sines.each_ref().map(|of| {
            let sum = |order: i32| -> f64 {
                let sine = |(k, &[size, rate]): (usize, &[f64; 2])| {
                    let angle = rate * time + k as f64;
                    size * rate.powi(order)
                        * [angle.sin(), angle.cos(), -angle.sin()][usize::try_from(order).unwrap()]
                };
                of.iter().enumerate().map(sine).sum()
            };
            [sum(0), sum(1), sum(2)]
        });
        let [q, v, a] = [0, 1, 2].map(|order| motion.map(|of| of[order]));
        let [hip, knee] = torques(q, v, a);
        let knee = knee + friction * (v[1] / 0.01).tanh();
        let [hip, knee] = [hip, knee].map(|torque| torque + 0.1 * random.normal());
        let [q1, q2] = q.map(|q| (q / count).round() * count);
        writeln!(csv, "{time:.3},{q1:.9},{q2:.9},{hip:.9},{knee:.9}").unwrap();
    }
    std::fs::write(path, csv).unwrap();
}

/// Motions of two logs.
const SINES: [[[[f64; 2]; 2]; 2]; 2] = [
    [[[0.5, 0.5], [0.3, 0.83]], [[0.4, 0.61], [0.3, 0.91]]],
    [[[0.4, 0.55], [0.35, 0.77]], [[0.5, 0.47], [0.25, 0.87]]],
];

/// A folder with the robot, and the two logs.
fn logged(name: &str, friction: f64) -> (PathBuf, [PathBuf; 2]) {
    let folder = scratch(name);
    std::fs::write(folder.join("robot.urdf"), URDF).unwrap();
    std::fs::write(folder.join("biped.toml"), "[base]\nkind = \"fixed\"\n").unwrap();
    let logs = ["train.csv", "judge.csv"].map(|file| folder.join(file));
    for ((path, sines), seed) in logs.iter().zip(SINES).zip(1..) {
        log(path, sines, (seed, friction));
    }
    (folder, logs)
}

fn diagnosed(name: &str, friction: f64) -> Value {
    let (folder, [train, judge]) = logged(name, friction);
    bipedc(&["diagnose", text(&folder), text(&train), "--validate", text(&judge), "--json"]).ok().json()
}

/// A search behind 10 Hz, at which it began whatever the motion, found couplings of the joints with inertias of −0.3 kg m².
#[test]
fn noise_of_encoders_is_no_inertia() {
    let answer = diagnosed("slow_clean", 0.0);
    assert_eq!(answer["effects"].as_array().unwrap().len(), 0, "{}", answer["summary"]);
    assert_eq!(answer["inertial_corrections"].as_array().unwrap().len(), 0, "{}", answer["summary"]);
    assert_eq!(answer["unexplained"], false, "{}", answer["summary"]);
    assert!(answer["cutoff_hz"].as_f64().unwrap() < 10.0, "{}", answer["cutoff_hz"]);
}

#[test]
fn friction_of_a_slow_motion_is_found_alone() {
    let answer = diagnosed("slow_friction", 0.5);
    let [found] = &answer["effects"].as_array().unwrap()[..] else { panic!("{}", answer["summary"]) };
    assert_eq!((&found["kind"], &found["joint"]), (&"coulomb_friction".into(), &"knee".into()));
    let torque = found["parameters"]["torque"].as_f64().unwrap();
    assert!((torque / 0.5 - 1.0).abs() < 0.03, "{torque}");
    assert_eq!(answer["unexplained"], false, "{}", answer["summary"]);
}

/// Behind 10 Hz, with rows that passed no filter of their own, the inertias of all of these logs came out negative, with intervals of a few
/// per cent: 63 of 96 intervals held the truth.
#[test]
fn masses_and_friction_lie_in_their_intervals() {
    let (mut inside, mut all) = (0, 0);
    for friction in [0.0, 0.5] {
        let (folder, logs) = logged(&format!("slow_identified_{friction}"), friction);
        for log in &logs {
            let answer = bipedc(&["identify", text(&folder), text(log), "--json"]).ok().json();
            assert!(answer["rows_hz"].as_f64().unwrap() < 4.0, "{}", answer["rows_hz"]);
            assert_eq!(answer["unseen"].as_array().unwrap().len(), 0, "{}", answer["unseen"]);
            for parameter in answer["parameters"].as_array().unwrap() {
                let name = parameter["name"].as_str().unwrap();
                let dry = if name == "knee.coulomb_friction" { friction } else { 0.0 };
                let truth = parameter["nominal"].as_f64().unwrap() + dry;
                let [low, high] = [0, 1].map(|end: usize| parameter["interval"][end].as_f64().unwrap());
                inside += usize::from((low..=high).contains(&truth));
                all += 1;
                let off = parameter["value"].as_f64().unwrap() - truth;
                assert!(!name.contains("Iyy") || off.abs() < 0.25 * truth, "{name}: {off} of {truth}");
            }
        }
    }
    println!("{inside} of {all} intervals hold the truth");
    assert!(all == 48 && inside >= 44, "{inside} of {all}");
}

/// Where nothing takes the noise off, inertias have no numbers, and it is said why.
#[test]
fn what_noise_hides_has_no_number() {
    let (folder, [log, _]) = logged("slow_hidden", 0.0);
    let behind = ["--cutoff", "10", "--row-cutoff", "100", "--json"];
    let answer = bipedc(&[["identify", text(&folder), text(&log)].as_slice(), &behind].concat()).ok().json();
    let unseen = answer["unseen"].to_string();
    assert!(unseen.contains("upper.Iyy") && unseen.contains("lower.Iyy"), "{unseen}");
    let warnings = answer["warnings"].to_string();
    assert!(warnings.contains("too slow for its encoders") && warnings.contains("upper.Iyy"), "{warnings}");
}

/// Filters are chosen from logs that are long enough to tell which.
#[test]
fn a_log_of_seconds_is_read_behind_the_usual_filter() {
    let (folder, [log, _]) = logged("slow_short", 0.0);
    let cutoff = |more: &[&str]| {
        let words = [&["identify", text(&folder), text(&log), "--json"], more].concat();
        bipedc(&words).ok().json()["logs"][0]["cutoff_hz"].as_f64().unwrap()
    };
    assert_eq!(cutoff(&["--to", "4"]), 10.0);
    assert_ne!(cutoff(&[]), 10.0);
}

/// A hundredth of a radian at 2.6 Hz, which a filter of 4 Hz takes a thirtieth off: before, a rotor of 0.03 kg m² and a correction.
#[test]
fn quick_motion_that_is_taken_off_within_the_noise_is_no_inertia() {
    let (folder, [train, judge]) = logged("slow_and_quick", 0.0);
    for ((path, sines), (seed, quick)) in
        [&train, &judge].into_iter().zip(SINES).zip([(1, [16.0, 17.5]), (2, [17.0, 16.3])])
    {
        let with = |joint: usize| [sines[joint].as_slice(), &[[0.01, quick[joint]]]].concat();
        write(path, [with(0), with(1)], (seed, 0.0), 16384.0);
    }
    let asked = ["diagnose", text(&folder), text(&train), "--validate", text(&judge), "--json"];
    let answer = bipedc(&asked).ok().json();
    for key in ["effects", "inertial_corrections", "suspects"] {
        assert_eq!(answer[key].as_array().map(Vec::len), Some(0), "{key}: {}", answer["summary"]);
    }
    assert!(answer["cutoff_hz"].as_f64().unwrap() > 4.0, "{}", answer["cutoff_hz"]);
}
