//! Phases that were followed already. What a phase does is told by the state in which it begins and by those gait parameters that its
//! functions read: over a map most phases of neighbouring cells are the same one.
use super::course::Course;
use super::near::{Near, Recent};
use super::{Chain, Refused};
use bipedc_compiler::program::Operand;
use bipedc_runtime::Argument;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Phases that are kept at most; then all are forgotten.
const MOST: usize = 40_000;

/// Gait parameters that functions of a phase read.
#[derive(Debug, Clone, Default)]
pub(super) struct Read {
    /// Those that say where its postures and its end are.
    pub shape: Vec<usize>,
    /// All.
    pub all: Vec<usize>,
}

/// A phase by its index, the bits of the state in which it begins and of the parameters.
pub(super) type Key = (usize, Vec<u64>);

/// A phase that was followed to its end.
#[derive(Clone)]
pub(super) struct Followed {
    /// s
    pub duration: f64,
    pub limited: bool,
    pub missed: bool,
    /// The phase that begins then, in which state of the whole robot.
    pub next: Result<(usize, Vec<f64>), Refused>,
}

/// Posture and direction after a phase that ended as its own formulas say.
pub(super) type Ended = Result<[Vec<f64>; 2], Refused>;

/// φ_m, ψ(φ₊, φ_m) and P(φ_m), and where the search for postures was then.
pub(super) type Centre = ([f64; 3], Near);

/// What chains of one gait know together: what one of them has found is what every other one would find.
#[derive(Default)]
pub(in crate::gait) struct Known {
    pub(super) followed: Store<Followed>,
    pub(super) centres: Store<Centre>,
    pub(super) ended: Store<Ended>,
}

/// What was found for some keys.
pub(super) struct Store<T>(Mutex<HashMap<Key, T>>);

impl<T> Default for Store<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Clone> Store<T> {
    pub fn get(&self, key: &Key) -> Option<T> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(key).cloned()
    }

    /// Keeps what was found, among not too many.
    pub fn keep(&self, key: Key, found: T) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() >= MOST {
            known.clear();
        }
        known.insert(key, found);
    }
}

/// Surfaces of the last phases.
#[derive(Default)]
pub(super) struct Courses(Recent<Key, Mutex<Course>>);

impl Courses {
    /// The surface of a phase: the one that is known, or a new one.
    pub fn of(&mut self, key: Key, new: impl FnOnce() -> Course) -> Arc<Mutex<Course>> {
        if let Some(known) = self.0.get(&key) {
            return known;
        }
        let made = Arc::new(Mutex::new(new()));
        self.0.keep(key, &made);
        made
    }
}

/// Bits of a state and of those parameters that are read.
pub(super) fn key(phase: usize, state: [&[f64]; 2], parameters: &[f64], read: &[usize]) -> Key {
    let state = state.into_iter().flatten().copied();
    let read = read.iter().map(|&k| parameters.get(k).copied().unwrap_or(f64::NAN));
    (phase, state.chain(read).map(f64::to_bits).collect())
}

impl Chain<'_> {
    /// Which gait parameters functions of a phase of the gait read.
    pub(super) fn read(bench: &super::PhasedBench, index: usize) -> Read {
        let (name, first) = (&bench.gait.phases[index].name, bench.compiled.arguments.parameter(0));
        let mut found = Read::default();
        for function in &bench.compiled.model.functions {
            if function.subject.as_ref() != Some(name) {
                continue;
            }
            let program = &function.program;
            let operands = program.instructions.iter().flat_map(|instruction| instruction.operands());
            let all = operands.chain(program.angles.iter().copied()).chain(program.outputs.iter().copied());
            let shape = function.family.starts_with("virtual_constraints")
                || ["wanted", "phase_end"].contains(&function.family);
            for operand in all {
                let Operand::Input(Argument::Parameters, place) = operand else { continue };
                let Some(k) = (place as usize).checked_sub(first) else { continue };
                if k < bench.gait.parameters.len() {
                    found.all.push(k);
                    found.shape.extend(shape.then_some(k));
                }
            }
        }
        for list in [&mut found.all, &mut found.shape] {
            list.sort_unstable();
            list.dedup();
        }
        found
    }

    /// The present phase as it began.
    pub(super) fn key_of_present(&self, phase: usize) -> Result<Key, Refused> {
        let of = self.phase(phase)?;
        let present = self.present.borrow();
        let parameters = present.controller.arguments().get(3..).unwrap_or(&[]);
        Ok(key(phase, [&present.begun, &[]], parameters, &of.read.all))
    }
}
