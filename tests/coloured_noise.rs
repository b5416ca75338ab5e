//! Logs whose noise is correlated in time: it is neither an effect nor something unexplained, and hides neither.
use crate::cli::{bipedc, scratch, text};
use bipedc_effects::random::Random;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

const URDF: &str = r#"<robot name="arm"><link name="bench"/><link name="arm"><inertial><origin xyz="0 0 -0.07"/>
<mass value="0.13"/><inertia ixx="2.87e-4" ixy="0" ixz="0" iyy="2.87e-4" iyz="0" izz="2e-5"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="bench"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="10" velocity="20"/></joint></robot>"#;
/// Mass times distance of its centre (kg m), and inertia about the axis (kg m²).
const MOMENT: f64 = 0.13 * 0.07;
const INERTIA: f64 = 2.87e-4 + 0.13 * 0.07 * 0.07;
/// Sampling, s.
const STEP: f64 = 0.004;

/// Noise of the first order: its standard deviation (N m) and the correlation of neighbouring samples.
type Noise = (f64, f64);

/// Samples of a log.
const SAMPLES: usize = 6000;

fn first_order((size, rho): Noise, seed: u64) -> Vec<f64> {
    let mut random = Random::new(seed);
    let mut noise = random.normal();
    let mut next = || {
        noise = rho * noise + (1.0 - rho * rho).sqrt() * random.normal();
        size * noise
    };
    (0..SAMPLES).map(|_| next()).collect()
}

/// White noise behind two low-passes of the first order with this cut-off (Hz), and white noise of a third of it.
fn behind_low_passes(size: f64, cutoff: f64, seed: u64) -> Vec<f64> {
    let kept = (-std::f64::consts::TAU * cutoff * STEP).exp();
    let mut states = [0.0; 2];
    let white = first_order((1.0, 0.0), seed);
    let passed = white.iter().map(|x| {
        states.iter_mut().fold(*x, |input, state| {
            *state = kept * *state + (1.0 - kept) * input;
            *state
        })
    });
    let passed: Vec<f64> = passed.collect();
    let of = |values: &[f64]| (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt();
    let more = first_order((1.0 / 3.0, 0.0), seed + 100);
    let both: Vec<f64> = passed.iter().zip(&more).map(|(x, w)| x / of(&passed) + w).collect();
    both.iter().map(|x| size / of(&both) * x).collect()
}

/// Noise of a tenth of its later size in the first half.
fn louder_later(size: f64, seed: u64) -> Vec<f64> {
    let later = |(i, x): (usize, f64)| if i < SAMPLES / 2 { 0.1 * x } else { x };
    let all: Vec<f64> = first_order((1.0, 0.0), seed).into_iter().enumerate().map(later).collect();
    all.iter().map(|x| size / (0.5_f64 * 1.01).sqrt() * x).collect()
}

/// Torque beyond the rigid arm's, of position and velocity, sample after sample.
type Hidden<'h> = &'h mut dyn FnMut(f64, f64) -> f64;

/// Twenty-four seconds of two sines at 250 Hz.
fn log(path: &Path, rates: [f64; 2], noise: &[f64], hidden: Hidden<'_>) {
    let mut csv = "time,shoulder/position,shoulder/effort\n".to_owned();
    for (sample, noise) in noise.iter().enumerate() {
        let time = sample as f64 * STEP;
        let [q, v, a] = [0.6, 0.4].into_iter().zip(rates).fold([0.0; 3], |[q, v, a], (size, rate)| {
            let (sin, cos) = (rate * time).sin_cos();
            [q + size * sin, v + size * rate * cos, a - size * rate * rate * sin]
        });
        let torque = INERTIA * a + 9.81 * MOMENT * q.sin() + hidden(q, v) + noise;
        writeln!(csv, "{time:.3},{q:.9},{torque:.9}").unwrap();
    }
    std::fs::write(path, csv).unwrap();
}

/// What is said of two logs of the arm; and its row's entry.
fn diagnosed(name: &str, noise: Noise, hidden: impl Fn() -> Box<dyn FnMut(f64, f64) -> f64>) -> Value {
    diagnosed_with(name, [1, 2].map(|seed| first_order(noise, seed)), hidden)
}

/// The same with the noise of each log.
fn diagnosed_with(
    name: &str,
    noise: [Vec<f64>; 2],
    hidden: impl Fn() -> Box<dyn FnMut(f64, f64) -> f64>,
) -> Value {
    let folder = scratch(name);
    std::fs::write(folder.join("robot.urdf"), URDF).unwrap();
    std::fs::write(folder.join("biped.toml"), "[base]\nkind = \"fixed\"\n").unwrap();
    let [train, judge] = ["train.csv", "judge.csv"].map(|file| folder.join(file));
    log(&train, [2.9, 5.3], &noise[0], &mut *hidden());
    log(&judge, [2.3, 6.7], &noise[1], &mut *hidden());
    bipedc(&["diagnose", text(&folder), text(&train), "--validate", text(&judge), "--json"]).ok().json()
}

fn row(answer: &Value, key: &str) -> f64 {
    answer["rows"]["shoulder"][key].as_f64().unwrap()
}

/// The noise was taken as white: 0.54 of its size with a correlation of 0.6, 0.25 with 0.9, and the joint was called unexplained.
#[test]
fn of_a_faultless_joint_nothing_is_left() {
    for (rho, size) in [(0.4, 0.004), (0.6, 0.1), (0.9, 0.004)] {
        let answer = diagnosed("coloured_clean", (size, rho), || Box::new(|_, _| 0.0));
        let noise = row(&answer, "noise") / size;
        assert!((noise - 1.0).abs() < 0.15, "{rho}: {noise} of the noise");
        assert_eq!(answer["effects"].as_array().unwrap().len(), 0, "{rho}: {}", answer["summary"]);
        assert_eq!((&answer["unexplained"], &answer["suspects"]), (&false.into(), &Value::Array(Vec::new())));
        let said = answer["summary"].as_str().unwrap();
        assert!(said.starts_with("Nothing is missing in effort"), "{rho}: {said}");
    }
}

#[test]
fn friction_is_found_and_nothing_else_is_left() {
    let dry = || -> Box<dyn FnMut(f64, f64) -> f64> { Box::new(|_, v: f64| 0.012 * (v / 0.02).tanh()) };
    for rho in [0.6, 0.9] {
        let answer = diagnosed("coloured_friction", (0.004, rho), dry);
        let [found] = &answer["effects"].as_array().unwrap()[..] else { panic!("{}", answer["summary"]) };
        assert_eq!(found["kind"], "coulomb_friction");
        let torque = found["parameters"]["torque"].as_f64().unwrap();
        assert!((torque / 0.012 - 1.0).abs() < 0.06, "{rho}: {torque}");
        assert_eq!(answer["unexplained"], false, "{rho}: {}", answer["summary"]);
        assert!(answer["summary"].as_str().unwrap().ends_with("Nothing else is missing in effort."));
    }
}

/// Noise behind a drive's low-pass, and noise of one half of a log, came out as 0.1 to 0.5 of themselves, and the joint was called unexplained.
#[test]
fn filtered_noise_and_noise_that_changes_are_noise() {
    let noises = [
        ("10 Hz", [1, 2].map(|seed| behind_low_passes(0.01, 10.0, seed))),
        ("25 Hz", [1, 2].map(|seed| behind_low_passes(0.01, 25.0, seed))),
        ("in the second half", [1, 2].map(|seed| louder_later(0.01, seed))),
    ];
    let dry = || -> Box<dyn FnMut(f64, f64) -> f64> { Box::new(|_, v: f64| 0.02 * (v / 0.02).tanh()) };
    for (what, noise) in noises {
        let clean = diagnosed_with("filtered_clean", noise.clone(), || Box::new(|_, _| 0.0));
        let told = row(&clean, "noise") / 0.01;
        assert!((told - 1.0).abs() < 0.2, "{what}: {told} of the noise");
        assert_eq!(clean["effects"].as_array().unwrap().len(), 0, "{what}: {}", clean["summary"]);
        assert_eq!(clean["unexplained"], false, "{what}: {}", clean["summary"]);
        // What hides in it is found all the same.
        let answer = diagnosed_with("filtered_friction", noise, dry);
        let [found] = &answer["effects"].as_array().unwrap()[..] else {
            panic!("{what}: {}", answer["summary"])
        };
        assert_eq!(found["kind"], "coulomb_friction", "{what}");
        assert_eq!(answer["unexplained"], false, "{what}: {}", answer["summary"]);
    }
}

/// Thirty standard errors of its mean; squares rise by a fifth, which passed for noise.
#[test]
fn a_bias_of_less_than_half_the_noise_is_found() {
    let answer = diagnosed("white_bias", (0.02, 0.0), || Box::new(|_, _| 0.009));
    let [found] = &answer["effects"].as_array().unwrap()[..] else { panic!("{}", answer["summary"]) };
    assert_eq!(found["kind"], "torque_bias", "{}", answer["summary"]);
    let bias = found["parameters"]["bias"].as_f64().unwrap();
    assert!((bias / 0.009 - 1.0).abs() < 0.15, "{bias}");
}

/// Friction that follows the way since the last reversal (Dahl's), which no effect of the library is.
#[test]
fn hysteresis_stays_unexplained() {
    let dahl = || -> Box<dyn FnMut(f64, f64) -> f64> {
        let mut bent = 0.0_f64;
        Box::new(move |_, v| {
            bent += STEP * (v - v.abs() * bent / 0.15);
            0.04 * bent / 0.15
        })
    };
    for rho in [0.0, 0.6, 0.9] {
        let answer = diagnosed("coloured_hysteresis", (0.004, rho), dahl);
        assert_eq!(answer["unexplained"], true, "{rho}: {}", answer["summary"]);
        assert_eq!(answer["suspects"][0], "shoulder");
        // An offset of the centre of mass that was found and given up again "stands already" no more.
        let reasons = answer["rejected"].as_array().unwrap().iter().map(|rejected| &rejected["why"]);
        assert!(reasons.into_iter().all(|why| why != "it stands already"), "{rho}: {}", answer["rejected"]);
        let noise = row(&answer, "noise") / 0.004;
        assert!((0.6..1.3).contains(&noise), "{rho}: {noise} of the noise");
    }
}

/// Seconds of small motions beside a posture that the arm has to be held in; noise is six times as large in the second half.
fn held(path: &Path, rates: [f64; 2], seed: u64) {
    let mut random = Random::new(seed);
    let mut csv = "time,shoulder/position,shoulder/effort\n".to_owned();
    for sample in 0..6000 {
        let time = f64::from(sample) * STEP;
        let [q, a] = [0.09, 0.06].into_iter().zip(rates).fold([1.2, 0.0], |[q, a], (size, rate)| {
            let sin = (rate * time).sin();
            [q + size * sin, a - size * rate * rate * sin]
        });
        let size = if sample < 3000 { 0.004 } else { 0.024 };
        let torque = INERTIA * a + 9.81 * MOMENT * q.sin() + size * random.normal();
        writeln!(csv, "{time:.3},{q:.9},{torque:.9}").unwrap();
    }
    std::fs::write(path, csv).unwrap();
}

/// The largest readings are those with the most noise: cut off, the error is smaller, and a limit was found with no doubt beside it.
#[test]
fn noise_that_grows_is_no_limit() {
    let folder = scratch("grown_noise");
    std::fs::write(folder.join("robot.urdf"), URDF).unwrap();
    std::fs::write(folder.join("biped.toml"), "[base]\nkind = \"fixed\"\n").unwrap();
    let [train, judge] = ["train.csv", "judge.csv"].map(|file| folder.join(file));
    held(&train, [2.9, 5.3], 1);
    held(&judge, [2.3, 6.7], 2);
    let answer =
        bipedc(&["diagnose", text(&folder), text(&train), "--validate", text(&judge), "--json"]).ok().json();
    assert_eq!(answer["effects"].as_array().unwrap().len(), 0, "{}", answer["summary"]);
}
