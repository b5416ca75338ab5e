//! Which results are in registers: those that are used soonest.
use super::assembler::{Assembler, At, Base, Register};
use crate::program::{Operand, Program};

/// How many there are.
const REGISTERS: usize = 16;
/// A result that is used again within so many instructions is brought back into a register.
const SOON: usize = 24;

/// Where results are while code is written.
pub struct Registers {
    /// What each register holds.
    holds: [Option<u32>; REGISTERS],
    /// By result.
    register: Vec<Option<Register>>,
    slot: Vec<Option<u32>>,
    /// Instructions that use each result, last first; outputs and angles are instructions too.
    uses: Vec<Vec<usize>>,
    free_slots: Vec<u32>,
    /// Slots that were given out.
    pub slots: u32,
    first_slot: usize,
    stride: usize,
}

impl Registers {
    /// Slots begin at a place in memory; a place has `stride` bytes.
    pub fn new(program: &Program, first_slot: usize, stride: usize) -> Self {
        let count = program.instructions.len();
        let mut uses = vec![Vec::new(); count];
        let mut used = |operand: Operand, at: usize| {
            if let Operand::Value(k) = operand {
                uses[k as usize].push(at);
            }
        };
        program.outputs.iter().for_each(|operand| used(*operand, count));
        for (index, instruction) in program.instructions.iter().enumerate().rev() {
            if index + 1 == program.angles_ready {
                // Between this instruction and the next one.
                program.angles.iter().for_each(|operand| used(*operand, index + 1));
            }
            instruction.operands().for_each(|operand| used(operand, index));
        }
        Self {
            holds: [None; REGISTERS],
            register: vec![None; count],
            slot: vec![None; count],
            uses,
            free_slots: Vec::new(),
            slots: 0,
            first_slot,
            stride,
        }
    }

    fn place_of(&self, slot: u32) -> At {
        At::Memory(Base::Memory, ((self.first_slot + slot as usize) * self.stride) as i32)
    }

    /// Where a result is.
    pub fn at(&self, value: u32) -> At {
        match (self.register[value as usize], self.slot[value as usize]) {
            (Some(register), _) => At::Register(register),
            (None, Some(slot)) => self.place_of(slot),
            (None, None) => unreachable!("a result is somewhere while it is used"),
        }
    }

    /// The same, in a register if it is needed again soon.
    pub fn near(&mut self, value: u32, index: usize, keep: &[Register], to: &mut Assembler) -> At {
        let at = self.at(value);
        let again = self.uses[value as usize].iter().rev().find(|next| **next > index);
        if matches!(at, At::Memory(..)) && again.is_some_and(|next| *next < index + SOON) {
            let register = self.take(index, keep, to);
            to.load(register, at);
            self.put(value, register);
            return At::Register(register);
        }
        at
    }

    /// A register for something else: a free one, else that of the result which is used last.
    pub fn take(&mut self, index: usize, keep: &[Register], to: &mut Assembler) -> Register {
        let mut best = (0, 0);
        for (k, held) in self.holds.iter().enumerate() {
            let register = k as Register;
            if keep.contains(&register) {
                continue;
            }
            let Some(value) = held else { return register };
            let next = self.uses[*value as usize].iter().rev().find(|next| **next >= index);
            let distance = next.map_or(usize::MAX, |next| *next);
            if distance >= best.1 {
                best = (register, distance);
            }
        }
        self.give_up(best.0, to);
        best.0
    }

    /// A register that holds nothing.
    pub fn free(&self, keep: &[Register]) -> Option<Register> {
        let free = |register: &Register| self.holds[*register as usize].is_none() && !keep.contains(register);
        (0..REGISTERS as Register).find(free)
    }

    /// Empties the register of a result that no instruction behind this one uses.
    pub fn empty_if_last(&mut self, value: u32, index: usize) -> bool {
        let last = self.uses[value as usize].iter().all(|next| *next <= index);
        if last && let Some(register) = self.register[value as usize].take() {
            self.holds[register as usize] = None;
        }
        last
    }

    /// What a register holds goes to memory, unless it is there already.
    fn give_up(&mut self, register: Register, to: &mut Assembler) {
        let Some(value) = self.holds[register as usize].take() else { return };
        self.register[value as usize] = None;
        if self.slot[value as usize].is_none() {
            let slot = self.free_slots.pop().unwrap_or_else(|| {
                self.slots += 1;
                self.slots - 1
            });
            self.slot[value as usize] = Some(slot);
            if let At::Memory(base, offset) = self.place_of(slot) {
                to.store(base, offset, register);
            }
        }
    }

    /// All of them, before a function is called.
    pub fn give_all_up(&mut self, to: &mut Assembler) {
        (0..REGISTERS as Register).for_each(|register| self.give_up(register, to));
    }

    /// A result is in a register now.
    pub fn put(&mut self, value: u32, register: Register) {
        self.holds[register as usize] = Some(value);
        self.register[value as usize] = Some(register);
    }

    /// Forgets what no instruction from this one on uses.
    pub fn let_go(&mut self, operand: Operand, index: usize) {
        let Operand::Value(value) = operand else { return };
        let k = value as usize;
        while self.uses[k].last().is_some_and(|next| *next < index) {
            self.uses[k].pop();
        }
        if !self.uses[k].is_empty() {
            return;
        }
        if let Some(register) = self.register[k].take() {
            self.holds[register as usize] = None;
        }
        if let Some(slot) = self.slot[k].take() {
            self.free_slots.push(slot);
        }
    }
}
