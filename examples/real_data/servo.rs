//! A hobby servo that swings a pendulum: friction that grows with the load.
use crate::run::{Failure, Part, Program, failure, robot, text};
use crate::table::write;
use bipedc_analysis::signal::{Butterworth, Grid, resample};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Constants of the servo that came with the logs (BAM, XL330, model M1 of `reference_fork_m1.json`): torque per current
/// (N m/A) and winding (ohm), both at the joint.
const TORQUE_CONSTANT: f64 = 0.323_211_39;
const RESISTANCE: f64 = 4.763_650_15;
/// PWM word at full duty.
const FULL: f64 = 885.0;
/// What belongs to the voltage model and is not known from elsewhere: the rotor's inertia (kg m²), damping by the back-EMF
/// (N m s/rad) and the torque per voltage; estimated again, beside what is found.
const MOTOR: &str = r#"[base]
kind = "fixed"

[[effect]]
kind = "rotor_inertia"
joint = "joint"
inertia = 0.0016

[[effect]]
kind = "viscous_friction"
joint = "joint"
damping = 0.01

[[effect]]
kind = "torque_gain"
joint = "joint"
gain = 1.0
"#;
/// Samples are put on a grid of this step, s; the velocity behind the back-EMF is filtered so, Hz.
const STEP: f64 = 0.005;
const BACK_EMF_HZ: f64 = 15.0;
/// Between logs that follow each other, s.
const PAUSE: f64 = 2.0;

/// The pendulum, and nothing of the servo.
pub const URDF: &str = r#"<robot name="pendulum"><link name="bench"/><link name="arm"><inertial><origin xyz="0 0 -0.1"/>
<mass value="0.49"/><inertia ixx="1e-6" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/></inertial></link>
<joint name="joint" type="revolute"><parent link="bench"/><child link="arm"/><axis xyz="0 -1 0"/>
<limit lower="-10" upper="10" effort="2" velocity="20"/></joint></robot>"#;

const WORDS: &str = "\
Hobby servo with a pendulum of 0.49 kg at 0.10 m (source: Rhoban/bam, Apache-2.0). There is no torque sensor: the effort is
the voltage model's, kt/R u - kt²/R qd, with the constants that came with the logs (kt = 0.3232 N m/A, R = 4.7637 ohm), u =
duty times supply voltage, and the duty from the logged PWM word (885 is full duty). Samples without motor torque are left
out. Trained on the trajectories sin_sin and up_and_down at three gains, judged on sin_time_square and lift_and_drop; the
rig's mass and length were weighed and measured, so inertias stay. Rotor inertia, damping and the torque per voltage stand in
the description and are estimated again: the constants of model M1 were fitted together with friction that does not depend
on the load, and have absorbed what does.

Known, in the position error of 6 s of free-running prediction on four logs kept aside: 62.8 mrad with Coulomb and viscous
friction, 61.2 to 62.7 with Stribeck friction, 47.0 with friction that grows with the load.";

/// Asks what is missing.
///
/// # Errors
/// Files that cannot be read or written; a refusal of the program.
pub fn run(data: &Path, folder: &Path, program: &Program) -> Result<Vec<Part>, Failure> {
    let pendulum = robot(folder, URDF, MOTOR)?;
    let (train, test) = (folder.join("train.csv"), folder.join("test.csv"));
    write_logs(data, [&train, &test])?;
    let named = [(&*pendulum, "xl330"), (&*train, "train.csv"), (&*test, "test.csv")];
    let options = ["--cutoff", "10", "--inertial", "none", "--refit"];
    let (command, answer) = program.diagnose(&named, &options)?;
    let measured = program.measure(&named, &options, &answer)?;
    Ok(vec![Part {
        title: "XL330 servo with a pendulum",
        words: WORDS.to_owned(),
        command,
        answer,
        measured,
    }])
}

/// Writes the log that teaches and the one that judges.
///
/// # Errors
/// Files that cannot be read or written.
pub fn write_logs(data: &Path, [train, test]: [&Path; 2]) -> Result<(), Failure> {
    let logs = logs(&data.join("bam_xl330"))?;
    join(&logs, &["sin_sin", "up_and_down"], train)?;
    join(&logs, &["sin_time_square", "lift_and_drop"], test)
}

/// The raw logs in the order of their names.
fn logs(data: &Path) -> Result<Vec<Value>, Failure> {
    let entries = std::fs::read_dir(data).map_err(|e| failure(format!("{}: {e}", data.display())))?;
    let raw = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        name.starts_with("20") && name.ends_with(".json")
    };
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(raw).collect();
    files.sort();
    let parse = |file: &PathBuf| {
        serde_json::from_str(&text(file)?).map_err(|e| failure(format!("{}: {e}", file.display())))
    };
    files.iter().map(parse).collect()
}

/// Writes the logs of some trajectories one after the other, with pauses, so that gaps are seen as such.
fn join(logs: &[Value], trajectories: &[&str], file: &Path) -> Result<(), Failure> {
    let mut all: [Vec<f64>; 3] = Default::default();
    for log in
        logs.iter().filter(|log| trajectories.contains(&log["trajectory"].as_str().unwrap_or_default()))
    {
        let start = all[0].last().map_or(0.0, |last| last + PAUSE);
        for sample in samples(log)? {
            all[0].push(start + sample[0]);
            all[1].push(sample[1]);
            all[2].push(sample[2]);
        }
    }
    let names = ["time", "joint/position", "joint/effort"].map(str::to_owned);
    let columns: Vec<(String, &[f64])> = names.into_iter().zip(all.iter().map(Vec::as_slice)).collect();
    write(file, &columns)
}

/// Time (s), position (rad) and torque (N m) of one log while the motor is on.
fn samples(log: &Value) -> Result<Vec<[f64; 3]>, Failure> {
    let entries = log["entries"].as_array().map(Vec::as_slice).unwrap_or_default();
    let column = |of: &dyn Fn(&Value) -> Option<f64>| -> Result<Vec<f64>, Failure> {
        entries.iter().map(of).collect::<Option<_>>().ok_or_else(|| failure("a servo log lacks a number"))
    };
    let time = column(&|e| e["timestamp"].as_f64())?;
    let position = column(&|e| e["position"].as_f64())?;
    let voltage = column(&|e| {
        let word = e["load"].as_f64()?;
        // Sixteen bits with a sign.
        let signed = if word > 32767.0 { word - 65536.0 } else { word };
        Some(signed / FULL * e["input_volts"].as_f64()?)
    })?;
    let powered = column(&|e| Some(if e["torque_enable"].as_bool()? { 1.0 } else { 0.0 }))?;
    let (Some(first), Some(last)) = (time.first(), time.last()) else { return Ok(Vec::new()) };
    let grid = Grid::covering(*first, STEP, *first, *last);
    let even = |values: &[f64]| resample(&time, values, grid);
    let (position, voltage, powered) = (even(&position), even(&voltage), even(&powered));
    let filter = Butterworth::new(BACK_EMF_HZ, 1.0 / STEP).map_err(|e| failure(format!("{e:?}")))?;
    let smooth = filter.zero_phase(&position);
    let inner = 1..smooth.len().saturating_sub(1);
    let sample = |i: usize| {
        let velocity = (smooth[i + 1] - smooth[i - 1]) / (2.0 * STEP);
        let current = (voltage[i] - TORQUE_CONSTANT * velocity) / RESISTANCE;
        [i as f64 * STEP, position[i], TORQUE_CONSTANT * current]
    };
    Ok(inner.filter(|&i| powered[i] > 0.99).map(sample).collect())
}
