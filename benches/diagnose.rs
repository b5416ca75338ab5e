//! Wall time and memory of a whole `bipedc diagnose`: 12 joints, 20 000 samples, the whole library.
//!
//! `cargo bench --bench diagnose` writes a log of 20 s at 1 kHz (inverse dynamics of sums of sines, Coulomb friction at
//! one joint, a viscous damper at another, noise on torques and positions), runs the command on it with none, one,
//! two and all effects to be looked for, and prints the times beside what is demanded. Nothing is timed inside the command:
//! deriving the model, reading, filtering and printing count.
#![allow(missing_docs)]
#[path = "harness/processor.rs"]
mod processor;

use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_runtime::{Argument, Model, State};
use processor::processor;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const SAMPLES: usize = 20_000;
const STEP: f64 = 1e-3;
/// Bars: all effects (s), memory (MB).
const BARS: [f64; 2] = [1.0, 500.0];
/// So many effects are all.
const ALL: usize = 12;

fn main() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("diagnose_bench");
    std::fs::create_dir_all(&folder).expect("a folder for the log");
    let log = folder.join("log.csv");
    std::fs::write(&log, text()).expect("the log");
    let asked = [0, 1, 2, ALL];
    let runs = asked.map(|most| run(&log, most));
    println!("{}", processor());
    println!("{:10} {:>8} {:>12} {:>10}", "effects", "s", "processor s", "peak MB");
    for (most, (time, [memory, busy])) in asked.iter().zip(&runs) {
        println!("{most:<10} {:>8.2} {busy:>12.2} {memory:>10.0}", time.as_secs_f64());
    }
    let memory = runs.iter().map(|(_, [memory, _])| *memory).fold(0.0, f64::max);
    let figures = [runs[3].0.as_secs_f64(), memory];
    for ((what, figure), bar) in ["all effects, s", "memory, MB"].iter().zip(figures).zip(BARS) {
        println!("{what:22} {figure:8.2} (bar {bar}) {}", if figure < bar { "held" } else { "missed" });
    }
}

/// Runs the command and watches its memory.
fn run(log: &Path, most: usize) -> (Duration, [f64; 2]) {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let start = Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_bipedc"))
        .args(["diagnose", "robots/tulip"])
        .arg(log)
        .args(["--json", "--most", &most.to_string()])
        .current_dir(root)
        .stdout(Stdio::null())
        .spawn()
        .expect("bipedc runs");
    let watched = watch(&mut child);
    (start.elapsed(), watched)
}

/// Peak memory in MB and time of all processors in s, as the system tells them until the process ends.
fn watch(child: &mut Child) -> [f64; 2] {
    let (status, stat) = (format!("/proc/{}/status", child.id()), format!("/proc/{}/stat", child.id()));
    let (mut peak, mut busy) = (0.0, 0.0);
    loop {
        if let Ok(text) = std::fs::read_to_string(&status) {
            let line = text.lines().find(|line| line.starts_with("VmHWM:"));
            let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok());
            peak = kilobytes.map_or(peak, |k| k / 1024.0);
        }
        if let Ok(text) = std::fs::read_to_string(&stat) {
            // Fields 14 and 15, hundredths of a second; the second field is the name in brackets.
            let after = text.rsplit_once(')').map_or("", |(_, rest)| rest);
            let ticks: Vec<f64> = after.split_whitespace().skip(11).take(2).flat_map(str::parse).collect();
            busy = ticks.iter().sum::<f64>().max(100.0 * busy) / 100.0;
        }
        match child.try_wait().expect("the process can be asked") {
            Some(status) => {
                assert!(status.success(), "bipedc failed");
                return [peak, busy];
            }
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    }
}

/// The log as CSV.
fn text() -> String {
    let robot = Robot::read(Path::new("robots/tulip")).expect("the robot");
    let robot = robot.with_base("fixed", None).expect("a fixed base");
    let request = FunctionRequest::of_robot("inverse_dynamics");
    let compiled = robot.compile_only(&[request]).expect("inverse dynamics");
    let joints: Vec<String> = compiled.tree.joints.iter().map(|joint| joint.name.clone()).collect();
    let model = ProgramModel::new(compiled);
    let model: &dyn Model<f64> = &model;
    let function = model.function("inverse_dynamics").expect("it was compiled");
    let mut random = Noise(7);
    let names = joints.iter().map(|name| format!("{name}/position,{name}/effort"));
    let mut text = format!("time,{}\n", names.collect::<Vec<_>>().join(","));
    for i in 0..SAMPLES {
        let t = STEP * i as f64;
        let motion: Vec<[f64; 3]> = (0..joints.len()).map(|joint| at(joint, t)).collect();
        let [q, v, a] = [0, 1, 2].map(|k| motion.iter().map(|m| m[k]).collect::<Vec<f64>>());
        let mut tau = vec![0.0; joints.len()];
        let state = State::new().with(Argument::Q, &q).with(Argument::V, &v).with(Argument::A, &a);
        model.evaluate(function, &state, &mut tau).expect("sizes are the model's own");
        tau[3] += 0.6 * (v[3] / 0.02).tanh();
        tau[8] += 0.25 * v[8];
        let _ = write!(text, "{t:.3}");
        for (q, tau) in q.iter().zip(&tau) {
            let _ = write!(text, ",{:.7},{:.5}", q + 1e-5 * random.next(), tau + 0.05 * random.next());
        }
        text.push('\n');
    }
    text
}

/// Position, velocity and acceleration of a joint: four sines whose frequencies no joints share.
fn at(joint: usize, t: f64) -> [f64; 3] {
    let mut motion = [0.0; 3];
    for k in 0..4 {
        let w = 0.7 + 1.3 * k as f64 + 0.137 * joint as f64 + 0.0619 * (joint * k) as f64;
        let (amplitude, phase) = (0.3 / (1.0 + k as f64), 1.7 * joint as f64 + 0.9 * k as f64);
        let (sin, cos) = (w * t + phase).sin_cos();
        motion[0] += amplitude * sin;
        motion[1] += amplitude * w * cos;
        motion[2] -= amplitude * w * w * sin;
    }
    motion
}

/// Nearly normal numbers: sums of twelve uniform ones (xorshift).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}
