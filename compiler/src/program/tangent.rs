//! A program that computes, beside values, slopes along many directions: values once, and of every operation only those slopes that are not zero whatever the state is. Its
//! numbers are those of [`super::slopes::Slopes`].
use super::batch::alive;
use super::{Instruction, Operand, Program};
use crate::expression::Purpose;
use bipedc_runtime::Argument;
use std::collections::BTreeMap;

/// Directions of a group: one for each of the states that machine code works on side by side.
pub(super) const LANES: usize = 8;

/// An argument that is none of the other program's: its elements are 1 in their own lane and 0 in the others.
pub(super) const SEEDS: Argument = Argument::Q;

/// A program of which a state stands in all lanes and slopes along one direction in each.
#[derive(Debug, Clone)]
pub(super) struct Tangent {
    pub program: Program,
    /// Of each slope that was asked for its output and lane. None: it is zero.
    pub places: Vec<Option<[usize; 2]>>,
}

impl Tangent {
    /// Of a program of [`Argument::Parameters`] alone, along these elements of it in groups of lanes; slopes by group, lane and output. None: it has operations for
    /// which there is no such program.
    pub fn new(program: &Program, directions: &[usize], wanted: &[[usize; 3]]) -> Option<Self> {
        let mut writer = Writer {
            groups: directions.len().div_ceil(LANES),
            seeds: directions.iter().enumerate().map(|(k, &d)| (d as u32, k)).collect(),
            values: Vec::new(),
            slopes: Vec::new(),
            angles: Vec::new(),
            written: Vec::new(),
        };
        let (before, after) = program.instructions.split_at(program.angles_ready);
        before.iter().try_for_each(|instruction| writer.instruction(instruction))?;
        let angles_ready = writer.written.len();
        let angles = writer.angles_of(&program.angles);
        after.iter().try_for_each(|instruction| writer.instruction(instruction))?;
        let mut known = BTreeMap::new();
        let mut outputs = Vec::new();
        let mut place = |&[group, lane, output]: &[usize; 3]| {
            let slope = writer.slope(program.outputs[output], group)?;
            let at = *known.entry((group, output)).or_insert_with(|| {
                outputs.push(slope);
                outputs.len() - 1
            });
            Some([at, lane])
        };
        let places = wanted.iter().map(&mut place).collect();
        let purposes = vec![Purpose::default(); writer.written.len()];
        let (instructions, arguments) = (writer.written, program.arguments);
        let whole = Program { angles, angles_ready, purposes, instructions, outputs, arguments };
        Some(Self { program: alive(&whole), places })
    }
}

struct Writer {
    groups: usize,
    /// Of an element of the parameters its place among the directions.
    seeds: BTreeMap<u32, usize>,
    /// Of each instruction its value, and its slopes by group.
    values: Vec<Operand>,
    slopes: Vec<Vec<Option<Operand>>>,
    /// Slopes of the angles, then what those of sine and cosine are once they are asked for.
    angles: Vec<[Vec<Option<Operand>>; 2]>,
    written: Vec<Instruction>,
}

/// A sum of which a part may be zero.
type Part = Option<Operand>;

impl Writer {
    fn push(&mut self, instruction: Instruction) -> Operand {
        self.written.push(instruction);
        Operand::Value(self.written.len() as u32 - 1)
    }

    fn value(&self, operand: Operand) -> Operand {
        match operand {
            Operand::Value(k) => self.values[k as usize],
            other => other,
        }
    }

    fn slope(&self, operand: Operand, group: usize) -> Part {
        match operand {
            Operand::Constant(_) => None,
            Operand::Input(_, element) => {
                let place = self.seeds.get(&element).filter(|&&place| place / LANES == group)?;
                Some(Operand::Input(SEEDS, (place % LANES) as u32))
            }
            Operand::Value(k) => self.slopes[k as usize][group],
            Operand::Sin(k) => self.angles[k as usize][0][group],
            Operand::Cos(k) => self.angles[k as usize][1][group],
        }
    }

    /// The angles of the program, and slopes of their sines and cosines behind it.
    fn angles_of(&mut self, angles: &[Operand]) -> Vec<Operand> {
        for (k, &angle) in angles.iter().enumerate() {
            let (sine, cosine) = (Operand::Sin(k as u32), Operand::Cos(k as u32));
            let (mut of_sine, mut of_cosine) = (Vec::new(), Vec::new());
            for group in 0..self.groups {
                let slope = self.slope(angle, group);
                of_sine.push(slope.map(|x| self.push(Instruction::Mul(x, cosine))));
                of_cosine.push(slope.map(|x| {
                    let product = self.push(Instruction::Mul(x, sine));
                    self.push(Instruction::Neg(product))
                }));
            }
            self.angles.push([of_sine, of_cosine]);
        }
        angles.iter().map(|&angle| self.value(angle)).collect()
    }

    fn sum(&mut self, a: Part, b: Part) -> Part {
        match (a, b) {
            (Some(a), Some(b)) => Some(self.push(Instruction::Add(a, b))),
            (one, other) => one.or(other),
        }
    }

    fn difference(&mut self, a: Part, b: Part) -> Part {
        match (a, b) {
            (Some(a), Some(b)) => Some(self.push(Instruction::Sub(a, b))),
            (a, None) => a,
            (None, Some(b)) => Some(self.push(Instruction::Neg(b))),
        }
    }

    fn times(&mut self, slope: Part, value: Operand) -> Part {
        slope.map(|slope| self.push(Instruction::Mul(slope, value)))
    }

    /// Slope of a product.
    fn product(&mut self, [a, b]: [Operand; 2], group: usize) -> Part {
        let (slope_a, slope_b) = (self.slope(a, group), self.slope(b, group));
        let (a, b) = (self.value(a), self.value(b));
        let first = self.times(slope_a, b);
        let second = self.times(slope_b, a);
        self.sum(first, second)
    }

    /// Signs of a fused operation, as it is rounded apart.
    fn signed(&mut self, product: Part, addend: Part, minus: [bool; 2]) -> Part {
        match minus {
            [false, false] => self.sum(product, addend),
            [false, true] => self.difference(product, addend),
            [true, false] => self.difference(addend, product),
            [true, true] => {
                let sum = self.sum(product, addend);
                sum.map(|sum| self.push(Instruction::Neg(sum)))
            }
        }
    }

    fn instruction(&mut self, own: &Instruction) -> Option<()> {
        let value = match *own {
            Instruction::Fused { a, b, c, minus_product, minus_addend } => {
                let product = self.push(Instruction::Mul(self.value(a), self.value(b)));
                let addend = self.value(c);
                self.signed(Some(product), Some(addend), [minus_product, minus_addend])?
            }
            // Abs has a slope that asks for a sign.
            Instruction::Call(..) | Instruction::Larger(..) => return None,
            _ => self.push(own.renamed(|operand| self.value(operand))),
        };
        let slopes = (0..self.groups).map(|group| self.slopes_of(own, value, group)).collect();
        self.values.push(value);
        self.slopes.push(slopes);
        Some(())
    }

    fn slopes_of(&mut self, own: &Instruction, value: Operand, group: usize) -> Part {
        let of = |to: &Self, operand| to.slope(operand, group);
        match *own {
            Instruction::Add(a, b) => self.sum(of(self, a), of(self, b)),
            Instruction::Sub(a, b) => self.difference(of(self, a), of(self, b)),
            Instruction::Mul(a, b) => self.product([a, b], group),
            Instruction::Div(a, b) => {
                let (slope_a, slope_b) = (of(self, a), of(self, b));
                let less = self.times(slope_b, value);
                let above = self.difference(slope_a, less)?;
                Some(self.push(Instruction::Div(above, self.value(b))))
            }
            Instruction::Neg(a) => of(self, a).map(|a| self.push(Instruction::Neg(a))),
            Instruction::Sqrt(a) => {
                let slope = of(self, a)?;
                let twice = self.push(Instruction::Add(value, value));
                Some(self.push(Instruction::Div(slope, twice)))
            }
            Instruction::Fused { a, b, c, minus_product, minus_addend } => {
                let product = self.product([a, b], group);
                let addend = of(self, c);
                self.signed(product, addend, [minus_product, minus_addend])
            }
            Instruction::Call(..) | Instruction::Larger(..) => None,
        }
    }
}
