//! Torques that are reported later than the motion, by a filter of their sensor: a delay of less than nothing, and no coupling or friction.
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
    let summary = answer["summary"].as_str().unwrap();
    println!("{summary}");
    let effects = answer["effects"].as_array().unwrap();
    let delays = effects.iter().filter(|effect| effect["kind"] == "actuator_delay");
    let delays: Vec<f64> = delays.map(|effect| effect["parameters"]["delay"].as_f64().unwrap()).collect();
    let lateness = LATE as f64 * step;
    assert!(delays.len() >= 8, "{summary}");
    for delay in &delays {
        assert!((delay / -lateness - 1.0).abs() < 0.05, "{delay} s of {lateness} s");
    }
    // The friction is in the log besides, and nothing else is.
    assert_eq!(effects.len(), delays.len() + 1, "{summary}");
    let friction = effects.iter().find(|effect| effect["kind"] == "coulomb_friction").expect(summary);
    assert_eq!(friction["joint"], "left_knee_pitch");
    assert!((friction["parameters"]["torque"].as_f64().unwrap() / 0.4 - 1.0).abs() < 0.03, "{summary}");
    assert!(summary.contains("ms later than it acts, behind a filter of its sensor"), "{summary}");
}
