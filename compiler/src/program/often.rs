//! When a program becomes machine code: once interpreting it has taken about as long as making that takes.
use super::native::Native;
use super::{Paired, Program};
use crate::tree::Twins;
use bipedc_runtime::lanes::F64x8;
use bipedc_runtime::{Argument, State};
use std::cell::RefCell;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

/// Calls after which machine code is made: a quarter of a microsecond per operation against a nanosecond per call that it saves.
const CALLS: u32 = 300;
/// The same of eight states at once.
const WIDE_CALLS: u32 = 100;
/// So many states at once are worth machine code of their own.
const MANY: usize = 1000;
/// In the environment, whatever its value: nothing becomes machine code.
const SWITCH: &str = "BIPEDC_INTERPRET";

thread_local! {
    static MEMORY: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
    /// Inputs and results of eight states.
    static WIDE: RefCell<[Vec<[f64; 8]>; 2]> = const { RefCell::new([Vec::new(), Vec::new()]) };
}

/// Whether anything becomes machine code.
pub(super) fn is_wanted() -> bool {
    std::env::var_os(SWITCH).is_none()
}

/// How often a program was called, and its machine code.
#[derive(Debug)]
pub(super) struct Often {
    calls: AtomicU32,
    wide_calls: AtomicU32,
    /// What it is made of; `None`: it is never made.
    program: Option<Program>,
    /// Limbs whose operations are computed at once, where that is known.
    twins: Option<Arc<Twins>>,
    /// Arguments, and how many of their elements are read: they stand in memory one after the other.
    inputs: Vec<(Argument, usize)>,
    of_one: OnceLock<Option<Native>>,
    of_eight: OnceLock<Option<Native>>,
}

impl Often {
    /// `inputs`: elements that are read.
    pub fn new(program: &Program, inputs: &[(u32, Argument, u32)], twins: Option<&Arc<Twins>>) -> Self {
        let elements = |wanted: Argument| {
            inputs.iter().filter(|input| input.1 == wanted).map(|input| input.2 as usize + 1).max()
        };
        let inputs =
            Argument::ALL.into_iter().filter_map(|argument| Some((argument, elements(argument)?))).collect();
        let wanted = is_wanted();
        let twins = twins.filter(|twins| !twins.is_empty()).cloned();
        // What operations are for tells to which limb they belong.
        let purposes = || if twins.is_some() { program.purposes.clone() } else { Vec::new() };
        let program = wanted.then(|| Program { purposes: purposes(), ..program.clone() });
        let none = || AtomicU32::new(0);
        Self {
            calls: none(),
            wide_calls: none(),
            program,
            twins,
            inputs,
            of_one: OnceLock::new(),
            of_eight: OnceLock::new(),
        }
    }

    /// Every place of memory that is an input.
    pub fn places(&self) -> Vec<(Argument, u32)> {
        self.inputs
            .iter()
            .flat_map(|&(argument, count)| (0..count as u32).map(move |k| (argument, k)))
            .collect()
    }

    fn paired(&self, program: &Program) -> Paired {
        self.twins.as_ref().map_or_else(|| Paired::alone(program), |twins| Paired::new(program, twins))
    }

    /// Runs the machine code; `false`: there is none yet.
    pub fn run(&self, state: &State<'_, f64>, output: &mut [f64]) -> bool {
        let Some(program) = &self.program else { return false };
        let native = match self.of_one.get() {
            Some(native) => native,
            // The one that counts this call makes it; others go on meanwhile.
            None if self.calls.fetch_add(1, Ordering::Relaxed) == CALLS => {
                self.of_one.get_or_init(|| Native::of_one(&self.paired(program), &self.places()))
            }
            None => return false,
        };
        let Some(native) = native else { return false };
        MEMORY.with_borrow_mut(|memory| {
            if memory.len() < native.memory() {
                memory.resize(native.memory(), 0.0);
            }
            let mut first = 0;
            for (argument, count) in &self.inputs {
                memory[first..first + count].copy_from_slice(&state.get(*argument)[..*count]);
                first += count;
            }
            native.run(memory, output);
        });
        true
    }

    /// Runs the machine code on eight states side by side; `false`: there is none yet.
    pub fn run_eight(&self, state: &State<'_, F64x8>, output: &mut [F64x8]) -> bool {
        let made = self.of_eight.get().is_some();
        if !made && self.wide_calls.fetch_add(1, Ordering::Relaxed) != WIDE_CALLS {
            return false;
        }
        let Some(native) = self.of_eight(MANY) else { return false };
        WIDE.with_borrow_mut(|[memory, results]| {
            memory.resize(memory.len().max(native.memory()), [0.0; 8]);
            results.resize(results.len().max(output.len()), [0.0; 8]);
            let mut places = memory.iter_mut();
            for (argument, count) in &self.inputs {
                let elements = state.get(*argument)[..*count].iter();
                // The argument is first: no place is lost where it ends.
                elements.zip(&mut places).for_each(|(element, place)| *place = element.to_array());
            }
            native.run_eight(memory, results);
            output.iter_mut().zip(results).for_each(|(to, result)| *to = F64x8::from_array(*result));
        });
        true
    }

    /// Whether there is machine code for one state.
    pub fn is_made(&self) -> bool {
        matches!(self.of_one.get(), Some(Some(_)))
    }

    /// Bytes that the machine code for one state takes, its constants and its memory of a call among them; 0: there is none.
    pub fn bytes(&self) -> usize {
        self.of_one.get().and_then(Option::as_ref).map_or(0, Native::bytes)
    }

    /// Machine code for eight states side by side, where there are many.
    pub fn of_eight(&self, states: usize) -> Option<&Native> {
        let program = self.program.as_ref().filter(|_| states >= MANY)?;
        self.of_eight.get_or_init(|| Native::of_eight(program, &self.places())).as_ref()
    }
}
