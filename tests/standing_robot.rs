//! A robot that stands: what the ground does and nobody logs (its horizontal forces where the corners of soles tell the normal ones alone, and all of them where
//! the log does not say that the robot stands), and noise of where its base is.
use crate::cli::{bipedc, scratch, text};
use bipedc_effects::random::Random;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const TULIP: &str = "robots/tulip";

/// TUlip bends its knees and leans from foot to foot, both soles on the ground.
fn scenario(seed: u32, rate: f64, effect: &str) -> String {
    let mut told = format!(
        "duration = 10.0\nstep = 0.001\nlog_step = 0.004\nseed = {seed}\n[control]\nstiffness = 900.0\ndamping = 12.0\nservo = \"drive\"\n{effect}"
    );
    let (slow, fast) = (0.4 * rate, 0.9 * rate);
    for side in ["right", "left"] {
        for (joint, middle, times) in
            [("hip_pitch", -0.2, -0.5), ("knee_pitch", 0.4, 1.0), ("ankle_pitch", -0.2, -0.5)]
        {
            let [a, b] = [0.12, 0.04].map(|size| times * size);
            writeln!(
                told,
                "[joint.{side}_{joint}]\nposition = {middle}\nsines = [[{a}, {slow}, 0.0], [{b}, {fast}, 1.0]]"
            )
            .unwrap();
        }
        for (joint, size) in [("hip_roll", 0.02), ("ankle_roll", -0.02)] {
            writeln!(told, "[joint.{side}_{joint}]\nsines = [[{size}, {}, 0.5]]", 0.3 * rate).unwrap();
        }
    }
    told
}

/// The columns of a log that are to be kept.
fn kept(log: &Path, name: &str, is_kept: impl Fn(&str) -> bool) -> PathBuf {
    let all = std::fs::read_to_string(log).unwrap();
    let header: Vec<&str> = all.lines().next().unwrap().split(',').collect();
    let columns: Vec<usize> = (0..header.len()).filter(|column| is_kept(header[*column])).collect();
    assert!(columns.len() > 10, "{header:?}");
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        columns.iter().map(|column| cells[*column]).collect::<Vec<_>>().join(",")
    };
    let path = log.with_file_name(name);
    std::fs::write(&path, all.lines().map(row).collect::<Vec<_>>().join("\n")).unwrap();
    path
}

/// Two motions of the standing robot.
fn logs(folder: &Path, effect: &str) -> [PathBuf; 2] {
    with_sensors(folder, "position_noise = 1e-5\neffort_noise = 0.02\n", effect)
}

/// The same with other sensors.
fn with_sensors(folder: &Path, sensors: &str, effect: &str) -> [PathBuf; 2] {
    [(1, 1.0), (2, 0.8)].map(|(seed, rate)| {
        let [file, log] = ["toml", "csv"].map(|end| folder.join(format!("{seed}.{end}")));
        std::fs::write(&file, scenario(seed, rate, &format!("[sensors]\n{sensors}{effect}"))).unwrap();
        bipedc(&["simulate", TULIP, "--scenario", text(&file), "--out", text(&log)]).ok();
        log
    })
}

fn is_joint(name: &str) -> bool {
    name == "time" || (!name.contains("foot") && !name.starts_with("base/"))
}

/// Before: gains of hips of 1.18 and 1.25 in a log in which nothing was hidden, because feet that push against each other were taken for feet that do not.
#[test]
fn horizontal_forces_that_no_corner_tells_are_no_effect() {
    let folder = scratch("corners-alone");
    let alone = |log: &PathBuf, name: &str| {
        let is_corner = |column: &str| {
            ["front", "rear"].iter().any(|end| column.contains(end)) && column.ends_with("/force/z")
        };
        kept(log, name, |column| is_joint(column) || column.starts_with("base/") || is_corner(column))
    };
    let clean = logs(&folder, "");
    let [train, judge] = [alone(&clean[0], "train.csv"), alone(&clean[1], "judge.csv")];
    let run = ["diagnose", TULIP, text(&train), "--validate", text(&judge), "--json"];
    let answer = bipedc(&run).ok().json();
    assert_eq!(answer["effects"].as_array().unwrap().len(), 0, "{}", answer["summary"]);
    assert_eq!(answer["unexplained"], false, "{}", answer["summary"]);
    let assumed = answer["assumptions"].to_string();
    assert!(
        assumed.contains("the horizontal forces and the moment about the vertical at `right_foot`"),
        "{assumed}"
    );
    assert!(answer["rows"]["right_knee_pitch"].is_object() && answer["rows"].get("right_hip_yaw").is_none());
    // Friction of a knee is found in what is left of the rows.
    let rubbing = logs(
        &folder,
        "[[effect]]\nkind = \"viscous_friction\"\njoint = \"left_knee_pitch\"\ndamping = 2.0\n",
    );
    let [train, judge] = [alone(&rubbing[0], "train.csv"), alone(&rubbing[1], "judge.csv")];
    let run = ["diagnose", TULIP, text(&train), "--validate", text(&judge), "--json"];
    let answer = bipedc(&run).ok().json();
    let [effect] = &answer["effects"].as_array().unwrap()[..] else { panic!("{}", answer["summary"]) };
    assert_eq!([&effect["kind"], &effect["joint"]], ["viscous_friction", "left_knee_pitch"]);
    let damping = effect["parameters"]["damping"].as_f64().unwrap();
    assert!((damping - 2.0).abs() < 0.06, "{damping}");
}

/// Before: minutes of search for what a held robot lacks.
#[test]
fn a_robot_that_stands_in_a_log_without_its_base_is_asked_for_it() {
    let folder = scratch("stands-unsaid");
    let [standing, _] = logs(&folder, "");
    let log = kept(&standing, "joints.csv", is_joint);
    let refused = bipedc(&["diagnose", TULIP, text(&log)]);
    refused.fails_with(&["the robot stands", "`right_foot`", "`left_foot`", "log base/position", "--anyway"]);
    // One that is held by its trunk is not.
    let hanging = folder.join("hanging.csv");
    let [file] = [folder.join("1.toml")];
    bipedc(&["simulate", TULIP, "--base", "fixed", "--scenario", text(&file), "--out", text(&hanging)]).ok();
    let free = kept(&hanging, "free.csv", is_joint);
    let answer = bipedc(&["diagnose", TULIP, text(&free), "--json"]).ok().json();
    assert_eq!(answer["effects"].as_array().unwrap().len(), 0, "{}", answer["summary"]);
}

/// Before: another mass and inertia of the torso, because a lighter one lets less of the noise of the base's accelerations through.
#[test]
fn noise_of_where_the_base_is_asks_for_no_other_masses() {
    let folder = scratch("noisy-base");
    let noise = "base_position_noise = 3e-4\nbase_orientation_noise = 3e-4\n";
    let [train, judge] = logs(&folder, noise);
    let run = ["diagnose", TULIP, text(&train), "--validate", text(&judge), "--json"];
    let answer = bipedc(&run).ok().json();
    let said =
        [&answer["effects"], &answer["inertial_corrections"]].map(|list| list.as_array().unwrap().len());
    assert_eq!(said, [0, 0], "{}", answer["summary"]);
    assert_eq!(answer["unexplained"], false, "{}", answer["summary"]);
}

/// Before: behind 20 Hz, for which the noise of encoders was the reason, something was left at a hip that was not; of a robot of 90 kg 6 % of the error was
/// explained, with two wrong intervals of four.
#[test]
fn noise_of_encoders_asks_for_no_faster_filter() {
    let folder = scratch("noisy-encoders");
    let sensors = "position_noise = 5e-5\neffort_noise = 0.2\nforce_noise = 1.0\nbase_position_noise = 1e-4\n\
                   base_orientation_noise = 1e-4\n";
    let carried =
        "[[effect]]\nkind = \"payload\"\nlink = \"torso\"\nmass = 3.0\nx = 0.05\ny = 0.02\nz = 0.2\n";
    let [train, judge] = with_sensors(&folder, sensors, carried);
    let run = ["diagnose", TULIP, text(&train), "--validate", text(&judge), "--json"];
    let answer = bipedc(&run).ok().json();
    let [payload] = &answer["effects"].as_array().unwrap()[..] else { panic!("{}", answer["summary"]) };
    assert_eq!([&payload["kind"], &payload["link"]], ["payload", "torso"]);
    assert_eq!(answer["unexplained"], false, "{}", answer["summary"]);
    for (name, truth) in [("mass", 3.0), ("x", 0.05), ("y", 0.02), ("z", 0.2)] {
        let [low, high] = [0, 1].map(|end| payload["ci95"][name][end].as_f64().unwrap());
        assert!(low < truth && truth < high, "{name}: {low} to {high}");
    }
    let [before, after] = ["before", "after"].map(|key| answer["rms"]["base_moment"][key].as_f64().unwrap());
    assert!(after < 0.5 * before, "{before} {after}");
}

/// A log with noise that remembers, in its forces and efforts; with a gap near its beginning, if one is wanted.
fn remembering(log: &Path, name: &str, gap: bool) -> PathBuf {
    const KEEPS: f64 = 0.7;
    let all = std::fs::read_to_string(log).unwrap();
    let mut lines = all.lines();
    let header = lines.next().unwrap();
    let size = |name: &str| match name {
        _ if name.ends_with("/effort") => 0.02,
        _ if name.contains("/force/") => 0.3,
        _ if name.contains("/moment/") => 0.01,
        _ => 0.0,
    };
    let sizes: Vec<f64> = header.split(',').map(size).collect();
    let (mut random, mut noise) = (Random::new(7), vec![0.0; sizes.len()]);
    let mut told = vec![header.to_owned()];
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        for ((cell, size), noise) in cells.iter_mut().zip(&sizes).zip(&mut noise) {
            *noise = KEEPS * *noise + (1.0 - KEEPS * KEEPS).sqrt() * random.normal();
            if *size > 0.0 {
                *cell = (cell.parse::<f64>().unwrap() + size * *noise).to_string();
            }
        }
        let time: f64 = cells[0].parse().unwrap();
        if !gap || !(1.5..1.9).contains(&time) {
            told.push(cells.join(","));
        }
    }
    let path = log.with_file_name(name);
    std::fs::write(&path, told.join("\n")).unwrap();
    path
}

/// Before: what is before the first gap alone told the noise, a fifth of it, and seven rows of a faultless log were unexplained.
#[test]
fn a_gap_hides_no_noise() {
    let [log, _] = logs(&scratch("noise-and-gap"), "");
    for (name, gap) in [("whole.csv", false), ("cut.csv", true)] {
        let log = remembering(&log, name, gap);
        let answer = bipedc(&["compare", TULIP, text(&log), "--cutoff", "5", "--json"]).ok().json();
        let rows = answer["channels"].as_array().unwrap().iter().filter(|row| row["kind"] != "sole");
        let times: Vec<f64> = rows
            .map(|row| {
                let [rms, noise] = ["rms", "noise"].map(|key| row[key].as_f64().unwrap());
                rms / noise
            })
            .collect();
        let most = times.iter().fold(0.0_f64, |most, times| most.max(*times));
        // The noise itself is told within a third or so by ten seconds.
        assert!(times.len() >= 18 && most < 1.6, "{name}: {times:?}");
    }
}
