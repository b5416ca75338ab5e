//! Wrong use: what is said names the column, the joint or the posture.
use crate::cli::{Run, bipedc, scratch, text};
use crate::support::measured::example;
use flate2::read::GzDecoder;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// The example's table, cell by cell, changed and written.
fn changed(
    folder: &Path,
    name: &str,
    rows: usize,
    change: impl Fn(&str, usize, &str) -> Option<String>,
) -> PathBuf {
    let mut table = String::new();
    let file = std::fs::File::open(example("postures").join("train.csv.gz")).unwrap();
    GzDecoder::new(file).read_to_string(&mut table).unwrap();
    let mut lines = table.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row = |(i, line): (usize, &str)| -> String {
        let cells = head.iter().zip(line.split(',')).filter_map(|(name, cell)| change(name, i, cell));
        cells.collect::<Vec<_>>().join(",")
    };
    let kept: Vec<&str> = head.iter().copied().filter(|name| change(name, 0, "0").is_some()).collect();
    let body: Vec<String> = lines.take(rows).enumerate().map(row).collect();
    let path = folder.join(name);
    std::fs::write(&path, format!("{}\n{}\n", kept.join(","), body.join("\n"))).unwrap();
    path
}

fn identify(path: &Path, more: &[&str]) -> Run {
    bipedc(&[&["identify", "robots/tulip", text(path), "--method", "cop"][..], more].concat())
}

#[test]
fn tables_that_cannot_be_right() {
    let folder = scratch("misuse");
    let same = |_: &str, _: usize, cell: &str| Some(cell.to_owned());
    let file = |name: &str, rows, change: &dyn Fn(&str, usize, &str) -> Option<String>| {
        changed(&folder, name, rows, change)
    };
    identify(&file("few.csv", 10, &same), &[]).fails_with(&["10 postures", "25 parameters", "13 postures"]);
    let scaled = |what: &'static str, factor: f64| {
        move |name: &str, _: usize, cell: &str| {
            let value: f64 = cell.parse().unwrap();
            Some(if name.contains(what) { (factor * value).to_string() } else { cell.to_owned() })
        }
    };
    identify(&file("mm.csv", 90, &scaled("cop/", 1e3)), &[]).fails_with(&["cop/x", "millimetres", "mapping"]);
    identify(&file("degrees.csv", 90, &scaled("/position", 57.29578)), &[])
        .fails_with(&["knee_pitch/position", "degrees"]);
    identify(&file("alike.csv", 90, &scaled("/position", 0.0)), &[]).fails_with(&["alike", "no joint moves"]);
    let without = |what: &'static str| {
        move |name: &str, _: usize, cell: &str| (!name.contains(what)).then(|| cell.to_owned())
    };
    identify(&file("no_x.csv", 90, &without("cop/x")), &[]).fails_with(&["cop/x", "right_foot"]);
    identify(&file("no_cop.csv", 90, &without("cop/")), &[]).fails_with(&["cop/x", "cop/y"]);
    identify(&file("no_joints.csv", 90, &without("/position")), &[]).fails_with(&["position of a joint"]);
    let nan = |name: &str, i: usize, cell: &str| {
        Some(if name == "left_knee_pitch/position" && i == 6 { "nan".to_owned() } else { cell.to_owned() })
    };
    identify(&file("nan.csv", 90, &nan), &[]).fails_with(&["left_knee_pitch/position", "8"]);
    let empty = |name: &str, i: usize, cell: &str| {
        Some(if name == "cop/y" && i == 3 { String::new() } else { cell.to_owned() })
    };
    identify(&file("empty.csv", 90, &empty), &[]).fails_with(&["cop/y", "posture 3"]);
    identify(&file("light.csv", 90, &scaled("/force/z", 0.01)), &[])
        .fails_with(&["corner forces carry", "--total-mass"]);
    let good = file("good.csv", 90, &same);
    identify(&good, &["--stance", "middle_foot"]).fails_with(&["middle_foot", "right_foot, left_foot"]);
    identify(&good, &["--stance", "left_foot"]).fails_with(&["outside the soles", "--stance"]);
    let shifted = |name: &str, i: usize, cell: &str| {
        let value: f64 = cell.parse().unwrap();
        Some(if name == "cop/y" && i == 4 { (value + 0.4).to_string() } else { cell.to_owned() })
    };
    let run = identify(&file("outside.csv", 90, &shifted), &[]).ok();
    assert!(
        run.err.contains("outside the soles in 1 of 90 postures") && run.err.contains("posture 5"),
        "{}",
        run.err
    );
    let tilted = |name: &str, i: usize, cell: &str| {
        let value: f64 = cell.parse().unwrap();
        let tilt = if name == "left_ankle_pitch/position" && i == 2 { 0.3 } else { 0.0 };
        Some((value + tilt).to_string())
    };
    let run = identify(&file("tilted.csv", 90, &tilted), &[]).ok();
    assert!(run.err.contains("not flat") && run.err.contains("`left_foot`"), "{}", run.err);
    let held = |name: &str, _: usize, cell: &str| {
        Some(if name == "right_hip_yaw/position" { "0.1".to_owned() } else { cell.to_owned() })
    };
    let run = identify(&file("held.csv", 90, &held), &["--json"]).ok();
    assert!(run.err.contains("hardly move") && run.err.contains("right_hip_yaw"), "{}", run.err);
}

#[test]
fn methods_that_do_not_fit() {
    let train = example("postures").join("train.csv.gz");
    let run = |more: &[&str]| bipedc(&[&["identify", "robots/tulip", text(&train)][..], more].concat());
    run(&[]).fails_with(&["logs over time"]);
    run(&["--method", "zmp"]).fails_with(&["--method cop"]);
    run(&["--symmetric"]).fails_with(&["--method cop"]);
    run(&["--stance", "left_foot"]).fails_with(&["--method"]);
    run(&["--method", "cop", "--total-mass", "-3"]).fails_with(&["--total-mass"]);
    let log = example("swaying").join("train.csv.gz");
    bipedc(&["identify", "robots/tulip", text(&log), "--method", "cop"]).fails_with(&["posture"]);
    bipedc(&["identify", "robots/tulip_v1_leg", text(&train), "--method", "cop"]).fails_with(&["foot"]);
    bipedc(&["identify", "robots/seven_link", text(&train), "--method", "cop"])
        .fails_with(&["three dimensions"]);
}
