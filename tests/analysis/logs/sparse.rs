//! A column that is empty costs its joint's effort, not the log; what exporters write for nothing counts as empty.
use crate::logs::errors::{Toy, layout};
use bipedc_analysis::compare::{Comparison, compare, compare_file};
use bipedc_analysis::log::{Log, Mapping, Reader};
use bipedc_analysis::measure::Options;
use bipedc_effects::diagnostic::Diagnostics;
use std::fmt::Write;
use std::io::Cursor;
use std::path::Path;

/// 500 rows, in which the fields behind the time are as `fields` says of a row's number.
fn text(header: &str, fields: impl Fn(usize) -> [String; 4]) -> String {
    (0..500).fold(format!("time,{header}\n"), |mut text, k| {
        writeln!(text, "{:.3},{}", 0.004 * k as f64, fields(k).join(",")).unwrap();
        text
    })
}

const HEADER: &str = "left_hip/position,left_hip/effort,left_knee/position,left_knee/effort";

/// The hip's and the knee's effort in each row, beside motions.
fn with_efforts(effort: impl Fn(usize) -> [&'static str; 2]) -> String {
    text(HEADER, |k| {
        let angle = format!("{}", 0.01 * (0.04 * k as f64).sin());
        let [hip, knee] = effort(k);
        [angle.clone(), hip.to_owned(), angle, knee.to_owned()]
    })
}

fn run(name: &str, text: &str) -> Result<Comparison, Diagnostics> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("sparse_{name}.csv"));
    std::fs::write(&path, text).unwrap();
    compare_file(&mut Toy, &layout(), &Log::open(&path).unwrap(), &Options::default())
}

fn channels(found: &Comparison) -> Vec<&str> {
    found.channels.iter().map(|channel| channel.name.as_str()).collect()
}

#[test]
fn an_empty_effort_is_left_out_with_a_word() {
    for nothing in ["", "nan", "n/a", "NULL", "None", "-", "NA"] {
        let found = run("whole", &with_efforts(|_| ["0.2", nothing])).unwrap();
        assert_eq!((channels(&found), found.samples), (vec!["left_hip"], 250), "{nothing}");
        assert_eq!(found.missing[0].reason, "`left_knee/effort` is empty in all 500 rows");
        let warnings: Vec<String> = found.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].contains("the effort of `left_knee` is left out"), "{warnings:?}");
    }
}

/// Of a joint whose own angle is logged: rows did not count without its motor's.
#[test]
fn an_empty_angle_of_a_motor_counts_as_not_logged() {
    let header = "left_hip/position,left_hip/effort,left_knee/position,left_knee/motor_position";
    let log = text(header, |k| {
        let angle = format!("{}", 0.01 * (0.04 * k as f64).sin());
        [angle.clone(), "0.2".to_owned(), angle, String::new()]
    });
    let found = run("motor", &log).unwrap();
    assert_eq!((channels(&found), found.samples), (vec!["left_hip"], 250));
    let warning = found.warnings[0].to_string();
    assert!(warning.contains("`left_knee/motor_position` is empty in all 500 rows"), "{warning}");
}

#[test]
fn a_half_empty_effort_leaves_the_others_their_samples() {
    let found = run("half", &with_efforts(|k| ["0.2", if k < 250 { "0.4" } else { "" }])).unwrap();
    assert_eq!((channels(&found), found.samples), (vec!["left_hip"], 250));
    let warning = found.warnings[0].to_string();
    assert!(warning.contains("empty in 250 of 500 rows") && warning.contains("half.csv:252"), "{warning}");
    // A few holes are holes of all.
    let found = run("holes", &with_efforts(|k| ["0.2", if k % 100 == 3 { "n/a" } else { "0.4" }])).unwrap();
    assert_eq!(channels(&found), ["left_hip", "left_knee"]);
    assert!(found.warnings.iter().any(|w| w.message.contains("empty or NaN in 5 of 500 rows")));
}

#[test]
fn rows_that_hold_one_joint_each_are_no_empty_columns() {
    let error = run("turns", &with_efforts(|k| if k % 2 == 0 { ["0.2", ""] } else { ["", "0.4"] }));
    let error = error.unwrap_err().to_string();
    assert!(error.contains("no row of the log is complete"), "{error}");
}

#[test]
fn text_is_still_an_error() {
    let error = run("text", &with_efforts(|_| ["0.2", "off"])).unwrap_err();
    assert!(error.to_string().contains("expected a number, found `off`"), "{error}");
}

/// The names of PlotJuggler, read by a pattern or line by line.
#[test]
fn columns_that_a_mapping_reads_are_not_ignored() {
    let mut header = HEADER.split(',').map(|name| format!("/js/{name}")).collect::<Vec<_>>().join(",");
    // Nobody reads it, and nobody asks for it.
    header.push_str(",/js/left_knee/velocity");
    let log = (0..500).fold(format!("time,{header}\n"), |mut text, k| {
        writeln!(text, "{:.3},{},0.2,0,0,0", 0.004 * k as f64, 0.01 * (0.04 * k as f64).sin()).unwrap();
        text
    });
    let pattern =
        "\"{joint}/position\" = \"/js/{joint}/position\"\n\"{joint}/effort\" = \"/js/{joint}/effort\"\n";
    let lines: String = HEADER.split(',').map(|name| format!("\"{name}\" = \"/js/{name}\"\n")).collect();
    let compared = |mapping: &str| {
        let mapping = Mapping::parse(Path::new("map.toml"), mapping).unwrap();
        let source = Box::new(Cursor::new(log.clone().into_bytes()));
        let reader = Reader::from_source(Path::new("log.csv"), source, &mapping).unwrap();
        compare(&mut Toy, &layout(), reader, &Options::default()).unwrap().warnings
    };
    for mapping in [pattern, &lines] {
        let warnings = compared(mapping);
        assert!(warnings.is_empty(), "{warnings:?}");
    }
    // A joint that is written wrongly is named where it stands.
    let warnings = compared(&format!("{pattern}\"left_kne/position\" = \"/js/left_knee/position\"\n"));
    let warning = warnings[0].to_string();
    assert!(warning.contains("`left_kne`") && warning.contains("map.toml:3:"), "{warning}");
    assert!(warning.contains("did you mean `left_knee`?") && warnings.len() == 1, "{warnings:?}");
}
