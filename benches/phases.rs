//! One hybrid step of the five-link walker, from landing to landing, with the emitted model: `cargo bench --bench phases`.
#[path = "harness/processor.rs"]
mod processor;

use bipedc::simulation::{plant, walker};
use bipedc_analysis::simulate::Scenario;
use bipedc_analysis::simulate::control::VirtualConstraints;
use bipedc_analysis::simulate::phases::{Assumptions, Effort, End, PhasedRobot, Precision, Start, walk};
use bipedc_compiler::Robot;
use five_link::FiveLink;
use processor::processor;
use std::path::Path;
use std::time::Instant;

const REPETITIONS: usize = 200;

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let robot = Robot::read(&root.join("robots/five_link")).unwrap_or_else(|e| panic!("{e}"));
    let plant = plant(&robot.description, &robot.tree().unwrap()).unwrap();
    let file = root.join("robots/five_link/scenarios/gait.toml");
    let scenario = Scenario::open(&file, &plant).unwrap_or_else(|e| panic!("{e}"));
    let phases = walker(&robot).unwrap().phases;
    let outputs = scenario.outputs.as_ref().unwrap();
    let names: Vec<&str> = phases.iter().map(|phase| phase.dynamics.as_str()).collect();
    let controller = VirtualConstraints::new(&FiveLink, plant.layout.base, outputs, &names).unwrap();
    let assumptions = Assumptions { friction: 0.6, ..Assumptions::default() };
    let robot =
        PhasedRobot::new(&FiveLink, plant.layout.base, &plant.feet, phases, assumptions, controller).unwrap();
    // A landing of the gait: after five steps from the scenario's beginning.
    let (mut x, _) = robot.standing(&plant, &scenario).unwrap();
    let precision = |relative: f64| Precision {
        relative,
        absolute: relative,
        largest_step: 0.1,
        largest_look: 0.01,
        ..Precision::default()
    };
    let settled =
        walk(&robot, Start { time: 0.0, phase: 0, x }, 1e2, 5, &precision(1e-10), &mut |_, _, _| ());
    x = settled.unwrap().last.x;
    println!("{}", processor());
    println!(
        "five-link walker, one step of 0.643 s with its impact, assumptions checked, emitted model, one core"
    );
    println!(
        "{:>9} {:>9} {:>7} {:>12} {:>8} {:>18} {:>16}",
        "tolerance", "ms", "steps", "evaluations", "guards", "µs per evaluation", "times real time"
    );
    for relative in [1e-6, 1e-8, 1e-10, 1e-12] {
        let mut fastest = f64::INFINITY;
        let mut done = None;
        for _ in 0..REPETITIONS {
            let start = Start { time: 0.0, phase: 0, x: x.clone() };
            let clock = Instant::now();
            let walked = walk(&robot, start, 5.0, 1, &precision(relative), &mut |_, _, _| ()).unwrap();
            fastest = fastest.min(clock.elapsed().as_secs_f64());
            assert_eq!(walked.end, End::Changes);
            done = Some(walked);
        }
        let Some(done) = done else { return };
        let Effort { steps, evaluations, guards, .. } = done.effort;
        println!(
            "{relative:9.0e} {:9.3} {steps:7} {evaluations:12} {guards:8} {:18.3} {:16.0}",
            1e3 * fastest,
            1e6 * fastest / evaluations as f64,
            done.last.time / fastest
        );
    }
}
