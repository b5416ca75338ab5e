//! When a program becomes machine code: once interpreting it has taken about as long as making that takes.
use super::Program;
use super::native::Native;
use bipedc_runtime::{Argument, State};
use std::cell::RefCell;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// Calls after which machine code is made: a quarter of a microsecond per operation against a nanosecond per call that it saves.
const CALLS: u32 = 300;
/// So many states at once are worth machine code of their own.
const MANY: usize = 1000;
/// In the environment, whatever its value: nothing becomes machine code.
const SWITCH: &str = "BIPEDC_INTERPRET";

thread_local! {
    static MEMORY: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
}

/// How often a program was called, and its machine code.
#[derive(Debug)]
pub(super) struct Often {
    calls: AtomicU32,
    /// What it is made of; `None`: it is never made.
    program: Option<Program>,
    of_one: OnceLock<Option<Native>>,
    of_eight: OnceLock<Option<Native>>,
}

/// Without the places of the interpreter.
fn order(inputs: &[(u32, Argument, u32)]) -> Vec<(Argument, u32)> {
    inputs.iter().map(|(_, argument, element)| (*argument, *element)).collect()
}

impl Often {
    pub fn new(program: &Program) -> Self {
        let wanted = std::env::var_os(SWITCH).is_none();
        let program = wanted.then(|| Program { purposes: Vec::new(), ..program.clone() });
        Self { calls: AtomicU32::new(0), program, of_one: OnceLock::new(), of_eight: OnceLock::new() }
    }

    /// Runs the machine code, whose inputs stand in this order; `false`: there is none yet.
    pub fn run(&self, inputs: &[(u32, Argument, u32)], state: &State<'_, f64>, output: &mut [f64]) -> bool {
        let Some(program) = &self.program else { return false };
        let native = match self.of_one.get() {
            Some(native) => native,
            // The one that counts this call makes it; others go on meanwhile.
            None if self.calls.fetch_add(1, Ordering::Relaxed) == CALLS => {
                self.of_one.get_or_init(|| Native::of_one(program, &order(inputs)))
            }
            None => return false,
        };
        let Some(native) = native else { return false };
        MEMORY.with_borrow_mut(|memory| {
            memory.resize(memory.len().max(native.memory()), 0.0);
            for (place, (_, argument, element)) in memory.iter_mut().zip(inputs) {
                *place = state.get(*argument)[*element as usize];
            }
            native.run(memory, output);
        });
        true
    }

    /// Whether there is machine code for one state.
    pub fn is_made(&self) -> bool {
        matches!(self.of_one.get(), Some(Some(_)))
    }

    /// Machine code for eight states side by side, where there are many.
    pub fn of_eight(&self, inputs: &[(u32, Argument, u32)], states: usize) -> Option<&Native> {
        let program = self.program.as_ref().filter(|_| states >= MANY)?;
        self.of_eight.get_or_init(|| Native::of_eight(program, &order(inputs))).as_ref()
    }
}
