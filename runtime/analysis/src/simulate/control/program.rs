//! Formulas as one straight-line program: values with their first two time derivatives along a motion, and gradients.
use bipedc_effects::effect::formula::{Binary, Function, Term};

/// A value and its first two derivatives with respect to time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jet {
    /// x
    pub value: f64,
    /// dx/dt
    pub rate: f64,
    /// d²x/dt²
    pub acceleration: f64,
}

impl Jet {
    fn constant(value: f64) -> Self {
        Self { value, rate: 0.0, acceleration: 0.0 }
    }

    /// `f(self)` from f, f′ and f″ there: the chain rule twice.
    fn through(self, [value, first, second]: [f64; 3]) -> Self {
        Self {
            value,
            rate: first * self.rate,
            acceleration: first * self.acceleration + second * self.rate * self.rate,
        }
    }
}

/// One operation; operands are earlier ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Step {
    Number(f64),
    Signal(usize),
    Negate(usize),
    Binary(Binary, usize, usize),
    Power(usize, i32),
    Call(Function, usize),
}

/// In place of an operand that there is not.
const NONE: usize = usize::MAX;

/// Several formulas over the same signals; what they have in common is computed once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Program {
    steps: Vec<Step>,
    roots: Vec<Root>,
}

/// An output.
#[derive(Debug, Clone, PartialEq)]
struct Root {
    step: usize,
    /// Operations that it depends on, the last first: their place and those of their operands, the second of which is beyond
    /// all steps where there is none.
    operations: Vec<[usize; 3]>,
    /// Signals that it depends on: their place and their index.
    signals: Vec<[usize; 2]>,
}

/// Workspace of a [`Program`].
#[derive(Debug, Clone, Default)]
pub struct Work {
    jets: Vec<Jet>,
    /// Derivatives of every step by its operands.
    slopes: Vec<[f64; 2]>,
    adjoint: Vec<f64>,
}

impl Program {
    /// Adds a step unless the same one is there; gives its place.
    pub(crate) fn step(&mut self, step: Step) -> usize {
        let known = self.steps.iter().position(|other| *other == step);
        known.unwrap_or_else(|| {
            self.steps.push(step);
            self.steps.len() - 1
        })
    }

    /// Adds a formula's tree; `names` are the places of its names.
    pub(crate) fn term(&mut self, term: &Term, names: &[usize]) -> usize {
        let step = match term {
            Term::Number(value) => Step::Number(*value),
            Term::Name(name) => return names[*name],
            Term::Negate(a) => Step::Negate(self.term(a, names)),
            Term::Binary(operation, a, b) => {
                let a = self.term(a, names);
                Step::Binary(*operation, a, self.term(b, names))
            }
            Term::Power(a, n) => Step::Power(self.term(a, names), *n),
            Term::Call(function, a) => Step::Call(*function, self.term(a, names)),
        };
        self.step(step)
    }

    /// Makes a step an output.
    pub(crate) fn output(&mut self, step: usize) {
        let mut reached = vec![false; step + 1];
        reached[step] = true;
        let (mut operations, mut signals) = (Vec::new(), Vec::new());
        for i in (0..=step).rev() {
            let [a, b] = match self.steps[i] {
                _ if !reached[i] => continue,
                Step::Number(_) => continue,
                Step::Signal(index) => {
                    signals.push([i, index]);
                    continue;
                }
                Step::Negate(a) | Step::Power(a, _) | Step::Call(_, a) => [Some(a), None],
                Step::Binary(_, a, b) => [Some(a), Some(b)],
            };
            [a, b].into_iter().flatten().for_each(|operand| reached[operand] = true);
            operations.push([i, a.unwrap_or(NONE), b.unwrap_or(NONE)]);
        }
        self.roots.push(Root { step, operations, signals });
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.roots.len()
    }

    /// Whether an output depends on any signal.
    pub fn moves(&self, output: usize) -> bool {
        !self.roots[output].signals.is_empty()
    }

    /// All outputs along a motion of the signals.
    pub fn run(&self, signals: &[Jet], work: &mut Work) {
        work.jets.clear();
        work.slopes.clear();
        for step in &self.steps {
            let jets = &work.jets;
            let one = |a: usize, of: [f64; 3]| (jets[a].through(of), [of[1], 0.0]);
            let (jet, slopes) = match *step {
                Step::Number(x) => (Jet::constant(x), [0.0; 2]),
                Step::Signal(index) => (signals[index], [0.0; 2]),
                Step::Negate(a) => one(a, [-jets[a].value, -1.0, 0.0]),
                Step::Binary(operation, a, b) => binary(operation, jets[a], jets[b]),
                Step::Power(a, n) => one(a, power(jets[a].value, n)),
                Step::Call(function, a) => one(a, call(function, jets[a].value)),
            };
            work.jets.push(jet);
            work.slopes.push(slopes);
        }
    }

    /// An output after [`Self::run`].
    pub fn output_at(&self, output: usize, work: &Work) -> Jet {
        work.jets[self.roots[output].step]
    }

    /// Derivatives of an output with respect to the signals, after [`Self::run`].
    pub fn gradient(&self, output: usize, work: &mut Work, gradient: &mut [f64]) {
        let Root { step: root, operations, signals } = &self.roots[output];
        let Work { slopes, adjoint, .. } = work;
        let nowhere = self.steps.len();
        adjoint.clear();
        adjoint.resize(nowhere + 1, 0.0);
        adjoint[*root] = 1.0;
        for &[i, a, b] in operations {
            let (d, [da, db]) = (adjoint[i], slopes[i]);
            // What is not chosen may have an infinite slope.
            if d == 0.0 {
                continue;
            }
            adjoint[a.min(nowhere)] += d * da;
            adjoint[b.min(nowhere)] += d * db;
        }
        gradient.fill(0.0);
        for &[place, index] in signals {
            gradient[index] += adjoint[place];
        }
    }
}

/// The result and its derivatives by both operands.
fn binary(operation: Binary, a: Jet, b: Jet) -> (Jet, [f64; 2]) {
    let linear = |sign: f64| Jet {
        value: a.value + sign * b.value,
        rate: a.rate + sign * b.rate,
        acceleration: a.acceleration + sign * b.acceleration,
    };
    let chosen = |first: bool| if first { (a, [1.0, 0.0]) } else { (b, [0.0, 1.0]) };
    match operation {
        Binary::Add => (linear(1.0), [1.0, 1.0]),
        Binary::Subtract => (linear(-1.0), [1.0, -1.0]),
        Binary::Multiply => {
            let jet = Jet {
                value: a.value * b.value,
                rate: a.rate * b.value + a.value * b.rate,
                acceleration: a.acceleration * b.value + 2.0 * a.rate * b.rate + a.value * b.acceleration,
            };
            (jet, [b.value, a.value])
        }
        Binary::Divide => {
            let value = a.value / b.value;
            let rate = (a.rate - value * b.rate) / b.value;
            let acceleration = (a.acceleration - 2.0 * rate * b.rate - value * b.acceleration) / b.value;
            (Jet { value, rate, acceleration }, [1.0 / b.value, -value / b.value])
        }
        Binary::Minimum => chosen(a.value <= b.value),
        Binary::Maximum => chosen(a.value >= b.value),
    }
}

/// xⁿ with its first two derivatives.
fn power(x: f64, n: i32) -> [f64; 3] {
    let f = f64::from(n);
    match n {
        0 => [1.0, 0.0, 0.0],
        1 => [x, 1.0, 0.0],
        2.. => {
            let low = x.powi(n - 2);
            [low * x * x, f * low * x, f * (f - 1.0) * low]
        }
        _ => [x.powi(n), f * x.powi(n - 1), f * (f - 1.0) * x.powi(n - 2)],
    }
}

/// A function with its first two derivatives.
fn call(function: Function, x: f64) -> [f64; 3] {
    match function {
        Function::Sin => {
            let (s, c) = x.sin_cos();
            [s, c, -s]
        }
        Function::Cos => {
            let (s, c) = x.sin_cos();
            [c, -s, -c]
        }
        Function::Tan => {
            let t = x.tan();
            let first = 1.0 + t * t;
            [t, first, 2.0 * t * first]
        }
        Function::Tanh => {
            let t = x.tanh();
            let first = 1.0 - t * t;
            [t, first, -2.0 * t * first]
        }
        Function::Exp => [x.exp(); 3],
        Function::Sqrt => {
            let root = x.sqrt();
            [root, 0.5 / root, -0.25 / (root * x)]
        }
        Function::Abs => [x.abs(), if x == 0.0 { 0.0 } else { x.signum() }, 0.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_effects::effect::formula::Formula;

    fn program(texts: &[&str]) -> Program {
        let mut program = Program::default();
        for text in texts {
            let formula = Formula::parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
            let names: Vec<usize> = formula
                .names()
                .iter()
                .map(|name| program.step(Step::Signal(usize::from(name == "y"))))
                .collect();
            let root = program.term(formula.root(), &names);
            program.output(root);
        }
        program
    }

    const TEXTS: [&str; 6] = [
        "x * sin(3 * y) / (1 + x^2)",
        "exp(-(y / x)^2) * tanh(y)",
        "tan(y) + sqrt(x) - abs(y) * cos(x)",
        "min(x * y, 3) + max(x, y)",
        "x^-3 + y^5 - x^0 + y^1",
        "-(x - y) / (x + 2 * y)^3",
    ];

    /// Signals that move as polynomials of time.
    fn motion(t: f64) -> [Jet; 2] {
        [
            Jet { value: 1.3 + 0.4 * t - t * t, rate: 0.4 - 2.0 * t, acceleration: -2.0 },
            Jet { value: 0.7 - 0.9 * t + 0.5 * t * t, rate: -0.9 + t, acceleration: 1.0 },
        ]
    }

    #[test]
    fn derivatives_along_a_motion_agree_with_differences() {
        let program = program(&TEXTS);
        let at = |t: f64| {
            let mut work = Work::default();
            program.run(&motion(t), &mut work);
            (0..program.outputs()).map(|i| program.output_at(i, &work)).collect::<Vec<_>>()
        };
        let h = 1e-4;
        let (before, now, after) = (at(-h), at(0.0), at(h));
        for (i, text) in TEXTS.iter().enumerate() {
            let rate = (after[i].value - before[i].value) / (2.0 * h);
            let acceleration = (after[i].rate - before[i].rate) / (2.0 * h);
            assert!((rate - now[i].rate).abs() < 1e-6 * (1.0 + rate.abs()), "{text}: {rate} {:?}", now[i]);
            let miss = (acceleration - now[i].acceleration).abs();
            assert!(miss < 1e-5 * (1.0 + acceleration.abs()), "{text}: {acceleration} {:?}", now[i]);
        }
    }

    #[test]
    fn rates_are_gradient_times_rates_and_common_parts_are_shared() {
        let program = program(&TEXTS);
        let (mut work, signals) = (Work::default(), motion(0.1));
        program.run(&signals, &mut work);
        for (i, text) in TEXTS.iter().enumerate() {
            let mut gradient = [0.0; 2];
            let rate = program.output_at(i, &work).rate;
            program.gradient(i, &mut work, &mut gradient);
            let found = gradient[0] * signals[0].rate + gradient[1] * signals[1].rate;
            assert!((found - rate).abs() < 1e-12 * (1.0 + rate.abs()), "{text}");
            assert!(program.moves(i));
        }
        let twice = super::tests::program(&["sin(x + y)", "2 * sin(x + y)"]);
        assert_eq!(twice.steps.len(), 6);
        assert!(!super::tests::program(&["1 + 2"]).moves(0));
    }
}
