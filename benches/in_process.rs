//! Programs in process against the same functions emitted: `cargo bench --bench in_process`, TUlip on random states, one core.
//!
//! Each figure is the best of many passes over 256 states. `making`: the call in which machine code is made.
#![allow(missing_docs)]
use bipedc_compiler::Robot;
use bipedc_compiler::compile::ProgramModel;
use bipedc_effects::random::Random;
use bipedc_runtime::{Argument, Model, State};
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

const STATES: usize = 256;
const PASSES: usize = 300;
/// Calls until a program is machine code, as `compiler/src/program/often.rs` has it.
const CALLS: usize = 300;
/// Functions of fewer operations are calls more than anything else.
const FEWEST: usize = 300;

type Values = [(Argument, Vec<f64>); 3];

/// Nanoseconds per call.
fn time(states: &[Values], mut call: impl FnMut(&State<'_, f64>)) -> f64 {
    let mut best = f64::MAX;
    for _ in 0..PASSES {
        let clock = Instant::now();
        for values in states {
            let state =
                values.iter().fold(State::new(), |state, (argument, list)| state.with(*argument, list));
            call(black_box(&state));
        }
        best = best.min(clock.elapsed().as_secs_f64() / states.len() as f64);
    }
    1e9 * best
}

fn main() {
    let robot = Robot::read(Path::new("robots/tulip")).expect("the robot");
    let compiled = robot.compile().expect("it compiles");
    let model = ProgramModel::new(compiled.clone());
    let (ours, emitted): (&dyn Model<f64>, &dyn Model<f64>) = (&model, &tulip::Tulip);
    let mut random = Random::new(1);
    let mut list = |argument, count| (argument, (0..count).map(|_| random.normal()).collect());
    let (nq, nv) = (ours.nq(), ours.nv());
    let states: Vec<Values> =
        (0..STATES).map(|_| [list(Argument::Q, nq), list(Argument::V, nv), list(Argument::A, nv)]).collect();
    let state: State<'_, f64> =
        states[0].iter().fold(State::new(), |s, (argument, list)| s.with(*argument, list));
    println!(
        "{:<34} {:>10} {:>14} {:>14} {:>12} {:>12} {:>10}",
        "", "operations", "interpreted ns", "in process ns", "emitted ns", "/ emitted", "making ms"
    );
    for (index, function) in compiled.functions.iter().enumerate() {
        let known =
            function.program.arguments().all(|a| matches!(a, Argument::Q | Argument::V | Argument::A));
        let operations = function.program.instructions.len();
        let Some(other) = emitted.function(&function.name).filter(|_| known && operations >= FEWEST) else {
            continue;
        };
        let mut out = vec![0.0; function.rows.len() * function.columns.len()];
        let mut call = |model: &dyn Model<f64>, index: usize, state: &State<'_, f64>| {
            model.evaluate(index, state, &mut out).expect("lengths are the model's own");
            black_box(&mut out);
        };
        (0..CALLS).for_each(|_| call(ours, index, &state));
        let clock = Instant::now();
        call(ours, index, &state);
        let making = 1e3 * clock.elapsed().as_secs_f64();
        let native = time(&states, |state| call(ours, index, state));
        let other = time(&states, |state| call(emitted, other, state));
        let evaluator = model.evaluator(index).expect("every function has one");
        let mut workspace = evaluator.workspace();
        let interpreted = time(&states, |state| evaluator.run(state, &mut workspace, black_box(&mut out)));
        println!(
            "{:<34} {operations:>10} {interpreted:>14.0} {native:>14.0} {other:>12.0} {:>12.2} {making:>10.2}",
            function.name,
            native / other
        );
    }
}
