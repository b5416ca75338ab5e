//! From text to tree, by precedence climbing.
use super::{Binary, Formula, FormulaError, Function, SMOOTHING, Term};

/// Longest text.
const LENGTH: usize = 4096;
/// Deepest nesting.
const DEPTH: usize = 64;
/// Largest exponent.
const EXPONENT: f64 = 8.0;

const FUNCTIONS: [(&str, Function); 7] = [
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("tanh", Function::Tanh),
    ("exp", Function::Exp),
    ("sqrt", Function::Sqrt),
    ("abs", Function::Abs),
];

pub(super) fn parse(text: &str) -> Result<Formula, FormulaError> {
    let characters: Vec<char> = text.chars().collect();
    if characters.len() > LENGTH {
        return Err(error(LENGTH, "the formula is too long".into(), "at most 4096 characters"));
    }
    let mut parser = Parser { text: characters, at: 0, names: Vec::new(), depth: 0 };
    let root = parser.sum()?;
    match parser.peek() {
        None => Ok(Formula { names: parser.names, root }),
        Some(c) => Err(error(
            parser.at,
            format!("`{c}` does not continue the formula"),
            match c {
                '.' => "names have `_` where joints, links and points have `.`",
                _ => "is an operator missing? products are written with `*`",
            },
        )),
    }
}

fn error(at: usize, message: String, help: &str) -> FormulaError {
    FormulaError { at, message, help: help.to_owned() }
}

struct Parser {
    text: Vec<char>,
    at: usize,
    names: Vec<String>,
    depth: usize,
}

type Parsed = Result<Term, FormulaError>;

impl Parser {
    fn peek(&mut self) -> Option<char> {
        while self.text.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, wanted: char, help: &str) -> Result<(), FormulaError> {
        if self.take(wanted) {
            return Ok(());
        }
        Err(error(self.at, format!("`{wanted}` expected"), help))
    }

    fn sum(&mut self) -> Parsed {
        let mut left = self.product()?;
        loop {
            let operation = match self.peek() {
                Some('+') => Binary::Add,
                Some('-') => Binary::Subtract,
                _ => return Ok(left),
            };
            self.at += 1;
            left = binary(operation, left, self.product()?);
        }
    }

    fn product(&mut self) -> Parsed {
        let mut left = self.signed()?;
        loop {
            let operation = match self.peek() {
                Some('*') => Binary::Multiply,
                Some('/') => Binary::Divide,
                _ => return Ok(left),
            };
            self.at += 1;
            left = binary(operation, left, self.signed()?);
        }
    }

    fn signed(&mut self) -> Parsed {
        self.depth += 1;
        if self.depth > DEPTH {
            return Err(error(self.at, "the formula is nested too deeply".into(), "at most 64 levels"));
        }
        let term = if self.take('-') {
            Term::Negate(Box::new(self.signed()?))
        } else if self.take('+') {
            self.signed()?
        } else {
            self.power()?
        };
        self.depth -= 1;
        Ok(term)
    }

    fn power(&mut self) -> Parsed {
        let base = self.atom()?;
        if !self.take('^') {
            return Ok(base);
        }
        self.peek();
        let at = self.at;
        let sign = if self.take('-') { -1.0 } else { 1.0 };
        let help = "exponents are whole numbers from -8 to 8; use sqrt(x) and exp(x) for others";
        match self.number()? {
            Some(n) if n.fract() == 0.0 && n <= EXPONENT => {
                Ok(Term::Power(Box::new(base), (sign * n) as i32))
            }
            _ => Err(error(at, "the exponent is no whole number from -8 to 8".into(), help)),
        }
    }

    fn number(&mut self) -> Result<Option<f64>, FormulaError> {
        self.peek();
        let start = self.at;
        let mut end = start;
        while let Some(&c) = self.text.get(end) {
            let exponent_sign =
                matches!(c, '+' | '-') && end > start && matches!(self.text[end - 1], 'e' | 'E');
            let exponent = matches!(c, 'e' | 'E') && end > start;
            if !(c.is_ascii_digit() || c == '.' || exponent || exponent_sign) {
                break;
            }
            end += 1;
        }
        if end == start {
            return Ok(None);
        }
        let text: String = self.text[start..end].iter().collect();
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => {
                self.at = end;
                Ok(Some(value))
            }
            _ => Err(error(start, format!("`{text}` is no number"), "write numbers like 0.5 or 1e-3")),
        }
    }

    fn atom(&mut self) -> Parsed {
        match self.peek() {
            Some('(') => {
                self.at += 1;
                let inner = self.sum()?;
                self.expect(')', "a parenthesis is not closed")?;
                Ok(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => match self.number()? {
                Some(value) => Ok(Term::Number(value)),
                None => Err(error(self.at, "a number is expected".into(), "write numbers like 0.5")),
            },
            Some(c) if c.is_alphabetic() || c == '_' => self.word(),
            Some(c) => Err(error(
                self.at,
                format!("`{c}` has no meaning here"),
                "a number, a name or `(` is expected",
            )),
            None => Err(error(
                self.at,
                "the formula ends too early".into(),
                "a number, a name or `(` is expected",
            )),
        }
    }

    fn word(&mut self) -> Parsed {
        let start = self.at;
        while self.text.get(self.at).is_some_and(|c| c.is_alphanumeric() || *c == '_') {
            self.at += 1;
        }
        let word: String = self.text[start..self.at].iter().collect();
        if self.peek() == Some('(') {
            self.at += 1;
            return self.call(&word, start);
        }
        let function = |name: &str| FUNCTIONS.iter().any(|(n, _)| *n == name);
        if function(&word) || matches!(word.as_str(), "sign" | "min" | "max" | "clip") {
            return Err(error(
                self.at,
                format!("`(` expected after `{word}`"),
                "functions are written like sin(x)",
            ));
        }
        if word == "pi" {
            return Ok(Term::Number(std::f64::consts::PI));
        }
        Ok(self.name(&word))
    }

    fn name(&mut self, word: &str) -> Term {
        let index = self.names.iter().position(|name| name == word).unwrap_or_else(|| {
            self.names.push(word.to_owned());
            self.names.len() - 1
        });
        Term::Name(index)
    }

    fn call(&mut self, word: &str, start: usize) -> Parsed {
        let first = self.sum()?;
        let term = match word {
            "sign" => {
                let smoothing = self.name(SMOOTHING);
                Term::Call(Function::Tanh, Box::new(binary(Binary::Divide, first, smoothing)))
            }
            "min" => binary(Binary::Minimum, first, self.further(word)?),
            "max" => binary(Binary::Maximum, first, self.further(word)?),
            "clip" => {
                let low = self.further(word)?;
                let high = self.further(word)?;
                binary(Binary::Minimum, binary(Binary::Maximum, first, low), high)
            }
            _ => match FUNCTIONS.iter().find(|(name, _)| *name == word) {
                Some((_, function)) => Term::Call(*function, Box::new(first)),
                None => {
                    let help = "functions: sin cos tan tanh exp sqrt abs sign min max clip";
                    return Err(error(start, format!("there is no function `{word}`"), help));
                }
            },
        };
        self.expect(')', "is the parenthesis not closed, or are there too many arguments?")?;
        Ok(term)
    }

    fn further(&mut self, word: &str) -> Parsed {
        self.expect(
            ',',
            if word == "clip" { "clip takes three arguments" } else { "it takes two arguments" },
        )?;
        self.sum()
    }
}

fn binary(operation: Binary, left: Term, right: Term) -> Term {
    Term::Binary(operation, Box::new(left), Box::new(right))
}
