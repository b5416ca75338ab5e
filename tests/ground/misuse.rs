//! Wrong use: what is said names the column, the joint or the posture.
use crate::ground::cli::{bipedc, scratch, text};
use crate::ground::support::measured::{Subjects, example};
use bipedc_analysis::experiments::postures::PostureExperiment;
use bipedc_analysis::identify::cop::check_postures;
use bipedc_analysis::log::{Mapping, Reader};
use flate2::read::GzDecoder;
use std::io::{Cursor, Read as _};
use std::path::Path;
use tulip::Tulip;

type Change<'a> = &'a dyn Fn(&str, usize, &str) -> Option<String>;

/// The example's table, cell by cell, changed.
fn changed(rows: usize, change: Change<'_>) -> String {
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
    format!("{}\n{}\n", kept.join(","), body.join("\n"))
}

/// All that is said of a table, errors before warnings.
fn said(stance: &str, change: Change<'_>) -> String {
    let subjects = Subjects::named("tulip");
    let (path, text) = (Path::new("postures.csv"), changed(90, change));
    let reader = Reader::from_source(path, Box::new(Cursor::new(text.into_bytes())), &Mapping::default());
    let read =
        reader.and_then(|r| PostureExperiment::from_reader(subjects.robot(&Tulip, &[]), r, Some(stance)));
    match read {
        Err(found) => found.0.iter().map(ToString::to_string).collect(),
        Ok(postures) => check_postures(&postures, &subjects.layout).iter().map(ToString::to_string).collect(),
    }
}

fn demand(said: &str, words: &[&str]) {
    words.iter().for_each(|word| assert!(said.contains(word), "no `{word}` in: {said}"));
}

fn same(_: &str, _: usize, cell: &str) -> Option<String> {
    Some(cell.to_owned())
}

#[test]
fn tables_that_cannot_be_right() {
    let scaled = |what: &'static str, factor: f64| {
        move |name: &str, _: usize, cell: &str| {
            let value: f64 = cell.parse().unwrap();
            Some(if name.contains(what) { (factor * value).to_string() } else { cell.to_owned() })
        }
    };
    let without = |what: &'static str| {
        move |name: &str, _: usize, cell: &str| (!name.contains(what)).then(|| cell.to_owned())
    };
    let right = |change: Change<'_>| said("right_foot", change);
    assert_eq!(right(&same), "", "nothing is wrong with the example");
    demand(&right(&scaled("cop/", 1e3)), &["error", "cop/x", "millimetres", "mapping"]);
    demand(&right(&scaled("cop/", 1e2)), &["error", "cop/x", "centimetres"]);
    demand(&right(&scaled("/position", 57.29578)), &["error", "knee_pitch/position", "degrees"]);
    demand(&right(&scaled("/position", 0.0)), &["error", "alike", "no joint moves"]);
    demand(&right(&without("cop/x")), &["error", "cop/x", "right_foot"]);
    demand(&right(&without("cop/")), &["error", "cop/x", "cop/y"]);
    demand(&right(&without("/position")), &["error", "position of a joint"]);
    demand(&said("left_foot", &same), &["error", "outside the soles", "--stance"]);
    let cell = |what: &'static str, row: usize, new: &'static str| {
        move |name: &str, i: usize, cell: &str| {
            Some(if name == what && i == row { new.to_owned() } else { cell.to_owned() })
        }
    };
    demand(&right(&cell("left_knee_pitch/position", 6, "nan")), &["error", "left_knee_pitch/position", "8"]);
    demand(&right(&cell("cop/y", 3, "")), &["error", "cop/y", "posture 3"]);
    demand(
        &right(&cell("cop/y", 4, "0.7")),
        &["warning", "outside the soles in 1 of 90 postures", "posture 5"],
    );
    demand(&right(&cell("left_ankle_pitch/position", 2, "0.4")), &["warning", "not flat", "`left_foot`"]);
    let held = |name: &str, _: usize, cell: &str| {
        Some(if name == "right_hip_yaw/position" { "0.1".to_owned() } else { cell.to_owned() })
    };
    demand(&right(&held), &["warning", "hardly move", "right_hip_yaw"]);
}

#[test]
fn tables_that_tell_too_little() {
    let folder = scratch("misuse");
    let identify = |name: &str, text: String| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        bipedc(&["identify", "robots/tulip", path.to_str().unwrap(), "--method", "cop"])
    };
    identify("few.csv", changed(10, &same)).fails_with(&["10 postures", "25 parameters", "13 postures"]);
    let light = |name: &str, _: usize, cell: &str| {
        let value: f64 = cell.parse().unwrap();
        Some(if name.contains("/force/z") { (0.01 * value).to_string() } else { cell.to_owned() })
    };
    identify("light.csv", changed(90, &light)).fails_with(&["corner forces carry", "--total-mass"]);
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
    run(&["--method", "cop", "--stance", "middle_foot"])
        .fails_with(&["middle_foot", "right_foot, left_foot"]);
    let log = example("swaying").join("train.csv.gz");
    bipedc(&["identify", "robots/tulip", text(&log), "--method", "cop"]).fails_with(&["posture"]);
    bipedc(&["identify", "robots/tulip_v1_leg", text(&train), "--method", "cop"]).fails_with(&["foot"]);
    bipedc(&["identify", "robots/seven_link", text(&train), "--method", "cop"])
        .fails_with(&["three dimensions"]);
}
