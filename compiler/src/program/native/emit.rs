//! From a program to machine code: the evaluator's operations on the evaluator's operands, so that every bit is its.
use super::assembler::{Assembler, At, Base, Binary, Bits, Fused, Register};
use super::outside;
use super::registers::Registers;
use crate::expression::Call;
use crate::program::{Instruction, Operand, Program};
use bipedc_runtime::Argument;
use rustc_hash::FxHashMap;

/// Signs, and everything but signs; constants of programs follow.
const MASKS: [u64; 2] = [1 << 63, !(1 << 63)];

/// Code with what it reads.
pub struct Emitted {
    pub code: Vec<u8>,
    /// Of each constant as many copies as a register has room for.
    pub constants: Vec<u64>,
    /// Numbers (times lanes) of memory.
    pub memory: usize,
}

struct Emitter<'a> {
    program: &'a Program,
    to: Assembler,
    registers: Registers,
    inputs: FxHashMap<(Argument, u32), usize>,
    constants: FxHashMap<u64, usize>,
    pool: Vec<u64>,
    /// Bytes of a place in memory.
    stride: usize,
}

/// Code of a program whose inputs stand in memory in this order; wide: four states at once, eight numbers apart. `None`: a law of an effect has no wide form.
pub fn emit(program: &Program, inputs: &[(Argument, u32)], wide: bool) -> Option<Emitted> {
    let calls = |i: &Instruction| matches!(i, Instruction::Call(call, _) if *call != Call::Abs);
    if wide && program.instructions.iter().any(calls) {
        return None;
    }
    let stride = if wide { 64 } else { 8 };
    let first_slot = inputs.len() + 3 * program.angles.len();
    let mut emitter = Emitter {
        program,
        to: Assembler::new(wide),
        registers: Registers::new(program, first_slot, stride),
        inputs: inputs.iter().enumerate().map(|(k, input)| (*input, k)).collect(),
        constants: FxHashMap::default(),
        pool: MASKS.to_vec(),
        stride,
    };
    emitter.to.begin();
    for (index, instruction) in program.instructions.iter().enumerate() {
        if index == program.angles_ready {
            emitter.angles();
        }
        emitter.instruction(index, instruction);
    }
    if program.angles_ready == program.instructions.len() {
        emitter.angles();
    }
    emitter.outputs();
    emitter.to.end();
    let copies = if wide { 4 } else { 2 };
    let constants = emitter.pool.iter().flat_map(|bits| std::iter::repeat_n(*bits, copies)).collect();
    let memory = first_slot + emitter.registers.slots as usize;
    Some(Emitted { code: emitter.to.code, constants, memory })
}

impl Emitter<'_> {
    fn constant(&mut self, bits: u64) -> At {
        let next = self.pool.len();
        let place = *self.constants.entry(bits).or_insert(next);
        if place == next {
            self.pool.push(bits);
        }
        self.pooled(place)
    }

    fn pooled(&self, place: usize) -> At {
        At::Memory(Base::Constants, (place * if self.to.wide { 32 } else { 16 }) as i32)
    }

    fn in_memory(&self, place: usize) -> At {
        At::Memory(Base::Memory, (place * self.stride) as i32)
    }

    fn at(&mut self, operand: Operand) -> At {
        let (angles, count) = (self.inputs.len(), self.program.angles.len());
        match operand {
            Operand::Constant(x) => self.constant(x.to_bits()),
            Operand::Input(argument, element) => self.in_memory(self.inputs[&(argument, element)]),
            Operand::Sin(k) => self.in_memory(angles + count + k as usize),
            Operand::Cos(k) => self.in_memory(angles + 2 * count + k as usize),
            Operand::Value(k) => self.registers.at(k),
        }
    }

    /// Where an operand is, in a register if it is needed again soon.
    fn near(&mut self, operand: Operand, index: usize, keep: &[Register]) -> At {
        match operand {
            Operand::Value(k) => self.registers.near(k, index, keep, &mut self.to),
            other => self.at(other),
        }
    }

    /// A register for the result of an instruction.
    fn target(&mut self, index: usize, keep: &[Register]) -> Register {
        self.registers.take(index, keep, &mut self.to)
    }

    fn angles(&mut self) {
        let count = self.program.angles.len();
        if count == 0 {
            return;
        }
        let (first, ready) = (self.inputs.len(), self.program.angles_ready);
        for (k, operand) in self.program.angles.iter().enumerate() {
            let at = self.at(*operand);
            let register = match at {
                At::Register(register) => register,
                At::Memory(..) => {
                    let register = self.target(ready, &[]);
                    self.to.load(register, at);
                    register
                }
            };
            self.to.store(Base::Memory, ((first + k) * self.stride) as i32, register);
        }
        self.registers.give_all_up(&mut self.to);
        let place = (first * self.stride) as i32;
        let function =
            if self.to.wide { outside::four_sines as *const () } else { outside::sines as *const () };
        self.to.call_with_place(function as usize, place, count as i32);
    }

    fn outputs(&mut self) {
        let count = self.program.instructions.len();
        let mut zero = None;
        for (k, operand) in self.program.outputs.iter().enumerate() {
            let at = self.at(*operand);
            // Many outputs of regressors are 0: that is kept in a register.
            let is_zero = matches!(operand, Operand::Constant(x) if x.to_bits() == 0);
            let keep: Vec<Register> = zero.into_iter().collect();
            let register = match (at, zero) {
                (At::Register(register), _) => register,
                (At::Memory(..), Some(zero)) if is_zero => zero,
                (At::Memory(..), _) => {
                    let register = self.target(count, &keep);
                    self.to.load(register, at);
                    register
                }
            };
            self.to.store(Base::Outputs, (k * self.stride) as i32, register);
            zero = zero.or(is_zero.then_some(register));
        }
    }

    fn instruction(&mut self, index: usize, instruction: &Instruction) {
        let to = match *instruction {
            Instruction::Add(a, b) => self.binary(index, Binary::Add, a, b, None),
            Instruction::Sub(a, b) => self.binary(index, Binary::Sub, a, b, None),
            Instruction::Mul(a, b) => self.binary(index, Binary::Mul, a, b, None),
            Instruction::Div(a, b) => self.binary(index, Binary::Div, a, b, None),
            Instruction::Larger(a, b) => self.binary(index, Binary::Max, a, b, None),
            Instruction::Neg(a) => self.bits(index, Bits::Xor, 0, a),
            Instruction::Call(Call::Abs, a) => self.bits(index, Bits::And, 1, a),
            Instruction::Sqrt(a) => {
                let at = self.near(a, index, &[]);
                let to = self.target(index, &[]);
                let first = if self.to.wide { 0 } else { to };
                self.to.binary(Binary::Sqrt, to, first, at);
                to
            }
            Instruction::Call(call, a) => self.call(call, a),
            Instruction::Fused { a, b, c, minus_product, minus_addend } => {
                // As `Real::fused` of this build.
                if cfg!(target_feature = "fma") {
                    self.fused(index, [a, b, c], [minus_product, minus_addend])
                } else {
                    self.product_and_sum(index, [a, b, c], [minus_product, minus_addend])
                }
            }
        };
        for operand in instruction.operands() {
            self.registers.let_go(operand, index + 1);
        }
        let result = index as u32;
        self.registers.put(result, to);
        self.registers.let_go(Operand::Value(result), index + 1);
    }

    /// `besides`: a register that is not to be overwritten.
    fn binary(
        &mut self,
        index: usize,
        operation: Binary,
        a: Operand,
        b: Operand,
        besides: Option<Register>,
    ) -> Register {
        let mut keep: Vec<Register> = besides.into_iter().collect();
        let mut first = self.near(a, index, &keep);
        keep.extend(register(first));
        let mut second = self.near(b, index, &keep);
        keep.extend(register(second));
        let commutes = matches!(operation, Binary::Add | Binary::Mul);
        if commutes && register(first).is_none() && register(second).is_some() {
            std::mem::swap(&mut first, &mut second);
        }
        match first {
            At::Register(first) => {
                // Operands are read before the result is written.
                let to = self.registers.free(&keep).or_else(|| self.last_used(index, [a, b], besides));
                let to = to.unwrap_or_else(|| self.target(index, &keep));
                self.to.binary(operation, to, first, second);
                to
            }
            At::Memory(..) => {
                let to = self.target(index, &keep);
                self.to.load(to, first);
                self.to.binary(operation, to, to, second);
                to
            }
        }
    }

    /// The register of an operand that no later instruction uses: it is free from now on.
    fn last_used(
        &mut self,
        index: usize,
        operands: [Operand; 2],
        besides: Option<Register>,
    ) -> Option<Register> {
        operands.into_iter().find_map(|operand| {
            let Operand::Value(k) = operand else { return None };
            let at = register(self.registers.at(k)).filter(|at| Some(*at) != besides)?;
            self.registers.empty_if_last(k, index).then_some(at)
        })
    }

    fn bits(&mut self, index: usize, operation: Bits, mask: usize, a: Operand) -> Register {
        let at = self.near(a, index, &[]);
        let keep: Vec<Register> = register(at).into_iter().collect();
        let to = self.target(index, &keep);
        let from = match at {
            At::Register(from) => from,
            At::Memory(..) => {
                self.to.load(to, at);
                to
            }
        };
        let mask = self.pooled(mask);
        self.to.bits(operation, to, from, mask);
        to
    }

    fn fused(
        &mut self,
        index: usize,
        [a, b, c]: [Operand; 3],
        [minus_product, minus_addend]: [bool; 2],
    ) -> Register {
        let addend = self.at(c);
        let mut keep: Vec<Register> = register(addend).into_iter().collect();
        let mut first = self.near(a, index, &keep);
        keep.extend(register(first));
        let mut second = self.near(b, index, &keep);
        keep.extend(register(second));
        if register(first).is_none() && register(second).is_some() {
            std::mem::swap(&mut first, &mut second);
        }
        let to = match self.last_used(index, [c, c], None) {
            Some(to) => to,
            None => {
                let to = self.target(index, &keep);
                self.to.load(to, addend);
                to
            }
        };
        keep.push(to);
        let factor = match first {
            At::Register(factor) => factor,
            At::Memory(..) => {
                let factor = self.target(index, &keep);
                self.to.load(factor, first);
                factor
            }
        };
        let operation = match (minus_product, minus_addend) {
            (false, false) => Fused::Add,
            (false, true) => Fused::Sub,
            (true, false) => Fused::NegAdd,
            (true, true) => Fused::NegSub,
        };
        self.to.fused(operation, to, factor, second);
        to
    }

    fn product_and_sum(&mut self, index: usize, [a, b, c]: [Operand; 3], minus: [bool; 2]) -> Register {
        let addend = self.near(c, index, &[]);
        let to = self.binary(index, Binary::Mul, a, b, register(addend));
        let [minus_product, minus_addend] = minus;
        match (minus_product, addend) {
            (true, At::Register(addend)) if !minus_addend => {
                self.to.binary(Binary::Sub, to, addend, At::Register(to));
                return to;
            }
            (true, _) => {
                let signs = self.pooled(0);
                self.to.bits(Bits::Xor, to, to, signs);
            }
            _ => {}
        }
        self.to.binary(if minus_addend { Binary::Sub } else { Binary::Add }, to, to, addend);
        to
    }

    fn call(&mut self, call: Call, a: Operand) -> Register {
        self.registers.give_all_up(&mut self.to);
        let at = self.at(a);
        self.to.load(0, at);
        self.to.call(outside::of(call) as usize);
        0
    }
}

fn register(at: At) -> Option<Register> {
    match at {
        At::Register(register) => Some(register),
        At::Memory(..) => None,
    }
}
