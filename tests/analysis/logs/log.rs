//! A log that is read several times: the file is read again only for what is not known of it.
use bipedc_analysis::log::{Log, Mapping, Reader, Table};
use std::path::{Path, PathBuf};

/// Rows with holes, blank lines between them.
const TEXT: &str =
    "time,knee/position,left_foot/cop/x,knee/effort\n0,1,,5\n\n0.1,2,0.5,\n0.2,nan,,7\n0.3,4,0.25,8\n";

fn written(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// Everything that a pass over some columns tells, the digits of all numbers too.
fn told(mut reader: Reader, columns: &[&str]) -> String {
    reader.select(columns);
    let (mut text, mut values) = (String::new(), Vec::new());
    while let Some(row) = reader.next_row(&mut values).unwrap() {
        text += &format!("{row:?} {values:?} {}\n", reader.rows());
    }
    text + &format!("{} {:?}", reader.rows(), reader.incomplete())
}

#[test]
fn rows_that_were_kept_are_those_of_the_file() {
    let path = written("kept.csv", TEXT);
    let log = Log::open(&path).unwrap();
    let all = ["knee/effort", "left_foot/cop/x", "knee/position"];
    for columns in [&all[..], &all[..], &all[..2], &[], &all[..]] {
        let fresh = told(Reader::open(&path, &Mapping::default()).unwrap(), columns);
        for pass in [log.rows(), log.clone().rows()] {
            assert_eq!(told(pass, columns), fresh);
        }
    }
}

#[test]
fn what_was_read_to_the_end_needs_no_file() {
    let path = written("gone.csv", TEXT);
    let log = Log::open(&path).unwrap();
    let first = told(log.rows(), &["knee/effort"]);
    std::fs::remove_file(&path).unwrap();
    assert_eq!(told(log.rows(), &["knee/effort"]), first);
    // FNV-1a of all bytes, as computed here.
    let hash = TEXT.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    assert_eq!(log.source().unwrap().hash, format!("{hash:016x}"));
    let mut other = log.rows();
    other.select(&["knee/position"]);
    let error = other.next_row(&mut Vec::new()).unwrap_err().to_string();
    assert!(error.contains("cannot read the file"), "{error}");
}

#[test]
fn a_pass_that_ends_early_keeps_nothing() {
    let path = written("early.csv", TEXT);
    let log = Log::open(&path).unwrap();
    let mut values = Vec::new();
    assert!(log.rows().next_row(&mut values).unwrap().is_some());
    std::fs::write(&path, TEXT.replace("0.3,4", "0.3,9")).unwrap();
    let position = |log: &Log| Table::read(log.rows(), &["knee/position"]).unwrap().columns[1][2];
    assert_eq!((position(&log), position(&Log::open(&path).unwrap())), (9.0, 9.0));
}

#[test]
fn other_columns_can_be_chosen_on_the_way() {
    let log = Log::open(written("on_the_way.csv", TEXT)).unwrap();
    let mut values = Vec::new();
    for _ in 0..2 {
        let mut reader = log.rows();
        reader.select(&["left_foot/cop/x"]);
        assert_eq!(reader.next_row(&mut values).unwrap().unwrap().line, 2);
        reader.select(&["knee/position"]);
        assert_eq!((reader.next_row(&mut values).unwrap().unwrap().line, &values[..]), (4, &[0.1, 2.0][..]));
        told(log.rows(), &["left_foot/cop/x"]);
    }
}

#[test]
fn bad_rows_are_told_every_time() {
    let log = Log::open(written("bad.csv", &(TEXT.to_owned() + "0.4,x,,1\n"))).unwrap();
    let why = || {
        let error = Table::read(log.rows(), &["knee/position"]).unwrap_err();
        (error.0[0].position, error.to_string())
    };
    assert_eq!(why(), why());
    assert_eq!(why().0, Some((7, 5)));
}

#[test]
fn a_file_whose_columns_change_meanwhile_is_refused() {
    let path = written("changed.csv", TEXT);
    let log = Log::open(&path).unwrap();
    std::fs::write(&path, TEXT.replace("knee/position", "hip/position")).unwrap();
    let error = Table::read(log.rows(), &["knee/position"]).unwrap_err().to_string();
    assert!(error.contains("have changed since it was opened") && error.contains("changed.csv"), "{error}");
}
