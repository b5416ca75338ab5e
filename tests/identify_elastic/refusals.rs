//! Wrong logs and wrong use: what is wrong is named, with joint and parameter.
use crate::identify_elastic::cli::{bipedc, scratch, text};
use crate::identify_elastic::leg::{example, identify};
use std::io::Read;
use std::path::{Path, PathBuf};

const ROBOT: &str = "robots/tulip_v1_leg";

/// The example's log, row by row: `change` sees the number of a row (0: the header) and its fields.
fn changed(folder: &Path, rows: usize, change: impl Fn(usize, &mut Vec<String>)) -> PathBuf {
    let mut whole = String::new();
    let file = std::fs::File::open(example("train.csv.gz")).unwrap();
    flate2::read::GzDecoder::new(file).read_to_string(&mut whole).unwrap();
    let mut out = String::new();
    for (i, line) in whole.lines().take(rows + 1).enumerate() {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        change(i, &mut fields);
        out += &(fields.join(",") + "\n");
    }
    let path = folder.join("log.csv");
    std::fs::write(&path, out).unwrap();
    path
}

fn column(name: &str) -> usize {
    let names = [
        "time",
        "right_hip_yaw/motor_position",
        "right_hip_yaw/motor_current",
        "right_hip_roll/motor_position",
        "right_hip_roll/motor_current",
        "right_hip_pitch/position",
        "right_hip_pitch/motor_position",
        "right_hip_pitch/motor_current",
        "right_knee_pitch/position",
        "right_knee_pitch/motor_position",
        "right_knee_pitch/motor_current",
    ];
    names.iter().position(|n| *n == name).unwrap()
}

fn mapped(name: &str, lines: &str) -> PathBuf {
    let path = scratch(name).join("mapping.toml");
    std::fs::write(&path, lines).unwrap();
    path
}

fn with_mapping(name: &str, lines: &str, more: &[&str]) -> crate::identify_elastic::cli::Run {
    let mapping = mapped(name, lines);
    identify(ROBOT, &example("train.csv.gz"), &[&["--mapping", text(&mapping)], more].concat())
}

#[test]
fn motor_and_joint_side_swapped() {
    let swap = "\"right_knee_pitch/position\" = \"right_knee_pitch/motor_position\"\n\"right_knee_pitch/motor_position\" = \"right_knee_pitch/position\"\n";
    with_mapping("elastic_swapped", swap, &[]).fails_with(&["right_knee_pitch", "swapped"]);
}

#[test]
fn wrong_units() {
    let scaled =
        |column: &str, scale: f64| format!("\"{column}\" = {{ column = \"{column}\", scale = {scale} }}\n");
    let degrees = scaled("right_hip_pitch/motor_position", 57.29577951308232);
    with_mapping("elastic_degrees", &degrees, &[]).fails_with(&["right_hip_pitch/motor_position", "degrees"]);
    let joint = scaled("right_hip_pitch/position", 57.29577951308232);
    with_mapping("elastic_joint_degrees", &joint, &[]).fails_with(&["right_hip_pitch", "degrees"]);
    let divided = scaled("right_knee_pitch/motor_position", 1.0 / 111.0);
    with_mapping("elastic_divided", &divided, &[])
        .fails_with(&["right_knee_pitch", "already divided by the gear ratio"]);
    let sign = scaled("right_knee_pitch/motor_position", -1.0);
    with_mapping("elastic_sign", &sign, &[]).fails_with(&["right_knee_pitch", "the other way round"]);
    let milli = scaled("right_ankle_pitch/motor_current", 1000.0);
    let answer = with_mapping("elastic_milliampere", &milli, &[]).ok().json();
    let warnings = answer["warnings"].to_string();
    assert!(warnings.contains("spring_stiffness") && warnings.contains("right_ankle_pitch"), "{warnings}");
}

#[test]
fn columns_that_are_missing() {
    let folder = scratch("elastic_missing");
    let without = |what: &'static str, joint: &'static str| {
        move |i: usize, fields: &mut Vec<String>| {
            if i == 0 {
                for field in fields.iter_mut().filter(|f| f.starts_with(joint) && f.ends_with(what)) {
                    *field = format!("unused_{field}").replace('/', "_");
                }
            }
        }
    };
    let log = changed(&folder, 3000, without("/motor_position", "right"));
    identify(ROBOT, &log, &[]).fails_with(&["right_knee_pitch/motor_position", "motor_current", "--mapping"]);
    let log = changed(&folder, 3000, without("/motor_position", "right_knee"));
    let answer = identify(ROBOT, &log, &[]).ok().json();
    let warnings = answer["warnings"].to_string();
    assert!(
        warnings.contains("`right_knee_pitch` teaches nothing") && warnings.contains("motor_position"),
        "{warnings}"
    );
    let names = answer["channels"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap());
    assert_eq!(names.filter(|n| *n == "right_knee_pitch").count(), 0);
    let torques = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/examples/coulomb/train.csv.gz");
    identify(ROBOT, &torques, &[]).fails_with(&["no series elastic drive is logged whole"]);
    identify("robots/tulip", &example("train.csv.gz"), &[])
        .fails_with(&["no series elastic drive", "[drives.JOINT]"]);
}

#[test]
fn data_without_content() {
    let folder = scratch("elastic_empty");
    let log = changed(&folder, 2, |_, _| ());
    identify(ROBOT, &log, &[]).fails_with(&["samples"]);
    let log = changed(&folder, 1, |_, _| ());
    identify(ROBOT, &log, &[]).fails_with(&["one row"]);
    let first = |i: usize, fields: &mut Vec<String>, from: usize| {
        if i > 0 {
            fields[from..].iter_mut().for_each(|field| "0.5".clone_into(field));
        }
    };
    let log = changed(&folder, 2000, move |i, fields| first(i, fields, 1));
    identify(ROBOT, &log, &[]).fails_with(&["right_hip_yaw/motor_position", "stands still"]);
    let current = column("right_knee_pitch/motor_current");
    let log = changed(&folder, 2000, |i, fields| {
        if i > 0 {
            "0.1".clone_into(&mut fields[current]);
        }
    });
    identify(ROBOT, &log, &[]).fails_with(&["right_knee_pitch/motor_current", "constant"]);
}

#[test]
fn not_a_number() {
    let folder = scratch("elastic_nan");
    let knee = column("right_knee_pitch/position");
    let log = changed(&folder, 3000, |i, fields| {
        if i == 700 {
            "nan".clone_into(&mut fields[knee]);
        }
    });
    let answer = identify(ROBOT, &log, &[]).ok().json();
    assert!(answer["warnings"].to_string().contains("right_knee_pitch/position"), "{}", answer["warnings"]);
    let log = changed(&folder, 3000, |i, fields| {
        if i == 700 {
            "two".clone_into(&mut fields[knee]);
        }
    });
    identify(ROBOT, &log, &[]).fails_with(&["right_knee_pitch/position", "two", ":701"]);
}

/// Gravity and a shifted knee: the spring pulls one way only.
#[test]
fn a_spring_that_is_loaded_one_way() {
    let folder = scratch("elastic_one_way");
    let motor = column("right_knee_pitch/motor_position");
    let log = changed(&folder, 3000, |i, fields| {
        if i > 0 {
            let x: f64 = fields[motor].parse().unwrap();
            fields[motor] = (x + 30.0).to_string();
        }
    });
    let answer = identify(ROBOT, &log, &[]).ok().json();
    let warnings = answer["warnings"].to_string();
    assert!(warnings.contains("spring of `right_knee_pitch` is loaded one way only"), "{warnings}");
}

#[test]
fn options_that_contradict() {
    let log = example("train.csv.gz");
    for (more, words) in [
        (&["--estimator", "huber"][..], &["huber"][..]),
        (&["--rotor", "all"], &["--rotor", "biped.toml"]),
        (&["--coupled", "right_hip_yaw,right_hip_roll"], &["--coupled"]),
        (&["--decimate", "4"], &["--decimate"]),
        (&["--steps", "one", "--estimator", "ordinary"], &["weights"]),
        (&["--slow", "80"], &["--slow"]),
    ] {
        identify(ROBOT, &log, more).fails_with(words);
    }
    bipedc(&["identify", ROBOT, text(&log), "--estimator", "instrumental"]).fails_with(&["effort"]);
    bipedc(&["identify", ROBOT, text(&log), "--steps", "one"])
        .fails_with(&["--steps one", "--method elastic"]);
}

/// A page and pictures: every joint's torque, every parameter.
#[test]
fn a_report_shows_torques_and_parameters() {
    let folder = scratch("elastic_report");
    let (page, pictures) = (folder.join("page.html"), folder.join("pictures"));
    identify(ROBOT, &example("train.csv.gz"), &["--report", text(&page), "--svg", text(&pictures)]).ok();
    let text = std::fs::read_to_string(&page).unwrap();
    for words in [
        "drive of right_knee_pitch: spring_stiffness",
        "right_foot.Ixx",
        "\"label\":\"identified\"",
        "std. error",
    ] {
        assert!(text.contains(words), "no {words}");
    }
    let picture = std::fs::read_to_string(pictures.join("right_knee_pitch.svg")).unwrap();
    assert!(picture.contains("measured − identified"), "{picture}");
}

/// The whole answer is in the documentation.
#[test]
fn every_key_is_documented() {
    let answer =
        identify(ROBOT, &example("train.csv.gz"), &["--validate", text(&example("validation.csv.gz"))])
            .ok()
            .json();
    let docs = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/identification.md"))
        .unwrap();
    let mut missing = Vec::new();
    let mut open = vec![answer["drives"].clone()];
    while let Some(value) = open.pop() {
        match value {
            serde_json::Value::Object(map) => {
                for (key, value) in map {
                    if !docs.contains(&format!("`{key}`")) {
                        missing.push(key);
                    }
                    open.push(value);
                }
            }
            serde_json::Value::Array(list) => open.extend(list),
            _ => {}
        }
    }
    missing.sort();
    missing.dedup();
    assert!(missing.is_empty(), "not in docs/identification.md: {missing:?}");
}
