//! One million samples of 12 joints folded into the regression of all base parameters: time and memory.
//!
//! `cargo bench --bench identify` takes the legs with torso (`benches/robots/lower12`), torso held, with viscous and
//! Coulomb friction and offset at every joint. Blocks of states go through the same path as those of a log: regressor,
//! sorting by stretch of motion, triangles, on two threads; then the estimate with error bars. The states are made before
//! the clock starts and used again and again, because a million of them would be memory of the bench's own.
#![allow(missing_docs)]
#[path = "harness/processor.rs"]
mod processor;

use bipedc::identification::base_regressor;
use bipedc_analysis::identify::{Design, Estimate, ExtraChoice, Method, Settings, Sums, fold};
use bipedc_analysis::measure::Recording;
use bipedc_analysis::robot::Trajectory;
use bipedc_analysis::robot::{BaseKind, Joint, JointLayout};
use bipedc_compiler::Robot;
use bipedc_runtime::nalgebra::DVector;
use processor::processor;
use std::path::Path;
use std::time::Instant;

const SAMPLES: usize = 1_000_000;
/// As the log's reader gives them.
const BLOCK: usize = 1 << 14;
const STEP: f64 = 1e-3;
const CELLS: usize = 24;
/// Bars: s, MB.
const BARS: [f64; 2] = [3.0, 200.0];

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let robot = Robot::read(&root.join("benches/robots/lower12")).expect("the robot");
    let robot = robot.with_base("fixed", None).expect("a held torso").without_effects();
    let tree = robot.tree().expect("a tree");
    let joints: Vec<Joint> = tree.joints.iter().map(|joint| Joint::revolute(joint.name.clone())).collect();
    let layout = JointLayout { joints, base: BaseKind::Fixed };
    let rows: Vec<usize> = (0..tree.nv).collect();
    let (base, regressor) = base_regressor(&robot.description, &tree, &rows).expect("a regressor");
    let extras = ExtraChoice::default().list(&rows);
    let design = Design::new(&layout, &base, &regressor, extras, &rows);
    let block = block(rows.len());
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(2);
    let settings = Settings { threads, ..Settings::default() };
    let before = peak();
    let start = Instant::now();
    let mut parts = vec![Sums::new(&design, CELLS); threads];
    let mut done = 0;
    while done < SAMPLES {
        let first = done as f64 * STEP;
        let cell = |time: f64| ((first + time) / (SAMPLES as f64 * STEP) * CELLS as f64) as usize % CELLS;
        fold(&design, &block, &cell, &settings, None, &mut parts);
        done += BLOCK;
    }
    let mut parts = parts.into_iter();
    let mut sums = parts.next().expect("one thread at least");
    parts.for_each(|part| sums.add(&part));
    let folded = start.elapsed().as_secs_f64();
    let held = DVector::zeros(design.unknowns.len());
    let estimate = Estimate::weighted(&design, &sums, held, Method::Weighted);
    let fit = estimate.fit(&design, &sums);
    let all = start.elapsed().as_secs_f64();
    println!("{}", processor());
    println!(
        "{} base parameters and {} of joints, {done} samples, {threads} threads: {:.2} µs a sample, error bars {:.3} s",
        base.names.len(),
        design.unknowns.len() - base.names.len(),
        1e6 * folded / done as f64,
        all - folded
    );
    assert!(fit.theta.iter().all(|x| x.is_finite()) && estimate.seen.len() == design.unknowns.len());
    let scale = SAMPLES as f64 / done as f64;
    for ((what, figure), bar) in
        ["one million samples, s", "memory, MB"].iter().zip([all * scale, peak().max(before)]).zip(BARS)
    {
        println!("{what:24} {figure:8.2} (bar {bar}) {}", if figure < bar { "held" } else { "missed" });
    }
}

/// States of all joints that swing by sums of sines, with efforts of a pattern that no model has.
fn block(joints: usize) -> Recording {
    let mut block = Recording {
        step: STEP,
        segments: std::iter::once(0..BLOCK).collect(),
        trajectory: Trajectory::with_widths(joints, joints, joints),
        ..Recording::default()
    };
    block.effort = vec![Some(Vec::new()); joints];
    for i in 0..BLOCK {
        let t = i as f64 * STEP;
        block.time.push(t);
        for j in 0..joints {
            let (w1, w2, phase) = (1.3 + 0.37 * j as f64, 4.1 + 0.53 * j as f64, 0.7 * j as f64);
            let (a, b) = (w1 * t + phase, w2 * t + 2.0 * phase);
            block.trajectory.q.push(0.5 * a.sin() + 0.2 * b.cos());
            block.trajectory.v.push(0.5 * w1 * a.cos() - 0.2 * w2 * b.sin());
            block.trajectory.a.push(-0.5 * w1 * w1 * a.sin() - 0.2 * w2 * w2 * b.cos());
            if let Some(effort) = &mut block.effort[j] {
                effort.push(5.0 * a.sin() + (97.0 * t + phase).sin());
            }
        }
    }
    block
}

/// Peak memory of this process so far, MB.
fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.trim().trim_end_matches(" kB").trim().parse::<f64>().ok());
    number.unwrap_or(f64::NAN) / 1024.0
}
