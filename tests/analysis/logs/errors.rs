//! Every bad log has a message that names place, fault and remedy.
use crate::logs::support;
use crate::logs::support::reader;
use bipedc_analysis::compare::{Comparison, compare};
use bipedc_analysis::log::{Kind, LONGEST_LINE, MOST_ERRORS, Mapping, Reader, Table};
use bipedc_analysis::measure::Options;
use bipedc_analysis::robot::{BaseKind, Batch, EvaluationError, InverseDynamics, Joint, JointLayout};
use bipedc_effects::diagnostic::Diagnostics;
use flate2::{Compression, write::GzEncoder};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// Two joints whose efforts are their accelerations; that of the hip depends on the knee's, too.
pub struct Toy;

impl InverseDynamics for Toy {
    fn nq(&self) -> usize {
        2
    }
    fn nv(&self) -> usize {
        2
    }
    fn torques(&mut self, batch: &Batch<'_>, tau: &mut [f64]) -> Result<(), EvaluationError> {
        for (tau, a) in tau.chunks_exact_mut(2).zip(batch.a.chunks_exact(2)) {
            (tau[0], tau[1]) = (a[0] + a[1], a[1]);
        }
        Ok(())
    }
}

pub fn layout() -> JointLayout {
    JointLayout {
        joints: vec![Joint::revolute("left_hip"), Joint::revolute("left_knee")],
        base: BaseKind::Fixed,
    }
}

const HEADER: &str = "time,left_hip/position,left_hip/effort,left_knee/position,left_knee/effort";

fn log(header: &str, rows: usize) -> String {
    let mut text = format!("{header}\n");
    for i in 0..rows {
        writeln!(text, "{:.3},0.1,0.2,{},0.4", 0.004 * i as f64, 0.01 * (0.04 * i as f64).sin()).unwrap();
    }
    text
}

fn run(text: impl Into<Vec<u8>>) -> Result<Comparison, Diagnostics> {
    compare(&mut Toy, &layout(), reader(text)?, &Options::default())
}

/// All parts of the message must be there.
fn assert_error(text: impl Into<Vec<u8>>, parts: &[&str]) {
    let message = run(text).expect_err("an error").to_string();
    println!("{message}\n");
    for part in ["error: ", "log.csv", "help: "].iter().chain(parts) {
        assert!(message.contains(part), "`{part}` is not in:\n{message}");
    }
}

/// The log of 500 rows with one line replaced.
fn with_line(number: usize, line: &str) -> String {
    let text = log(HEADER, 500);
    let mut lines: Vec<&str> = text.lines().collect();
    lines[number - 1] = line;
    lines.join("\n")
}

#[test]
fn a_good_log() {
    let comparison = run(log(HEADER, 500)).unwrap();
    assert!(comparison.warnings.is_empty(), "{:?}", comparison.warnings);
    assert_eq!((comparison.channels.len(), comparison.samples), (2, 250));
}

#[test]
fn missing_file() {
    let error = Reader::open(Path::new("/no/such/log.csv"), &Mapping::default()).err().unwrap().to_string();
    assert!(error.contains("cannot read the file") && error.contains("/no/such/log.csv"), "{error}");
}

#[test]
fn empty_and_headless() {
    assert_error("", &["the file is empty"]);
    assert_error("\n\r\n", &["the file is empty"]);
    assert_error(HEADER, &["a header but no rows"]);
    assert_error("0.0,1,2\n0.1,1,2\n", &["log.csv:1:1", "no header row", "starts with the number 0.0"]);
    assert_error(log(HEADER, 1), &["log.csv:2", "only one row"]);
    assert_error(log(HEADER, 100), &["too short", "100 rows", "0.5 s"]);
    assert_error(log(HEADER, 3), &["too short"]);
}

#[test]
fn wrong_separators_and_kinds() {
    assert_error("time;a/position\n0;1\n", &["log.csv:1:1", "separated by semicolons, expected commas"]);
    assert_error("time\ta/position\n0\t1\n", &["separated by tabs"]);
    assert_error("stamp,left_hip/position\n0,1\n", &["first column is `stamp`", "time = \"stamp\""]);
    assert_error(
        "left_hip/position,time\n0,1\n",
        &["first column is `left_hip/position`", "move column `time`"],
    );
    assert_error("posture,left_hip/position\n0,1\n", &["needs a log", "`posture`"]);
}

#[test]
fn columns_missing_unknown_or_double() {
    assert_error(
        log("time,a/x,b/y,c/z,d", 500),
        &["no column is of a joint", "`a/x`", "joints of the robot: `left_hip`"],
    );
    let no_effort = log("time,left_hip/position,left_hip/x,left_knee/position,left_knee/y", 500);
    assert_error(no_effort, &["no joint of the robot has a column `<joint>/effort`"]);
    let no_position = log("time,left_hip/x,left_hip/effort,left_knee/y,left_knee/effort", 500);
    assert_error(no_position, &["no joint of the robot has a column `<joint>/position`"]);
    let double = "time,left_hip/position,left_hip/effort,left_hip/position\n0,1,2,3\n";
    assert_error(double, &["log.csv:1:40", "`left_hip/position` appears twice: as number 2 and 4"]);
}

#[test]
fn unknown_joints_are_a_warning() {
    let comparison =
        run(log("time,left_hip/position,left_hip/effort,left_kne/position,left_knee/effort", 500));
    // Without the knee's position nothing is left, as the hip's effort depends on it.
    let error = comparison.unwrap_err().to_string();
    assert!(error.contains("no joint can be compared") && error.contains("`left_knee`"), "{error}");
    let mut text = String::new();
    for (i, line) in log(HEADER, 500).lines().enumerate() {
        writeln!(text, "{line},{}", if i == 0 { "left_kne/velocity" } else { "x" }).unwrap();
    }
    let warnings = run(text).unwrap().warnings;
    let message = warnings[0].to_string();
    assert!(message.starts_with("warning: columns of `left_kne` are ignored"), "{message}");
    assert!(message.contains("log.csv:1") && message.contains("did you mean `left_knee`?"), "{message}");
    assert_eq!(warnings.len(), 1);
}

#[test]
fn a_missing_position_limits_what_is_compared() {
    let comparison =
        run(log("time,left_hip/x,left_hip/effort,left_knee/position,left_knee/effort", 500)).unwrap();
    assert_eq!(comparison.channels.len(), 1);
    assert_eq!(comparison.channels[0].name, "left_knee");
    assert_eq!(comparison.missing[0].name, "left_hip");
    assert!(comparison.missing[0].reason.contains("`left_hip`, which has no position column"));
    assert!(comparison.assumptions.iter().any(|a| a.contains("stand still at zero: `left_hip`")));
    let comparison =
        run(log("time,left_hip/position,left_hip/x,left_knee/position,left_knee/effort", 500)).unwrap();
    assert!(comparison.missing[0].reason.contains("no column `left_hip/effort`"));
    assert!(comparison.to_string().contains("not compared: left_hip: "));
}

#[test]
fn bad_numbers() {
    let line = "1.192,0.1,0.2,abc,0.4";
    assert_error(
        with_line(300, line),
        &["log.csv:300:15", "`left_knee/position`: expected a number, found `abc`"],
    );
    assert_error(with_line(300, "1.192,0.1,0.2,-inf,4"), &["log.csv:300:15", "infinite"]);
    assert_error(with_line(300, "1.192,0.1,0.2,1e999,4"), &["log.csv:300:15", "infinite or too large"]);
    assert_error(with_line(300, "x,0.1,0.2,0.3,0.4"), &["log.csv:300:1", "`time`: expected a number"]);
    assert_error(with_line(300, "1.192,0.1,0.2,\"3,0.4"), &["log.csv:300:15", "quotation mark"]);
    assert_error(
        with_line(300, "1,192,0,1,0,2,0,3,0,4"),
        &["log.csv:300", "the row has 10 fields, the header 5"],
    );
    assert_error(with_line(300, "1.192,0.1"), &["log.csv:300", "the row has 2 fields, the header 5"]);
}

/// Replaces fields of the lines `from..to` (numbers from 1).
fn with_hole(from: usize, to: usize, line: impl Fn(usize) -> String) -> String {
    let text = log(HEADER, 500);
    let lines = text
        .lines()
        .enumerate()
        .map(|(i, original)| if (from..to).contains(&(i + 1)) { line(i - 1) } else { original.to_owned() });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn missing_numbers_are_gaps_with_a_warning() {
    let messages = |text: String| {
        let comparison = run(text).unwrap();
        (comparison.samples, comparison.warnings.iter().map(ToString::to_string).collect::<Vec<_>>())
    };
    // One lost sample of an effort is bridged: the row alone does not count.
    let nan = |i: usize| format!("{:.3},0.1,0.2,{},nan", 0.004 * i as f64, 0.01 * (0.04 * i as f64).sin());
    let (samples, warnings) = messages(with_hole(300, 301, nan));
    assert_eq!(samples, 249);
    let of_effort = |m: &String| m.contains("`left_knee/effort` is empty or NaN in 1 of 500 rows");
    assert!(warnings.iter().any(|m| of_effort(m) && m.contains("log.csv:300")), "{warnings:?}");
    // A stretch of an empty position is a gap.
    let empty = |i: usize| format!("{:.3},0.1,0.2,,0.4", 0.004 * i as f64);
    let (_, warnings) = messages(with_hole(400, 420, empty));
    assert!(warnings.iter().any(|m| m.contains("gap of 0.0840 s")), "{warnings:?}");
    assert!(warnings.iter().any(|m| m.contains("`left_knee/position` is empty or NaN in 20 of 500")));
    // A column that was never recorded is named.
    assert_error(
        with_hole(2, 502, empty),
        &["no row of the log is complete", "`left_knee/position`", "500 of 500"],
    );
    // Tables have no gaps.
    let table = Table::read(support::reader("posture,a/position\n0,\n1,2\n").unwrap(), &["a/position"]);
    assert!(table.unwrap_err().to_string().contains("the field is empty"));
}

#[test]
fn many_errors_are_told_at_once_but_not_all() {
    let text = log(HEADER, 500).replace(",0.4", ",oops");
    let errors = run(text).unwrap_err().0;
    assert_eq!(errors.len(), bipedc_analysis::log::MOST_ERRORS);
    assert_eq!((errors[0].position.unwrap().0, errors[9].position.unwrap().0), (2, 11));
}

#[test]
fn time_that_does_not_run() {
    // Two rows of a time: one of them is left out.
    let warnings = run(with_line(300, "1.188,0.1,0.2,0.3,0.4")).unwrap().warnings;
    let message = warnings.iter().find(|w| w.message.contains("repeat the time")).unwrap().to_string();
    assert!(message.contains("1 of 500 rows") && message.contains("log.csv:300"), "{message}");
    assert_error(
        with_line(300, "0.5,0.1,0.2,0.3,0.4"),
        &["log.csv:300:1", "time runs back from 1.188 s to 0.5 s"],
    );
    assert_error(with_line(300, "nan,0.1,0.2,0.3,0.4"), &["log.csv:300:1", "`time`: the value is NaN"]);
    assert_error(with_line(300, "n/a,0.1,0.2,0.3,0.4"), &["log.csv:300:1", "`time`: expected a number"]);
}

#[test]
fn gaps_and_uneven_clocks_are_warnings() {
    let gap = log(HEADER, 500) + &log("", 500).replace("\n0.", "\n9.").replace("\n1.", "\n10.");
    let comparison = run(gap).unwrap();
    let messages: Vec<String> = comparison.warnings.iter().map(ToString::to_string).collect();
    assert!(
        messages.iter().any(|m| m.contains("gap of 7.0040 s") && m.contains("log.csv:503")),
        "{messages:?}"
    );
    assert_eq!(comparison.segments, 2);
    let mut uneven = String::from(HEADER);
    for i in 0..500 {
        let t = 0.004 * (f64::from(i) + 0.3 * f64::from(i * i % 5) / 5.0);
        write!(uneven, "\n{t:.6},0.1,0,0.1,0").unwrap();
    }
    let comparison = run(uneven).unwrap();
    let message = comparison.warnings[0].to_string();
    assert!(message.contains("the sampling is not even") && message.contains("log.csv:3"), "{message}");
    assert!(comparison.rms < 1e-6, "a constant stays constant: {}", comparison.rms);
}

#[test]
fn not_text() {
    assert_error(b"time,left_hip/p\xf6sition\n0,1\n".to_vec(), &["log.csv:1:16", "not UTF-8"]);
    let utf16: Vec<u8> = [0xff, 0xfe].into_iter().chain("time,a\n".bytes().flat_map(|b| [b, 0])).collect();
    assert_error(utf16, &["log.csv:1:1", "not UTF-8"]);
    assert_error(b"PK\x03\x04....".to_vec(), &["ZIP archive"]);
    assert_error(b"\x89MCAP0\r\n".to_vec(), &["MCAP"]);
    assert_error(vec![b'a'; LONGEST_LINE + 100], &["log.csv:1", "longer than 1048576 bytes"]);
    assert_error(
        with_line(300, &format!("1.192,{},0.2,0.3,0.4", "9x".repeat(1000))),
        &["log.csv:300:7", "..."],
    );
}

/// What a recorder leaves that lost its power, and what old programs wrote.
#[test]
fn bytes_that_are_no_text() {
    assert_error(log(HEADER, 500) + "\0\0\0\0", &["log.csv:502:1", "NUL bytes", "lose power"]);
    assert_error(with_line(300, "1.192,\0\0,0.2,0.3,0.4"), &["log.csv:300:7", "NUL bytes"]);
    assert_error(log(HEADER, 500) + &"\0".repeat(LONGEST_LINE + 100), &["log.csv:502:1", "NUL bytes"]);
    assert_error(log(HEADER, 500).replace('\n', "\r"), &["log.csv:1:75", "carriage return"]);
}

/// Small archives of much nothing: little memory, and a message soon.
#[test]
fn archives_of_nothing() {
    let packed = |head: &str, piece: &str, times: usize| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(head.as_bytes()).unwrap();
        (0..times).for_each(|_| encoder.write_all(piece.as_bytes()).unwrap());
        encoder.finish().unwrap()
    };
    let long = "1".repeat(1 << 16);
    assert_error(packed("", &long, 400), &["log.csv:1", "longer than 1048576 bytes", "is this a CSV file?"]);
    let many = "some/column,".repeat(1 << 12);
    assert_error(packed("time,", &many, 400), &["log.csv:1", "longer", "commas: keep `time`"]);
    let blank = "\n".repeat(1 << 16);
    let error = ["log.csv:1048579", "more than 1048576 blank lines in a row"];
    assert_error(packed("", &blank, 400), &["log.csv:1048577", error[1]]);
    assert_error(packed(&log(HEADER, 1), &blank, 400), &error);
}

/// One message for each of ten thousand equal names would help nobody.
#[test]
fn a_header_has_few_messages() {
    let text = format!("time{}\n0{}\n", ",x".repeat(10_000), ",0".repeat(10_000));
    let error = run(text).unwrap_err();
    assert_eq!(error.0.len(), MOST_ERRORS);
}

#[test]
fn marks_blanks_quotes_and_line_ends_do_not_matter() {
    let text = format!("\u{feff}{}", log(&HEADER.replace("left_hip/effort", " \"left_hip/effort\" "), 500));
    let crlf = text.replace('\n', "\r\n\r\n");
    assert_eq!(run(crlf).unwrap().channels, run(log(HEADER, 500)).unwrap().channels);
}

#[test]
fn gzip_whole_and_cut() {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(log(HEADER, 500).as_bytes()).unwrap();
    let bytes = encoder.finish().unwrap();
    assert_eq!(run(bytes.clone()).unwrap().samples, 250);
    assert_error(bytes[..bytes.len() / 2].to_vec(), &["cannot read the file", "copied completely"]);
    assert_error(bytes[..5].to_vec(), &["cannot read the file"]);
}

#[test]
fn senseless_options() {
    let run = |options: Options| compare(&mut Toy, &layout(), reader(log(HEADER, 500)).unwrap(), &options);
    let error = |options: Options| run(options).unwrap_err().to_string();
    let default = Options::default;
    assert!(
        error(Options { cutoff_hz: Some(125.0), ..default() })
            .contains("not below half the sampling rate of 250")
    );
    assert!(error(Options { cutoff_hz: Some(-1.0), ..default() }).contains("the cut-off of -1 Hz"));
    assert!(error(Options { cutoff_hz: Some(0.001), ..default() }).contains("ten-thousandth"));
    assert!(error(Options { trim_s: f64::NAN, ..default() }).contains("cannot be left out"));
    assert!(
        error(Options { from_s: Some(2.0), to_s: Some(1.0), ..default() }).contains("no time lies between")
    );
    assert!(
        error(Options { from_s: Some(50.0), ..default() })
            .contains("no sample of the log counts between 50 s and its end")
    );
    assert!(error(Options { candidates: vec![], ..default() }).contains("no cut-off"));
    let slow = run(Options { candidates: vec![10.0, 200.0], ..default() }).unwrap();
    assert!(slow.assumptions.iter().any(|a| a.contains("not tried") && a.contains("200 Hz")));
    let three = JointLayout { joints: vec![Joint::revolute("a"); 3], base: BaseKind::Planar };
    let error =
        compare(&mut Toy, &three, reader(log(HEADER, 500)).unwrap(), &default()).unwrap_err().to_string();
    assert!(error.contains("the model has nq 2 and nv 2, its base and 3 joints make 6 and 6"), "{error}");
}

#[test]
fn postures_and_impacts_are_read() {
    let example = |name: &str| support::repository(&format!("tests/data/examples/{name}/train.csv.gz"));
    let reader = Reader::open(&example("postures"), &Mapping::default()).unwrap();
    assert_eq!(reader.kind(), Kind::Posture);
    let postures = Table::read(reader, &["left_knee_pitch/position", "nothing", "cop/x"]).unwrap();
    assert_eq!((postures.rows(), postures.names.len()), (90, 3));
    assert_eq!(postures.column("posture").unwrap()[1], 1.0);
    assert!(postures.column("nothing").is_none());
    let reader = Reader::open(&example("impacts"), &Mapping::default()).unwrap();
    assert_eq!(reader.kind(), Kind::Impact);
    let impacts = Table::read(reader, &["base/linear_velocity/x/before"]).unwrap();
    assert_eq!((impacts.rows(), impacts.lines[59]), (60, 61));
}

#[test]
fn a_centre_of_pressure_may_be_absent() {
    let reader = support::reader("posture,foot/cop/x,cop/y\n0,,nan\n1,2,3\n").unwrap();
    let table = Table::read(reader, &["foot/cop/x", "cop/y"]).unwrap();
    assert!(table.columns[1][0].is_nan() && table.columns[2][0].is_nan());
    assert_eq!((table.columns[1][1], table.columns[2][1]), (2.0, 3.0));
}

/// One such sample took minutes and gigabytes in a diagnosis, and spoilt what it said.
#[test]
fn a_glitch_of_one_sample_is_named() {
    for value in ["10000", "-7.5", "1e9"] {
        let text = with_line(251, &format!("0.996,0.1,0.2,{value},0.4"));
        let number: f64 = value.parse().unwrap();
        assert_error(
            text,
            &["log.csv:251:15", "`left_knee/position` jumps from", &format!("to {number} for one sample")],
        );
    }
    assert_error(with_line(251, "0.996,0.1,0.2,1e150,0.4"), &["log.csv:251:15", "infinite or too large"]);
    let two = with_line(251, "0.996,0.1,0.2,1e4,0.4\n0.998,0.1,0.2,1e4,0.4");
    assert_error(two, &["log.csv:251:15", "for 2 samples"]);
}

/// What moves fast, wraps around or is noisy is no glitch.
#[test]
fn other_jumps_are_no_glitches() {
    assert!(run(with_line(251, "0.996,0.1,0.2,3.9,0.4")).is_ok());
    let mut wrapped = format!("{HEADER}\n");
    for i in 0..500 {
        let angle = (0.02 * f64::from(i) + 3.0).rem_euclid(std::f64::consts::TAU);
        writeln!(wrapped, "{:.3},0.1,0.2,{angle},0.4", 0.004 * f64::from(i)).unwrap();
    }
    assert!(run(wrapped).is_ok());
}
