//! The torque of a kind that is linear in one parameter, where that parameter is 1: a column of a regression.
use super::formula::{Binary, Bound, Formula, Function, SMOOTHING, Term};
use super::kind::{Kind, Law};

/// The torque at a joint per unit of a kind's only parameter; dry friction with a sharp sign.
#[derive(Debug, Clone)]
pub struct UnitTorque(Form);

/// What most are, without a formula to be run.
#[derive(Debug, Clone)]
enum Form {
    Constant(f64),
    Velocity,
    Sign,
    Acceleration,
    /// Of velocity, acceleration and smoothing; then the parameter, and the true torque where the law is of a reading.
    Formula(Bound),
}

const NAMES: [&str; 3] = ["velocity", "acceleration", SMOOTHING];

/// So small that the sign of any speed is sharp.
const SHARP: f64 = f64::MIN_POSITIVE;

impl UnitTorque {
    /// `None` unless the kind is offered to identifications, and its law is a formula in the motion of its joint and
    /// one parameter.
    pub fn of(kind: &'static Kind) -> Option<Self> {
        kind.identified?;
        let mut estimated = kind.estimated();
        let (parameter, None) = (estimated.next()?.name, estimated.next()) else { return None };
        let formula = Formula::parse(kind.formula()?).ok()?;
        let reading = match kind.law {
            Law::Torque(_) => None,
            // A true torque of zero: what is left is what the reading adds.
            Law::Reading(_) => Some("torque"),
            _ => return None,
        };
        let names: Vec<&str> = NAMES.into_iter().chain([parameter]).chain(reading).collect();
        let bound = formula.bind(&names).ok()?;
        let moves = formula.names().iter().any(|name| NAMES.contains(&name.as_str()));
        Some(Self(match factor(&formula, parameter) {
            Some(form) => form,
            None if !moves => Form::Constant(bound.evaluate(&[0.0, 0.0, SHARP, 1.0, 0.0][..names.len()])),
            None => Form::Formula(bound),
        }))
    }

    /// Whether it is the sign of the velocity and nothing else: dry friction.
    pub fn is_sign(&self) -> bool {
        matches!(self.0, Form::Sign)
    }

    /// At a motion of the joint, rad/s and rad/s².
    pub fn at(&self, velocity: f64, acceleration: f64) -> f64 {
        match &self.0 {
            Form::Constant(value) => *value,
            Form::Velocity => velocity,
            Form::Sign => f64::from(i8::from(velocity > 0.0) - i8::from(velocity < 0.0)),
            Form::Acceleration => acceleration,
            Form::Formula(bound) => bound.evaluate(&[velocity, acceleration, SHARP, 1.0, 0.0]),
        }
    }
}

/// The other factor of `parameter * …`, if it is one of the simple ones.
fn factor(formula: &Formula, parameter: &str) -> Option<Form> {
    let Term::Binary(Binary::Multiply, a, b) = formula.root() else { return None };
    let name = |term: &Term| match term {
        Term::Name(index) => formula.names().get(*index).map(String::as_str),
        _ => None,
    };
    if name(a) != Some(parameter) {
        return None;
    }
    match (name(b), b.as_ref()) {
        (Some("velocity"), _) => Some(Form::Velocity),
        (Some("acceleration"), _) => Some(Form::Acceleration),
        (None, Term::Call(Function::Tanh, argument)) => match argument.as_ref() {
            Term::Binary(Binary::Divide, x, by) => {
                (name(x) == Some("velocity") && name(by) == Some(SMOOTHING)).then_some(Form::Sign)
            }
            _ => None,
        },
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::{KINDS, kinds};

    /// Every kind that is offered has a column, and it is its law at a parameter of 1.
    #[test]
    fn offered_kinds_have_columns() {
        for kind in KINDS.iter().filter(|kind| kind.identified.is_some()) {
            let unit = UnitTorque::of(kind).unwrap_or_else(|| panic!("{kind} has no column"));
            let formula = Formula::parse(kind.formula().unwrap()).unwrap();
            for (v, a) in [(0.7, -0.3), (-1.3, 2.0), (0.0, 0.4)] {
                let value = |name: &String| match name.as_str() {
                    "velocity" => v,
                    "acceleration" => a,
                    "torque" if kind.parameter("torque").is_none() => 0.0,
                    SMOOTHING => 1e-300,
                    _ => 1.0,
                };
                let values: Vec<f64> = formula.names().iter().map(value).collect();
                let names: Vec<&str> = formula.names().iter().map(String::as_str).collect();
                let expected = formula.bind(&names).unwrap().evaluate(&values);
                assert_eq!(unit.at(v, a), expected, "{kind} at {v}, {a}");
            }
        }
    }

    #[test]
    fn others_have_none() {
        for kind in [&kinds::PAYLOAD, &kinds::PARALLEL_SPRING, &kinds::STRIBECK_FRICTION, &kinds::FORMULA] {
            assert!(UnitTorque::of(kind).is_none(), "{kind}");
        }
    }
}
