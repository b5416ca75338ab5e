//! Straight-line programs: what is emitted as Rust and what runs in process.
mod along;
mod batch;
mod count;
mod dual;
mod evaluate;
mod local;
mod lower;
#[cfg(target_arch = "x86_64")]
mod native;
#[cfg(not(target_arch = "x86_64"))]
#[path = "no_native.rs"]
mod native;
mod often;
mod schedule;
mod slopes;
mod tangent;
mod twins;

pub use batch::{BatchColumns, BatchStates};
pub use count::{Operations, longest_chain};
pub use dual::Dual;
pub use evaluate::Evaluator;
pub use local::LocalFunction;
pub use lower::{Order, lower};
pub use schedule::{schedule, schedule_pairs};
pub use twins::{Pair, Paired, angles_by_twins};

use crate::expression::{Call, Purpose};
use bipedc_runtime::{Argument, Arguments};

/// Where an operand comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Operand {
    /// A number.
    Constant(f64),
    /// An element of an argument.
    Input(Argument, u32),
    /// Sine of the k-th angle.
    Sin(u32),
    /// Cosine of the k-th angle.
    Cos(u32),
    /// Result of the k-th instruction.
    Value(u32),
}

/// One operation; its result is the value with the instruction's index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Instruction {
    /// a + b
    Add(Operand, Operand),
    /// a - b
    Sub(Operand, Operand),
    /// a · b
    Mul(Operand, Operand),
    /// a / b
    Div(Operand, Operand),
    /// -a
    Neg(Operand),
    /// √a
    Sqrt(Operand),
    /// A function of the laws of effects.
    Call(Call, Operand),
    /// The larger of two.
    Larger(Operand, Operand),
    /// ±a·b ± c, with one rounding where the target can.
    Fused {
        /// Factor.
        a: Operand,
        /// Factor.
        b: Operand,
        /// Addend.
        c: Operand,
        /// The product counts negatively.
        minus_product: bool,
        /// The addend counts negatively.
        minus_addend: bool,
    },
}

impl Instruction {
    /// All operands.
    pub fn operands(&self) -> impl Iterator<Item = Operand> {
        let list = match *self {
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) | Self::Div(a, b) | Self::Larger(a, b) => {
                [Some(a), Some(b), None]
            }
            Self::Neg(a) | Self::Sqrt(a) | Self::Call(_, a) => [Some(a), None, None],
            Self::Fused { a, b, c, .. } => [Some(a), Some(b), Some(c)],
        };
        list.into_iter().flatten()
    }

    /// The same operation on other operands.
    pub fn renamed(&self, f: impl Fn(Operand) -> Operand) -> Self {
        match *self {
            Self::Add(a, b) => Self::Add(f(a), f(b)),
            Self::Sub(a, b) => Self::Sub(f(a), f(b)),
            Self::Mul(a, b) => Self::Mul(f(a), f(b)),
            Self::Div(a, b) => Self::Div(f(a), f(b)),
            Self::Neg(a) => Self::Neg(f(a)),
            Self::Sqrt(a) => Self::Sqrt(f(a)),
            Self::Call(call, a) => Self::Call(call, f(a)),
            Self::Larger(a, b) => Self::Larger(f(a), f(b)),
            Self::Fused { a, b, c, minus_product, minus_addend } => {
                Self::Fused { a: f(a), b: f(b), c: f(c), minus_product, minus_addend }
            }
        }
    }
}

/// A function as a list of operations without branches.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// Angles (rad) whose sine and cosine are needed; instructions before `angles_ready` compute them.
    pub angles: Vec<Operand>,
    /// Number of instructions that run before the sines and cosines.
    pub angles_ready: usize,
    /// In order of execution.
    pub instructions: Vec<Instruction>,
    /// What each instruction was derived for.
    pub purposes: Vec<Purpose>,
    /// Results, column after column.
    pub outputs: Vec<Operand>,
    /// Arguments that are read.
    pub arguments: Arguments,
}

impl Program {
    /// The arguments it reads, in the order in which functions take them.
    pub fn arguments(&self) -> impl Iterator<Item = Argument> + use<> {
        let read = self.arguments;
        Argument::ALL.into_iter().filter(move |&a| read.has(a))
    }

    /// The same operations in another order: the indices of those that come first, second, … `angles_ready` stays, so no operation
    /// may change over to the other side.
    pub fn reorder(&mut self, order: &[usize]) {
        let mut new_index = vec![0; order.len()];
        for (new, &old) in order.iter().enumerate() {
            new_index[old] = new as u32;
        }
        let renamed = |o: Operand| match o {
            Operand::Value(k) => Operand::Value(new_index[k as usize]),
            other => other,
        };
        self.instructions = order.iter().map(|&old| self.instructions[old].renamed(renamed)).collect();
        self.purposes = order.iter().map(|&old| self.purposes[old]).collect();
        self.angles.iter_mut().chain(&mut self.outputs).for_each(|operand| *operand = renamed(*operand));
    }
}
