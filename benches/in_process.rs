//! Programs in process against the same functions emitted: `cargo bench --bench in_process [ROBOT [FUNCTION]]`, random states, one core.
//!
//! Each figure is the best of many passes over 256 states. `making`: the call in which machine code is made; KiB: what it
//! takes of memory, with constants and room for a call. To count instructions
//! (`valgrind --tool=callgrind`, `perf stat`): with `BENCH_CALLS=N`, ROBOT and FUNCTION that one is called so often in process and
//! nothing else is done but its making; with `BENCH_EMITTED=1` beside it, the emitted one.
#![allow(missing_docs)]
#[path = "harness/processor.rs"]
mod processor;

use bipedc_compiler::Robot;
use bipedc_compiler::compile::{Function, ProgramModel};
use bipedc_effects::random::Random;
use bipedc_macros::Biped;
use bipedc_runtime::{Argument, Model, State};
use processor::processor;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

const STATES: usize = 256;
const PASSES: usize = 300;
/// Calls until a program is machine code, as `compiler/src/program/often.rs` has it.
const CALLS: usize = 300;
/// Functions of fewer operations are calls more than anything else.
const FEWEST: usize = 100;

#[derive(Biped)]
#[biped(description = "benches/robots/lower12", functions = [
    "inverse_dynamics", "bias", "mass_matrix_upper", "forward_dynamics", "inverse_dynamics_regressor",
])]
pub struct Lower12;

type Values = [(Argument, Vec<f64>); 4];

fn state(values: &Values) -> State<'_, f64> {
    values.iter().fold(State::new(), |state, (argument, list)| state.with(*argument, list))
}

/// Nanoseconds per call.
fn time(states: &[Values], mut call: impl FnMut(&State<'_, f64>)) -> f64 {
    let mut best = f64::MAX;
    for _ in 0..PASSES {
        let clock = Instant::now();
        for values in states {
            call(black_box(&state(values)));
        }
        best = best.min(clock.elapsed().as_secs_f64() / states.len() as f64);
    }
    1e9 * best
}

/// What to call so often, and nothing else.
struct Counted {
    calls: usize,
    emitted: bool,
}

struct Bench<'a> {
    model: ProgramModel,
    emitted: &'a dyn Model<f64>,
    states: Vec<Values>,
}

impl<'a> Bench<'a> {
    fn new(folder: &str, emitted: &'a dyn Model<f64>) -> Self {
        let robot = Robot::read(Path::new(folder)).expect("the robot");
        let model = ProgramModel::new(robot.compile().expect("it compiles"));
        let mut random = Random::new(1);
        let mut list = |argument, count| (argument, (0..count).map(|_| random.normal()).collect());
        let (nq, nv) = (Model::<f64>::nq(&model), Model::<f64>::nv(&model));
        let mut state =
            || [list(Argument::Q, nq), list(Argument::V, nv), list(Argument::A, nv), list(Argument::Tau, nv)];
        let states = (0..STATES).map(|_| state()).collect();
        Self { model, emitted, states }
    }

    fn call(&self, model: &dyn Model<f64>, index: usize, state: &State<'_, f64>, out: &mut [f64]) {
        model.evaluate(index, state, out).expect("lengths are the model's own");
        black_box(out);
    }

    fn function(&self, function: &Function, index: usize, counted: Option<&Counted>) {
        let known = |a| matches!(a, Argument::Q | Argument::V | Argument::A | Argument::Tau);
        let operations = function.program.instructions.len();
        let large = operations >= FEWEST && function.program.arguments().all(known);
        let Some(other) = self.emitted.function(&function.name).filter(|_| large) else { return };
        let mut out = vec![0.0; function.rows.len() * function.columns.len()];
        let first = state(&self.states[0]);
        (0..CALLS).for_each(|_| self.call(&self.model, index, &first, &mut out));
        let clock = Instant::now();
        self.call(&self.model, index, &first, &mut out);
        let making = 1e3 * clock.elapsed().as_secs_f64();
        if let Some(counted) = counted {
            let (model, index): (&dyn Model<f64>, _) =
                if counted.emitted { (self.emitted, other) } else { (&self.model, index) };
            (0..counted.calls).for_each(|_| self.call(model, index, black_box(&first), &mut out));
            return;
        }
        let native = time(&self.states, |state| self.call(&self.model, index, state, &mut out));
        let other = time(&self.states, |state| self.call(self.emitted, other, state, &mut out));
        let evaluator = self.model.evaluator(index).expect("every function has one");
        let mut workspace = evaluator.workspace();
        let interpreted =
            time(&self.states, |state| evaluator.run(state, &mut workspace, black_box(&mut out)));
        println!(
            "{:<34} {operations:>10} {interpreted:>14.0} {native:>14.1} {other:>12.1} {:>12.2} {making:>10.2} {:>8.1}",
            function.name,
            native / other,
            evaluator.machine_code_bytes() as f64 / 1024.0
        );
    }
}

fn main() {
    println!("{}", processor());
    let robots: [(&str, &str, &dyn Model<f64>); 3] = [
        ("lower12", "benches/robots/lower12", &Lower12),
        ("tulip", "robots/tulip", &tulip::Tulip),
        ("five_link", "robots/five_link", &five_link::FiveLink),
    ];
    let mut wanted = std::env::args().skip(1).filter(|a| !a.starts_with('-'));
    let (robot, function) = (wanted.next(), wanted.next());
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<usize>().ok());
    let emitted = number("BENCH_EMITTED").is_some();
    let counted = number("BENCH_CALLS").map(|calls| Counted { calls, emitted });
    for (name, folder, emitted) in robots {
        if robot.as_ref().is_some_and(|robot| robot != name) {
            continue;
        }
        if counted.is_none() {
            println!(
                "{name:<34} {:>10} {:>14} {:>14} {:>12} {:>12} {:>10} {:>8}",
                "operations",
                "interpreted ns",
                "in process ns",
                "emitted ns",
                "/ emitted",
                "making ms",
                "KiB"
            );
        }
        let bench = Bench::new(folder, emitted);
        for (index, compiled) in bench.model.compiled().functions.iter().enumerate() {
            if function.as_ref().is_none_or(|wanted| *wanted == compiled.name) {
                bench.function(compiled, index, counted.as_ref());
            }
        }
    }
}
