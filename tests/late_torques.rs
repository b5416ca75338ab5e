//! Torques that are reported later than the motion: no effect of the library does that, and the answer says what it is.
use crate::cli::{bipedc, scratch, text};
use flate2::read::GzDecoder;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Samples by which efforts come late.
const LATE: usize = 3;

/// A log of an independent simulator, all efforts of it late, and its step (s).
fn late(folder: &Path, name: &str) -> (PathBuf, f64) {
    let mut whole = String::new();
    let file = std::fs::File::open(Path::new("tests/data/examples/coulomb").join(name)).unwrap();
    GzDecoder::new(file).read_to_string(&mut whole).unwrap();
    let rows: Vec<Vec<&str>> = whole.lines().map(|line| line.split(',').collect()).collect();
    let is_effort = |column: usize| rows[0][column].ends_with("/effort");
    let field = |row: usize, column: usize| rows[if is_effort(column) { row - LATE } else { row }][column];
    let mut lines = vec![rows[0].join(",")];
    lines.extend(
        (1 + LATE..rows.len())
            .map(|row| (0..rows[0].len()).map(|column| field(row, column)).collect::<Vec<_>>().join(",")),
    );
    let file = folder.join(name.replace(".gz", ""));
    std::fs::write(&file, lines.join("\n")).unwrap();
    let time = |row: usize| rows[row][0].parse::<f64>().unwrap();
    (file, time(2) - time(1))
}

#[test]
fn late_torques_are_told_by_their_lateness() {
    let folder = scratch("late_torques");
    let (train, step) = late(&folder, "train.csv.gz");
    let (judge, _) = late(&folder, "validation.csv.gz");
    let answer = bipedc(&["diagnose", "robots/tulip", text(&train), "--validate", text(&judge), "--json"]);
    let answer = answer.ok().json();
    let lateness = LATE as f64 * step;
    let parts = answer["unexplained_parts"].as_array().unwrap();
    let told: Vec<f64> = parts.iter().filter_map(|part| part["late_s"].as_f64()).collect();
    println!("{lateness} s: {told:?}\n{}", answer["summary"]);
    assert!(told.len() >= 4 && 2 * told.len() >= parts.len(), "{}", answer["unexplained_parts"]);
    // Where friction or drag was taken for a part of it, what is left is less late.
    let mut parts: Vec<f64> = told.iter().map(|found| found / lateness).collect();
    parts.sort_by(f64::total_cmp);
    assert!((parts[parts.len() / 2] - 1.0).abs() < 0.05, "{told:?} s of {lateness} s");
    assert!(parts[0] > 0.5 && parts[parts.len() - 1] < 1.1, "{told:?} s of {lateness} s");
    assert!(
        answer["summary"].as_str().unwrap().contains("ms later than the motion"),
        "{}",
        answer["summary"]
    );
}
