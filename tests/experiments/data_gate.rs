//! Wrong use of logs is named before anything is searched for in them, and true effects are left alone.
use crate::experiments::support::measured::{Subjects, example};
use bipedc_analysis::experiments::data_checks::inspect;
use bipedc_analysis::experiments::{Experiment, MotionExperiment};
use bipedc_analysis::log::Log;
use bipedc_analysis::measure::{Options, Recording};
use bipedc_effects::diagnostic::{Diagnostic, Severity};
use std::sync::OnceLock;
use tulip::Tulip;

/// Places of `left_knee_pitch`, `left_hip_pitch` and `left_hip_roll` in the order of the joints.
const KNEE: usize = 9;
const HIP: usize = 8;
const ROLL: usize = 7;

fn subjects() -> &'static Subjects {
    static SUBJECTS: OnceLock<Subjects> = OnceLock::new();
    SUBJECTS.get_or_init(|| Subjects::named("tulip"))
}

fn read(name: &str, file: &str) -> Recording {
    let options = Options { cutoff_hz: Some(16.0), ..Options::default() };
    let log = Log::open(example(name).join(file)).unwrap();
    let mut recording = Recording::read(&log, &subjects().layout, &options).unwrap();
    recording.thin(4000);
    recording
}

pub(super) fn coulomb() -> Recording {
    static LOG: OnceLock<Recording> = OnceLock::new();
    LOG.get_or_init(|| read("coulomb", "train.csv.gz")).clone()
}

pub(super) fn experiment(recording: Recording) -> MotionExperiment<'static> {
    let subjects = subjects();
    MotionExperiment::new(&Tulip, &subjects.layout, &subjects.link_inertias, recording, &[]).unwrap()
}

pub(super) fn judge(recording: Recording) -> Vec<Diagnostic> {
    let found = inspect(&experiment(recording), None).training;
    found.iter().for_each(|finding| println!("{finding}\n"));
    found
}

/// The only error has all these words.
fn assert_error(found: &[Diagnostic], words: &[&str]) {
    let errors: Vec<String> =
        found.iter().filter(|d| d.severity == Severity::Error).map(ToString::to_string).collect();
    assert_eq!(errors.len(), 1, "{errors:?}");
    for word in words {
        assert!(errors[0].contains(word), "no `{word}` in {}", errors[0]);
    }
}

fn assert_warning(found: &[Diagnostic], words: &[&str]) {
    let fits = |d: &&Diagnostic| words.iter().all(|word| d.message.contains(word));
    assert!(found.iter().any(|d| fits(&d)), "no warning with {words:?} in {found:?}");
}

/// Changes position, velocity and acceleration of joints, `[q, v, a]` by joint.
fn moved(recording: &mut Recording, mut change: impl FnMut(&mut [f64])) {
    let joints = subjects().layout.joints.len();
    let (samples, count) = (recording.samples(), joints);
    for values in [&mut recording.trajectory.q, &mut recording.trajectory.v, &mut recording.trajectory.a] {
        let width = values.len() / samples;
        values.chunks_exact_mut(width).for_each(|row| change(&mut row[width - count..]));
    }
}

#[test]
fn example_logs_pass() {
    for (name, repeats) in [("coulomb", true), ("null", true), ("rotor_inertia", true), ("backlash", false)] {
        let (train, other) = (read(name, "train.csv.gz"), read(name, "validation.csv.gz"));
        let (train, other) = (experiment(train), experiment(other));
        let found = inspect(&train, Some(&other));
        assert!(found.training.is_empty() && found.validation.is_empty(), "{name}: {found:?}");
        // Their motions are sums of sines with a common period of 10 s; of the last only a tenth comes again.
        let alone = inspect(&train, None).training;
        assert_eq!(alone.len(), usize::from(repeats), "{name}: {alone:?}");
        if repeats {
            assert_warning(&alone, &["the log repeats its motion every 10.0"]);
        }
    }
}

#[test]
fn a_flipped_torque_is_named() {
    let mut log = coulomb();
    log.effort[KNEE].as_mut().unwrap().iter_mut().for_each(|u| *u = -*u);
    let found = judge(log);
    assert_error(
        &found,
        &["`left_knee_pitch/effort` has the wrong sign", "\"left_knee_pitch/effort\" = { sign = -1 }"],
    );
}

#[test]
#[ignore = "takes long"]
fn torques_in_another_unit_are_named() {
    for (factor, words) in [(1e3, "mN m"), (1e-3, "kN m")] {
        let mut log = coulomb();
        log.effort[KNEE].as_mut().unwrap().iter_mut().for_each(|u| *u *= factor);
        log.noise[KNEE] *= factor;
        assert_error(&judge(log), &["`left_knee_pitch/effort`", "unit", words]);
    }
}

/// As in free swings, where gravity and inertia cancel: what is measured is next to nothing beside what the model expects, whatever its sign, and says nothing of
/// the sign or the unit; nor does a torque that has nothing to do with the model's, which in another unit friction alone would explain.
#[test]
fn torques_that_are_next_to_nothing_are_no_mix_up() {
    for factor in [-0.15, -0.05, 0.02] {
        let mut log = coulomb();
        log.effort[KNEE].as_mut().unwrap().iter_mut().for_each(|u| *u *= factor);
        log.noise[KNEE] *= factor.abs();
        let found = judge(log);
        assert!(found.iter().all(|d| d.severity != Severity::Error), "{factor}: {found:?}");
    }
    let mut log = coulomb();
    let times = log.time.clone();
    let effort = log.effort[KNEE].as_mut().unwrap();
    effort
        .iter_mut()
        .zip(times)
        .for_each(|(u, time)| *u = 0.08 * (2.3 * time).sin() + 0.05 * (7.9 * time).cos());
    log.noise[KNEE] = 1e-3;
    let found = judge(log);
    assert!(found.iter().all(|d| d.severity != Severity::Error), "{found:?}");
}

#[test]
fn positions_in_degrees_are_named() {
    let mut log = coulomb();
    moved(&mut log, |joints| joints[KNEE] = joints[KNEE].to_degrees());
    assert_error(&judge(log), &["`left_knee_pitch/position` is in degrees", "scale = 0.0174532925"]);
}

/// Angles of motors in front of gears are no degrees.
#[test]
fn a_motors_angle_is_no_angle_in_degrees() {
    for ratio in [12.0, 40.0, 100.0] {
        let mut log = coulomb();
        moved(&mut log, |joints| joints[KNEE] *= ratio);
        let found = judge(log);
        assert_error(
            &found,
            &["`left_knee_pitch/position` is about", "times too large, such as a motor's angle"],
        );
        let said = found
            .iter()
            .find_map(|d| d.message.split("about ").nth(1)?.split(' ').next()?.parse::<f64>().ok());
        assert!((said.unwrap() / ratio - 1.0).abs() < 0.05, "{said:?} for {ratio}");
    }
}

/// Position and torque of a motor: the torque alone looked like one that the model has nothing to do with, and masses were corrected by all of themselves.
#[test]
fn a_motors_angle_with_its_torque_is_named() {
    for ratio in [12.0, 50.0] {
        let mut log = coulomb();
        moved(&mut log, |joints| joints[KNEE] *= ratio);
        log.effort[KNEE].as_mut().unwrap().iter_mut().for_each(|u| *u /= ratio);
        log.noise[KNEE] /= ratio;
        let words = ["`left_knee_pitch/position` is about", "those of a motor", "\"left_knee_pitch/effort\""];
        assert_error(&judge(log), &words);
    }
}

#[test]
fn a_position_whose_counts_are_doubled_is_named() {
    for factor in [2.0, 4.0] {
        let mut log = coulomb();
        moved(&mut log, |joints| joints[KNEE] *= factor);
        let words = format!("is about {factor} times too large");
        let scale = format!("scale = {}", 1.0 / factor);
        assert_error(&judge(log), &["`left_knee_pitch/position`", &words, &scale]);
    }
}

#[test]
fn a_joint_that_counts_the_other_way_round_is_named() {
    let mut log = coulomb();
    moved(&mut log, |joints| joints[KNEE] = -joints[KNEE]);
    log.effort[KNEE].as_mut().unwrap().iter_mut().for_each(|u| *u = -*u);
    assert_error(&judge(log), &["`left_knee_pitch/position` and its effort count the other way round"]);
}

#[test]
fn an_angle_that_counts_from_elsewhere_is_named() {
    for (quarters, words) in
        [(1.0, "about 90 degrees off"), (-1.0, "about -90 degrees off"), (2.0, "about 180 degrees off")]
    {
        let mut log = coulomb();
        let width = log.trajectory.q.len() / log.samples();
        for row in log.trajectory.q.chunks_exact_mut(width) {
            row[width - 12 + KNEE] += quarters * std::f64::consts::FRAC_PI_2;
        }
        assert_error(&judge(log), &["`left_knee_pitch/position` counts from elsewhere", words, "offset = "]);
    }
}

#[test]
fn two_joints_that_are_swapped_are_named() {
    let mut log = coulomb();
    moved(&mut log, |joints| joints.swap(KNEE, HIP));
    log.effort.swap(KNEE, HIP);
    log.noise.swap(KNEE, HIP);
    let words =
        ["`left_hip_pitch/position`, `left_knee_pitch/position` are swapped", "`left_hip_pitch/effort`"];
    assert_error(&judge(log), &words);
}

/// A sign that all torques have wrong was called swapped columns.
#[test]
fn what_all_joints_have_wrong_is_named_once() {
    let mut log = coulomb();
    log.effort.iter_mut().flatten().flatten().for_each(|u| *u = -*u);
    assert_error(&judge(log), &["efforts of all joints have the wrong sign", "sign = -1"]);
    let mut log = coulomb();
    moved(&mut log, |joints| joints.iter_mut().for_each(|q| *q = q.to_degrees()));
    assert_error(&judge(log), &["positions of all joints are in degrees", "scale = 0.0174532925"]);
}

#[test]
fn efforts_that_never_change_are_named() {
    let mut log = coulomb();
    log.effort[KNEE].as_mut().unwrap().fill(0.0);
    assert_warning(&judge(log.clone()), &["never change", "left_knee_pitch/effort"]);
    log.effort.iter_mut().flatten().for_each(|effort| effort.fill(0.0));
    assert_error(&judge(log), &["no effort changes", "tells nothing of torques"]);
}

#[test]
fn a_flipped_position_is_named() {
    let mut log = coulomb();
    moved(&mut log, |joints| joints[KNEE] = -joints[KNEE]);
    assert_error(&judge(log), &["`left_knee_pitch/position` has the wrong sign"]);
}

#[test]
fn swapped_positions_are_named() {
    let mut log = coulomb();
    moved(&mut log, |joints| joints.swap(KNEE, HIP));
    assert_error(&judge(log), &["`left_hip_pitch/position`, `left_knee_pitch/position` are swapped"]);
}

#[test]
fn swapped_torques_are_named() {
    for (other, name) in [(HIP, "left_hip_pitch"), (ROLL, "left_hip_roll")] {
        let mut log = coulomb();
        log.effort.swap(KNEE, other);
        log.noise.swap(KNEE, other);
        assert_error(&judge(log), &[&format!("`{name}/effort`, `left_knee_pitch/effort` are swapped")]);
    }
}

#[test]
fn gains_and_strong_friction_are_no_mix_up() {
    for gain in [0.5, 2.0] {
        let mut log = coulomb();
        let samples = log.samples();
        let (width, offset) =
            (log.trajectory.v.len() / samples, log.trajectory.v.len() / samples - 12 + KNEE);
        let v: Vec<f64> = log.trajectory.v.iter().skip(offset).step_by(width).copied().collect();
        for (u, v) in log.effort[KNEE].as_mut().unwrap().iter_mut().zip(v) {
            *u = gain * *u + 3.0 * (v / 0.02).tanh();
        }
        let found = judge(log);
        assert!(found.iter().all(|d| d.message.contains("repeats its motion")), "{found:?}");
    }
}

#[test]
fn torques_of_another_robot_are_doubted() {
    let mut log = coulomb();
    // Every joint's torque from another time: the same joints, another motion.
    for effort in log.effort.iter_mut().flatten() {
        let count = effort.len();
        effort.rotate_left(count / 3);
    }
    assert_warning(&judge(log), &["little to do with the model's"]);
}

#[test]
fn joints_that_hardly_move_are_named() {
    let mut log = coulomb();
    moved(&mut log, |joints| joints[KNEE] *= 1e-3);
    assert_warning(&judge(log), &["joint `left_knee_pitch` hardly moves: friction cannot be told from bias"]);
}

#[test]
fn short_logs_are_doubted() {
    let options = Options { cutoff_hz: Some(16.0), to_s: Some(2.0), ..Options::default() };
    let file = Log::open(example("coulomb").join("train.csv.gz")).unwrap();
    let log = Recording::read(&file, &subjects().layout, &options).unwrap();
    assert_warning(&judge(log), &["only 1.", "s of motion"]);
}

#[test]
fn clipped_torques_are_named() {
    let mut log = coulomb();
    let effort = log.effort[KNEE].as_mut().unwrap();
    let limit = 0.6 * effort.iter().copied().fold(0.0, f64::max);
    effort.iter_mut().for_each(|u| *u = u.min(limit));
    assert_warning(&judge(log), &["the effort of `left_knee_pitch` is clipped at"]);
}

#[test]
fn a_stuck_encoder_is_named() {
    let mut log = coulomb();
    let samples = log.samples();
    let (from, to) = (samples / 3, samples / 2);
    for (values, still) in
        [(&mut log.trajectory.q, false), (&mut log.trajectory.v, true), (&mut log.trajectory.a, true)]
    {
        let width = values.len() / samples;
        let held = values[from * width + width - 12 + KNEE];
        for row in values.chunks_exact_mut(width).take(to).skip(from) {
            row[width - 12 + KNEE] = if still { 0.0 } else { held };
        }
    }
    assert_warning(&judge(log), &["the position of `left_knee_pitch` does not change at all"]);
}

/// Where joints move one at a time, all others rest by design; of encoders that are stuck one warning tells.
#[test]
fn joints_that_take_turns_are_not_stuck() {
    let mut turns = coulomb();
    let samples = turns.samples();
    let mut sample = 0;
    let joints = subjects().layout.joints.len();
    let still = |joint: usize, sample: usize| joint != sample % samples * joints / samples;
    moved(&mut turns, |row| {
        (0..joints).filter(|joint| still(*joint, sample)).for_each(|joint| row[joint] = 0.0);
        sample += 1;
    });
    let stuck = |found: &[Diagnostic]| {
        found
            .iter()
            .filter(|d| d.message.contains("not change at all"))
            .map(|d| d.message.clone())
            .collect::<Vec<_>>()
    };
    let found = stuck(&judge(turns));
    assert!(found.is_empty(), "{found:?}");
    let mut two = coulomb();
    let mut sample = 0;
    moved(&mut two, |row| {
        if (samples / 3..samples / 2).contains(&(sample % samples)) {
            (row[KNEE], row[HIP]) = (0.0, 0.0);
        }
        sample += 1;
    });
    let found = stuck(&judge(two));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("`left_knee_pitch` from") && found[0].contains("`left_hip_pitch` from"));
}

#[test]
fn a_log_in_which_nothing_moves_is_one_error() {
    let mut log = coulomb();
    moved(&mut log, |joints| joints.fill(0.0));
    let found = judge(log);
    assert_error(&found, &["no joint moves"]);
    assert!(!found.iter().any(|d| d.message.contains("effort") || d.message.contains("hardly")), "{found:?}");
}

#[test]
#[ignore = "takes long"]
fn the_same_motion_twice_is_named() {
    let log = coulomb();
    // The first half again after itself.
    let half = log.samples() / 2;
    let mut twice = log.clone();
    for values in [&mut twice.trajectory.q, &mut twice.trajectory.v, &mut twice.trajectory.a] {
        let width = values.len() / log.samples();
        values.copy_within(..half * width, half * width);
    }
    let period = log.time[half] - log.time[0];
    let found = judge(twice);
    assert_warning(&found, &["the log repeats its motion", &format!("every {period:.1}"), "optimistic"]);
    // And between logs: the second half of a log judges the whole.
    let mut trajectory = log.trajectory.clone();
    trajectory.retain(&(half..log.samples()).collect::<Vec<_>>());
    let second = Recording {
        time: log.time[half..].to_vec(),
        segments: std::iter::once(0..log.samples() - half).collect(),
        trajectory,
        effort: log.effort.iter().map(|e| e.as_ref().map(|e| e[half..].to_vec())).collect(),
        transmission: log.transmission.iter().map(|e| e.as_ref().map(|e| e[half..].to_vec())).collect(),
        ..log.clone()
    };
    let (train, other) = (experiment(log), experiment(second));
    let found = inspect(&train, Some(&other as &dyn Experiment)).training;
    assert_warning(&found, &["shows the motion of the training log again"]);
}

/// `cargo run --release --example hidden_effects -- --generate DIR`, then `HIDDEN_EFFECTS=DIR cargo test --release
/// --test data_gate -- --ignored --nocapture`.
#[test]
#[ignore = "needs the logs of the scoreboard"]
fn effects_of_the_library_are_no_mix_ups() {
    let folder = std::env::var_os("HIDDEN_EFFECTS").expect("HIDDEN_EFFECTS names a folder");
    let options = Options { cutoff_hz: Some(16.0), ..Options::default() };
    let (mut logs, mut errors) = (0, Vec::new());
    for case in std::fs::read_dir(folder).unwrap() {
        let case = case.unwrap().path();
        // Feet on the ground: `diagnose` reads these logs otherwise.
        if ["swaying", "standing"].iter().any(|word| case.to_string_lossy().contains(word)) {
            continue;
        }
        let truth = std::fs::read_to_string(case.join("truth.json")).unwrap_or_default();
        if !truth.contains("\"robot\": \"tulip\"") {
            continue;
        }
        let [train, other] = ["train.csv", "validation.csv"].map(|file| {
            let read = |log| Recording::read(&log, &subjects().layout, &options);
            Log::open(case.join(file)).and_then(read).ok().map(|mut recording| {
                recording.thin(10_000);
                experiment(recording)
            })
        });
        let (Some(train), Some(other)) = (train, other) else { continue };
        logs += 1;
        let found = inspect(&train, Some(&other as &dyn Experiment));
        for finding in found.training.iter().chain(&found.validation) {
            println!("{}: {}", case.display(), finding.message);
            if finding.severity == Severity::Error {
                errors.push(format!("{}: {}", case.display(), finding.message));
            }
        }
    }
    println!("{logs} cases with joint torques");
    assert!(logs > 20 && errors.is_empty(), "{errors:#?}");
}
