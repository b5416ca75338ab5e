//! What machine code does, step by step: operations on one number, or on two side by side that both legs need.
//!
//! Numbers of a pair are brought side by side, and taken apart, by steps of their own: what several operations need so is made once.
use super::assembler::{Binary, Bits, Fused};
use crate::expression::Call;
use crate::program::{Instruction, Operand, Pair, Paired, angles_by_twins};
use bipedc_runtime::Argument;
use rustc_hash::FxHashMap;

/// The result of a step.
pub type Unit = u32;

/// Where a step finds an operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Source {
    Unit(Unit),
    /// A place in memory: an input, a sine or a cosine.
    Place(usize),
    /// A constant, or two of them.
    Pool(usize),
}

/// A number: what stands at a source; of two side by side the first or, where so said, the second.
pub type Member = (Source, bool);

/// What one step does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    Binary(Binary, Source, Source),
    /// Of a number and a mask.
    Bits(Bits, Source, Source),
    Sqrt(Source),
    /// ± a b ± c
    Fused(Fused, [Source; 3]),
    Call(Call, Source),
    /// The second one of a pair.
    Second(Unit),
    /// One number twice.
    Twice(Member),
    /// Two numbers as a pair.
    Join(Member, Member),
    /// Goes to a place of memory.
    Angle(usize, Member),
    /// All sines and cosines.
    Sines,
    /// Goes to a place of the results.
    Output(usize, Member),
}

impl Step {
    /// Steps whose results it takes.
    pub fn units(&self) -> impl Iterator<Item = Unit> {
        let list = match *self {
            Self::Binary(_, a, b) | Self::Bits(_, a, b) => [Some(a), Some(b), None],
            Self::Join((a, _), (b, _)) => [Some(a), Some(b), None],
            Self::Fused(_, [a, b, c]) => [Some(a), Some(b), Some(c)],
            Self::Sqrt(a) | Self::Call(_, a) => [Some(a), None, None],
            Self::Twice((a, _)) | Self::Angle(_, (a, _)) | Self::Output(_, (a, _)) => [Some(a), None, None],
            Self::Second(a) => [Some(Source::Unit(a)), None, None],
            Self::Sines => [None; 3],
        };
        list.into_iter().flatten().filter_map(|source| match source {
            Source::Unit(unit) => Some(unit),
            _ => None,
        })
    }
}

/// Steps, and what they read beside memory.
pub struct Steps {
    /// Each with whether its result is a pair.
    pub list: Vec<(Step, bool)>,
    /// Constants by twos: of a pair, or the same twice.
    pub pool: Vec<[u64; 2]>,
}

/// Signs, and everything but signs.
const SIGN: u64 = 1 << 63;

/// An operand of one or of both, and whether it counts negatively.
type Signed = (Source, [bool; 2]);

/// What stands alone or side by side by a step of its own: one member, or two.
type Gathered = (Member, Option<Member>);

struct Writer<'a> {
    paired: &'a Paired,
    inputs: FxHashMap<(Argument, u32), usize>,
    /// Place of each angle among the sines.
    order: Vec<usize>,
    steps: Vec<(Step, bool)>,
    pool: Vec<[u64; 2]>,
    pooled: FxHashMap<[u64; 2], usize>,
    /// Of each instruction its step, and whether it is one of a pair: the second?
    of_value: Vec<(Unit, Option<bool>)>,
    /// Steps that bring numbers together or apart, by what they do.
    known: FxHashMap<Gathered, Source>,
}

/// Steps of a program whose inputs stand in memory in this order, behind them its angles, their sines and their cosines.
pub fn steps(paired: &Paired, inputs: &[(Argument, u32)]) -> Steps {
    let program = &paired.program;
    let mut order = vec![0; program.angles.len()];
    angles_by_twins(program, &paired.pairs)
        .into_iter()
        .enumerate()
        .for_each(|(place, k)| order[k as usize] = place);
    let mut writer = Writer {
        paired,
        inputs: inputs.iter().enumerate().map(|(k, input)| (*input, k)).collect(),
        order,
        steps: Vec::new(),
        pool: Vec::new(),
        pooled: FxHashMap::default(),
        of_value: vec![(0, None); program.instructions.len()],
        known: FxHashMap::default(),
    };
    let mut outputs = vec![Vec::new(); program.instructions.len()];
    for (k, operand) in program.outputs.iter().enumerate() {
        if let Operand::Value(value) = operand {
            outputs[*value as usize].push(k);
        }
    }
    let mut index = 0;
    while index < program.instructions.len() {
        if index == program.angles_ready {
            writer.angles();
        }
        for _ in 0..writer.instruction(index) {
            // As soon as they are known: they hold no register then.
            std::mem::take(&mut outputs[index])
                .into_iter()
                .for_each(|k| writer.output(k, Operand::Value(index as u32)));
            index += 1;
        }
    }
    if program.angles_ready == program.instructions.len() {
        writer.angles();
    }
    for (k, operand) in program.outputs.iter().enumerate() {
        if !matches!(operand, Operand::Value(_)) {
            writer.output(k, *operand);
        }
    }
    Steps { list: writer.steps, pool: writer.pool }
}

impl Writer<'_> {
    fn push(&mut self, step: Step, pair: bool) -> Source {
        self.steps.push((step, pair));
        Source::Unit(self.steps.len() as u32 - 1)
    }

    fn constant(&mut self, bits: [u64; 2]) -> Source {
        let next = self.pool.len();
        let place = *self.pooled.entry(bits).or_insert(next);
        if place == next {
            self.pool.push(bits);
        }
        Source::Pool(place)
    }

    /// A step that is written once for all who need its result.
    fn once(&mut self, key: Gathered, step: Step) -> Source {
        if let Some(made) = self.known.get(&key) {
            return *made;
        }
        let made = self.push(step, key.1.is_some());
        self.known.insert(key, made);
        made
    }

    /// Where a number is, and whether it is the second of a pair there.
    fn member(&mut self, operand: Operand) -> Member {
        let (angles, count) = (self.inputs.len(), self.order.len());
        let source = match operand {
            Operand::Constant(x) => self.constant([x.to_bits(); 2]),
            Operand::Input(argument, element) => Source::Place(self.inputs[&(argument, element)]),
            Operand::Sin(k) => Source::Place(angles + count + self.order[k as usize]),
            Operand::Cos(k) => Source::Place(angles + 2 * count + self.order[k as usize]),
            Operand::Value(k) => {
                let (unit, second) = self.of_value[k as usize];
                return (Source::Unit(unit), second == Some(true));
            }
        };
        (source, false)
    }

    /// One number alone; the first of a pair is where the pair is.
    fn one(&mut self, operand: Operand) -> Source {
        let member = self.member(operand);
        match member {
            (Source::Unit(pair), true) => self.once((member, None), Step::Second(pair)),
            (source, _) => source,
        }
    }

    /// Two numbers side by side.
    fn both(&mut self, a: Operand, b: Operand) -> Source {
        if let (Operand::Constant(x), Operand::Constant(y)) = (a, b) {
            return self.constant([x.to_bits(), y.to_bits()]);
        }
        let (x, y) = (self.member(a), self.member(b));
        if a == b {
            return self.once((x, Some(x)), Step::Twice(x));
        }
        match (x, y) {
            ((Source::Unit(pair), false), (Source::Unit(other), true)) if pair == other => x.0,
            // They stand side by side in memory.
            ((Source::Place(k), _), (Source::Place(l), _)) if l == k + 1 => x.0,
            _ => self.once((x, Some(y)), Step::Join(x, y)),
        }
    }

    /// With the signs that it counts with, where they are minus.
    fn negated(&mut self, (source, minus): Signed, pair: bool) -> Source {
        if !minus[0] && !minus[1] {
            return source;
        }
        let mask = minus.map(|minus| if minus { SIGN } else { 0 });
        if let Source::Pool(place) = source {
            let [a, b] = self.pool[place];
            return self.constant([a ^ mask[0], b ^ mask[1]]);
        }
        let mask = self.constant(mask);
        self.push(Step::Bits(Bits::Xor, source, mask), pair)
    }

    fn angles(&mut self) {
        let program = &self.paired.program;
        if program.angles.is_empty() {
            return;
        }
        let first = self.inputs.len();
        for (k, operand) in program.angles.iter().enumerate() {
            let member = self.member(*operand);
            self.push(Step::Angle(first + self.order[k], member), false);
        }
        self.push(Step::Sines, false);
    }

    fn output(&mut self, k: usize, operand: Operand) {
        let member = self.member(operand);
        self.push(Step::Output(k, member), false);
    }

    /// Writes an instruction, or it and its twin; how many.
    fn instruction(&mut self, index: usize) -> usize {
        let own = self.paired.program.instructions[index];
        let Some(pair) = self.paired.pairs[index] else {
            let result = self.alone(own);
            self.of_value[index] = (result, None);
            return 1;
        };
        let other = self.paired.program.instructions[index + 1];
        let result = self.twins(own, other, pair);
        self.of_value[index] = (result, Some(false));
        self.of_value[index + 1] = (result, Some(true));
        2
    }

    fn alone(&mut self, instruction: Instruction) -> Unit {
        let binary = |to: &mut Self, operation, a, b| {
            let (a, b) = (to.one(a), to.one(b));
            to.push(Step::Binary(operation, a, b), false)
        };
        let made = match instruction {
            Instruction::Add(a, b) => binary(self, Binary::Add, a, b),
            Instruction::Sub(a, b) => binary(self, Binary::Sub, a, b),
            Instruction::Mul(a, b) => binary(self, Binary::Mul, a, b),
            Instruction::Div(a, b) => binary(self, Binary::Div, a, b),
            Instruction::Larger(a, b) => binary(self, Binary::Max, a, b),
            Instruction::Neg(a) => {
                let (a, mask) = (self.one(a), self.constant([SIGN; 2]));
                self.push(Step::Bits(Bits::Xor, a, mask), false)
            }
            Instruction::Call(Call::Abs, a) => {
                let (a, mask) = (self.one(a), self.constant([!SIGN; 2]));
                self.push(Step::Bits(Bits::And, a, mask), false)
            }
            Instruction::Sqrt(a) => {
                let a = self.one(a);
                self.push(Step::Sqrt(a), false)
            }
            Instruction::Call(call, a) => {
                let a = self.one(a);
                self.push(Step::Call(call, a), false)
            }
            Instruction::Fused { a, b, c, minus_product, minus_addend } => {
                let [a, b, c] = [a, b, c].map(|x| self.one(x));
                self.fused([a, b, c], ([minus_product; 2], [minus_addend; 2]), false)
            }
        };
        unit(made)
    }

    fn twins(&mut self, first: Instruction, second: Instruction, pair: Pair) -> Unit {
        let made = match (first, second) {
            (Instruction::Mul(a, b), Instruction::Mul(c, d)) => {
                let (c, d) = pair.ordered(c, d);
                let (x, y) = (self.both(a, c), self.both(b, d));
                self.push(Step::Binary(Binary::Mul, x, y), true)
            }
            (Instruction::Div(a, b), Instruction::Div(c, d)) => {
                let (x, y) = (self.both(a, c), self.both(b, d));
                self.push(Step::Binary(Binary::Div, x, y), true)
            }
            (Instruction::Sqrt(a), Instruction::Sqrt(b)) => {
                let x = self.both(a, b);
                self.push(Step::Sqrt(x), true)
            }
            (Instruction::Neg(a), Instruction::Neg(b)) => {
                let x = self.both(a, b);
                let mask = self.constant([SIGN; 2]);
                self.push(Step::Bits(Bits::Xor, x, mask), true)
            }
            (
                Instruction::Fused { a, b, c, minus_product, minus_addend },
                Instruction::Fused { a: d, b: e, c: f, minus_product: product_too, minus_addend: addend_too },
            ) => {
                let (d, e) = pair.ordered(d, e);
                let sources = [self.both(a, d), self.both(b, e), self.both(c, f)];
                self.fused(sources, ([minus_product, product_too], [minus_addend, addend_too]), true)
            }
            _ => {
                let ((a, minus_a), (b, minus_b)) = terms(first);
                let (c, d) = terms(second);
                let ((c, minus_c), (d, minus_d)) = pair.ordered(c, d);
                let (x, y) = (self.both(a, c), self.both(b, d));
                self.sum((x, [minus_a, minus_c]), (y, [minus_b, minus_d]))
            }
        };
        unit(made)
    }

    /// ± x ± y of a pair.
    fn sum(&mut self, x: Signed, y: Signed) -> Source {
        let (operation, a, b) = match (x.1, y.1) {
            (signs, [true, true]) => (Binary::Sub, (x.0, signs), y.0),
            ([true, true], signs) => (Binary::Sub, (y.0, signs), x.0),
            (signs, _) => (Binary::Add, (x.0, signs), self.negated(y, true)),
        };
        let a = self.negated(a, true);
        self.push(Step::Binary(operation, a, b), true)
    }

    /// ± a b ± c, as `Real::fused` of this build.
    fn fused(
        &mut self,
        [a, b, c]: [Source; 3],
        (product, addend): ([bool; 2], [bool; 2]),
        pair: bool,
    ) -> Source {
        let same = |signs: [bool; 2]| signs[0] == signs[1];
        if cfg!(target_feature = "fma") {
            let (a, product) =
                if same(product) { (a, product[0]) } else { (self.negated((a, product), pair), false) };
            let (c, addend) =
                if same(addend) { (c, addend[0]) } else { (self.negated((c, addend), pair), false) };
            let operation = match (product, addend) {
                (false, false) => Fused::Add,
                (false, true) => Fused::Sub,
                (true, false) => Fused::NegAdd,
                (true, true) => Fused::NegSub,
            };
            return self.push(Step::Fused(operation, [a, b, c]), pair);
        }
        let made = self.push(Step::Binary(Binary::Mul, a, b), pair);
        match (product, addend) {
            ([true, true], [false, false]) => self.push(Step::Binary(Binary::Sub, c, made), pair),
            (_, [true, true]) => {
                let made = self.negated((made, product), pair);
                self.push(Step::Binary(Binary::Sub, made, c), pair)
            }
            _ => {
                let made = self.negated((made, product), pair);
                let c = self.negated((c, addend), pair);
                self.push(Step::Binary(Binary::Add, made, c), pair)
            }
        }
    }
}

fn unit(source: Source) -> Unit {
    match source {
        Source::Unit(unit) => unit,
        _ => unreachable!("a step has a result"),
    }
}

/// The terms of a sum, and whether they count negatively.
fn terms(instruction: Instruction) -> ((Operand, bool), (Operand, bool)) {
    match instruction {
        Instruction::Add(a, b) => ((a, false), (b, false)),
        Instruction::Sub(a, b) => ((a, false), (b, true)),
        _ => unreachable!("twins are the same operation"),
    }
}
