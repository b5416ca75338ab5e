//! The small language in which laws are written: `torque * sign(velocity)`.
//!
//! Numbers, names, `+ - * / ^`, parentheses, the constant `pi` and the functions `sin cos tan tanh exp sqrt abs sign
//! min max clip`. Exponents are whole numbers from -8 to 8. `sign(x)` means `tanh(x / smoothing)`, so that friction
//! is smooth; `clip(x, low, high)` is `min(max(x, low), high)`.
mod bound;
mod parse;

pub use bound::{Bound, Values};

use std::fmt;

/// A parsed formula.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    names: Vec<String>,
    root: Term,
}

/// A formula as a tree.
#[derive(Debug, Clone, PartialEq)]
pub enum Term {
    /// A number.
    Number(f64),
    /// Index into [`Formula::names`].
    Name(usize),
    /// `-a`
    Negate(Box<Self>),
    /// `a ∘ b`
    Binary(Binary, Box<Self>, Box<Self>),
    /// `a ^ n`
    Power(Box<Self>, i32),
    /// `f(a)`
    Call(Function, Box<Self>),
}

/// Operations on two terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Minimum,
    Maximum,
}

/// Functions of one term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Function {
    Sin,
    Cos,
    Tan,
    Tanh,
    Exp,
    Sqrt,
    Abs,
}

/// What is wrong with a formula, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormulaError {
    /// Index of the character, from 0.
    pub at: usize,
    /// What was wrong.
    pub message: String,
    /// What to do.
    pub help: String,
}

impl fmt::Display for FormulaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (character {})", self.message, self.at + 1)
    }
}

impl std::error::Error for FormulaError {}

/// The speed that `sign` is smoothed over.
pub const SMOOTHING: &str = "smoothing";

impl Formula {
    /// Reads a formula. Names may be any; [`Formula::bind`] says which exist.
    ///
    /// # Errors
    /// The first place where it has no meaning.
    pub fn parse(text: &str) -> Result<Self, FormulaError> {
        parse::parse(text)
    }

    /// The names in it, in the order of their first use. `smoothing` is among them where `sign` is used.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The tree.
    pub fn root(&self) -> &Term {
        &self.root
    }

    /// Gives every name a place in a list of values.
    ///
    /// # Errors
    /// The first name that is not in the list.
    pub fn bind<'n>(&'n self, list: &[&str]) -> Result<Bound, &'n str> {
        let slot = |name: &'n String| list.iter().position(|n| n == name).ok_or(name.as_str());
        let slots: Vec<usize> = self.names.iter().map(slot).collect::<Result<_, _>>()?;
        Ok(Bound::new(&self.root, &slots))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> f64 {
        let formula = Formula::parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
        formula.bind(&["x", "y", SMOOTHING]).unwrap().evaluate(&[2.0, -0.5, 0.1])
    }

    #[test]
    fn arithmetic_follows_the_usual_precedence() {
        assert_eq!(value("1 + 2 * 3"), 7.0);
        assert_eq!(value("-x^2"), -4.0);
        assert_eq!(value("2^-1 * x"), 1.0);
        assert_eq!(value("8 / 4 / 2"), 1.0);
        assert_eq!(value("1 - 2 - 3"), -4.0);
        assert_eq!(value("(1 + y) * 1e1"), 5.0);
        assert_eq!(value("min(x, 1) + max(y, 0) + clip(x, -1, 1.5)"), 2.5);
        assert_eq!(value("sign(y)"), (-5.0f64).tanh());
        assert_eq!(value("cos(pi)"), -1.0);
    }

    #[test]
    fn gradients_agree_with_differences() {
        for text in [
            "x * sin(3 * y) / (1 + x^2)",
            "exp(-(y / x)^2) * sign(y)",
            "tan(y) + sqrt(x) - abs(y) * tanh(x)",
            "clip(x * y, -3, 3) + max(x, y)",
            "x^-3 + y^5",
        ] {
            let formula = Formula::parse(text).unwrap();
            let bound = formula.bind(&["x", "y", SMOOTHING]).unwrap();
            let at = [1.3, 0.7, 0.4];
            let mut gradient = [0.0; 3];
            let f = bound.gradient(&at, &mut gradient);
            assert!((f - bound.evaluate(&at)).abs() < 1e-14);
            for i in 0..3 {
                let h = 1e-6;
                let shifted = |s: f64| {
                    let mut x = at;
                    x[i] += s * h;
                    bound.evaluate(&x)
                };
                let difference = (shifted(1.0) - shifted(-1.0)) / (2.0 * h);
                assert!((gradient[i] - difference).abs() < 1e-8, "{text}: {i}");
            }
        }
    }

    #[test]
    fn nonsense_is_refused_with_its_place() {
        for (text, at) in [
            ("", 0),
            ("1 +", 3),
            ("2 * (x", 6),
            ("x $ y", 2),
            ("sin x", 4),
            ("foo(x)", 0),
            ("x^y", 2),
            ("x^99", 2),
            ("min(x)", 5),
            ("1e999", 0),
            ("x y", 2),
        ] {
            assert_eq!(Formula::parse(text).map(|_| ()).map_err(|e| e.at), Err(at), "{text}");
        }
        assert!(Formula::parse(&"(".repeat(100_000)).is_err());
        assert!(Formula::parse(&"-".repeat(3_000)).is_err());
    }
}
