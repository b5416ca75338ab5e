//! How much faster than real time TUlip stands and falls at 1 kHz, beside MuJoCo: `cargo bench --bench simulate`.
//!
//! Processor time of this thread, best of several runs, so that others on the machine count little. MuJoCo runs if the interpreter
//! `$PYTHON` (default `python3`) has it; ours and its runs take turns.
#[path = "../tests/time_stepping/humanoid.rs"]
#[allow(dead_code)]
mod humanoid;

#[path = "harness/processor.rs"]
mod processor;

use humanoid::{Case, Humanoid, STANDING};
use processor::processor;
use std::collections::BTreeMap;
use std::process::Command;
use std::time::Instant;

const STEPS: usize = 3000;
const REPEATS: usize = 5;
const ROUNDS: usize = 3;

/// What a task took.
struct Timed {
    /// s per step, the best.
    step: f64,
    worst_residual: f64,
    rounds: f64,
}

fn main() {
    // One run of one task alone, for counting instructions: `valgrind --tool=callgrind PROGRAM NAME`.
    let only = std::env::args().nth(1).filter(|name| !name.starts_with("--"));
    let cases = [
        ("standing", STANDING),
        ("standing, dry joints", Case { dry: 0.5, ..STANDING }),
        ("dropped", Case { clearance: 0.1, tilt: 0.05, ..STANDING }),
        ("collapsing", Case { tilt: 0.1, stiffness: 0.0, damping: 0.1, ..STANDING }),
    ];
    if let Some(name) = only {
        for (_, case) in cases.into_iter().filter(|(other, _)| *other == name) {
            run(case);
        }
        return;
    }
    let mut best: BTreeMap<&str, Timed> = BTreeMap::new();
    let mut peer: BTreeMap<String, f64> = BTreeMap::new();
    for _ in 0..ROUNDS {
        for (name, case) in cases {
            for _ in 0..REPEATS {
                let found = run(case);
                let kept = best.entry(name).or_insert(Timed { step: f64::INFINITY, ..found });
                kept.step = kept.step.min(found.step);
            }
        }
        for (name, step) in mujoco() {
            let kept = peer.entry(name).or_insert(f64::INFINITY);
            *kept = kept.min(step);
        }
    }
    println!("{}", processor());
    println!(
        "TUlip, {STEPS} steps of 1 ms, relative residual 1e-6, processor time of one core, best of {}",
        ROUNDS * REPEATS
    );
    println!(
        "{:22} {:>9} {:>16} {:>15} {:>8} {:>16} {:>7}",
        "", "µs/step", "times real time", "worst residual", "rounds", "MuJoCo, µs/step", "ratio"
    );
    for (name, _) in cases {
        let Some(Timed { step, worst_residual, rounds }) = best.get(name) else { continue };
        let beside = peer.get(name).map_or_else(
            || format!("{:>16} {:>7}", "–", "–"),
            |other| format!("{:16.1} {:7.2}", 1e6 * other, other / step),
        );
        println!(
            "{name:22} {:9.1} {:16.0} {worst_residual:15.1e} {rounds:8.1} {beside}",
            1e6 * step,
            1e-3 / step
        );
    }
    if peer.is_empty() {
        println!("(set PYTHON to an interpreter with mujoco to compare: pip install mujoco==4.0.0)");
    }
}

fn run(case: Case) -> Timed {
    let mut robot = Humanoid::new(case, 1e-6);
    let (mut worst_residual, mut rounds) = (0.0_f64, 0);
    let begun = Clock::now();
    for _ in 0..STEPS {
        let solved = robot.step(1e-3).solved;
        worst_residual = worst_residual.max(solved.residual);
        rounds += solved.sweeps + solved.newton;
    }
    Timed { step: begun.seconds() / STEPS as f64, worst_residual, rounds: rounds as f64 / STEPS as f64 }
}

/// Task and seconds per step.
fn mujoco() -> Vec<(String, f64)> {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/mujoco_tulip.py");
    let run = Command::new(python).args([script, &STEPS.to_string(), &REPEATS.to_string()]).output();
    let Some(output) = run.ok().filter(|output| output.status.success()) else { return Vec::new() };
    let text = String::from_utf8_lossy(&output.stdout);
    let line = |line: &str| {
        let (name, time) = line.split_once('\t')?;
        Some((name.to_owned(), 1e-6 * time.trim().parse::<f64>().ok()?))
    };
    text.lines().filter_map(line).collect()
}

/// Time that this thread was on a processor (Linux), else the clock's.
struct Clock {
    wall: Instant,
    on_processor: Option<u64>,
}

impl Clock {
    fn now() -> Self {
        Self { wall: Instant::now(), on_processor: on_processor() }
    }

    fn seconds(&self) -> f64 {
        match (self.on_processor, on_processor()) {
            (Some(before), Some(now)) if now > before => 1e-9 * (now - before) as f64,
            _ => self.wall.elapsed().as_secs_f64(),
        }
    }
}

/// Nanoseconds.
fn on_processor() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse().ok()
}
