//! Programs as machine code of this processor, made while they run. Without AVX, and on other processors than x86-64, there is none.
mod assembler;
mod emit;
mod outside;
mod registers;
mod units;

use super::{Paired, Program};
use bipedc_runtime::Argument;
use emit::{Emitted, emit};
use memmap2::{Mmap, MmapMut};

/// Memory, outputs, constants.
type Code = unsafe extern "sysv64" fn(*mut f64, *mut f64, *const u64);

/// Machine code of a program, for one state or for eight side by side.
#[derive(Debug)]
pub(super) struct Native {
    code: Mmap,
    constants: Vec<u64>,
    memory: usize,
    outputs: usize,
}

impl Native {
    /// For one state. The program's inputs stand in memory in this order; pairs are computed at once. `None`: not on this machine.
    pub fn of_one(program: &Paired, inputs: &[(Argument, u32)]) -> Option<Self> {
        Self::new(program, inputs, false)
    }

    /// For eight states; `None` also where laws of effects call functions.
    pub fn of_eight(program: &Program, inputs: &[(Argument, u32)]) -> Option<Self> {
        Self::new(&Paired::alone(program), inputs, true)
    }

    fn new(paired: &Paired, inputs: &[(Argument, u32)], wide: bool) -> Option<Self> {
        if !std::is_x86_feature_detected!("avx") {
            return None;
        }
        let Emitted { code, constants, memory } = emit(paired, inputs, wide)?;
        let mut pages = MmapMut::map_anon(code.len()).ok()?;
        pages.copy_from_slice(&code);
        let code = pages.make_exec().ok()?;
        Some(Self { code, constants, memory, outputs: paired.program.outputs.len() })
    }

    /// Numbers of memory that a call needs, of each state.
    pub fn memory(&self) -> usize {
        self.memory
    }

    /// Of the code, its constants and the memory of a call.
    pub fn bytes(&self) -> usize {
        self.code.len() + size_of::<u64>() * self.constants.len() + size_of::<f64>() * self.memory
    }

    fn code(&self) -> Code {
        // SAFETY: the pages hold a function of this signature from their beginning on, as long as this lives.
        unsafe { std::mem::transmute::<*const u8, Code>(self.code.as_ptr()) }
    }

    /// Runs code of one state on the inputs at the beginning of `memory`.
    pub fn run(&self, memory: &mut [f64], output: &mut [f64]) {
        assert!(memory.len() >= self.memory && output.len() >= self.outputs, "too little memory");
        // SAFETY: the code touches `memory` numbers of the first, `outputs` of the second, and its own constants.
        unsafe { self.code()(memory.as_mut_ptr(), output.as_mut_ptr(), self.constants.as_ptr()) }
    }

    /// Runs code of eight states, as above.
    pub fn run_eight(&self, memory: &mut [[f64; 8]], output: &mut [[f64; 8]]) {
        assert!(memory.len() >= self.memory && output.len() >= self.outputs, "too little memory");
        let (memory, output) = (memory.as_mut_ptr().cast::<f64>(), output.as_mut_ptr().cast::<f64>());
        for half in [0, 4] {
            // SAFETY: as above; the code touches the first four of each eight numbers, from the fourth on the others.
            unsafe { self.code()(memory.add(half), output.add(half), self.constants.as_ptr()) }
        }
    }
}
