//! Operation counts: a measure of work without noise.
use super::{Instruction, Operand, Program};
use std::fmt;

/// How many of each operation a program does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Operations {
    /// Additions and subtractions that are not fused.
    pub additions: usize,
    /// Products that are not fused.
    pub multiplications: usize,
    /// Fused multiply-adds.
    pub fused: usize,
    /// Quotients.
    pub divisions: usize,
    /// Square roots.
    pub square_roots: usize,
    /// Pairs of sine and cosine.
    pub sin_cos: usize,
    /// Exponentials, hyperbolic tangents, magnitudes, signs and comparisons, in the laws of effects.
    pub functions: usize,
}

impl Operations {
    /// Of a program. Negations cost nothing: they fold into the instructions around them.
    pub fn of(program: &Program) -> Self {
        let mut count = Self { sin_cos: program.angles.len(), ..Self::default() };
        for instruction in &program.instructions {
            match instruction {
                Instruction::Add(..) | Instruction::Sub(..) => count.additions += 1,
                Instruction::Mul(..) => count.multiplications += 1,
                Instruction::Div(..) => count.divisions += 1,
                Instruction::Sqrt(..) => count.square_roots += 1,
                Instruction::Fused { .. } => count.fused += 1,
                Instruction::Call(..) | Instruction::Larger(..) => count.functions += 1,
                Instruction::Neg(..) => {}
            }
        }
        count
    }

    /// Instructions; negations are none of their own.
    pub fn instructions(&self) -> usize {
        let others = self.divisions + self.square_roots + self.functions;
        self.additions + self.multiplications + self.fused + others
    }

    /// Additions, multiplications, divisions and square roots; a fused operation is two.
    pub fn total(&self) -> usize {
        self.additions + self.multiplications + 2 * self.fused + self.divisions + self.square_roots
    }
}

/// Cycles from sines and cosines to the last result if everything ran at once.
pub fn longest_chain(program: &Program) -> usize {
    let mut done: Vec<usize> = Vec::with_capacity(program.instructions.len());
    for instruction in &program.instructions {
        let ready = |operand: Operand| match operand {
            Operand::Value(k) => done[k as usize],
            _ => 0,
        };
        let start = instruction.operands().map(ready).max().unwrap_or(0);
        let latency = match instruction {
            Instruction::Div(..) | Instruction::Sqrt(_) => 14,
            Instruction::Call(..) => 32,
            Instruction::Neg(_) => 0,
            _ => 4,
        };
        done.push(start + latency);
    }
    done.into_iter().max().unwrap_or(0)
}

impl fmt::Display for Operations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [
            (self.additions, "add"),
            (self.multiplications, "mul"),
            (self.fused, "fused"),
            (self.divisions, "div"),
            (self.square_roots, "sqrt"),
            (self.sin_cos, "sin_cos"),
            (self.functions, "functions"),
        ];
        write!(f, "{} operations:", self.total())?;
        let listed: Vec<String> =
            parts.iter().filter(|(n, _)| *n > 0).map(|(n, name)| format!(" {n} {name}")).collect();
        f.write_str(&listed.join(","))
    }
}
