//! Which results are in registers: those that are used soonest.
use super::assembler::{Assembler, At, Base, Register, Width};
use super::units::{Step, Unit};

/// How many there are.
const REGISTERS: usize = 16;
/// A result that is used again within so many instructions is brought back into a register.
const SOON: usize = 24;

/// Where results are while code is written.
pub struct Registers {
    /// What each register holds.
    holds: [Option<Unit>; REGISTERS],
    /// By result.
    register: Vec<Option<Register>>,
    slot: Vec<Option<u32>>,
    width: Vec<Width>,
    /// Steps that use each result, last first.
    uses: Vec<Vec<usize>>,
    /// For one number, and for pairs.
    free_slots: [Vec<u32>; 2],
    /// Slots that were given out.
    pub slots: u32,
    /// Bytes of a slot.
    stride: usize,
}

impl Registers {
    /// Of steps, each with how wide its result is; a slot has `stride` bytes.
    pub fn new(steps: &[(Step, bool)], single: Width, stride: usize) -> Self {
        let mut uses = vec![Vec::new(); steps.len()];
        for (index, (step, _)) in steps.iter().enumerate().rev() {
            step.units().for_each(|unit| uses[unit as usize].push(index));
        }
        Self {
            holds: [None; REGISTERS],
            register: vec![None; steps.len()],
            slot: vec![None; steps.len()],
            width: steps.iter().map(|(_, pair)| if *pair { Width::Two } else { single }).collect(),
            uses,
            free_slots: [Vec::new(), Vec::new()],
            slots: 0,
            stride,
        }
    }

    fn place_of(&self, slot: u32) -> At {
        At::Memory(Base::Memory, (slot as usize * self.stride) as i32)
    }

    /// Where a result is.
    pub fn at(&self, value: Unit) -> At {
        match (self.register[value as usize], self.slot[value as usize]) {
            (Some(register), _) => At::Register(register),
            (None, Some(slot)) => self.place_of(slot),
            (None, None) => unreachable!("a result is somewhere while it is used"),
        }
    }

    /// The same, in a register if it is needed again soon.
    pub fn near(&mut self, value: Unit, index: usize, keep: &[Register], to: &mut Assembler) -> At {
        let at = self.at(value);
        let again = self.uses[value as usize].iter().rev().find(|next| **next > index);
        if matches!(at, At::Memory(..)) && again.is_some_and(|next| *next < index + SOON) {
            let register = self.take(index, keep, to);
            to.load(self.width[value as usize], register, at);
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
    pub fn empty_if_last(&mut self, value: Unit, index: usize) -> bool {
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
            let width = self.width[value as usize];
            let pair = usize::from(width == Width::Two);
            let slot = self.free_slots[pair].pop().unwrap_or_else(|| {
                self.slots += 1 + pair as u32;
                self.slots - 1 - pair as u32
            });
            self.slot[value as usize] = Some(slot);
            if let At::Memory(base, offset) = self.place_of(slot) {
                to.store(width, base, offset, register);
            }
        }
    }

    /// All of them, before a function is called.
    pub fn give_all_up(&mut self, to: &mut Assembler) {
        (0..REGISTERS as Register).for_each(|register| self.give_up(register, to));
    }

    /// A result is in a register now.
    pub fn put(&mut self, value: Unit, register: Register) {
        self.holds[register as usize] = Some(value);
        self.register[value as usize] = Some(register);
    }

    /// Forgets a result that no step from this one on uses.
    pub fn let_go(&mut self, value: Unit, index: usize) {
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
            self.free_slots[usize::from(self.width[k] == Width::Two)].push(slot);
        }
    }
}
