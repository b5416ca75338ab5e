//! Rows that are late or stand twice are put right; a clock that runs back is not.
use crate::logs::support::reader;
use bipedc_analysis::log::{REACH, Reader, Repairs, Table};
use std::fmt::Write;

/// Time stamps as rows, with a value that is that of the time.
fn text(times: impl IntoIterator<Item = usize>) -> String {
    times.into_iter().fold("time,knee/position,knee/effort\n".to_owned(), |mut text, k| {
        writeln!(text, "{},{},{}", k as f64 * 0.004, (k as f64 * 0.01).sin(), k).unwrap();
        text
    })
}

/// Efforts and lines as they are read, what was put right, and all errors.
fn read(text: &str) -> Result<(Vec<usize>, Vec<usize>, Repairs), Vec<String>> {
    let mut reader: Reader = reader(text).unwrap();
    reader.select(&["knee/position", "knee/effort"]);
    let (mut efforts, mut lines, mut row) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        match reader.next_row(&mut row) {
            Ok(Some(found)) => {
                efforts.push(row[2] as usize);
                lines.push(found.line);
            }
            Ok(None) => return Ok((efforts, lines, reader.repairs())),
            Err(errors) => return Err(errors.0.iter().map(ToString::to_string).collect()),
        }
    }
}

#[test]
fn neighbours_that_were_swapped_are_sorted() {
    let mut times: Vec<usize> = (0..1000).collect();
    (1..10).for_each(|k| times.swap(100 * k, 100 * k + 1));
    let (efforts, lines, repairs) = read(&text(times)).unwrap();
    assert!(efforts.iter().copied().eq(0..1000));
    assert_eq!((lines[99], lines[100], lines[101]), (101, 103, 102));
    assert_eq!(repairs, Repairs { late: (9, 103), doubled: (0, 0) });
}

#[test]
fn a_packet_that_comes_late_is_sorted_in() {
    let times = (0..300).chain(320..340).chain(300..320).chain(340..600);
    let (efforts, _, repairs) = read(&text(times)).unwrap();
    assert!(efforts.iter().copied().eq(0..600));
    assert_eq!(repairs.late, (20, 322));
}

#[test]
fn rows_that_stand_twice_are_left_out() {
    // Each hundredth row again, and a stretch that was written twice.
    let rows = (0..1000).flat_map(|k| vec![k; if k % 100 == 50 { 2 } else { 1 }]);
    let (efforts, _, repairs) = read(&text(rows)).unwrap();
    assert!(efforts.iter().copied().eq(0..1000));
    assert_eq!(repairs, Repairs { late: (0, 0), doubled: (10, 53) });
    let (efforts, _, repairs) = read(&text((0..400).chain(350..700))).unwrap();
    assert!(efforts.iter().copied().eq(0..700));
    assert_eq!(repairs.doubled, (50, 402));
}

#[test]
fn halves_of_a_row_make_one() {
    let halves = "time,knee/position,knee/effort\n0,1,\n0,,5\n0.004,,6\n0.004,2,\n0.008,3,7\n";
    let table = Table::read(reader(halves).unwrap(), &["knee/position", "knee/effort"]).unwrap();
    assert_eq!(table.columns, [[0.0, 0.004, 0.008], [1.0, 2.0, 3.0], [5.0, 6.0, 7.0]]);
}

#[test]
fn a_clock_that_runs_back_is_one_error() {
    let one = |times: Vec<usize>, line: &str| {
        let errors = read(&text(times)).expect_err(line);
        assert_eq!(errors.len(), 1, "{errors:?}");
        assert!(errors[0].contains("time runs back from") && errors[0].contains(line), "{errors:?}");
    };
    let again = |first: usize, from: usize| (0..first).chain(from..1000).collect::<Vec<_>>();
    // Far, by no more rows than wait, and soon after the log begins; other numbers at the same times.
    one(again(500, 0).into_iter().map(|k| k + 7).collect(), "log.csv:502:1");
    one((0..500).map(|k| 2 * k).chain((485..2000).map(|k| 2 * k + 1)).collect(), "log.csv:502");
    one((5000..5003).chain(0..1000).collect(), "log.csv:5");
    let mut swapped = again(500, 200);
    (1..4).for_each(|k| swapped.swap(100 * k, 100 * k + 1));
    one(swapped, "log.csv:502");
    const { assert!(REACH < 100) };
}

#[test]
fn a_clock_that_is_too_coarse_is_one_error() {
    let mut coarse = String::from("time,knee/position,knee/effort\n");
    (0..1000).for_each(|k| writeln!(coarse, "{},{k},1", k / 100).unwrap());
    let errors = read(&coarse).unwrap_err();
    assert!(errors.len() == 1 && errors[0].contains("time stands still at 0 s"), "{errors:?}");
}
