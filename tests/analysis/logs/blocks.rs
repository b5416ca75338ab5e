//! A log in blocks gives the result of the whole log; gaps cut it.
use crate::logs::support::reader;
use bipedc_analysis::log::{Blocks, Log, Sampling};
use bipedc_analysis::measure::{Options, Recording};
use bipedc_analysis::robot::{BaseKind, Joint, JointLayout};
use bipedc_analysis::signal::{Butterworth, Grid, Spline, TRUNCATION, resample};
use std::fmt::Write;
use std::path::Path;

const STEP: f64 = 0.004;

fn signal(t: f64) -> f64 {
    0.8 * (2.1 * t).sin() + 0.2 * (9.3 * t).cos() + 0.01 * (311.0 * t).sin() + 0.05 * t
}

/// A log of one joint, at `time(i)`.
fn log(rows: usize, time: impl Fn(usize) -> f64) -> String {
    let mut text = String::from("time,ignored,knee/position\n");
    for i in 0..rows {
        let t = time(i);
        writeln!(text, "{t},text,{}", signal(t)).unwrap();
    }
    text
}

fn blocks(text: &str, overlap: usize, trim: f64) -> Blocks {
    let mut reader = reader(text).unwrap();
    assert!(reader.select(&["knee/position"]).is_empty());
    Blocks::new(Sampling::probe(reader).unwrap(), overlap, trim)
}

/// Time and the derivatives at all core samples.
fn by_blocks(text: &str, filter: &Butterworth, step: f64) -> (Vec<(f64, [f64; 3])>, usize) {
    let mut blocks = blocks(text, filter.overlap() + 40, 0.5);
    let (mut result, mut count) = (Vec::new(), 0);
    while let Some(block) = blocks.next_block().unwrap() {
        count += 1;
        let last = block.time.len() - 1;
        let grid = Grid::covering(block.start, step, block.time[0], block.time[last]);
        let even = if block.uniform {
            block.columns[0].clone()
        } else {
            resample(block.time, &block.columns[0], grid)
        };
        let spline = Spline::new(&filter.zero_phase(&even), step).unwrap();
        for i in block.core.clone() {
            let t = block.time[i];
            result.push((t, if block.uniform { spline.at_sample(i) } else { spline.at(t - grid.start) }));
        }
    }
    (result, count)
}

fn assert_blocks_equal_whole(rows: usize, time: impl Fn(usize) -> f64, cutoff: f64) {
    let text = log(rows, &time);
    let times: Vec<f64> = (0..rows).map(&time).collect();
    let filter = Butterworth::new(cutoff, 1.0 / STEP).unwrap();
    let (pieces, count) = by_blocks(&text, &filter, STEP);
    assert!(count > 2, "{count} blocks do not test anything");
    let values: Vec<f64> = times.iter().map(|t| signal(*t)).collect();
    let grid = Grid::covering(0.0, STEP, times[0], times[rows - 1]);
    let whole = Spline::new(&filter.zero_phase(&resample(&times, &values, grid)), STEP).unwrap();
    let range =
        values.iter().fold(f64::MIN, |m, v| m.max(*v)) - values.iter().fold(f64::MAX, |m, v| m.min(*v));
    let expected: Vec<_> = times.iter().filter(|t| **t >= 0.499 && **t <= times[rows - 1] - 0.499).collect();
    assert_eq!(pieces.len(), expected.len(), "every sample belongs to one core");
    let rate = 2.0 * std::f64::consts::PI * cutoff;
    for ((t, found), expected_time) in pieces.iter().zip(expected) {
        assert_eq!(t, expected_time);
        let expected = whole.at(*t);
        // Rounding of the recursive filters and of the division by the step adds to the truncation.
        let bound = |k: i32| 4.0 * TRUNCATION * range * rate.powi(k) + 1e-12 * range / STEP.powi(k);
        for k in 0..3 {
            let error = (found[k] - expected[k]).abs();
            assert!(
                error < bound(k as i32),
                "derivative {k} at {t} s: {error:e}, bound {:e}",
                bound(k as i32)
            );
        }
    }
}

#[test]
fn blocks_equal_the_whole_log() {
    assert_blocks_equal_whole(50_000, |i| STEP * i as f64, 10.0);
    assert_blocks_equal_whole(50_000, |i| STEP * i as f64, 90.0);
}

#[test]
fn blocks_equal_the_whole_log_on_an_uneven_clock() {
    assert_blocks_equal_whole(50_000, |i| STEP * (i as f64 + 0.2 * (i as f64).sin()), 16.0);
}

#[test]
fn a_short_log_is_one_block() {
    let mut blocks = blocks(&log(4000, |i| STEP * i as f64), 300, 0.5);
    let block = blocks.next_block().unwrap().unwrap();
    assert!(block.uniform);
    assert_eq!((block.time.len(), block.core.clone()), (4000, 125..3875));
    assert!(blocks.next_block().unwrap().is_none());
    assert_eq!(blocks.report().segments, 1);
    assert!(blocks.report().warnings.is_empty());
}

#[test]
fn gaps_cut_the_log_and_are_reported() {
    // Lines 1002 and 1052 follow a pause of half a second and of two seconds.
    let time = |i: usize| {
        STEP * i as f64
            + if i >= 1050 {
                2.5
            } else if i >= 1000 {
                0.5
            } else {
                0.0
            }
    };
    let mut blocks = blocks(&log(3000, time), 300, 0.5);
    let mut cores = Vec::new();
    while let Some(block) = blocks.next_block().unwrap() {
        cores.push((block.time[block.core.start], block.time[block.core.end - 1], block.start));
    }
    assert_eq!(cores.len(), 2);
    assert!((cores[0].1 - (STEP * 999.0 - 0.5)).abs() < 1e-9);
    assert!((cores[1].0 - (time(1050) + 0.5)).abs() < 1e-9);
    let messages: Vec<String> = blocks.report().warnings.iter().map(ToString::to_string).collect();
    assert_eq!((blocks.report().gaps, blocks.report().segments, messages.len()), (2, 2, 3), "{messages:?}");
    assert!(
        messages[0].contains("gap of 0.5040 s") && messages[0].contains("log.csv:1002"),
        "{}",
        messages[0]
    );
    assert!(
        messages[1].contains("gap of 2.0040 s") && messages[1].contains("log.csv:1052"),
        "{}",
        messages[1]
    );
    assert!(
        messages[2].contains("50 samples") && messages[2].contains("too short a stretch"),
        "{}",
        messages[2]
    );
}

/// A simulation's first sample, in which feet sink in, would be spread over half a second by a filter.
#[test]
fn a_jolt_at_the_beginning_is_left_out() {
    let log = |first: f64| {
        let mut text = String::from("time,knee/position,knee/effort\n");
        for i in 0..500 {
            let t = f64::from(i) * STEP;
            let effort = if i == 1 { first } else { 9.0 * (3.0 * t).cos() };
            writeln!(text, "{t},{},{effort}", signal(t)).unwrap();
        }
        text
    };
    let read = |first: f64| {
        let mut reader = reader(log(first).as_str()).unwrap();
        assert!(reader.select(&["knee/position", "knee/effort"]).is_empty());
        let mut blocks = Blocks::new(Sampling::probe(reader).unwrap(), 0, 0.0);
        let begin = blocks.next_block().unwrap().unwrap().time[0];
        assert!(blocks.next_block().unwrap().is_none());
        (begin, blocks.report().warnings.iter().map(ToString::to_string).collect::<String>())
    };
    let (begin, said) = read(-2085.0);
    assert!((begin - 2.0 * STEP).abs() < 1e-12, "{begin}");
    assert!(said.contains("`knee/effort` is -2085 there") && said.contains("first 2 rows"), "{said}");
    // Large, but not beyond what a drive does once more.
    assert_eq!(read(40.0), (0.0, String::new()));
}

#[test]
fn two_lost_samples_are_no_gap() {
    let mut blocks = blocks(&log(2000, |i| STEP * (i + if i > 700 { 2 } else { 0 }) as f64), 300, 0.5);
    let block = blocks.next_block().unwrap().unwrap();
    assert!(!block.uniform);
    assert!(blocks.next_block().unwrap().is_none());
    assert_eq!((blocks.report().gaps, blocks.report().first_uneven), (0, Some(703)));
}

/// What is thinned while it is read is what is thinned afterwards, bit for bit, as long as the log is not very long.
#[test]
fn thinned_logs_are_logs_thinned() {
    let mut text = String::from("time,knee/position,knee/effort\n");
    for i in 0..40_000 {
        // Two gaps, so that stretches begin within blocks.
        let t = STEP * i as f64 + if i > 9000 { 3.0 } else { 0.0 } + if i > 30_000 { 1.0 } else { 0.0 };
        writeln!(text, "{t:.3},{:.6},{:.4}", signal(t), (7.7 * t).sin() + 1e-3 * ((i * i) % 97) as f64)
            .unwrap();
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("thinned.csv");
    std::fs::write(&path, text).unwrap();
    let layout = JointLayout { joints: vec![Joint::revolute("knee")], base: BaseKind::Fixed };
    let (log, options) = (Log::open(&path).unwrap(), Options::default());
    let mut whole = Recording::read(&log, &layout, &options).unwrap();
    whole.thin(1000);
    let thinned = Recording::read_thinned(&log, &layout, &options, 1000).unwrap();
    assert_eq!(thinned.segments.len(), 3);
    // `Debug` writes floating-point numbers with all their digits.
    assert_eq!(format!("{whole:?}"), format!("{thinned:?}"));
}
