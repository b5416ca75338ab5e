//! Instructions that do the same for both legs, brought next to one another: emitted code computes them as one.
//!
//! Nothing is derived anew. Two instructions are twins if they are the same operation and the operands of one are the twins of
//! the other's; constants and signs may differ. What has no twin stays alone.
use super::{Instruction, Operand, Program};
use crate::tree::Twins;
use rustc_hash::FxHashMap;

/// A program in which twins stand next to one another.
#[derive(Debug, Clone, PartialEq)]
pub struct Paired {
    /// The same operations in another order.
    pub program: Program,
    /// Of each instruction that the next one is the twin of: how.
    pub pairs: Vec<Option<Pair>>,
}

/// An instruction and the next one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pair {
    /// The second one's first operand stands for the first one's second, and the other way round.
    pub exchanged: bool,
}

impl Pair {
    /// Operands of the second one in the order of those of the first that they stand for.
    pub fn ordered<T>(self, a: T, b: T) -> (T, T) {
        if self.exchanged { (b, a) } else { (a, b) }
    }
}

impl Paired {
    /// Nothing is paired.
    pub fn alone(program: &Program) -> Self {
        Self { program: program.clone(), pairs: vec![None; program.instructions.len()] }
    }

    /// With all twins that a program has.
    pub fn new(program: &Program, twins: &Twins) -> Self {
        if twins.is_empty() {
            return Self::alone(program);
        }
        let mut search = Search::new(program, twins);
        let mut partner = search.run();
        let mut order = loop {
            match order(program, &partner) {
                Ok(order) => break order,
                // One of both needs the other by way of a third.
                Err(k) => {
                    let other = partner[k].take();
                    other.into_iter().for_each(|other| partner[other] = None);
                }
            }
        };
        search.orient(&partner, &mut order);
        let mut pairs = vec![None; order.len()];
        for (at, pair) in order.windows(2).enumerate() {
            let (first, second) = (pair[0], pair[1]);
            if partner[first] == Some(second) && (at == 0 || pairs[at - 1].is_none()) {
                pairs[at] = Some(Pair { exchanged: search.exchanged(first, second) });
            }
        }
        let mut program = program.clone();
        program.reorder(&order);
        Self { program, pairs }
    }
}

/// The angles in the order in which their sines are taken: twins side by side and first, so that both come out of one half
/// of a register, and what has no twin behind them. Without pairs in the order they have.
pub fn angles_by_twins(program: &Program, pairs: &[Option<Pair>]) -> Vec<u32> {
    let count = program.angles.len();
    let mut twin = vec![None; count];
    for (k, pair) in pairs.iter().enumerate().filter_map(|(k, pair)| Some((k, (*pair)?))) {
        let operands = |k: usize| program.instructions[k].operands().collect::<Vec<_>>();
        let (first, mut second) = (operands(k), operands(k + 1));
        if pair.exchanged {
            second.swap(0, 1);
        }
        for operands in first.into_iter().zip(second) {
            if let (Operand::Sin(a), Operand::Sin(b)) | (Operand::Cos(a), Operand::Cos(b)) = operands
                && a != b
            {
                twin[a as usize].get_or_insert(b);
            }
        }
    }
    let (mut order, mut placed) = (Vec::with_capacity(count), vec![false; count]);
    for a in 0..count {
        let Some(b) = twin[a].filter(|&b| !placed[a] && !placed[b as usize]) else { continue };
        order.extend([a as u32, b]);
        (placed[a], placed[b as usize]) = (true, true);
    }
    order.extend((0..count as u32).filter(|&a| !placed[a as usize]));
    order
}

/// Which operation, whatever its constants and signs; operands of sums and products in one order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Kind {
    Sum,
    Product,
    Quotient,
    Root,
    Negative,
    Fused,
}

/// An operand without its number, if it is a constant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Source {
    Constant,
    Input(u8, u32),
    Sin(u32),
    Cos(u32),
    Value(u32),
}

type Key = (Kind, [Source; 3]);

fn source(operand: Operand) -> Source {
    match operand {
        Operand::Constant(_) => Source::Constant,
        Operand::Input(argument, k) => Source::Input(argument as u8, k),
        Operand::Sin(k) => Source::Sin(k),
        Operand::Cos(k) => Source::Cos(k),
        Operand::Value(k) => Source::Value(k),
    }
}

/// What identifies an instruction when its operands are replaced; `None` for what is not paired.
fn key(instruction: &Instruction, replaced: impl Fn(Operand) -> Source) -> Option<Key> {
    let kind = match instruction {
        Instruction::Add(..) | Instruction::Sub(..) => Kind::Sum,
        Instruction::Mul(..) => Kind::Product,
        Instruction::Div(..) => Kind::Quotient,
        Instruction::Sqrt(_) => Kind::Root,
        Instruction::Neg(_) => Kind::Negative,
        Instruction::Fused { .. } => Kind::Fused,
        Instruction::Call(..) | Instruction::Larger(..) => return None,
    };
    let mut sources = [Source::Constant; 3];
    for (to, operand) in sources.iter_mut().zip(instruction.operands()) {
        *to = replaced(operand);
    }
    if kind != Kind::Quotient && sources[1] < sources[0] && instruction.operands().count() > 1 {
        sources.swap(0, 1);
    }
    Some((kind, sources))
}

struct Search<'a> {
    program: &'a Program,
    twins: &'a Twins,
    /// Instructions of each kind with the same operands.
    alike: FxHashMap<Key, Vec<usize>>,
    /// Of each angle and each instruction, the one of the other limb: itself if it belongs to none.
    angle: Vec<u32>,
    value: Vec<u32>,
}

impl<'a> Search<'a> {
    fn new(program: &'a Program, twins: &'a Twins) -> Self {
        let mut alike: FxHashMap<Key, Vec<usize>> = FxHashMap::default();
        for (k, instruction) in program.instructions.iter().enumerate() {
            if let Some(key) = key(instruction, source) {
                alike.entry(key).or_default().push(k);
            }
        }
        let values = (0..program.instructions.len() as u32).collect();
        let angles = (0..program.angles.len() as u32).collect();
        Self { program, twins, alike, angle: angles, value: values }
    }

    /// Of each instruction, its twin.
    fn run(&mut self) -> Vec<Option<usize>> {
        let ready = self.program.angles_ready;
        // What has none is taken as it is by both limbs.
        (0..ready).for_each(|k| self.value[k] = self.find(k).unwrap_or(k as u32));
        for k in 0..self.program.angles.len() {
            let twin = self.other(self.program.angles[k]);
            let same = |&angle: &Operand| source(angle) == twin;
            self.angle[k] = self.program.angles.iter().position(same).unwrap_or(k) as u32;
        }
        (ready..self.value.len()).for_each(|k| self.value[k] = self.find(k).unwrap_or(k as u32));
        let twin = |k: usize| {
            let other = self.value[k] as usize;
            let same_part = (k < ready) == (other < ready);
            (other != k && same_part && self.value[other] as usize == k).then_some(other)
        };
        (0..self.value.len()).map(twin).collect()
    }

    /// Exchanges twins where their operands are exchanged: the first ones of all pairs belong to one limb.
    fn orient(&self, partner: &[Option<usize>], order: &mut [usize]) {
        let mut is_second = vec![false; order.len()];
        let mut at = 0;
        while let Some(&[first, second]) = order.get(at..at + 2) {
            if partner[first] != Some(second) {
                at += 1;
                continue;
            }
            let operands = self.program.instructions[first].operands();
            let votes: i32 = operands.map(|o| self.limb(o, partner, &is_second)).sum();
            let body = |k: usize| self.program.purposes[k].body;
            if votes < 0 || votes == 0 && body(second) < body(first) {
                order.swap(at, at + 1);
            }
            is_second[order[at + 1]] = true;
            at += 2;
        }
    }

    /// 1 for operands of the limb that comes first, -1 for those of the other, 0 for what belongs to none.
    fn limb(&self, operand: Operand, partner: &[Option<usize>], is_second: &[bool]) -> i32 {
        let (own, other) = match operand {
            Operand::Constant(_) => return 0,
            Operand::Input(argument, k) => (k, self.twins.element(argument, k).unwrap_or(k)),
            Operand::Sin(k) | Operand::Cos(k) => (k, self.angle[k as usize]),
            Operand::Value(k) => {
                let (paired, second) = (partner[k as usize].is_some(), is_second[k as usize]);
                (u32::from(paired && second), u32::from(paired && !second))
            }
        };
        (other.cmp(&own)) as i32
    }

    /// Whether the first operand of one is not what the first of the other stands for.
    fn exchanged(&self, first: usize, second: usize) -> bool {
        let operand = |k: usize| self.program.instructions[k].operands().next();
        let there = operand(first).map(|o| self.other(o));
        there != operand(second).map(source)
    }

    /// The source that an operand has in the other limb.
    fn other(&self, operand: Operand) -> Source {
        match operand {
            Operand::Constant(_) => Source::Constant,
            Operand::Input(argument, k) => {
                Source::Input(argument as u8, self.twins.element(argument, k).unwrap_or(k))
            }
            Operand::Sin(k) => Source::Sin(self.angle[k as usize]),
            Operand::Cos(k) => Source::Cos(self.angle[k as usize]),
            Operand::Value(k) => Source::Value(self.value[k as usize]),
        }
    }

    /// The instruction that does in the other limb what this one does; of several that differ by constants and signs alone, the
    /// one that has the same place among those that were derived for the other body.
    fn find(&self, k: usize) -> Option<u32> {
        let instruction = &self.program.instructions[k];
        let there = self.alike.get(&key(instruction, |o| self.other(o))?)?;
        let here = self.alike.get(&key(instruction, source)?)?;
        let body = |k: usize| self.program.purposes[k].body;
        let own = body(k);
        let wanted = own.map(|own| self.twins.body(own).unwrap_or(own));
        let of = |list: &[usize], wanted: Option<usize>| -> Vec<usize> {
            list.iter().copied().filter(|&k| body(k) == wanted).collect()
        };
        let same_place = |here: &[usize], there: &[usize]| {
            let place = here.iter().position(|&other| other == k)?;
            (here.len() == there.len()).then(|| there[place] as u32)
        };
        same_place(&of(here, own), &of(there, wanted)).or_else(|| same_place(here, there))
    }
}

/// Instructions in an order in which twins follow one another; else a pair that cannot be.
fn order(program: &Program, partner: &[Option<usize>]) -> Result<Vec<usize>, usize> {
    let mut walk = Walk { program, partner, state: vec![State::New; partner.len()], order: Vec::new() };
    (0..partner.len()).try_for_each(|k| walk.from(k))?;
    Ok(walk.order)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    New,
    /// Its operands are being written down.
    Begun,
    Done,
}

/// Depth first, operands before what needs them, with an explicit stack: chains grow long.
struct Walk<'a> {
    program: &'a Program,
    partner: &'a [Option<usize>],
    state: Vec<State>,
    order: Vec<usize>,
}

impl Walk<'_> {
    fn from(&mut self, k: usize) -> Result<(), usize> {
        let mut stack = vec![k];
        while let Some(&top) = stack.last() {
            let both = [Some(top), self.partner[top]];
            match self.state[top] {
                State::Done => drop(stack.pop()),
                State::Begun => {
                    stack.pop();
                    let mut members: Vec<usize> = both.into_iter().flatten().collect();
                    members.sort_unstable();
                    members.iter().for_each(|&k| self.state[k] = State::Done);
                    self.order.extend(members);
                }
                State::New => {
                    both.into_iter().flatten().for_each(|k| self.state[k] = State::Begun);
                    let before = stack.len();
                    for operand in
                        both.into_iter().flatten().flat_map(|k| self.program.instructions[k].operands())
                    {
                        let Operand::Value(value) = operand else { continue };
                        match self.state[value as usize] {
                            State::New => stack.push(value as usize),
                            State::Begun => return Err(self.pair_among(&stack[..before], value as usize)),
                            State::Done => {}
                        }
                    }
                    // The first operand is written down first, as it was.
                    stack[before..].reverse();
                }
            }
        }
        Ok(())
    }

    /// What begins and needs itself does so by way of a pair.
    fn pair_among(&self, stack: &[usize], needed: usize) -> usize {
        let open = stack.iter().rev().copied().filter(|&k| self.state[k] == State::Begun);
        std::iter::once(needed).chain(open).find(|&k| self.partner[k].is_some()).unwrap_or(needed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Robot;
    use crate::program::{Evaluator, schedule_pairs};
    use bipedc_runtime::{Argument, State};
    use std::path::Path;

    fn compiled(robot: &str) -> crate::compile::CompiledModel {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(robot);
        Robot::read(&folder).unwrap().compile().unwrap()
    }

    fn results(program: &Program, state: &State<'_, f64>) -> Vec<u64> {
        let mut out = vec![f64::NAN; program.outputs.len()];
        Evaluator::new(program).run_one(state, &mut out);
        out.iter().map(|x| x.to_bits()).collect()
    }

    fn kind(instruction: Instruction) -> Kind {
        key(&instruction, source).unwrap().0
    }

    fn check(paired: &Paired, name: &str) {
        let p = &paired.program;
        for k in (0..paired.pairs.len()).filter(|&k| paired.pairs[k].is_some()) {
            let [first, second] = [k, k + 1].map(|k| p.instructions[k]);
            assert_eq!(kind(first), kind(second), "{name}: {k}");
            assert!(second.operands().all(|o| o != Operand::Value(k as u32)), "{name}: {k} needs its twin");
            assert!(paired.pairs[k + 1].is_none() && k + 1 != p.angles_ready, "{name}: {k}");
        }
        for (k, instruction) in p.instructions.iter().enumerate() {
            let before = |o: Operand| if let Operand::Value(v) = o { (v as usize) < k } else { true };
            assert!(instruction.operands().all(before), "{name}: {k} comes before its operands");
        }
    }

    #[test]
    fn twins_stand_side_by_side_and_change_no_bit() {
        let model = compiled("tulip");
        let numbers = |n: usize, size: f64| -> Vec<f64> {
            (0..n).map(|k| size * (1.0 + 7.3 * k as f64).sin()).collect()
        };
        let lists = Argument::ALL.map(|argument| numbers(200, 0.4 + 0.1 * argument as u8 as f64));
        let of = |argument: Argument| &lists[argument as usize][..model.argument_length(argument)];
        let state = Argument::ALL.into_iter().fold(State::new(), |state, a| state.with(a, of(a)));
        let twins = Twins::of(&model.tree);
        for f in &model.functions {
            let mut paired = Paired::new(&f.program, &twins);
            let count = paired.pairs.iter().flatten().count();
            for _ in 0..2 {
                check(&paired, &f.name);
                assert_eq!(paired.pairs.iter().flatten().count(), count, "{}", f.name);
                assert_eq!(results(&paired.program, &state), results(&f.program, &state), "{}", f.name);
                schedule_pairs(&mut paired);
            }
        }
    }

    /// Of both legs' work nearly everything is computed at once; counts are those of today.
    #[test]
    fn so_much_is_computed_at_once() {
        let model = compiled("tulip");
        let twins = Twins::of(&model.tree);
        let pairs = |name: &str| {
            let f = model.functions.iter().find(|f| f.name == name).unwrap();
            (Paired::new(&f.program, &twins).pairs.iter().flatten().count(), f.program.instructions.len())
        };
        let found = LEAST.map(|(name, _)| (name, pairs(name)));
        let fewer = found.iter().zip(LEAST).any(|((_, (count, _)), (_, least))| *count < least);
        assert!(!fewer, "pairs, and instructions of all: {found:?}; there were {LEAST:?}");
    }

    const LEAST: [(&str, usize); 4] = [
        ("inverse_dynamics", 355),
        ("mass_matrix_upper", 273),
        ("forward_dynamics", 824),
        ("inverse_dynamics_regressor", 957),
    ];
}
