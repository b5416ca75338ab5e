//! Logs of a pendulum that is led along a smooth motion: friction that has faded long before the joint is as fast as it usually is, effects that `amend` is
//! asked for, sampling rates at twice a usual cut-off, wild readings.
use crate::cli::{bipedc, scratch, text};
use bipedc_effects::random::Random;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const URDF: &str = r#"<robot name="pendulum">
  <link name="stand"><inertial><mass value="5"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="rod"><inertial><origin xyz="0 0 -0.3"/><mass value="1.5"/><inertia ixx="0.01" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="swing" type="revolute"><parent link="stand"/><child link="rod"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="50" velocity="20"/></joint>
</robot>
"#;

const DESCRIPTION: &str = "[base]\nkind = \"fixed\"\nlink = \"stand\"\n";

/// The robot in a folder.
fn described(folder: &Path) -> PathBuf {
    let robot = folder.join("robot");
    std::fs::create_dir_all(&robot).unwrap();
    std::fs::write(robot.join("robot.urdf"), URDF).unwrap();
    std::fs::write(robot.join("biped.toml"), DESCRIPTION).unwrap();
    robot
}

/// Friction by velocity, N m.
fn curve(speed: f64) -> f64 {
    (0.4 + 0.3 * (-(speed / 0.1).powi(2)).exp()) * speed.signum()
}

/// A log of 16 s at 250 Hz; the torque is the pendulum's own (m l² + I) q̈ + m g l sin q with friction and noise.
fn log(folder: &Path, seed: u64) -> PathBuf {
    log_with(folder, seed, curve)
}

/// The same with other friction.
fn log_with(folder: &Path, seed: u64, friction: fn(f64) -> f64) -> PathBuf {
    let mut random = Random::new(seed);
    let shift = seed as f64;
    let sines = [(0.6, 1.9, 0.3 * shift), (0.35, 3.7, 1.0 + shift), (0.2, 5.9, 2.0 * shift)];
    let mut table = "time,swing/position,swing/effort\n".to_owned();
    for step in 0..4000 {
        let time = 0.004 * f64::from(step);
        let [mut q, mut v, mut a] = [0.0; 3];
        for (size, rate, phase) in sines {
            let (sine, cosine) = (rate * time + phase).sin_cos();
            (q, v, a) = (q + size * sine, v + size * rate * cosine, a - size * rate * rate * sine);
        }
        let torque =
            (1.5 * 0.09 + 0.02) * a + 1.5 * 9.81 * 0.3 * q.sin() + friction(v) + 0.03 * random.normal();
        writeln!(table, "{time:.3},{:.8},{torque:.6}", q + 1e-5 * random.normal()).unwrap();
    }
    let file = folder.join(format!("{seed}.csv"));
    std::fs::write(&file, table).unwrap();
    file
}

/// Before: dry friction of 0.4 N m, and "nothing else is missing" (with a curve that fades at 0.12 rad/s it was said that more is left near reversals).
#[test]
fn a_curve_that_fades_within_a_tenth_of_the_usual_speed_is_one() {
    let folder = scratch("early-fading");
    let robot = described(&folder);
    let logs = [1, 2].map(|seed| log(&folder, seed));
    let answer: Value =
        bipedc(&["diagnose", text(&robot), text(&logs[0]), "--validate", text(&logs[1]), "--json"])
            .ok()
            .json();
    let found = answer["effects"].as_array().unwrap();
    assert_eq!(found.len(), 1, "{}", answer["summary"]);
    assert_eq!(found[0]["kind"], "stribeck_friction", "{}", answer["summary"]);
    for (name, truth, within) in
        [("coulomb", 0.4, 0.02), ("static", 0.7, 0.03), ("stribeck_velocity", 0.1, 0.05)]
    {
        let value = found[0]["parameters"][name].as_f64().unwrap();
        assert!((value / truth - 1.0).abs() < within, "{name} {value} instead of {truth}");
        let [low, high] = [0, 1].map(|end| found[0]["ci95"][name][end].as_f64().unwrap());
        assert!(low < truth && truth < high, "{name}: {truth} is not between {low} and {high}");
    }
    assert_eq!(answer["unexplained"], false, "{}", answer["summary"]);
}

/// Before: given values were where the estimate began, and what raised the error was written.
#[test]
fn what_is_given_to_amend_is_held() {
    let folder = scratch("given-to-amend");
    let robot = described(&folder);
    let log = log(&folder, 3);
    let given = ["--effect", "stribeck_friction", "--joint", "swing", "--set", "static=0.65"];
    bipedc(&[&["amend", text(&robot), text(&log)], &given[..]].concat()).ok();
    let written = std::fs::read_to_string(robot.join("biped.toml")).unwrap();
    assert!(written.contains("static = 0.65  # N m"), "{written}");
    let coulomb = written.lines().find_map(|line| line.strip_prefix("coulomb = ")).unwrap();
    let coulomb: f64 = coulomb.split_whitespace().next().unwrap().parse().unwrap();
    assert!((coulomb - 0.4).abs() < 0.02, "{written}");
}

/// Before: the tool asked for more memory than there is. At half the sampling rate a filter rings for ever, and steps of 0.02 s are not 0.02 to the last digit.
#[test]
fn logs_at_twice_a_usual_cutoff_are_compared() {
    let folder = scratch("twice-a-cutoff");
    let robot = described(&folder);
    let table = std::fs::read_to_string(log(&folder, 4)).unwrap();
    // 50, 80, 125, 180 and 250 Hz: 25, 40, 62.5, 90 and 125 Hz are half of them.
    for rate in [50_u32, 80, 125, 180, 250] {
        let rows = table.lines().skip(1).enumerate().take(700).map(|(step, row)| {
            let time = step as f64 / f64::from(rate);
            format!("{time:.9},{}\n", row.split_once(',').unwrap().1)
        });
        let file = folder.join(format!("{rate}_hz.csv"));
        std::fs::write(&file, format!("time,swing/position,swing/effort\n{}", rows.collect::<String>()))
            .unwrap();
        let compared = bipedc(&["compare", text(&robot), text(&file), "--json"]).ok().json();
        assert!(compared["cutoff_hz"].as_f64().unwrap() < 0.49 * f64::from(rate), "{rate} Hz");
    }
}

/// Before: written with errors that rise, and no word.
#[test]
fn an_estimate_that_raises_the_error_is_not_written() {
    let folder = scratch("raised-by-amend");
    let robot = described(&folder);
    let (train, judge) = (log(&folder, 5), log_with(&folder, 6, |_| 0.0));
    let friction = ["--effect", "coulomb_friction", "--joint", "swing", "--validate", text(&judge)];
    bipedc(&[&["amend", text(&robot), text(&train)], &friction[..]].concat()).fails_with(&[
        "its held-out error of the effort rises from",
        "nothing was written",
        "--set",
    ]);
    assert_eq!(std::fs::read_to_string(robot.join("biped.toml")).unwrap(), DESCRIPTION);
    assert!(!robot.join("history.json").exists());
}

/// Before: not a word, and 25 kN m of error. A second wild reading 16 000 rows later is of the same joint: one warning is enough.
#[test]
fn single_wild_readings_are_told_once() {
    let folder = scratch("wild-readings");
    let robot = described(&folder);
    let table = std::fs::read_to_string(log(&folder, 7)).unwrap();
    let lines: Vec<&str> = table.lines().skip(1).collect();
    let rows = (0..40_000).map(|step| {
        let row: Vec<&str> = lines[step % lines.len()].split(',').collect();
        let effort = if [9000, 30_000].contains(&step) { "1e6" } else { row[2] };
        format!("{:.3},{},{effort}\n", 0.004 * step as f64, row[1])
    });
    let file = folder.join("wild.csv");
    std::fs::write(&file, format!("time,swing/position,swing/effort\n{}", rows.collect::<String>())).unwrap();
    let told = bipedc(&["compare", text(&robot), text(&file)]).ok().err;
    assert_eq!(told.matches("wild readings").count(), 1, "{told}");
    assert!(told.contains("`swing/effort` is 1000000 N m at 36 s"), "{told}");
}
