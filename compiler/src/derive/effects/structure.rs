//! What laws must be like so that forward dynamics can take them back: linear in accelerations, and in the
//! load but for its sign. Tried with numbers at seeded states, which finds what formulas hide.
use super::{Joint, JointLaws, Signal, TorqueLaw};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::VARIABLES;
use bipedc_effects::effect::formula::Bound;
use bipedc_effects::random::Random;

const STATES: usize = 40;
/// Places in [`VARIABLES`].
const ACCELERATION: usize = 2;
const LOAD: usize = 3;
const OTHER_ACCELERATION: usize = 6;

/// A law that numbers can be put into.
struct Numeric {
    bound: Bound,
    constants: Vec<f64>,
}

impl Numeric {
    fn new(law: &super::ValuedFormula, variables: &[&str]) -> Option<Self> {
        let mut names = variables.to_vec();
        names.extend(law.parameters.keys().map(String::as_str));
        let bound = law.formula.bind(&names).ok()?;
        Some(Self { bound, constants: law.parameters.values().copied().collect() })
    }

    fn at(&self, variables: &[f64]) -> f64 {
        let values: Vec<f64> = variables.iter().chain(&self.constants).copied().collect();
        self.bound.evaluate(&values)
    }
}

/// Refuses laws without a value, and notes those that forward dynamics cannot take back.
pub(super) fn check(laws: &mut JointLaws) -> Result<(), Diagnostic> {
    for joint in &laws.joints {
        signals(joint)?;
        let numeric: Vec<Numeric> =
            joint.torques.iter().filter_map(|law| Numeric::new(&law.text, &VARIABLES)).collect();
        for law in &joint.torques {
            valued(joint, law)?;
        }
        if laws.nonlinear.is_none() {
            laws.nonlinear = problem(joint, &numeric);
        }
    }
    Ok(())
}

fn valued(joint: &Joint, law: &TorqueLaw) -> Result<(), Diagnostic> {
    match law.text.without_value() {
        None => Ok(()),
        Some(what) => {
            let message = format!("the formula of an effect at joint `{}`: {what}", joint.name);
            Err(Diagnostic::error(message).help("in every state; change the formula or its parameters"))
        }
    }
}

fn signals(joint: &Joint) -> Result<(), Diagnostic> {
    for signal in &joint.signals {
        let Signal::Reading(text) = signal else { continue };
        let Some(law) = Numeric::new(text, &["torque"]) else { continue };
        let (at_zero, at_one) = (law.at(&[0.0]), law.at(&[1.0]));
        let slope = at_one - at_zero;
        if !(slope.is_finite() && slope != 0.0 && at_zero.is_finite()) {
            let message = format!("the reading of joint `{}` cannot be turned around", joint.name);
            return Err(Diagnostic::error(message).help("is a gain zero?"));
        }
    }
    Ok(())
}

/// Why T(q, v, a, L) is not of the form f + S L + M a with S > 0 on either side of L = 0.
fn problem(joint: &Joint, laws: &[Numeric]) -> Option<Diagnostic> {
    let torque = |x: &[f64; 7]| x[LOAD] + laws.iter().map(|law| law.at(x)).sum::<f64>();
    let mut random = Random::new(1);
    for _ in 0..STATES {
        let mut x = [0.0; 7].map(|_: f64| random.symmetric() * 3.0);
        let wanted = [random.symmetric() * 20.0, random.symmetric() * 20.0, random.symmetric() * 20.0];
        let mut value = |a: f64, load: f64, other: f64| {
            (x[ACCELERATION], x[LOAD], x[OTHER_ACCELERATION]) = (a, load, other);
            torque(&x)
        };
        let rest = value(0.0, 0.0, 0.0);
        let own = value(1.0, 0.0, 0.0) - rest;
        let other = value(0.0, 0.0, 1.0) - rest;
        let sides = [value(0.0, 1.0, 0.0) - rest, rest - value(0.0, -1.0, 0.0)];
        let side = if wanted[1] > 0.0 { sides[0] } else { sides[1] };
        let expected = rest + own * wanted[0] + side * wanted[1] + other * wanted[2];
        let got = value(wanted[0], wanted[1], wanted[2]);
        let scale = 1.0 + rest.abs() + got.abs() + expected.abs();
        // Where the formula overflows nothing can be told.
        if !scale.is_finite() {
            continue;
        }
        if (got - expected).abs() > 1e-9 * scale {
            let message = format!(
                "the effects at joint `{}` are not linear in acceleration and load: forward dynamics cannot take them back",
                joint.name
            );
            return Some(Diagnostic::error(message).help(
                "write products such as `inertia * acceleration`, `c * abs(load) * sign(velocity)`; or leave the forward dynamics out under [generate]",
            ));
        }
        if sides.iter().any(|&side| side <= 0.0) {
            let message = format!(
                "the effects at joint `{}` take more than the whole load: no acceleration belongs to a torque",
                joint.name
            );
            return Some(Diagnostic::error(message).help("are the coefficients of the load too large?"));
        }
    }
    None
}
