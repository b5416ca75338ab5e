//! `bipedc log`: what it tells of logs, and that what it proposes is right.
use crate::cli;

use cli::{bipedc, scratch, text};
use flate2::read::GzDecoder;
use serde_json::Value;
use std::fmt::Write as _;
use std::io::Read;
use std::path::{Path, PathBuf};

const LOG: &str = "tests/data/examples/coulomb/validation.csv.gz";

/// A log as rows of texts, the names first.
fn table(path: &str) -> Vec<Vec<String>> {
    let mut text = String::new();
    GzDecoder::new(std::fs::File::open(path).unwrap()).read_to_string(&mut text).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn write_table(path: &Path, rows: &[Vec<String>]) {
    let lines: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    std::fs::write(path, lines.join("\n") + "\n").unwrap();
}

/// The rows of a comparison as JSON.
fn channels(log: &str, more: &[&str]) -> Value {
    let compare = ["compare", "robots/tulip", log, "--cutoff", "16", "--json"];
    bipedc(&[&compare[..], more].concat()).ok().json()["channels"].clone()
}

/// A name of ours as others write it.
type Rename<'a> = &'a dyn Fn(&str) -> String;

/// What the names become, and the mapping that `bipedc log` proposes for them.
fn renamed(folder: &str, rename: Rename<'_>) -> (PathBuf, PathBuf) {
    let folder = scratch(folder);
    let (log, mapping) = (folder.join("log.csv"), folder.join("columns.toml"));
    let mut rows = table(LOG);
    rows[0] = rows[0].iter().map(|name| rename(name)).collect();
    write_table(&log, &rows);
    bipedc(&["log", text(&log), "--robot", "robots/tulip", "--out", text(&mapping)]).ok();
    (log, mapping)
}

#[test]
fn a_log_is_told() {
    let run = bipedc(&["log", LOG, "--robot", "robots/tulip"]).ok();
    for words in [
        "a log over time, 2501 rows, 37 columns",
        "time: 10 s (0 s to 10 s), in column `time`",
        "sampling: 250 Hz (median step 0.004 s; all steps within 1 % of it)",
        "gaps: none",
        "time stamps: all increase",
        "\nleft_knee_pitch/effort      understood  N m",
        "position: 12 of 12",
        "effort: 12 of 12",
    ] {
        assert!(run.out.contains(words), "no `{words}` in:\n{}", run.out);
    }
    assert!(!run.out.contains("mapping") && run.err.is_empty(), "{}{}", run.out, run.err);
    let json = bipedc(&["log", LOG, "--robot", "robots/tulip", "--json"]).ok().json();
    let keys: Vec<&String> = json.as_object().unwrap().keys().collect();
    let expected =
        ["columns", "file", "has_header", "kind", "proposal", "robot", "rows", "sampling", "warnings"];
    assert_eq!(keys, expected);
    let help = bipedc(&["log", "--help"]).ok().out;
    for value in [&json, &json["sampling"], &json["columns"][0], &json["robot"], &json["proposal"]] {
        for key in value.as_object().unwrap().keys() {
            assert!(help.contains(&format!("\"{key}\"")), "`{key}` is not in the help");
        }
    }
    let postures = bipedc(&["log", "tests/data/examples/postures/train.csv.gz"]).ok().out;
    assert!(postures.contains("a table of postures") && !postures.contains("sampling"), "{postures}");
}

/// With the mapping that is proposed a log of other names is compared as one of ours.
#[test]
fn proposed_mappings_are_right() {
    let expected = channels(LOG, &[]);
    let joints: Vec<String> =
        expected.as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap().to_owned()).collect();
    let number = |joint: &str| joints.iter().position(|other| other == joint).unwrap();
    let split = |name: &str| name.rsplit_once('/').map(|(joint, what)| (joint.to_owned(), what.to_owned()));
    let plotjuggler = |name: &str| match split(name) {
        Some(_) => format!("/joint_states/{name}"),
        None => "__time".to_owned(),
    };
    let arrays = |name: &str| match split(name) {
        Some((joint, what)) => format!("/joint_states/{what}[{}]", number(&joint)),
        None => "/joint_states/header/stamp".to_owned(),
    };
    let letters = |name: &str| match split(name) {
        Some((joint, what)) => {
            let letter = [("position", "q"), ("velocity", "qd"), ("effort", "tau")];
            let (_, letter) = letter.iter().find(|(long, _)| *long == what).unwrap();
            format!("{letter}_{}", 1 + number(&joint))
        }
        None => "t".to_owned(),
    };
    let camel = |name: &str| match split(name) {
        Some((joint, what)) => {
            let (side, rest) = joint.split_once('_').unwrap();
            let parts = rest.split('_').map(|part| part[..1].to_uppercase() + &part[1..]);
            format!("{}{}.{}", side[..1].to_uppercase(), parts.collect::<String>(), &what[..3])
        }
        None => "timestamp".to_owned(),
    };
    // `eff` is no word that anybody uses.
    let camel = |name: &str| camel(name).replace(".eff", ".torque");
    let styles: [(&str, Rename<'_>); 4] =
        [("plotjuggler", &plotjuggler), ("arrays", &arrays), ("letters", &letters), ("camel", &camel)];
    for (style, rename) in styles {
        let (log, mapping) = renamed(&format!("log_{style}"), rename);
        let found = channels(text(&log), &["--mapping", text(&mapping)]);
        assert_eq!(found, expected, "{style}\n{}", std::fs::read_to_string(&mapping).unwrap());
        // Without the mapping nothing of it is understood; with it nothing more is proposed.
        bipedc(&["compare", "robots/tulip", text(&log)]).fails_with(&["log.csv:1", "`bipedc log"]);
        let again = ["log", text(&log), "--robot", "robots/tulip", "--mapping", text(&mapping), "--json"];
        assert_eq!(bipedc(&again).ok().json()["proposal"]["entries"], Value::Array(Vec::new()), "{style}");
        let mapping = std::fs::read_to_string(&mapping).unwrap();
        let assumes = mapping.contains("# To be checked");
        assert_eq!(assumes, matches!(style, "arrays" | "letters"), "{mapping}");
    }
}

/// Commands take one mapping file: what is proposed beside one that was given holds both.
#[test]
fn a_mapping_that_was_given_is_part_of_what_is_proposed() {
    let plotjuggler = |name: &str| match name.contains('/') {
        true => format!("/joint_states/{name}"),
        false => "__time".to_owned(),
    };
    let (log, whole) = renamed("log_merged", &plotjuggler);
    let (part, both) = (log.with_file_name("part.toml"), log.with_file_name("both.toml"));
    let pattern = "time = \"__time\"\n\"{joint}/position\" = \"/joint_states/{joint}/position\"\n";
    std::fs::write(&part, pattern).unwrap();
    let told = bipedc(&["log", text(&log), "--robot", "robots/tulip", "--mapping", text(&part)]).ok();
    assert!(told.out.contains("As part.toml says") && told.out.contains("time = \"__time\""), "{}", told.out);
    let given = ["--mapping", text(&part), "--out", text(&both)];
    bipedc(&[&["log", text(&log), "--robot", "robots/tulip"], &given[..]].concat()).ok();
    let expected = channels(text(&log), &["--mapping", text(&whole)]);
    assert_eq!(channels(text(&log), &["--mapping", text(&both)]), expected);
}

/// Degrees, milliampere, milliseconds: what names and steps say of units is in the mapping.
#[test]
fn units_are_mapped() {
    let folder = scratch("log_units");
    let (log, mapping) = (folder.join("log.csv"), folder.join("columns.toml"));
    let mut rows = table(LOG);
    let names = rows[0].clone();
    rows[0] = names
        .iter()
        .map(|name| match name.strip_suffix("/position") {
            Some(joint) => format!("{joint}_pos_deg"),
            None if name == "time" => "t_ms".to_owned(),
            None => name.replace("/effort", " torque [mNm]").replace('/', "."),
        })
        .collect();
    for row in &mut rows[1..] {
        for (field, name) in row.iter_mut().zip(&names) {
            let value: f64 = field.parse().unwrap();
            let factor = match name.rsplit('/').next().unwrap() {
                "time" | "effort" => 1000.0,
                "position" => 180.0 / std::f64::consts::PI,
                _ => 1.0,
            };
            *field = (factor * value).to_string();
        }
    }
    write_table(&log, &rows);
    bipedc(&["log", text(&log), "--robot", "robots/tulip", "--out", text(&mapping)]).ok();
    let (found, expected) = (channels(text(&log), &["--mapping", text(&mapping)]), channels(LOG, &[]));
    for (found, expected) in found.as_array().unwrap().iter().zip(expected.as_array().unwrap()) {
        let [found, expected] = [found, expected].map(|channel| channel["rms"].as_f64().unwrap());
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }
    let mapping = std::fs::read_to_string(&mapping).unwrap();
    assert!(mapping.contains("time = { column = \"t_ms\", scale = 0.001 } # ms"), "{mapping}");
}

/// Joint states as `ros2 topic echo --csv` prints them: names within the rows, seconds and nanoseconds apart.
#[test]
fn joint_states_without_a_header_are_written_with_one() {
    let folder = scratch("log_joint_states");
    let (echo, out) = (folder.join("echo.csv"), folder.join("log.csv"));
    let rows = table(LOG);
    // As a broadcaster orders them: by the alphabet.
    let mut joints: Vec<&str> = rows[0].iter().filter_map(|name| name.strip_suffix("/position")).collect();
    joints.sort_unstable();
    let column = |name: String| rows[0].iter().position(|other| *other == name).unwrap();
    let mut lines = String::new();
    for row in &rows[1..] {
        let nanoseconds = (1e9 * row[0].parse::<f64>().unwrap()).round() as u64;
        write!(lines, "{},{},", 1_700_000_000 + nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000)
            .unwrap();
        let mut put = |text: &str| write!(lines, ",{text}").unwrap();
        joints.iter().for_each(|joint| put(joint));
        joints.iter().for_each(|joint| put(&row[column(format!("{joint}/position"))]));
        // No velocities: one empty field.
        put("");
        joints.iter().for_each(|joint| put(&row[column(format!("{joint}/effort"))]));
        lines.push('\n');
    }
    std::fs::write(&echo, &lines).unwrap();
    let told = bipedc(&["log", text(&echo), "--robot", "robots/tulip", "--csv", text(&out)]).ok();
    assert!(
        told.out.contains("no header row: joint states") && told.out.contains("effort: 12 of 12"),
        "{}",
        told.out
    );
    assert!(told.err.contains("25 columns, 2501 rows"), "{}", told.err);
    assert_eq!(channels(text(&out), &[]), channels(LOG, &[]));
    // Another publisher's message in between is not mixed in.
    let mut mixed: Vec<&str> = lines.lines().collect();
    mixed.insert(100, "1700000000,5,,wheel,1,2,3");
    std::fs::write(&echo, mixed.join("\n")).unwrap();
    let told = bipedc(&["log", text(&echo), "--csv", text(&out)]).ok();
    assert!(
        told.err.contains("echo.csv:101") && told.err.contains("2501 rows; 1 rows left out"),
        "{}",
        told.err
    );
    // A row that comes late stays, and is sorted in by whoever reads it.
    let mut late: Vec<&str> = lines.lines().collect();
    let row = late.remove(100);
    late.insert(103, row);
    std::fs::write(&echo, late.join("\n")).unwrap();
    let told = bipedc(&["log", text(&echo), "--robot", "robots/tulip", "--csv", text(&out)]).ok();
    assert!(told.err.contains("25 columns, 2501 rows\n"), "{}", told.err);
    assert_eq!(channels(text(&out), &[]), channels(LOG, &[]));
    let mapping = folder.join("columns.toml");
    let refused = ["log", text(&echo), "--robot", "robots/tulip", "--out", text(&mapping)];
    bipedc(&refused).fails_with(&["no header row", "--csv"]);
}

/// What is wrong with a log is told with line numbers, all of it at once.
#[test]
fn odd_logs_are_told() {
    let folder = scratch("log_odd");
    let log = folder.join("log.csv");
    let mut lines = String::from("time,hip/position,hip/effort,note,spare,left_sole/force/z\n");
    for k in 0..200 {
        let time = match k {
            50 => 0.49, // as the row before
            60 => 0.30, // back
            100.. => 1.0 + 0.01 * f64::from(k),
            _ => 0.01 * f64::from(k),
        };
        let effort = if k == 70 { "NaN".to_owned() } else { format!("{}", k % 7) };
        let note = if k == 5 { "start" } else { "" };
        writeln!(
            lines,
            "{time:.4},{},{effort},{note},3,{}",
            0.1 * f64::from(k),
            if k == 8 { "1e15" } else { "9" }
        )
        .unwrap();
    }
    lines += "9,1\n";
    std::fs::write(&log, lines).unwrap();
    let run = bipedc(&["log", text(&log), "--robot", "robots/three_link"]).ok();
    for words in [
        "gaps: 2 of more than 3.5 steps, the longest 1.01 s, from 0.99 s on (line 102)",
        "1 doubled, first in line 52; 1 running back, first in line 62",
        "1 missing, first in line 72",
        "swings through 19.9 rad: degrees?",
        "never changes",
        "1 no usable numbers, first `start` in line 7",
        "1 no usable numbers, first `1e15` in line 10",
        "not understood",
        "no column is of any of them",
        "the robot has no `hip`",
        "the robot has no `left_sole`: did you mean `left_foot`?",
    ] {
        assert!(run.out.contains(words), "no `{words}` in:\n{}", run.out);
    }
    for words in ["log.csv:52", "log.csv:62", "log.csv:202", "another number of fields"] {
        assert!(run.err.contains(words), "no `{words}` in:\n{}", run.err);
    }
}

#[test]
fn what_is_no_log_is_refused() {
    let folder = scratch("log_refused");
    let log = folder.join("log.csv");
    let refused = |content: &[u8], words: &[&str]| {
        std::fs::write(&log, content).unwrap();
        bipedc(&["log", text(&log)]).fails_with(&[&["log.csv"], words].concat());
    };
    refused(b"", &["the file is empty"]);
    refused(b"time,a/position\n", &[":1", "a header but no rows"]);
    refused(b"time,a/position\n0,1\n", &[":2", "only one row"]);
    refused(b"\x89MCAP0\r\n", &["an MCAP file"]);
    refused(b"time,\xff\xfe\n", &[":1", "not UTF-8"]);
    refused(b"time;a/position\n0;1\n", &[":1", "semicolons"]);
    refused(b"time,a,a\n0,1,2\n", &[":1:8", "appears twice"]);
    refused(b"0,1,2\n1,2,3\n", &[":1", "no header row", "ros2 topic echo"]);
    refused(b"time,a\n0,\"1\n", &[":2", "quotation mark"]);
    refused(&[b'x'; 2 << 20], &["longer than"]);
    bipedc(&["log", text(&folder)]).fails_with(&["cannot read"]);
    bipedc(&["log", "nowhere.csv"]).fails_with(&["nowhere.csv"]);
    std::fs::write(&log, "time,a\n0,1\n0.1,2\n").unwrap();
    let (mapping, out) = (folder.join("m.toml"), folder.join("o.csv"));
    let (mapping, out) = (text(&mapping), text(&out));
    bipedc(&["log", text(&log), "--csv", text(&log)]).fails_with(&["--csv would overwrite the log"]);
    bipedc(&["log", text(&log), "--csv", out]).fails_with(&["no column", "--robot"]);
    let nothing = ["log", text(&log), "--robot", "robots/three_link", "--out", mapping];
    bipedc(&nothing).fails_with(&["nothing to propose"]);
    assert!(!Path::new(mapping).exists() && !Path::new(out).exists());
    std::fs::write(mapping, "\n\"a/position\" = \"b\"\n").unwrap();
    bipedc(&["log", text(&log), "--mapping", mapping]).fails_with(&["m.toml:2", "no column `b`"]);
}

/// What the library says is what the command prints.
#[test]
fn the_library_says_the_same() {
    let bench = bipedc::Workbench::open("robots/tulip").unwrap();
    let found = bench.inventory(LOG, &bipedc_analysis::log::Mapping::default()).unwrap();
    let printed = bipedc(&["log", LOG, "--robot", "robots/tulip"]).ok().out;
    assert_eq!(found.to_string(), printed);
    let json = bipedc(&["log", LOG, "--robot", "robots/tulip", "--json"]).ok().json();
    assert_eq!(serde_json::to_value(&found).unwrap(), json);
}
