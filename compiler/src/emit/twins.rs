//! Two instructions written as one, on `R::Two`: the bits of each are those that it has alone.
use super::statements::{Code, constant};
use crate::program::{Instruction, Operand, angles_by_twins};

/// An operand of one of the two, and whether it counts negatively.
type Signed = (Operand, bool);

impl Code<'_> {
    /// The name of the value that holds the results of instruction `k` and of the next one.
    pub fn pair_name(k: usize) -> String {
        format!("t{k}_{}", k + 1)
    }

    /// Instruction `k` and the next one.
    pub fn pair(&self, k: usize) -> String {
        let [first, second] = [k, k + 1].map(|k| self.program.instructions[k]);
        // Sums and products of the second one are written in the order in which they stand for those of the first.
        let exchanged = self.pairs[k].is_some_and(|pair| pair.exchanged);
        match (first, second) {
            (Instruction::Mul(a, b), Instruction::Mul(c, d)) => {
                let (c, d) = ordered(c, d, exchanged);
                format!("{} * {}", self.both(a, c), self.both(b, d))
            }
            (Instruction::Div(a, b), Instruction::Div(c, d)) => {
                format!("{} / {}", self.both(a, c), self.both(b, d))
            }
            (Instruction::Sqrt(a), Instruction::Sqrt(b)) => format!("R::Two::sqrt({})", self.both(a, b)),
            (Instruction::Neg(a), Instruction::Neg(b)) => format!("-{}", self.both(a, b)),
            (
                Instruction::Fused { a, b, c, minus_product, minus_addend },
                Instruction::Fused {
                    a: d,
                    b: e,
                    c: f,
                    minus_product: minus_too,
                    minus_addend: minus_addend_too,
                },
            ) => {
                let (d, e) = ordered(d, e, exchanged);
                let (x, y) = match (a, d) {
                    (Operand::Constant(_), Operand::Constant(_)) => {
                        (self.signed_both((a, minus_product), (d, minus_too)), self.both(b, e))
                    }
                    _ if matches!((b, e), (Operand::Constant(_), Operand::Constant(_))) => {
                        (self.both(a, d), self.signed_both((b, minus_product), (e, minus_too)))
                    }
                    _ => (self.signed_both((a, minus_product), (d, minus_too)), self.both(b, e)),
                };
                let z = self.signed_both((c, minus_addend), (f, minus_addend_too));
                format!("R::Two::fused({x}, {y}, {z})")
            }
            _ => {
                let (c, d) = terms(second);
                self.pair_of_sums(terms(first), ordered(c, d, exchanged))
            }
        }
    }

    /// The angles in the order in which their sines are taken.
    pub fn angles_by_twins(&self) -> Vec<u32> {
        angles_by_twins(self.program, self.pairs)
    }

    /// `a ± b` of each.
    fn pair_of_sums(&self, (a, b): (Signed, Signed), (c, d): (Signed, Signed)) -> String {
        let (x, y) = (self.both(a.0, c.0), self.both(b.0, d.0));
        match ((a.1, b.1), (c.1, d.1)) {
            ((false, false), (false, false)) => format!("{x} + {y}"),
            ((false, true), (false, true)) => format!("{x} - {y}"),
            ((true, false), (true, false)) => format!("{y} - {x}"),
            // Factors of 1 and -1 change no bit of a sum.
            _ if a.1 == c.1 => format!("R::Two::fused({y}, {}, {})", signs(b.1, d.1), self.signed_both(a, c)),
            _ if b.1 == d.1 => format!("R::Two::fused({x}, {}, {})", signs(a.1, c.1), self.signed_both(b, d)),
            _ => format!("R::Two::fused({x}, {}, {y} * {})", signs(a.1, c.1), signs(b.1, d.1)),
        }
    }

    /// Operands of both, with their signs.
    fn signed_both(&self, (a, minus): Signed, (b, minus_too): Signed) -> String {
        if let (Operand::Constant(x), Operand::Constant(y)) = (a, b) {
            let number = |x: f64, minus: bool| Operand::Constant(if minus { -x } else { x });
            return self.both(number(x, minus), number(y, minus_too));
        }
        match (minus, minus_too) {
            (false, false) => self.both(a, b),
            (true, true) => format!("-{}", self.both(a, b)),
            _ => format!("{} * {}", self.both(a, b), signs(minus, minus_too)),
        }
    }

    /// Operands of both.
    fn both(&self, a: Operand, b: Operand) -> String {
        match (a, b) {
            _ if a == b => format!("both({})", self.operand(a)),
            (Operand::Value(k), Operand::Value(l)) if l == k + 1 && self.is_first(k as usize) => {
                self.name(k as usize)
            }
            (Operand::Value(l), Operand::Value(k)) if l == k + 1 && self.is_first(k as usize) => {
                format!("{}.swapped()", self.name(k as usize))
            }
            _ => format!("two({}, {})", self.operand(a), self.operand(b)),
        }
    }
}

fn ordered<T>(a: T, b: T, exchanged: bool) -> (T, T) {
    if exchanged { (b, a) } else { (a, b) }
}

/// 1, or -1 where the sign is minus.
fn signs(first: bool, second: bool) -> String {
    let one = |minus: bool| constant(if minus { -1.0 } else { 1.0 });
    format!("two({}, {})", one(first), one(second))
}

/// The terms of a sum.
fn terms(instruction: Instruction) -> (Signed, Signed) {
    match instruction {
        Instruction::Add(a, b) => ((a, false), (b, false)),
        Instruction::Sub(a, b) => ((a, false), (b, true)),
        _ => unreachable!("twins are the same operation"),
    }
}
