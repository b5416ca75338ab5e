//! Mapping files: other names, factors, signs, frames.
use bipedc_analysis::log::{ForceFrame, Mapping, Reader, Table};
use std::io::Cursor;
use std::path::Path;

fn parse(text: &str) -> Result<Mapping, String> {
    Mapping::parse(Path::new("map.toml"), text).map_err(|e| e.to_string())
}

fn open(log: &str, mapping: &str) -> Result<Reader, String> {
    let source = Box::new(Cursor::new(log.to_owned().into_bytes()));
    Reader::from_source(Path::new("log.csv"), source, &parse(mapping).unwrap()).map_err(|e| e.to_string())
}

#[test]
fn names_factors_and_signs() {
    let mapping = r#"
time = "header/stamp"
"left_knee/position" = { column = "joint_states/KneeL/pos", scale = 0.5, offset = 0.25, sign = -1 }
"left_knee/effort" = { scale = 2 }
"left_foot/force" = { frame = "sole" }
"#;
    let log = "n,joint_states/KneeL/pos,left_knee/effort,header/stamp\n7,3,4,0.1\n7,5,6,0.2\n";
    let reader = open(log, mapping).unwrap();
    assert!(!reader.has("joint_states/KneeL/position") && reader.has("left_knee/position"));
    let table = Table::read(reader, &["left_knee/position", "left_knee/effort"]).unwrap();
    assert_eq!(table.columns, [vec![0.1, 0.2], vec![-1.25, -2.25], vec![8.0, 12.0]]);
    assert_eq!(parse(mapping).unwrap().frames["left_foot/force"], ForceFrame::Sole);
}

#[test]
fn a_column_that_the_log_does_not_have() {
    let error = open("time,KneeL/pos\n0,1\n", "\n\"left_knee/position\" = \"KneeL/ps\"\n").err().unwrap();
    assert!(error.contains("the log has no column `KneeL/ps`") && error.contains("map.toml:2:24"), "{error}");
    assert!(error.contains("did you mean `KneeL/pos`?"), "{error}");
}

#[test]
fn mistakes_in_the_file() {
    let wrong = |text: &str, parts: &[&str]| {
        let error = parse(text).unwrap_err();
        println!("{error}\n");
        for part in parts {
            assert!(error.contains(part), "`{part}` is not in:\n{error}");
        }
    };
    wrong("a = = 1", &["map.toml:1:5", "error: "]);
    wrong(
        "\n\"k/positon\" = \"a\"",
        &["map.toml:2:15", "`k/positon` is no column", "did you mean `k/position`?"],
    );
    wrong("\"k/position\" = { colum = \"a\" }", &["unknown key `colum`", "did you mean `column`?"]);
    wrong("\"k/position\" = { column = 3 }", &["expected a column name or { column"]);
    wrong("\"k/position\" = 3", &["`k/position`: expected a column name"]);
    wrong("\"k/position\" = { sign = 2 }", &["sign is 2, expected 1 or -1"]);
    wrong("\"k/position\" = { scale = 0 }", &["scale 0 and offset 0 have no meaning"]);
    wrong("\"k/position\" = { scale = nan }", &["scale NaN"]);
    wrong("\"k/position\" = { frame = \"sole\" }", &["only the force or torque of a foot has a frame"]);
    wrong("\"f/force\" = { frame = \"body\" }", &["frame is \"world\" or \"sole\""]);
    wrong("\"k/position\" = { sign = 2 }\n\"k/effort\" = { scale = 0 }", &["sign is 2", "scale 0"]);
    let missing = Mapping::open(Path::new("/no/such/map.toml")).unwrap_err().to_string();
    assert!(missing.contains("cannot read the mapping file") && missing.contains("/no/such/map.toml"));
}

#[test]
fn one_line_for_all_joints() {
    let mapping = r#"
time = "stamp"
"{joint}/position" = { column = "/states/{joint}/pos", scale = 0.5 }
"{joint}/effort" = "tau[{joint}]"
"knee/position" = "knee_by_hand"
"{foot}/force" = { frame = "sole" }
"{foot}/force/z" = "fz_{foot}"
"#;
    let log = "stamp,/states/hip/pos,/states/knee/pos,knee_by_hand,tau[knee],fz_left_foot,fz_right_foot\n0,2,3,4,5,6,7\n";
    let reader = open(log, mapping).unwrap();
    let names = ["hip/position", "knee/position", "knee/effort", "left_foot/force/z", "right_foot/force/z"];
    assert_eq!(reader.frame("left_foot/force"), ForceFrame::Sole);
    let table = Table::read(reader, &names).unwrap();
    // What has a line of its own keeps it.
    assert_eq!(table.columns, [vec![0.0], vec![1.0], vec![4.0], vec![5.0], vec![6.0], vec![7.0]]);
}

#[test]
fn patterns_that_stand_for_nothing() {
    let refused = |text: &str, part: &str| {
        let error = parse(text).unwrap_err();
        assert!(error.contains(part), "{text}: {error}");
    };
    refused("\"{joint}/position\" = \"pos\"", "`{joint}/position` = `pos` is no pattern");
    refused("\"knee/position\" = \"{joint}/pos\"", "is no pattern");
    refused("\"{joint}/position\" = \"{foot}/pos\"", "is no pattern");
    refused("\"{joint}/position\" = \"{joint}/{joint}\"", "is no pattern");
    refused("\"{joint}/positoin\" = \"{joint}/pos\"", "did you mean `{joint}/position`?");
    let error = open("time,a/pos\n0,1\n", "\n\"{joint}/effort\" = \"{joint}/tau\"\n").err().unwrap();
    assert!(error.contains("the log has no column like `{joint}/tau`"), "{error}");
    assert!(
        error.contains("map.toml:2:20") && error.contains("columns of the log: `time`, `a/pos`"),
        "{error}"
    );
}
