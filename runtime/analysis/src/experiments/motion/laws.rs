//! Laws of effects at one joint over all samples.
use bipedc_effects::effect::formula::{Bound, Formula, SMOOTHING};
use bipedc_effects::effect::{Effect, Law, VARIABLES};
use std::ops::Range;

/// Default of `smoothing` in users' formulas, rad/s.
const DEFAULT_SMOOTHING: f64 = 0.02;

/// A law with its parameters' values filled in.
pub(super) struct Ready {
    bound: Bound,
    /// Variables first, then parameters.
    values: Vec<f64>,
}

impl Ready {
    /// The law `text` in these variables with the effect's parameters; `None` if it has no meaning.
    pub fn new(text: &str, variables: &[&str], effect: &Effect) -> Option<Self> {
        let formula = Formula::parse(text).ok()?;
        let mut names = variables.to_vec();
        let mut values = vec![0.0; variables.len()];
        for name in formula.names() {
            if names.contains(&name.as_str()) {
                continue;
            }
            let value = match effect.kind.parameter(name) {
                Some(_) => effect.value(name),
                None if name == SMOOTHING => {
                    effect.parameters.get(SMOOTHING).copied().unwrap_or(DEFAULT_SMOOTHING)
                }
                None => *effect.parameters.get(name)?,
            };
            names.push(name);
            values.push(value);
        }
        Some(Self { bound: formula.bind(&names).ok()?, values })
    }

    /// The value where the variables have these values.
    pub fn at(&mut self, variables: &[f64], work: &mut Vec<f64>) -> f64 {
        self.values[..variables.len()].copy_from_slice(variables);
        self.bound.run(&self.values, work)
    }
}

/// A torque law of an effect, from the library or the user's own.
pub(super) fn torque_law(effect: &Effect) -> Option<Ready> {
    match effect.kind.law {
        Law::Torque(text) => Ready::new(text, &VARIABLES, effect),
        Law::Formula => Ready::new(effect.torque.as_deref()?, &VARIABLES, effect),
        _ => None,
    }
}

/// Motion of one joint over all samples, as slices with a stride.
#[derive(Clone, Copy)]
pub(super) struct Strided<'a> {
    values: &'a [f64],
    offset: usize,
    width: usize,
}

impl<'a> Strided<'a> {
    /// Element `offset` of every group of `width`.
    pub fn new(values: &'a [f64], offset: usize, width: usize) -> Self {
        Self { values, offset, width }
    }
    /// At this sample.
    pub fn at(&self, sample: usize) -> f64 {
        self.values[sample * self.width + self.offset]
    }
}

/// `signal` at `delay` later, per stretch; held at its end. Four-point interpolation: exact for cubics.
pub(super) fn advanced(signal: &[f64], segments: &[Range<usize>], steps: f64) -> Vec<f64> {
    let mut out = signal.to_vec();
    let (whole, part) = (steps.floor(), steps - steps.floor());
    for segment in segments {
        let stretch = &signal[segment.clone()];
        let last = stretch.len().saturating_sub(1);
        let at = |index: f64| stretch[(index.max(0.0) as usize).min(last)];
        for (i, value) in out[segment.clone()].iter_mut().enumerate() {
            let base = i as f64 + whole;
            let [y0, y1, y2, y3] = [at(base - 1.0), at(base), at(base + 1.0), at(base + 2.0)];
            let t = part;
            *value = -t * (t - 1.0) * (t - 2.0) / 6.0 * y0 + (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0 * y1
                - (t + 1.0) * t * (t - 2.0) / 2.0 * y2
                + (t + 1.0) * t * (t - 1.0) / 6.0 * y3;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_effects::effect::{Location, kinds};

    #[test]
    fn a_cubic_is_advanced_exactly() {
        let signal: Vec<f64> = (0..40).map(|i| f64::from(i).powi(3)).collect();
        let shifted = advanced(&signal, std::slice::from_ref(&(0..40)), 2.25);
        for (i, value) in shifted.iter().enumerate().take(36).skip(1) {
            assert!((value - (i as f64 + 2.25).powi(3)).abs() < 1e-8);
        }
    }

    #[test]
    fn a_users_formula_takes_its_own_parameters() {
        let mut effect = Effect::new(&kinds::FORMULA, Location::joint("a"), &[("k", 2.0)]);
        effect.torque = Some("k * sin(3 * position) * velocity".to_owned());
        let mut law = torque_law(&effect).unwrap();
        let value = law.at(&[0.2, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0], &mut Vec::new());
        assert!((value - 6.0 * 0.6f64.sin()).abs() < 1e-15);
    }
}
