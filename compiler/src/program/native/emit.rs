//! From steps to machine code: the evaluator's operations on the evaluator's operands, so that every bit is its.
use super::assembler::{Assembler, At, Base, Binary, Bits, Form, Fused, Register, Width};
use super::outside;
use super::registers::Registers;
use super::units::{Member, Source, Step, steps};
use crate::expression::Call;
use crate::program::{Instruction, Paired};
use bipedc_runtime::Argument;

/// Code with what it reads.
pub struct Emitted {
    pub code: Vec<u8>,
    /// Of each constant as many copies as a register has room for.
    pub constants: Vec<u64>,
    /// Numbers (times lanes) of memory.
    pub memory: usize,
}

struct Emitter {
    to: Assembler,
    registers: Registers,
    /// What a number of one state is here.
    single: Width,
    /// Inputs, then three times as many numbers as there are angles; slots stand behind them.
    inputs: usize,
    angles: usize,
    /// Bytes of a place in memory.
    stride: usize,
    /// A register that holds 0 while results are stored.
    zero: Option<Register>,
}

/// Code of a program whose inputs stand in memory in this order; wide: four states at once, eight numbers apart (then nothing is paired). `None`: a law of an effect
/// has no wide form.
pub fn emit(paired: &Paired, inputs: &[(Argument, u32)], wide: bool) -> Option<Emitted> {
    let calls = |i: &Instruction| matches!(i, Instruction::Call(call, _) if *call != Call::Abs);
    if wide && paired.program.instructions.iter().any(calls) {
        return None;
    }
    let steps = steps(paired, inputs);
    let (single, stride) = if wide { (Width::Four, 64) } else { (Width::One, 8) };
    let mut emitter = Emitter {
        to: Assembler::default(),
        registers: Registers::new(&steps.list, single, stride),
        single,
        inputs: inputs.len(),
        angles: paired.program.angles.len(),
        stride,
        zero: None,
    };
    let first_slot = emitter.first_slot();
    emitter.to.begin((first_slot * stride) as i32);
    for (index, (step, pair)) in steps.list.iter().enumerate() {
        emitter.step(index, *step, if *pair { Width::Two } else { single }, &steps.pool);
    }
    emitter.leave_wide();
    emitter.to.end();
    let copies = if wide { 2 } else { 1 };
    let constants = steps.pool.iter().flat_map(|bits| std::iter::repeat_n(*bits, copies)).flatten().collect();
    let memory = first_slot + emitter.registers.slots as usize;
    Some(Emitted { code: emitter.to.code, constants, memory })
}

impl Emitter {
    fn first_slot(&self) -> usize {
        self.inputs + 3 * self.angles
    }

    fn leave_wide(&mut self) {
        if self.single == Width::Four {
            self.to.leave_wide();
        }
    }

    /// Where a place of memory is, from the first slot on.
    fn offset(&self, place: usize) -> i32 {
        ((place as isize - self.first_slot() as isize) * self.stride as isize) as i32
    }

    fn at(&self, source: Source) -> At {
        match source {
            Source::Unit(unit) => self.registers.at(unit),
            Source::Place(place) => At::Memory(Base::Memory, self.offset(place)),
            Source::Pool(place) => {
                let bytes = if self.single == Width::Four { 32 } else { 16 };
                At::Memory(Base::Constants, (place * bytes) as i32)
            }
        }
    }

    /// Where an operand is, in a register if it is needed again soon.
    fn near(&mut self, source: Source, index: usize, keep: &mut Vec<Register>) -> At {
        let at = match source {
            Source::Unit(unit) => self.registers.near(unit, index, keep, &mut self.to),
            _ => self.at(source),
        };
        keep.extend(register(at));
        at
    }

    /// A number: in a register as its first or, where so said, second one; else where it is in memory.
    fn member(&self, (source, second): Member) -> (At, bool) {
        match self.at(source) {
            At::Memory(base, offset) => (At::Memory(base, offset + if second { 8 } else { 0 }), false),
            at => (at, second),
        }
    }

    /// A register for the result of a step.
    fn target(&mut self, index: usize, keep: &[Register]) -> Register {
        self.registers.take(index, keep, &mut self.to)
    }

    /// The register of an operand that no later step uses: it is free from now on.
    fn last_used(&mut self, index: usize, source: Source) -> Option<Register> {
        let Source::Unit(unit) = source else { return None };
        let at = register(self.registers.at(unit))?;
        self.registers.empty_if_last(unit, index).then_some(at)
    }

    fn step(&mut self, index: usize, step: Step, width: Width, pool: &[[u64; 2]]) {
        let result = match step {
            Step::Binary(operation, a, b) => Some(self.binary(index, width, operation, a, b)),
            Step::Bits(operation, a, mask) => Some(self.bits(index, width, operation, a, mask)),
            Step::Sqrt(a) => {
                let at = self.near(a, index, &mut Vec::new());
                let to = self.target(index, &[]);
                let first = if width == Width::One { to } else { 0 };
                self.to.binary(width, Binary::Sqrt, to, first, at);
                Some(to)
            }
            Step::Fused(operation, sources) => Some(self.fused(index, width, operation, sources)),
            Step::Call(call, a) => {
                self.registers.give_all_up(&mut self.to);
                self.to.load(width, 0, self.at(a));
                self.to.call(outside::of(call) as usize);
                Some(0)
            }
            Step::Second(pair) => Some(self.second(index, pair)),
            Step::Twice(a) => Some(self.twice(index, a)),
            Step::Join(a, b) => Some(self.join(index, a, b)),
            Step::Angle(place, a) => {
                let offset = self.offset(place);
                self.keep_in(index, (Base::Memory, offset), a);
                None
            }
            Step::Sines => {
                self.sines();
                None
            }
            Step::Output(k, a) => {
                self.output(index, k, a, pool);
                None
            }
        };
        step.units().for_each(|unit| self.registers.let_go(unit, index + 1));
        if let Some(to) = result {
            self.registers.put(index as u32, to);
            self.registers.let_go(index as u32, index + 1);
        }
    }

    fn sines(&mut self) {
        self.registers.give_all_up(&mut self.to);
        let wide = self.single == Width::Four;
        let function = if wide { outside::four_sines as *const () } else { outside::sines as *const () };
        let offset = self.offset(self.inputs);
        self.leave_wide();
        self.to.call_with_place(function as usize, offset, self.angles as i32);
    }

    fn output(&mut self, index: usize, k: usize, member: Member, pool: &[[u64; 2]]) {
        let place = (Base::Outputs, (k * self.stride) as i32);
        // Many outputs of regressors are 0: that is kept in a register, behind everything that is computed.
        let is_zero = matches!(member.0, Source::Pool(constant) if pool[constant] == [0; 2]);
        match self.zero.filter(|_| is_zero) {
            Some(zero) => self.to.store(self.single, place.0, place.1, zero),
            None => {
                let register = self.keep_in(index, place, member);
                self.zero = self.zero.or(is_zero.then_some(register));
            }
        }
    }

    /// Stores a number; by which register.
    fn keep_in(&mut self, index: usize, (base, offset): (Base, i32), member: Member) -> Register {
        match self.member(member) {
            (At::Register(register), true) => {
                self.to.store_second(base, offset, register);
                register
            }
            (at, _) => {
                let register = register(at).unwrap_or_else(|| {
                    let keep: Vec<Register> = self.zero.into_iter().collect();
                    let register = self.target(index, &keep);
                    self.to.load(self.single, register, at);
                    register
                });
                self.to.store(self.single, base, offset, register);
                register
            }
        }
    }

    fn binary(&mut self, index: usize, width: Width, operation: Binary, a: Source, b: Source) -> Register {
        let mut keep = Vec::new();
        let mut first = self.near(a, index, &mut keep);
        let mut second = self.near(b, index, &mut keep);
        let commutes = matches!(operation, Binary::Add | Binary::Mul);
        if commutes && register(first).is_none() && register(second).is_some() {
            std::mem::swap(&mut first, &mut second);
        }
        match first {
            At::Register(first) => {
                // Operands are read before the result is written.
                let to = self.registers.free(&keep).or_else(|| self.last_used(index, a));
                let to = to.or_else(|| self.last_used(index, b));
                let to = to.unwrap_or_else(|| self.target(index, &keep));
                self.to.binary(width, operation, to, first, second);
                to
            }
            At::Memory(..) => {
                let to = self.target(index, &keep);
                self.to.load(width, to, first);
                self.to.binary(width, operation, to, to, second);
                to
            }
        }
    }

    fn bits(&mut self, index: usize, width: Width, operation: Bits, a: Source, mask: Source) -> Register {
        let mut keep = Vec::new();
        let at = self.near(a, index, &mut keep);
        let to = self.target(index, &keep);
        let from = register(at).unwrap_or_else(|| {
            self.to.load(width, to, at);
            to
        });
        let mask = self.at(mask);
        self.to.bits(width, operation, to, from, mask);
        to
    }

    fn fused(&mut self, index: usize, width: Width, operation: Fused, [a, b, c]: [Source; 3]) -> Register {
        let mut keep = Vec::new();
        let addend = self.near(c, index, &mut keep);
        let (mut a, mut b) = ((a, self.near(a, index, &mut keep)), (b, self.near(b, index, &mut keep)));
        if register(a.1).is_none() && register(b.1).is_some() {
            std::mem::swap(&mut a, &mut b);
        }
        let (to, form, first, second) = match self.in_place_of(index, a, b, (c, addend)) {
            Some(found) => found,
            None => self.beside(index, width, [a.1, b.1, addend], &keep),
        };
        keep.push(to);
        let first = register(first).unwrap_or_else(|| {
            let register = self.target(index, &keep);
            self.to.load(width, register, first);
            register
        });
        self.to.fused(width, (operation, form), to, first, second);
        to
    }

    /// A fused operation whose result takes the register of an operand that is not used again. If any factor is in a register, `a` is.
    fn in_place_of(
        &mut self,
        index: usize,
        a: (Source, At),
        b: (Source, At),
        c: (Source, At),
    ) -> Option<(Register, Form, At, At)> {
        if let Some(to) = self.last_used(index, c.0) {
            return Some((to, Form::AddendFactorFactor, a.1, b.1));
        }
        for (own, other) in [(a, b), (b, a)] {
            // Of two operands in memory one has to be loaded: that one's register is the result's then.
            let in_memory = register(other.1).is_none() && register(c.1).is_none();
            if !in_memory && let Some(to) = self.last_used(index, own.0) {
                return Some(match other.1 {
                    At::Register(_) => (to, Form::FactorFactorAddend, other.1, c.1),
                    At::Memory(..) => (to, Form::FactorAddendFactor, c.1, other.1),
                });
            }
        }
        None
    }

    /// A fused operation in a register of its own: an operand that is in memory is loaded there, else the addend is copied.
    fn beside(
        &mut self,
        index: usize,
        width: Width,
        [a, b, c]: [At; 3],
        keep: &[Register],
    ) -> (Register, Form, At, At) {
        let to = self.target(index, keep);
        let (loaded, form, first, second) = match (a, b, c) {
            (At::Memory(..), _, At::Register(_)) => (a, Form::FactorAddendFactor, c, b),
            (_, At::Memory(..), At::Register(_)) => (b, Form::FactorFactorAddend, a, c),
            _ => (c, Form::AddendFactorFactor, a, b),
        };
        self.to.load(width, to, loaded);
        (to, form, first, second)
    }

    fn second(&mut self, index: usize, pair: u32) -> Register {
        match self.member((Source::Unit(pair), true)) {
            (At::Register(from), _) => {
                let to = self.target(index, &[from]);
                self.to.shuffle(to, (from, true), (from, true));
                to
            }
            (at, _) => {
                let to = self.target(index, &[]);
                self.to.load(Width::One, to, at);
                to
            }
        }
    }

    fn twice(&mut self, index: usize, member: Member) -> Register {
        let (at, second) = self.member(member);
        let keep: Vec<Register> = register(at).into_iter().collect();
        let to = self.target(index, &keep);
        match at {
            At::Register(from) if second => self.to.shuffle(to, (from, true), (from, true)),
            at => self.to.twice(to, at),
        }
        to
    }

    fn join(&mut self, index: usize, a: Member, b: Member) -> Register {
        let (first, second) = (self.member(a), self.member(b));
        let keep: Vec<Register> = [first.0, second.0].into_iter().filter_map(register).collect();
        let to = self.target(index, &keep);
        let from = match first {
            (At::Register(from), false) => (from, false),
            // What is joined from memory comes behind a first number.
            (At::Register(from), true) if register(second.0).is_some() => (from, true),
            (At::Register(from), true) => {
                self.to.shuffle(to, (from, true), (from, true));
                (to, false)
            }
            (at, _) => {
                self.to.load(Width::One, to, at);
                (to, false)
            }
        };
        match second {
            (At::Register(other), is_second) => self.to.shuffle(to, from, (other, is_second)),
            (at, _) => self.to.join(to, from.0, at),
        }
        to
    }
}

fn register(at: At) -> Option<Register> {
    match at {
        At::Register(register) => Some(register),
        At::Memory(..) => None,
    }
}
