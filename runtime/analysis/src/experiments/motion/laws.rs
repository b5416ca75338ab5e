//! Laws of effects at one joint over all samples.
use bipedc_effects::effect::{Acts, BoundLaw, Effect, VARIABLES};
use std::ops::Range;

/// A torque law of an effect, from the library or the user's own.
pub(super) fn torque_law(effect: &Effect) -> Option<BoundLaw> {
    let acts = effect.kind.law.acts() == Acts::Torque;
    BoundLaw::new(effect.law_text().filter(|_| acts)?, &VARIABLES, effect).ok()
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
