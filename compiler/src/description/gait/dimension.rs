//! Units of formulas: what is added has one unit, angles are numbers.
use bipedc_effects::effect::formula::{Binary, Formula, Function, Term};

/// Exponents of metre, kilogram and second; `None` for a bare number, which may stand for anything.
pub(super) type Dimension = Option<[i32; 3]>;

/// Dimension of angles and ratios.
const PLAIN: [i32; 3] = [0, 0, 0];

const UNITS: [(&str, [i32; 3]); 7] = [
    ("1", PLAIN),
    ("rad", PLAIN),
    ("m", [1, 0, 0]),
    ("kg", [0, 1, 0]),
    ("s", [0, 0, 1]),
    ("N", [1, 1, -2]),
    ("J", [2, 1, -2]),
];

/// `rad`, `m/s`, `N m`, `m/s^2`, `kg m²`.
pub(super) fn parse_unit(text: &str) -> Option<[i32; 3]> {
    let mut parts = text.split('/');
    let mut sum = factors(parts.next()?)?;
    for below in parts {
        let below = factors(below)?;
        sum.iter_mut().zip(below).for_each(|(a, b)| *a -= b);
    }
    Some(sum)
}

fn factors(text: &str) -> Option<[i32; 3]> {
    let mut sum = PLAIN;
    let mut any = false;
    for word in text.split_whitespace() {
        let (name, power) = match word.strip_suffix('²').or_else(|| word.strip_suffix("^2")) {
            Some(name) => (name, 2),
            None => (word, 1),
        };
        let (_, unit) = UNITS.iter().find(|(other, _)| *other == name)?;
        sum.iter_mut().zip(unit).for_each(|(a, b)| *a += power * b);
        any = true;
    }
    any.then_some(sum)
}

/// A dimension for people.
pub(super) fn words(dimension: [i32; 3]) -> String {
    if dimension == PLAIN {
        return "rad or a ratio".to_owned();
    }
    let named = dimension.iter().zip(["m", "kg", "s"]).filter(|(power, _)| **power != 0);
    let of =
        |(power, unit): (&i32, &str)| if *power == 1 { unit.to_owned() } else { format!("{unit}^{power}") };
    named.map(of).collect::<Vec<_>>().join(" ")
}

/// The dimension of a formula whose names have these.
///
/// # Errors
/// What does not go together.
pub(super) fn dimension_of(formula: &Formula, names: &[Dimension]) -> Result<Dimension, String> {
    term(formula.root(), names)
}

fn term(of: &Term, names: &[Dimension]) -> Result<Dimension, String> {
    match of {
        Term::Number(_) => Ok(None),
        Term::Name(k) => Ok(names.get(*k).copied().flatten()),
        Term::Negate(a) => term(a, names),
        Term::Binary(operation, a, b) => {
            let (a, b) = (term(a, names)?, term(b, names)?);
            match operation {
                Binary::Multiply => Ok(product(a, b, 1)),
                Binary::Divide => Ok(product(a, b, -1)),
                Binary::Add | Binary::Subtract | Binary::Minimum | Binary::Maximum => same(a, b),
            }
        }
        Term::Power(a, n) => Ok(term(a, names)?.map(|of| of.map(|power| power.saturating_mul(*n)))),
        Term::Call(Function::Abs, a) => term(a, names),
        Term::Call(Function::Sqrt, a) => match term(a, names)? {
            Some(of) if of.iter().any(|power| power % 2 != 0) => {
                Err(format!("it takes the root of something in {}", words(of)))
            }
            of => Ok(of.map(|of| of.map(|power| power / 2))),
        },
        Term::Call(_, a) => match term(a, names)? {
            Some(of) if of != PLAIN => {
                Err(format!("a function takes an angle or a ratio, not {}", words(of)))
            }
            _ => Ok(Some(PLAIN)),
        },
    }
}

/// A bare number times something has that thing's unit.
fn product(a: Dimension, b: Dimension, sign: i32) -> Dimension {
    match (a, b) {
        (None, None) => None,
        (Some(a), None) => Some(a),
        (None, Some(b)) => Some(b.map(|power| power.saturating_mul(sign))),
        (Some(a), Some(b)) => {
            let mut sum = a;
            sum.iter_mut().zip(b).for_each(|(x, y)| *x = x.saturating_add(y.saturating_mul(sign)));
            Some(sum)
        }
    }
}

/// Both sides of a sum.
pub(super) fn same(a: Dimension, b: Dimension) -> Result<Dimension, String> {
    match (a, b) {
        (Some(a), Some(b)) if a != b => Err(format!("{} and {} are added or compared", words(a), words(b))),
        (a, b) => Ok(a.or(b)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Dimension, String> {
        let formula = Formula::parse(text).unwrap();
        let known = [("x", [1, 0, 0]), ("angle", PLAIN), ("t", [0, 0, 1])];
        let unit = |name: &String| known.iter().find(|(other, _)| other == name).map(|(_, unit)| *unit);
        dimension_of(&formula, &formula.names().iter().map(unit).collect::<Vec<_>>())
    }

    #[test]
    fn units_are_read() {
        for (text, unit) in [
            ("rad", Some(PLAIN)),
            ("N m", Some([2, 1, -2])),
            ("m/s^2", Some([1, 0, -2])),
            ("kg m²", Some([2, 1, 0])),
            ("rad/s", Some([0, 0, -1])),
            ("deg", None),
            ("", None),
            ("m/", None),
        ] {
            assert_eq!(parse_unit(text), unit, "{text}");
        }
    }

    #[test]
    fn what_is_added_has_one_unit() {
        assert_eq!(of("x / t^2"), Ok(Some([1, 0, -2])));
        assert_eq!(of("2 * sin(angle) * x + 0.1"), Ok(Some([1, 0, 0])));
        assert_eq!(of("sqrt(x * x) - 1"), Ok(Some([1, 0, 0])));
        for wrong in ["x + angle", "sin(x)", "sqrt(x)", "max(t, x)"] {
            assert!(of(wrong).is_err(), "{wrong}");
        }
    }
}
