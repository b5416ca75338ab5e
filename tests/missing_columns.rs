//! Logs that lack a position: what depends on it is left out by every command alike, and said.
use crate::cli::{bipedc, scratch, text};
use flate2::read::GzDecoder;
use serde_json::Value;
use std::collections::BTreeSet;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Has an effort and no position.
const UNSEEN: &str = "right_hip_roll";

/// A log of an independent simulator without a column.
fn without(folder: &Path, name: &str, column: &str) -> PathBuf {
    let mut whole = String::new();
    let file = std::fs::File::open(Path::new("tests/data/examples/coulomb").join(name)).unwrap();
    GzDecoder::new(file).read_to_string(&mut whole).unwrap();
    let taken = whole.lines().next().unwrap().split(',').position(|head| head == column).unwrap();
    let kept = |line: &str| {
        let fields = line.split(',').enumerate().filter(|(i, _)| *i != taken);
        fields.map(|(_, field)| field).collect::<Vec<_>>().join(",")
    };
    let file = folder.join(name.replace(".gz", ""));
    std::fs::write(&file, whole.lines().map(kept).collect::<Vec<_>>().join("\n")).unwrap();
    file
}

#[test]
fn a_joint_that_nobody_saw_is_held_against_no_model() {
    let folder = scratch("missing_position");
    let column = format!("{UNSEEN}/position");
    let [train, judge] = ["train.csv.gz", "validation.csv.gz"].map(|name| without(&folder, name, &column));
    let compared = bipedc(&["compare", "robots/tulip", text(&judge), "--json"]).ok().json();
    let channels = compared["channels"].as_array().unwrap().iter();
    let compared: BTreeSet<&str> = channels.map(|channel| channel["name"].as_str().unwrap()).collect();
    assert!(compared.len() >= 6 && compared.iter().all(|name| !name.starts_with("right")), "{compared:?}");
    let answer = bipedc(&["diagnose", "robots/tulip", text(&train), "--validate", text(&judge), "--json"]);
    let answer = answer.ok();
    let (said, answer) = (answer.err.clone(), answer.json());
    let rows: BTreeSet<&str> = answer["rows"].as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(rows, compared, "{}", answer["summary"]);
    let told = format!("effort ({} of 12 joints; not looked at: ", rows.len());
    let summary = answer["summary"].as_str().unwrap();
    assert!(summary.contains(&told) && summary.contains(&format!("`{UNSEEN}`")), "{summary}");
    let effects = answer["effects"].as_array().unwrap();
    let kinds: Vec<&Value> = effects.iter().map(|found| &found["kind"]).collect();
    assert_eq!(kinds, ["coulomb_friction"], "{}", answer["summary"]);
    assert_eq!(answer["unexplained"], false, "{}", answer["summary"]);
    let assumed = answer["assumptions"].to_string();
    assert!(assumed.contains(&format!("depends on `{UNSEEN}`, which has no position column")), "{assumed}");
    assert!(
        said.contains("what depends on its motion is left out") && !said.contains("hardly moves"),
        "{said}"
    );
    let refused = ["no column `right_hip_roll/position`", "[joints] locked = { right_hip_roll = ANGLE }"];
    bipedc(&["identify", "robots/tulip", text(&train)]).fails_with(&refused);
}
