//! Maps of gaits, and plans: `cargo bench --bench maps`. Everything on all processors, programs evaluated in process.
#[path = "harness/processor.rs"]
mod processor;

use bipedc::Robot;
use bipedc::gait::{GaitBench, MapOptions, Over, PhasedBench, PlanOptions, Range};
use bipedc::progress::{Run, Silent};
use bipedc::simulation::walker;
use processor::processor;
use std::path::Path;
use std::time::Instant;

const REPETITIONS: usize = 5;
/// Values of each parameter.
const VALUES: usize = 200;
const SPEEDS: [f64; 6] = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0];

fn over(name: &str, low: f64, high: f64, count: usize) -> Over {
    Over { name: name.to_owned(), range: Range { low, high, count } }
}

fn gait(name: &str) -> GaitBench {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name);
    let robot = Robot::read(&folder).unwrap_or_else(|e| panic!("{e}"));
    GaitBench::open(&robot, "thesis", &Silent).unwrap_or_else(|e| panic!("{e}"))
}

/// Seconds of the fastest repetition.
fn fastest(mut work: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..REPETITIONS {
        let clock = Instant::now();
        work();
        best = best.min(clock.elapsed().as_secs_f64());
    }
    best
}

/// Columns (step lengths) and rows (push-off) of the map of several phases: a tenth and half of what a picture has.
const COLUMNS: usize = 10;
const ROWS: usize = 100;

/// Figure 7.5: a robot with feet, four phases to a step, three speeds. Once: it takes a minute.
fn several_phases(run: &Run<'_>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/seven_link_v1");
    let robot = Robot::read(&folder).unwrap_or_else(|e| panic!("{e}"));
    let bench = PhasedBench::open(&robot, "adjustable", &Silent).unwrap_or_else(|e| panic!("{e}"));
    let walker = walker(&robot).unwrap_or_else(|e| panic!("{e}"));
    let options = MapOptions {
        speeds: vec![0.2, 0.35, 0.5],
        over: vec![over("step_length", 0.25, 0.332, COLUMNS), over("push_off", -6.0, 10.0, ROWS)],
        ..MapOptions::default()
    };
    let clock = Instant::now();
    let map = bench.map(&walker.phases, &options, None, run).unwrap_or_else(|e| panic!("{e}"));
    let seconds = clock.elapsed().as_secs_f64();
    let passes: usize = map.maps.iter().map(|map| map.counts["passes"]).sum();
    let cells = COLUMNS * ROWS;
    let name = format!("seven-link (figure 7.5), {cells} cells");
    println!("{name:<34} {seconds:8.3} {:12.1} {passes:20}", 1e6 * seconds / cells as f64);
}

fn main() {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    println!("{}", processor());
    println!("maps of {VALUES} × {VALUES} cells and {} speeds, {processors} processors", SPEEDS.len());
    println!("{:<34} {:>8} {:>12} {:>20}", "", "s", "µs per cell", "cells that pass");
    let run = Run { progress: &Silent, stop: &|| false };
    let (three, five) = (gait("three_link"), gait("five_link"));
    let figures = [
        ("three-link robot (figure 7.2)", &three, ("step_length", 0.1, 1.4), ("torso_lean", -2.0, 2.0)),
        ("five-link robot (figure 7.4)", &five, ("step_length", 0.1, 1.0), ("torso_lean", -0.6, 1.2)),
    ];
    for (name, bench, x, y) in figures {
        let axes = [x, y].map(|(name, low, high)| over(name, low, high, VALUES));
        let options = MapOptions { speeds: SPEEDS.to_vec(), over: axes.to_vec(), ..MapOptions::default() };
        let mut passes = 0;
        let seconds = fastest(|| {
            let map = bench.map(&options, None, &run).unwrap_or_else(|e| panic!("{e}"));
            passes = map.maps.iter().map(|map| map.counts["passes"]).sum();
        });
        let cells = (VALUES * VALUES) as f64;
        println!("{name:<34} {seconds:8.3} {:12.1} {passes:20}", 1e6 * seconds / cells);
    }
    several_phases(&run);
    println!("\n{:<34} {:>8} {:>12}", "fewest steps to 2 rad/s", "s", "speeds");
    let speeds: Vec<f64> = (1..=40).map(|k| 0.1 * f64::from(k)).collect();
    for (name, bench) in [("three-link robot", &three), ("five-link robot", &five)] {
        let options =
            PlanOptions { from_speeds: speeds.clone(), to: 2.0, most: 30, ..PlanOptions::default() };
        let seconds = fastest(|| drop(bench.plans(&options, &run).unwrap_or_else(|e| panic!("{e}"))));
        println!("{name:<34} {seconds:8.3} {:12}", speeds.len());
    }
}
