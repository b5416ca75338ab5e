//! Maps of which most cells are interpolated: of steps that formulas stand for, so that every cell is known, and of the robot with feet.
use super::{WALKER, phased, robot};
use crate::cli::{bipedc, scratch, text};
use bipedc::gait::{MapOptions, Over, Range};
use bipedc::progress::{Run, Silent};
use bipedc::simulation::walker;
use bipedc_analysis::gait::{Assumptions, Cell, Interpolation, MapRequest, Reason, Sparing, Watch};
use std::cell::{Cell as Shared, RefCell};
use std::sync::atomic::{AtomicUsize, Ordering};

const SPEED: f64 = 0.5;
const TOLERANCE: f64 = 1e-3;

/// Steps that fail in a band, fall back behind a curve, and have a speed with a kink along a line elsewhere.
fn cell(values: &[f64]) -> Cell {
    let [x, y] = [values[1], values[0]];
    if (0.41..0.55).contains(&x) {
        return Cell::failing(Reason::OutputsMissed);
    }
    let kink = (x + 0.3 * y - 0.8).max(0.0);
    let square = 0.3 + 0.15 * (4.0 * x).sin() + 0.1 * y * y - 0.4 * kink - 0.9 * (x - y - 0.3).max(0.0);
    if square > 0.0 { Cell::passing(square.sqrt()) } else { Cell::failing(Reason::FallsBack) }
}

fn request() -> MapRequest {
    let axis = |count: usize| (0..count).map(|k| k as f64 / (count - 1) as f64).collect();
    let axes = [(1, axis(83)), (0, axis(120))];
    MapRequest { values: vec![0.0; 2], from: None, axes, speeds: vec![SPEED], assume: Assumptions::default() }
}

fn sparing() -> Sparing {
    Sparing { tolerance: TOLERANCE, from_cells: 0, shared: 0, bounds: [[0.1, 0.95], [0.05, 0.9]] }
}

fn whole() -> Vec<Cell> {
    let (request, mut cells) = (request(), Vec::new());
    let [columns, rows] = request.size();
    for row in 0..rows {
        cells.extend((0..columns).map(|column| cell(&request.at(column, row))));
    }
    cells
}

fn filled(known: &[Cell], sparing: &Sparing) -> (Vec<Cell>, Option<Interpolation>, usize) {
    let asked = AtomicUsize::new(0);
    let watch = Watch { advance: &|_| {}, stop: &|| false };
    let (cells, found) = request().cells_sparing(known, sparing, &watch, |values, _| {
        asked.fetch_add(1, Ordering::Relaxed);
        cell(values)
    });
    (cells, found[0], asked.into_inner())
}

/// Fastest and slowest cell within the bounds.
fn extremes(cells: &[Cell]) -> [(f64, usize); 2] {
    let (request, bounds) = (request(), sparing().bounds);
    let columns = request.size()[0];
    let inside = |place: usize| {
        let at = [request.axes[0].1[place % columns], request.axes[1].1[place / columns]];
        at.iter().zip(bounds).all(|(x, [low, high])| (low..=high).contains(x))
    };
    let good = cells.iter().enumerate().filter(|(place, _)| inside(*place));
    let good: Vec<_> = good.filter_map(|(place, cell)| Some((cell.good()?, place))).collect();
    [
        good.iter().copied().reduce(|a, b| if b.0 > a.0 { b } else { a }).unwrap(),
        good.iter().copied().reduce(|a, b| if b.0 < a.0 { b } else { a }).unwrap(),
    ]
}

#[test]
fn interpolated_cells_are_those_that_would_be_computed() {
    let (whole, (cells, found, asked)) = (whole(), filled(&[], &sparing()));
    let found = found.unwrap();
    let mut farthest: f64 = 0.0;
    let mut reasons = [0; 3];
    for (place, (own, known)) in cells.iter().zip(&whole).enumerate() {
        assert_eq!(own.reason, known.reason, "{place}");
        if !own.interpolated {
            assert_eq!(own, known, "{place}");
            continue;
        }
        let which = [Reason::Passes, Reason::OutputsMissed, Reason::FallsBack];
        reasons[which.iter().position(|reason| *reason == own.reason).unwrap()] += 1;
        if let (Some(own), Some(known)) = (own.good(), known.good()) {
            farthest = farthest.max((own - known).abs());
        }
    }
    assert!(farthest < TOLERANCE * SPEED, "{farthest:e}");
    assert!(reasons.iter().all(|count| *count > 300), "{reasons:?}");
    assert_eq!((found.computed, found.interpolated), (asked, cells.len() - asked));
    assert!(asked < cells.len() / 3, "{asked} of {} computed", cells.len());
    // What was computed to see it is among them.
    let largest = found.largest_deviation.unwrap();
    assert!(found.checked > 20 && largest > 0.0 && largest <= farthest.max(found.tolerance), "{found:?}");
    assert!((found.tolerance - TOLERANCE * SPEED).abs() < 1e-15);
}

#[test]
fn extremes_are_computed_and_those_of_the_whole_map() {
    let (cells, ..) = filled(&[], &sparing());
    assert_eq!(extremes(&cells), extremes(&whole()));
    for (_, place) in extremes(&cells) {
        assert!(!cells[place].interpolated, "{place}");
    }
}

#[test]
fn small_maps_are_computed_cell_by_cell() {
    let (cells, found, asked) = filled(&[], &Sparing { from_cells: usize::MAX, ..sparing() });
    assert_eq!((cells, found, asked), (whole(), None, 83 * 120));
}

/// A tighter tolerance computes more.
#[test]
fn fewer_cells_are_interpolated_where_more_is_asked_for() {
    let (_, loose, _) = filled(&[], &sparing());
    let (_, tight, _) = filled(&[], &Sparing { tolerance: 1e-6, ..sparing() });
    let [loose, tight] = [loose.unwrap(), tight.unwrap()];
    assert!(tight.computed > loose.computed + 100, "{loose:?} {tight:?}");
    assert!(tight.largest_deviation.unwrap() <= tight.tolerance, "{tight:?}");
}

/// Wherever it is interrupted, the same cells come of it, none is computed twice, and what is interpolated is not kept before all is known.
#[test]
fn an_interrupted_map_goes_on() {
    let (uninterrupted, interpolation, all) = filled(&[], &sparing());
    for most in [0, 1, 3, 10, 30] {
        let (asked, questions) = (AtomicUsize::new(0), Shared::new(0));
        let parts = RefCell::new(Vec::new());
        let stop = || {
            questions.set(questions.get() + 1);
            questions.get() > most
        };
        let watch = Watch { advance: &|part| parts.borrow_mut().push(part), stop: &stop };
        let (some, found) = request().cells_sparing(&[], &sparing(), &watch, |values, _| {
            asked.fetch_add(1, Ordering::Relaxed);
            cell(values)
        });
        assert_eq!(found, [None]);
        let known = some.iter().filter(|cell| cell.reason != Reason::NotComputed).count();
        assert_eq!(known, asked.into_inner());
        assert!(known < all && some.iter().all(|cell| !cell.interpolated), "{most}: {known}");
        assert!(parts.borrow().iter().all(|part| (0.0..=1.0).contains(part)), "{parts:?}");
        let (whole, found, asked) = filled(&some, &sparing());
        assert_eq!((&whole, found, asked), (&uninterrupted, interpolation, all - known), "{most}");
    }
    // A whole one asks for nothing; where every cell is asked for, interpolated ones are computed.
    assert_eq!(filled(&uninterrupted, &sparing()).2, 0);
    let every = Sparing { from_cells: usize::MAX, ..sparing() };
    let (cells, _, asked) = filled(&uninterrupted, &every);
    assert_eq!((cells, asked), (whole(), 83 * 120 - all));
}

fn over(name: &str, low: f64, high: f64, count: usize) -> Over {
    Over { name: name.to_owned(), range: Range { low, high, count } }
}

/// Figure 7.5, coarsely: both ways of computing it.
#[test]
#[ignore = "takes long"]
fn the_map_of_the_robot_with_feet_is_the_one_of_all_cells() {
    let (bench, phases) = (phased(WALKER, "adjustable"), walker(&robot(WALKER)).unwrap().phases);
    let options = MapOptions {
        speeds: vec![0.35],
        over: vec![over("step_length", 0.25, 0.332, 45), over("push_off", -6.0, 10.0, 25)],
        interpolated_from: Some(0),
        ..MapOptions::default()
    };
    let run = Run { progress: &Silent, stop: &|| false };
    let file = scratch("gait_map_sparing").join("map.csv");
    let found = bench.map(&phases, &options, Some(&file), &run).unwrap();
    let again = bench.map(&phases, &options, Some(&file), &run).unwrap();
    assert_eq!(found, again);
    let every = MapOptions { interpolated_from: None, ..options };
    let whole = bench.map(&phases, &every, None, &run).unwrap();
    let ([one], [all]) = (&found.maps[..], &whole.maps[..]) else { panic!("one speed, one map") };
    assert_eq!((&one.reason, &one.counts), (&all.reason, &all.counts));
    // Cells between which others are interpolated are integrated less closely: their squares to less than half of what is allowed of others.
    let alike = |a: f64, b: f64| (a * a - b * b).abs() < 5e-4 * 0.35 * 0.35;
    for (own, other) in [(one.fastest, all.fastest), (one.slowest, all.slowest)] {
        let (own, other) = (own.unwrap(), other.unwrap());
        assert!(own.at == other.at && alike(own.next_speed, other.next_speed), "{own:?} {other:?}");
    }
    let computed = one.computed.as_ref().unwrap();
    let found = one.interpolation.unwrap();
    assert!(all.computed.is_none() && all.interpolation.is_none());
    assert!(found.interpolated > 300, "{found:?}");
    let (mut farthest, mut closely, mut cells) = (0.0_f64, 0, 0);
    for (row, speeds) in all.next_speed.iter().enumerate() {
        for (column, speed) in speeds.iter().enumerate() {
            let own = one.next_speed[row][column];
            if computed[row][column] == 1 {
                assert!(own.zip(*speed).map_or(own == *speed, |(a, b)| alike(a, b)), "{column} {row}");
                let apart = own.zip(*speed).map_or(0.0, |(a, b)| (a * a - b * b).abs());
                closely += usize::from(apart < 2e-5 * 0.35 * 0.35);
                cells += 1;
            } else if let (Some(own), Some(speed)) = (own, speed) {
                farthest = farthest.max((own - speed).abs());
            }
        }
    }
    println!("{found:?}, farthest {farthest:.1e}, {closely} of {cells} computed cells within 2e-5");
    assert!(4 * closely > 3 * cells, "{closely} of {cells}");
    assert!(farthest > 0.0 && farthest < 3.5e-4, "{farthest}");
    // The same request goes on from its file to every cell.
    let on = bench.map(&phases, &every, Some(&file), &run).unwrap();
    assert_eq!((&on.maps[0].reason, &on.maps[0].interpolation), (&all.reason, &all.interpolation));
    let pairs = on.maps[0].next_speed.iter().flatten().zip(all.next_speed.iter().flatten());
    assert!(pairs.into_iter().all(|(a, b)| a.zip(*b).map_or(a == b, |(a, b)| alike(a, b))));
}

#[test]
fn keys_and_columns_say_what_was_computed() {
    let file = scratch("gait_map_computed").join("map.csv");
    let fixed = ["gait", "map", WALKER, "--gait", "adjustable", "--speed", "0.35", "--json", "--every-cell"];
    let over = ["--over", "step_length=0.29:0.3:2", "--over", "push_off=0:2:2", "--csv", text(&file)];
    let json = bipedc(&[&fixed[..], &over[..]].concat()).ok().json();
    assert!(json["maps"][0]["interpolation"].is_null() && json["maps"][0]["computed"].is_null(), "{json}");
    let written = std::fs::read_to_string(&file).unwrap();
    assert!(written.contains("step_length,push_off,speed,next_speed,computed,reason\n"), "{written}");
    assert_eq!(written.lines().skip(2).filter(|line| line.contains(",1,")).count(), 4, "{written}");
    // Marks that are none are not read.
    std::fs::write(&file, written.replacen(",1,", ",2,", 1)).unwrap();
    bipedc(&[&fixed[..], &over[..]].concat()).fails_with(&["missing or damaged"]);
}
