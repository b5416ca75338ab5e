//! A law's formula as an expression with its slopes.
use super::{Call, Graph, Sym};
use bipedc_effects::effect::VARIABLES;
use bipedc_effects::effect::formula::{Binary, Formula, Function, Term};
use std::collections::BTreeMap;

/// A value with its derivatives with respect to a list of quantities that the caller keeps.
#[derive(Debug, Clone)]
pub struct Sloped<'g> {
    pub value: Sym<'g>,
    pub slopes: Vec<Sym<'g>>,
}

impl<'g> Sloped<'g> {
    /// A value that depends on none of `count` quantities.
    pub fn constant(value: Sym<'g>, count: usize) -> Self {
        Self { value, slopes: vec![value.zero(); count] }
    }

    /// The `seed`-th of `count` quantities.
    pub fn seed(value: Sym<'g>, seed: usize, count: usize) -> Self {
        let mut out = Self::constant(value, count);
        out.slopes[seed] = value.constant(1.0);
        out
    }

    fn chain(&self, value: Sym<'g>, slope: impl FnOnce() -> Sym<'g>) -> Self {
        if self.is_constant() {
            return Self::constant(value, self.slopes.len());
        }
        let slope = slope();
        Self { value, slopes: self.slopes.iter().map(|&s| slope * s).collect() }
    }

    fn is_constant(&self) -> bool {
        self.slopes.iter().all(|s| s.is_zero())
    }

    /// The sum.
    pub fn plus(&self, other: &Self) -> Self {
        self.with(other, |a, b| a + b)
    }

    fn with(&self, other: &Self, f: impl Fn(Sym<'g>, Sym<'g>) -> Sym<'g>) -> Self {
        let slopes = self.slopes.iter().zip(&other.slopes).map(|(&a, &b)| f(a, b)).collect();
        Self { value: f(self.value, other.value), slopes }
    }
}

type Made<'g> = Result<Sloped<'g>, String>;

/// A formula with the numbers of its parameters.
#[derive(Debug, Clone)]
pub struct ValuedFormula {
    pub formula: Formula,
    pub parameters: BTreeMap<String, f64>,
}

impl ValuedFormula {
    /// The law for values of its variables.
    ///
    /// # Errors
    /// It divides by zero or leaves the numbers whatever the state is.
    pub fn of<'g>(&self, variables: &[(&str, Sloped<'g>)]) -> Made<'g> {
        let first = &variables[0].1;
        let (some, count) = (first.value, first.slopes.len());
        let names: Vec<Sloped<'g>> = self
            .formula
            .names()
            .iter()
            .map(|name| match variables.iter().find(|(other, _)| other == name) {
                Some((_, value)) => value.clone(),
                None => {
                    let value = self.parameters.get(name).copied().unwrap_or(0.0);
                    Sloped::constant(some.constant(value), count)
                }
            })
            .collect();
        Builder { names: &names, some, count }.term(self.formula.root())
    }

    /// Why a law of torques has no value, whatever the state is: a dry run on a graph of its own.
    pub fn without_value(&self) -> Option<String> {
        let graph = Graph::new();
        let input = |k| {
            let expr = graph.input(bipedc_runtime::Argument::Q, k);
            Sloped::seed(Sym::new(&graph, expr), k, VARIABLES.len())
        };
        let variables: Vec<_> = VARIABLES.into_iter().enumerate().map(|(k, name)| (name, input(k))).collect();
        self.of(&variables).err()
    }
}

struct Builder<'a, 'g> {
    names: &'a [Sloped<'g>],
    some: Sym<'g>,
    count: usize,
}

impl<'g> Builder<'_, 'g> {
    fn term(&self, term: &Term) -> Made<'g> {
        match term {
            Term::Number(x) => Ok(Sloped::constant(self.some.constant(*x), self.count)),
            Term::Name(k) => Ok(self.names[*k].clone()),
            Term::Negate(a) => self.term(a).map(|a| a.with(&a, |x, _| -x)),
            Term::Binary(operation, a, b) => self.binary(*operation, &self.term(a)?, &self.term(b)?),
            Term::Power(a, n) => self.power(&self.term(a)?, *n),
            Term::Call(function, a) => call(*function, &self.term(a)?),
        }
    }

    fn binary(&self, operation: Binary, a: &Sloped<'g>, b: &Sloped<'g>) -> Made<'g> {
        Ok(match operation {
            Binary::Add => a.plus(b),
            Binary::Subtract => a.with(b, |x, y| x - y),
            Binary::Multiply => product(a, b),
            Binary::Divide => return quotient(a, b),
            Binary::Maximum => larger(a, b),
            Binary::Minimum => {
                let negative = |x: &Sloped<'g>| x.with(x, |x, _| -x);
                negative(&larger(&negative(a), &negative(b)))
            }
        })
    }

    fn power(&self, a: &Sloped<'g>, n: i32) -> Made<'g> {
        let one = Sloped::constant(self.some.constant(1.0), self.count);
        let positive = (0..n.unsigned_abs()).fold(one.clone(), |power, _| product(&power, a));
        if n < 0 { quotient(&one, &positive) } else { Ok(positive) }
    }
}

fn product<'g>(a: &Sloped<'g>, b: &Sloped<'g>) -> Sloped<'g> {
    let slopes = a.slopes.iter().zip(&b.slopes).map(|(&x, &y)| x * b.value + a.value * y).collect();
    Sloped { value: a.value * b.value, slopes }
}

fn quotient<'g>(a: &Sloped<'g>, b: &Sloped<'g>) -> Made<'g> {
    if b.value.constant_value() == Some(0.0) {
        return Err("it divides by zero".to_owned());
    }
    let value = a.value / b.value;
    let slope = |(&x, &y): (&Sym<'g>, &Sym<'g>)| {
        let change = x - value * y;
        if change.is_zero() { change } else { change / b.value }
    };
    Ok(Sloped { value, slopes: a.slopes.iter().zip(&b.slopes).map(slope).collect() })
}

/// Where both are equal, half the slope of each.
fn larger<'g>(a: &Sloped<'g>, b: &Sloped<'g>) -> Sloped<'g> {
    let value = a.value.larger(b.value);
    if a.is_constant() && b.is_constant() {
        return Sloped::constant(value, a.slopes.len());
    }
    let first = ((a.value - b.value).call(Call::Sign) + 1.0) * 0.5;
    let slopes = a.slopes.iter().zip(&b.slopes).map(|(&x, &y)| y + first * (x - y)).collect();
    Sloped { value, slopes }
}

fn call<'g>(function: Function, a: &Sloped<'g>) -> Made<'g> {
    let x = a.value;
    let finite = |y: f64| x.constant_value().is_none() || y.is_finite();
    let number = x.constant_value().unwrap_or(0.0);
    Ok(match function {
        Function::Sin => a.chain(x.sin_of_any(), || x.cos_of_any()),
        Function::Cos => a.chain(x.cos_of_any(), || -x.sin_of_any()),
        Function::Tan => {
            let (sine, cosine) = (call(Function::Sin, a)?, call(Function::Cos, a)?);
            return quotient(&sine, &cosine);
        }
        Function::Tanh => {
            let t = x.call(Call::Tanh);
            a.chain(t, || x.constant(1.0) - t * t)
        }
        Function::Exp if !finite(number.exp()) => return Err("its exponential overflows".to_owned()),
        Function::Exp => a.chain(x.call(Call::Exp), || x.call(Call::Exp)),
        Function::Sqrt if number < 0.0 => return Err("it takes the root of a negative number".to_owned()),
        Function::Sqrt => {
            let root = x.sqrt();
            a.chain(root, || x.constant(0.5) / root)
        }
        Function::Abs => a.chain(x.call(Call::Abs), || x.call(Call::Sign)),
    })
}
