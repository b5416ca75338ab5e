//! A formula whose names have places in a list of values: evaluation and gradient.
use super::{Binary, Function, Term};
use std::borrow::Cow;

/// One step; operands are earlier steps.
#[derive(Debug, Clone, Copy)]
enum Step {
    Number(f64),
    Value(usize),
    Negate(usize),
    Binary(Binary, usize, usize),
    Power(usize, i32),
    Call(Function, usize),
}

/// So many places are evaluated together: their values stay in the processor's nearest memory.
const TOGETHER: usize = 128;

/// Values of one name at many places.
#[derive(Debug, Clone)]
pub enum Values<'v> {
    /// The same at all of them.
    Same(f64),
    /// One for each.
    Each(Cow<'v, [f64]>),
}

/// A formula that can be evaluated.
#[derive(Debug, Clone)]
pub struct Bound {
    steps: Vec<Step>,
}

impl Bound {
    pub(super) fn new(root: &Term, slots: &[usize]) -> Self {
        let mut bound = Self { steps: Vec::new() };
        bound.push(root, slots);
        bound
    }

    fn push(&mut self, term: &Term, slots: &[usize]) -> usize {
        let step = match term {
            Term::Number(value) => Step::Number(*value),
            Term::Name(name) => Step::Value(slots[*name]),
            Term::Negate(a) => Step::Negate(self.push(a, slots)),
            Term::Binary(operation, a, b) => {
                let a = self.push(a, slots);
                Step::Binary(*operation, a, self.push(b, slots))
            }
            Term::Power(a, n) => Step::Power(self.push(a, slots), *n),
            Term::Call(function, a) => Step::Call(*function, self.push(a, slots)),
        };
        self.steps.push(step);
        self.steps.len() - 1
    }

    /// The value.
    ///
    /// # Panics
    /// If `values` is shorter than the list that the formula was bound to.
    pub fn evaluate(&self, values: &[f64]) -> f64 {
        let mut work = Vec::new();
        self.run(values, &mut work)
    }

    /// The value, with a workspace that many calls share.
    ///
    /// # Panics
    /// As [`Bound::evaluate`].
    pub fn run(&self, values: &[f64], work: &mut Vec<f64>) -> f64 {
        work.clear();
        for step in &self.steps {
            let value = match *step {
                Step::Number(x) => x,
                Step::Value(slot) => values[slot],
                Step::Negate(a) => -work[a],
                Step::Binary(operation, a, b) => apply(operation, work[a], work[b]),
                Step::Power(a, n) => work[a].powi(n),
                Step::Call(function, a) => call(function, work[a]),
            };
            work.push(value);
        }
        work[work.len() - 1]
    }

    /// The values at many places, the same to the last bit as one after the other.
    ///
    /// # Panics
    /// If `values` is shorter than the list that the formula was bound to, or one of them shorter than `out`.
    pub fn run_at_all(&self, values: &[Values<'_>], out: &mut [f64]) {
        let mut work = vec![[0.0; TOGETHER]; self.steps.len()];
        for (k, out) in out.chunks_mut(TOGETHER).enumerate() {
            let first = k * TOGETHER;
            for (i, step) in self.steps.iter().enumerate() {
                let (before, after) = work.split_at_mut(i);
                let to = &mut after[0][..out.len()];
                match *step {
                    Step::Number(x) => to.fill(x),
                    Step::Value(slot) => match &values[slot] {
                        Values::Same(x) => to.fill(*x),
                        Values::Each(all) => to.copy_from_slice(&all[first..first + out.len()]),
                    },
                    Step::Negate(a) => to.iter_mut().zip(&before[a]).for_each(|(to, a)| *to = -a),
                    Step::Binary(operation, a, b) => apply_all(operation, [&before[a], &before[b]], to),
                    Step::Power(a, n) => to.iter_mut().zip(&before[a]).for_each(|(to, a)| *to = a.powi(n)),
                    Step::Call(function, a) => {
                        to.iter_mut().zip(&before[a]).for_each(|(to, a)| *to = call(function, *a));
                    }
                }
            }
            out.copy_from_slice(&work[self.steps.len() - 1][..out.len()]);
        }
    }

    /// Whether the formula asks for a value of the list that it was bound to.
    pub fn asks_for(&self, slot: usize) -> bool {
        self.steps.iter().any(|step| matches!(step, Step::Value(other) if *other == slot))
    }

    /// The value; `gradient[i]` becomes its derivative with respect to `values[i]`.
    ///
    /// # Panics
    /// If `values` or `gradient` is shorter than the list that the formula was bound to.
    pub fn gradient(&self, values: &[f64], gradient: &mut [f64]) -> f64 {
        let mut work = Vec::with_capacity(self.steps.len());
        let value = self.run(values, &mut work);
        let mut adjoint = vec![0.0; work.len()];
        gradient.fill(0.0);
        adjoint[work.len() - 1] = 1.0;
        for (i, step) in self.steps.iter().enumerate().rev() {
            let d = adjoint[i];
            match *step {
                Step::Number(_) => {}
                Step::Value(slot) => gradient[slot] += d,
                Step::Negate(a) => adjoint[a] -= d,
                Step::Binary(operation, a, b) => {
                    let (da, db) = slopes(operation, work[a], work[b]);
                    adjoint[a] += d * da;
                    adjoint[b] += d * db;
                }
                Step::Power(a, n) => adjoint[a] += d * f64::from(n) * work[a].powi(n - 1),
                Step::Call(function, a) => adjoint[a] += d * slope(function, work[a], work[i]),
            }
        }
        value
    }
}

fn apply(operation: Binary, a: f64, b: f64) -> f64 {
    match operation {
        Binary::Add => a + b,
        Binary::Subtract => a - b,
        Binary::Multiply => a * b,
        Binary::Divide => a / b,
        Binary::Minimum => a.min(b),
        Binary::Maximum => a.max(b),
    }
}

/// The same of many, with one loop for each operation: registers hold several places then.
fn apply_all(operation: Binary, [a, b]: [&[f64]; 2], to: &mut [f64]) {
    let pairs = to.iter_mut().zip(a.iter().zip(b));
    match operation {
        Binary::Add => pairs.for_each(|(to, (a, b))| *to = a + b),
        Binary::Subtract => pairs.for_each(|(to, (a, b))| *to = a - b),
        Binary::Multiply => pairs.for_each(|(to, (a, b))| *to = a * b),
        Binary::Divide => pairs.for_each(|(to, (a, b))| *to = a / b),
        Binary::Minimum => pairs.for_each(|(to, (a, b))| *to = a.min(*b)),
        Binary::Maximum => pairs.for_each(|(to, (a, b))| *to = a.max(*b)),
    }
}

fn slopes(operation: Binary, a: f64, b: f64) -> (f64, f64) {
    let choose = |first: bool| if first { (1.0, 0.0) } else { (0.0, 1.0) };
    match operation {
        Binary::Add => (1.0, 1.0),
        Binary::Subtract => (1.0, -1.0),
        Binary::Multiply => (b, a),
        Binary::Divide => (1.0 / b, -a / (b * b)),
        Binary::Minimum => choose(a <= b),
        Binary::Maximum => choose(a >= b),
    }
}

fn call(function: Function, a: f64) -> f64 {
    match function {
        Function::Sin => a.sin(),
        Function::Cos => a.cos(),
        Function::Tan => a.tan(),
        Function::Tanh => a.tanh(),
        Function::Exp => a.exp(),
        Function::Sqrt => a.sqrt(),
        Function::Abs => a.abs(),
    }
}

/// Derivative at `a`, where the value is `f`.
fn slope(function: Function, a: f64, f: f64) -> f64 {
    match function {
        Function::Sin => a.cos(),
        Function::Cos => -a.sin(),
        Function::Tan => 1.0 + f * f,
        Function::Tanh => 1.0 - f * f,
        Function::Exp => f,
        Function::Sqrt => 0.5 / f,
        Function::Abs => {
            if a == 0.0 {
                0.0
            } else {
                a.signum()
            }
        }
    }
}
