//! Slopes of a program along directions, as machine code once they are asked for again and again.
use super::Program;
use super::native::Native;
use super::often::is_wanted;
use super::tangent::{LANES, SEEDS, Tangent};
use bipedc_runtime::Argument;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Calls after which machine code is made: it is many times as fast as numbers that carry their slopes through an interpreter.
const CALLS: u32 = 10;

/// What is asked for, and its machine code.
#[derive(Debug)]
pub(super) struct Along {
    program: Program,
    inputs: usize,
    directions: Vec<usize>,
    /// Group, lane and output of each slope.
    wanted: Vec<[usize; 3]>,
    calls: AtomicU32,
    made: OnceLock<Option<Made>>,
}

#[derive(Debug)]
struct Made {
    native: Native,
    outputs: usize,
    places: Vec<Option<[usize; 2]>>,
    /// Memory that nobody needs at the moment: workers come and go.
    idle: Mutex<Vec<Room>>,
}

/// Inputs and what is computed from them, and results.
#[derive(Debug)]
struct Room {
    memory: Vec<[f64; LANES]>,
    results: Vec<[f64; LANES]>,
}

impl Made {
    fn room(&self, inputs: usize) -> Room {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        idle.unwrap_or_else(|| {
            let mut memory = vec![[0.0; LANES]; self.native.memory()];
            memory[inputs..].iter_mut().enumerate().take(LANES).for_each(|(lane, seed)| seed[lane] = 1.0);
            Room { memory, results: vec![[0.0; LANES]; self.outputs] }
        })
    }
}

impl Along {
    /// Of a program of so many parameters.
    pub fn new(program: &Program, inputs: usize, directions: &[usize], wanted: Vec<[usize; 3]>) -> Self {
        Self {
            program: program.clone(),
            inputs,
            directions: directions.to_vec(),
            wanted,
            calls: AtomicU32::new(0),
            made: OnceLock::new(),
        }
    }

    fn make(&self) -> Option<Made> {
        let Tangent { program, places } = Tangent::new(&self.program, &self.directions, &self.wanted)?;
        let parameters = (0..self.inputs as u32).map(|k| (Argument::Parameters, k));
        let inputs: Vec<_> = parameters.chain((0..LANES as u32).map(|k| (SEEDS, k))).collect();
        let native = Native::of_eight(&program, &inputs)?;
        Some(Made { native, outputs: program.outputs.len(), places, idle: Mutex::default() })
    }

    /// All slopes that are wanted; false: there is no machine code (yet).
    pub fn run(&self, x: impl Iterator<Item = f64>, out: &mut [f64]) -> bool {
        let made = match self.made.get() {
            Some(made) => made,
            // The one that counts this call makes it; others go on meanwhile.
            None if is_wanted() && self.calls.fetch_add(1, Ordering::Relaxed) == CALLS => {
                self.made.get_or_init(|| self.make())
            }
            None => return false,
        };
        let Some(made) = made else { return false };
        let mut room = made.room(self.inputs);
        room.memory[..self.inputs].iter_mut().zip(x).for_each(|(to, x)| *to = [x; LANES]);
        made.native.run_eight(&mut room.memory, &mut room.results);
        for (out, place) in out.iter_mut().zip(&made.places) {
            *out = place.map_or(0.0, |[output, lane]| room.results[output][lane]);
        }
        made.idle.lock().unwrap_or_else(PoisonError::into_inner).push(room);
        true
    }
}
