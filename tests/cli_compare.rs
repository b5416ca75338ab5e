//! `bipedc compare`: the example logs against what is known of them.
use crate::cli;

use cli::{Run, bipedc, piped, scratch, text};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

const LOG: &str = "tests/data/examples/null/validation.csv.gz";

/// Show 7 on one example; the library's own tests do the others.
#[test]
fn errors_are_those_of_an_ideal_model() {
    let truth = std::fs::read_to_string("tests/data/examples/null/truth.json").unwrap();
    let nominal = serde_json::from_str::<Value>(&truth).unwrap()["nominal"].clone();
    let value = bipedc(&["compare", "robots/tulip", LOG, "--cutoff", "10,16", "--json"]).ok().json();
    let near = |found: &Value, expected: &Value| {
        let ratio = found.as_f64().unwrap() / expected.as_f64().unwrap();
        assert!((ratio - 1.0).abs() < 0.05, "{found} {expected}");
    };
    near(&value["rms"], &nominal["rms"]);
    assert_eq!(value["cutoff_hz"], nominal["cutoff_hz"]);
    let channels = value["channels"].as_array().unwrap();
    assert_eq!(channels.len(), 12);
    for channel in channels {
        near(&channel["rms"], &nominal["rms_by_joint"][channel["name"].as_str().unwrap()]);
        assert_eq!(channel["unit"], "N m");
        assert!(channel["max"].is_f64() && channel["relative"].is_f64() && channel["samples"].is_u64());
    }
}

#[test]
fn the_table_says_what_was_done() {
    let run = bipedc(&["compare", "robots/tulip", LOG, "--cutoff", "16", "--from", "2", "--to", "3"]).ok();
    for words in [
        "right_knee_pitch",
        "N m",
        "cut-off 16 Hz",
        "251 from 2.000 s to 3.000 s",
        "0.5 s left out",
        "assumed:",
    ] {
        assert!(run.out.contains(words), "no `{words}` in {}", run.out);
    }
}

/// Joints that the description holds have no place in the model: their columns are no riddle.
#[test]
fn columns_of_locked_joints_are_passed_over() {
    let folder = scratch("compare_locked");
    std::fs::copy("robots/tulip/robot.urdf", folder.join("robot.urdf")).unwrap();
    let toml = std::fs::read_to_string("robots/tulip/biped.toml").unwrap();
    let locked = "\n[joints]\nlocked = [\"left_ankle_roll\", \"right_ankle_roll\"]\n";
    std::fs::write(folder.join("biped.toml"), toml + locked).unwrap();
    let run = bipedc(&["compare", text(&folder), LOG, "--cutoff", "16"]).ok();
    assert!(!run.err.contains("ankle_roll"), "{}", run.err);
    let run = bipedc(&["log", LOG, "--robot", text(&folder)]).ok();
    assert!(run.out.contains("`left_ankle_roll` does not move in the description"), "{}", run.out);
}

/// Motors' angles beside those of their joints are a row of their own.
#[test]
fn play_shows_in_a_row_of_the_transmission() {
    let log = "tests/data/examples/backlash/validation.csv.gz";
    let value = bipedc(&["compare", "robots/tulip", log, "--cutoff", "16", "--json"]).ok().json();
    let channels = value["channels"].as_array().unwrap();
    let row = channels.iter().find(|channel| channel["kind"] == "transmission").unwrap();
    assert_eq!(
        (row["name"].as_str(), row["unit"].as_str()),
        (Some("left_hip_roll/motor_position"), Some("rad"))
    );
    assert!(value["kinds"]["transmission"]["rms"].as_f64().unwrap() > 0.005, "{value}");
    assert_eq!(value["unit"], "N m");
}

/// A log of one joint of the three-link walker, 100 rows; times are multiplied, and one effort is replaced.
fn three_link_log(name: &str, per_second: f64, effort: &str) -> std::path::PathBuf {
    let file = scratch(name).join("log.csv");
    let joints = ["left_hip_pitch", "right_hip_pitch"];
    let head = joints.map(|joint| format!(",{joint}/position,{joint}/effort")).concat();
    let row = |i: i32| {
        let (time, angle) = (0.02 * f64::from(i) * per_second, (0.3 * f64::from(i)).sin());
        let effort = if i == 50 { effort } else { "0.1" };
        format!("{time},{angle},{effort},{angle},0.2\n")
    };
    std::fs::write(&file, format!("time{head}\n{}", (0..100).map(row).collect::<String>())).unwrap();
    file
}

/// Most robots measure the motor: its angle stands for the joint's where that was not logged, and the answer says so.
#[test]
fn the_motors_side_stands_for_the_joints() {
    let log = three_link_log("compare_motor_side", 1.0, "0.1");
    let joints = std::fs::read_to_string(&log).unwrap();
    let motors = log.with_file_name("motors.csv");
    std::fs::write(&motors, joints.replace("left_hip_pitch/position", "left_hip_pitch/motor_position"))
        .unwrap();
    let compare = |log: &Path| {
        bipedc(&["compare", "robots/three_link", "--base", "fixed", text(log), "--json"]).ok().json()
    };
    let (by_joints, by_motors) = (compare(&log), compare(&motors));
    // A mapping says the same of a log whose `position` is the motor's.
    let mapping = log.with_file_name("motors.toml");
    std::fs::write(&mapping, "\"left_hip_pitch/motor_position\" = \"left_hip_pitch/position\"\n").unwrap();
    let mapped = [
        "compare",
        "robots/three_link",
        "--base",
        "fixed",
        text(&log),
        "--mapping",
        text(&mapping),
        "--json",
    ];
    assert_eq!(bipedc(&mapped).ok().json()["assumptions"], by_motors["assumptions"]);
    assert_eq!(by_motors["channels"], by_joints["channels"]);
    let assumed = |answer: &Value| {
        let lines = answer["assumptions"].as_array().unwrap();
        lines.iter().any(|line| line.as_str().unwrap().contains("`motor_position` for `left_hip_pitch`:"))
    };
    assert!(assumed(&by_motors) && !assumed(&by_joints), "{}", by_motors["assumptions"]);
    // And so does the description, whatever gear is in between.
    for gear in ["", "[drives.left_hip_pitch]\ngear_ratio = 50.0\n"] {
        let folder = log.with_file_name("robot");
        let encoders = format!("\n[joints]\nmotor_encoders = [\"left_hip_pitch\"]\n{gear}");
        copied("robots/three_link", &folder, &encoders);
        let described =
            bipedc(&["compare", text(&folder), "--base", "fixed", text(&log), "--json"]).ok().json();
        assert_eq!(described["assumptions"], by_motors["assumptions"]);
        for (here, there) in channels(&described).zip(channels(&by_joints)) {
            assert_eq!(here["name"], there["name"]);
            let [here, there] = [here, there].map(|channel| channel["rms"].as_f64().unwrap());
            assert!(
                (here - there).abs() <= 1e-9 * there,
                "{here} by the motor's encoder, {there} by the joint's"
            );
        }
        // What the log itself calls the motor's stays so: an angle of the shaft.
        let [own, mapped] = ["", text(&mapping)].map(|mapping| {
            let mapping: &[&str] = if mapping.is_empty() { &[] } else { &["--mapping", mapping] };
            let log = if mapping.is_empty() { &motors } else { &log };
            let compare =
                [&["compare", text(&folder), "--base", "fixed", text(log), "--json"], mapping].concat();
            bipedc(&compare).ok().json()["channels"].clone()
        });
        assert_eq!(own, mapped);
        assert_eq!(own == described["channels"], gear.is_empty());
    }
}

/// A robot's description in another folder, with more lines.
fn copied(robot: &str, folder: &Path, lines: &str) {
    std::fs::create_dir_all(folder).unwrap();
    std::fs::copy(Path::new(robot).join("robot.urdf"), folder.join("robot.urdf")).unwrap();
    let description = std::fs::read_to_string(Path::new(robot).join("biped.toml")).unwrap();
    std::fs::write(folder.join("biped.toml"), description + lines).unwrap();
}

fn channels(answer: &Value) -> impl Iterator<Item = &Value> {
    answer["channels"].as_array().unwrap().iter()
}

#[test]
fn enormous_values_are_named_and_printed_sanely() {
    let compare =
        |log: &std::path::Path| bipedc(&["compare", "robots/three_link", "--base", "fixed", text(log)]);
    compare(&three_link_log("compare_huge", 1.0, "-1e150")).fails_with(&[
        "log.csv:52:",
        "`left_hip_pitch/effort`: the value is infinite or too large (at most 1e12)",
        "`-1e150`",
    ]);
    let run = compare(&three_link_log("compare_large", 1.0, "1e12")).ok();
    assert!(run.out.contains("1.00e12 N m") && !run.out.contains("inf"), "{}", run.out);
}

#[test]
fn times_that_are_no_seconds_are_told_by_their_unit() {
    let refused = [("nanoseconds", 1e9), ("microseconds", 1e6), ("milliseconds", 1e3)];
    for (unit, per_second) in refused {
        let log = three_link_log(&format!("compare_{unit}"), per_second, "0.1");
        let compare = ["compare", "robots/three_link", "--base", "fixed", text(&log)];
        let scale = format!("scale = {:e}", 1.0 / per_second);
        bipedc(&compare).fails_with(&["log.csv:2", &format!("seems to be in {unit}"), "time = {", &scale]);
        // What the message says helps, and who means it may say so.
        let mapping = log.with_file_name("columns.toml");
        std::fs::write(&mapping, format!("time = {{ {scale} }}\n")).unwrap();
        let mapped = [&compare[..], &["--mapping", text(&mapping)]].concat();
        assert!(bipedc(&mapped).ok().out.contains("at 50.000000 Hz"));
        std::fs::write(&mapping, "time = { scale = 1 }\n").unwrap();
        bipedc(&mapped).fails_with(&["half the sampling rate"]);
    }
}

#[test]
fn bad_logs_are_refused() {
    let compare = |log: &str| bipedc(&["compare", "robots/tulip", log]);
    compare("nowhere.csv").fails_with(&["nowhere.csv"]);
    let file = scratch("compare").join("log.csv");
    std::fs::write(&file, "").unwrap();
    compare(text(&file)).fails_with(&["empty", "log.csv"]);
    let head =
        "time,left_hip_pitch/position,left_hip_pitch/effort,right_hip_pitch/position,right_hip_pitch/effort";
    std::fs::write(&file, format!("{head}\n0,0,0,0,0\n0.1,x,0,0,0\n")).unwrap();
    bipedc(&["compare", "robots/three_link", text(&file)]).fails_with(&["log.csv:3"]);
    bipedc(&["compare", "robots/tulip", LOG, "--mapping", "nowhere.toml"]).fails_with(&["nowhere.toml"]);
}

#[test]
fn reports_are_written() {
    let folder = scratch("compare_report");
    let (page, pictures) = (folder.join("out.html"), folder.join("svg"));
    bipedc(&["compare", "robots/tulip", LOG, "--report", text(&page), "--svg", text(&pictures)]).ok();
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.starts_with("<!DOCTYPE html>") && html.len() < 5_000_000, "{} bytes", html.len());
    // The robot, and each of the twelve joints over time and against four signals.
    assert_eq!(std::fs::read_dir(&pictures).unwrap().count(), 1 + 12 * 5);
    bipedc(&["compare", "robots/tulip", LOG, "--report", "/proc/nowhere/out.html"]).fails_with(&["nowhere"]);
}

/// Tables and logs with foot forces; a clean log has no structure.
#[test]
fn everything_measured_is_compared() {
    let compare = |name: &str| {
        let file = format!("tests/data/examples/{name}/validation.csv.gz");
        bipedc(&["compare", "robots/tulip", &file, "--where", "--json"]).ok().json()
    };
    let rms = |value: &Value, kind: &str| value["kinds"][kind]["rms"].as_f64().unwrap();
    let postures = compare("postures");
    assert_eq!((&postures["abscissa"], &postures["unit"]), (&Value::from("posture"), &Value::from("m")));
    assert!((postures["rms"].as_f64().unwrap() / 0.0075647 - 1.0).abs() < 0.01);
    // The reference values were computed at 10 Hz.
    let file = "tests/data/examples/swaying/validation.csv.gz";
    let swaying =
        bipedc(&["compare", "robots/tulip", file, "--where", "--cutoff", "10", "--json"]).ok().json();
    assert!((rms(&swaying, "base_force") / 5.29581 - 1.0).abs() < 0.02);
    assert!((rms(&swaying, "base_moment") / 0.54569 - 1.0).abs() < 0.02);
    // The payload is on the torso, so the legs' joints are predicted down to the noise of the feet's sensors.
    assert!(rms(&swaying, "effort") < 0.09, "{}", rms(&swaying, "effort"));
    let rows = swaying["where"].as_array().unwrap();
    let phases = rows[0]["phases"].as_array().unwrap();
    assert!(phases.iter().any(|phase| phase["name"] == "double support"));
    assert_eq!(rows.iter().filter(|row| row["kind"] == "effort").count(), 10);
    let null = compare("null");
    for row in null["where"].as_array().unwrap() {
        assert_eq!(row["signature"].as_array().unwrap().len(), 0, "{row}");
        // Efforts of these joints have a noise of 0.05, 0.03 or 0.02 N m.
        let noise = row["noise"].as_f64().unwrap();
        assert!([0.05, 0.03, 0.02].iter().any(|truth| (noise / truth - 1.0).abs() < 0.07), "{row}");
    }
}

/// Before: 0.0742 and 0.0635 N m of the same row, as all of the log and as the samples of an experiment tell it.
#[test]
fn a_row_has_one_noise() {
    for name in ["backlash", "coulomb"] {
        let file = format!("tests/data/examples/{name}/validation.csv.gz");
        let answer = bipedc(&["compare", "robots/tulip", &file, "--where", "--json"]).ok().json();
        let [rows, channels] = ["where", "channels"].map(|list| answer[list].as_array().unwrap());
        assert!(rows.len() >= 12);
        for row in rows {
            let own = channels.iter().find(|channel| channel["name"] == row["name"]).unwrap();
            assert_eq!(own["noise"], row["noise"], "{own} {row}");
        }
    }
}

/// Degrees read as radians leave what looks like noise and is many times what was measured: it was called noise.
#[test]
fn what_is_left_is_no_noise_where_it_is_more_than_was_measured() {
    let folder = scratch("compare_degrees");
    let mapping = folder.join("degrees.toml");
    let scale = "\"{joint}/position\" = { column = \"{joint}/position\", scale = 57.29578 }\n";
    std::fs::write(&mapping, scale).unwrap();
    let run = bipedc(&["compare", "robots/tulip", LOG, "--mapping", text(&mapping), "--json"]).ok().json();
    for row in run["channels"].as_array().unwrap() {
        let [rms, relative, noise] =
            ["rms", "relative", "noise"].map(|key| row[key].as_f64().unwrap_or(f64::NAN));
        let measured = rms / relative;
        assert!(relative < 1.5 || noise < 1.01 * measured, "{measured} measured: {row}");
    }
}

/// A pendulum with dry friction, and a log of it.
fn pendulum(folder: &Path) -> (String, String) {
    let urdf = r#"<robot name="pendulum"><link name="base"/><link name="rod"><inertial><origin xyz="0 0 -0.2"/>
<mass value="2"/><inertia ixx="0.03" iyy="0.03" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>"#;
    std::fs::write(folder.join("robot.urdf"), urdf).unwrap();
    std::fs::write(folder.join("biped.toml"), "[base]\nkind = \"fixed\"\nlink = \"base\"\n").unwrap();
    let mut log = String::from("time,hinge/position,hinge/effort\n");
    for i in 0..3000 {
        let t = 0.01 * f64::from(i);
        let sines = [(0.5, 1.9), (0.3, 3.1), (0.2, 4.7), (0.1, 7.3)];
        let sum = |f: &dyn Fn(f64, f64) -> f64| sines.iter().map(|(a, w)| f(*a, *w)).sum::<f64>();
        let (q, v) = (sum(&|a, w| a * (w * t).sin()), sum(&|a, w| a * w * (w * t).cos()));
        let torque = 0.11 * sum(&|a, w| -a * w * w * (w * t).sin()) + 2.0 * 9.81 * 0.2 * q.sin();
        let noise = 0.01 * (f64::from(i * i % 101) / 50.0 - 1.0);
        writeln!(log, "{t:.3},{q:.6},{:.6}", torque + 0.3 * (v / 0.01).tanh() + noise).unwrap();
    }
    (text(folder).to_owned(), log)
}

/// What had to be put right in the time stamps is told with its line, and changes no number.
#[test]
fn repaired_time_stamps_are_told() {
    let folder = scratch("compare_order");
    let (robot, log) = pendulum(&folder);
    let mut rows: Vec<&str> = log.lines().collect();
    // Row 1000 behind the one after it, row 2000 twice; the header is line 1.
    rows.swap(1001, 1002);
    rows.insert(2001, rows[2001]);
    let (clean, odd) = (folder.join("clean.csv"), folder.join("odd.csv"));
    std::fs::write(&clean, &log).unwrap();
    std::fs::write(&odd, rows.join("\n") + "\n").unwrap();
    let compare = |log: &Path| bipedc(&["compare", &robot, text(log)]).ok();
    let (expected, told) = (compare(&clean), compare(&odd));
    assert_eq!((told.out, expected.err), (expected.out, String::new()));
    for (what, line) in [
        (
            "warning: 1 of 3001 rows stand behind rows of a later time, first in this line: they were sorted in",
            1003,
        ),
        (
            "warning: 1 of 3001 rows repeat the time of another row, first in this line: they were left out",
            2003,
        ),
    ] {
        let told = told.err.split(what).nth(1).unwrap_or_else(|| panic!("no `{what}` in {}", told.err));
        let place = told.lines().nth(1).unwrap();
        assert!(place.ends_with(&format!("odd.csv:{line}")), "{what}: {place}");
    }
}

/// The answer to a log from a pipe is that to a file but for its name, which is the one given.
#[cfg(unix)]
#[test]
fn logs_may_come_through_pipes() {
    let folder = scratch("compare_pipes");
    let (robot, log) = pendulum(&folder);
    let (file, fifo) = (folder.join("log.csv"), folder.join("log.fifo"));
    std::fs::write(&file, &log).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    for (command, options) in [
        ("compare", &["--where", "--free-run", "0.5"][..]),
        ("diagnose", &["--inertial", "none", "--most", "1"]),
        ("identify", &[]),
    ] {
        let run = |log: &str, give: &dyn Fn(&[&str]) -> Run| {
            let arguments = [&[command, &robot, log, "--json"], options].concat();
            give(&arguments).ok().json().to_string().replace(&format!("\"{log}\""), "\"LOG\"")
        };
        let expected = run(text(&file), &bipedc);
        assert_eq!(run("/dev/stdin", &|arguments| piped(arguments, log.as_bytes())), expected);
        let through_fifo = std::thread::scope(|scope| {
            scope.spawn(|| std::fs::write(&fifo, &log));
            run(text(&fifo), &bipedc)
        });
        assert_eq!(through_fifo, expected);
    }
}

/// A message names what was given, and comes as soon as it is known: the rest is not waited for.
#[cfg(unix)]
#[test]
fn wrong_pipes_are_named() {
    let bad = |log: &[u8], words: &[&str]| {
        piped(&["compare", "robots/tulip", "/dev/stdin"], log).fails_with(&[&["/dev/stdin"], words].concat());
    };
    bad(b"", &["the file is empty"]);
    bad(b"time,left_hip_pitch/position\n0,x\n", &["/effort"]);
    bipedc(&["diagnose", "robots/tulip", "/dev/zero"]).fails_with(&["/dev/zero:1:1", "NUL bytes"]);
    let same = ["diagnose", "robots/tulip", "/dev/stdin", "--validate", "/dev/fd/0", "--cutoff", "16"];
    let log = std::fs::read(LOG).unwrap();
    piped(&same, &log).fails_with(&["/dev/fd/0", "the validation log is the training log"]);
}

/// What README prints of its first command is what the command prints.
#[test]
fn readme_shows_the_true_answer() {
    let [train, judge] =
        ["train", "validation"].map(|log| format!("tests/data/examples/coulomb/{log}.csv.gz"));
    let printed = bipedc(&["diagnose", "robots/tulip", &train, "--validate", &judge]).ok().out;
    let readme = std::fs::read_to_string("README.md").unwrap();
    assert!(readme.contains(&format!("-- diagnose robots/tulip {train} --validate {judge}\n")));
    let block = readme.split("The first prints:").nth(1).unwrap().split("```").nth(1).unwrap();
    // README breaks lines elsewhere, and stops before the tables.
    let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let (shown, printed) = (words(block.trim().trim_end_matches("...")), words(&printed));
    assert!(shown.len() > 20);
    assert_eq!(shown, printed[..shown.len()]);
}
