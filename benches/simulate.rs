//! How much faster than real time TUlip stands and falls at 1 kHz: `cargo bench --bench simulate`.
#[path = "../tests/time_stepping/humanoid.rs"]
#[allow(dead_code)]
mod humanoid;

use humanoid::{Case, Humanoid, STANDING};
use std::time::Instant;

const STEPS: usize = 3000;

fn main() {
    let cases = [
        ("standing", STANDING),
        ("standing, dry joints", Case { dry: 0.5, ..STANDING }),
        ("dropped", Case { clearance: 0.1, tilt: 0.05, ..STANDING }),
        ("collapsing", Case { tilt: 0.1, stiffness: 0.0, damping: 0.1, ..STANDING }),
    ];
    println!("TUlip, {STEPS} steps of 1 ms, relative residual 1e-6, one core");
    println!("{:22} {:>9} {:>16} {:>15} {:>8}", "", "µs/step", "times real time", "worst residual", "rounds");
    for (name, case) in cases {
        let mut robot = Humanoid::new(case, 1e-6);
        let (mut worst, mut rounds) = (0.0_f64, 0);
        let start = Instant::now();
        for _ in 0..STEPS {
            let solved = robot.step(1e-3).solved;
            worst = worst.max(solved.residual);
            rounds += solved.sweeps + solved.newton;
        }
        let per_step = start.elapsed().as_secs_f64() / STEPS as f64;
        let rounds = rounds as f64 / STEPS as f64;
        println!("{name:22} {:9.1} {:16.0} {worst:15.1e} {rounds:8.1}", 1e6 * per_step, 1e-3 / per_step);
    }
}
