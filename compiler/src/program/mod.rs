//! Straight-line programs: what is emitted as Rust and what runs in process.
mod count;
mod evaluate;
mod lower;

pub use count::Operations;
pub use evaluate::Evaluator;
pub use lower::lower;

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
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) | Self::Div(a, b) => [Some(a), Some(b), None],
            Self::Neg(a) | Self::Sqrt(a) => [Some(a), None, None],
            Self::Fused { a, b, c, .. } => [Some(a), Some(b), Some(c)],
        };
        list.into_iter().flatten()
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
    /// Results, column after column.
    pub outputs: Vec<Operand>,
    /// Arguments that are read.
    pub arguments: Arguments,
}
