//! The first zero of a function, with bounded work.
use crate::real::Scalar;

/// Places at which a sign is asked for.
pub(super) const SAMPLES: usize = 256;
/// Rounds of narrowing: halving alone ends after 53.
const ROUNDS: usize = 120;

/// The first place between `low` and `high` where `f` vanishes or changes its sign, to rounding. Where `f` has no value, or an
/// infinite one, there is no sign.
pub(super) fn first_zero<R: Scalar>([low, high]: [R; 2], mut f: impl FnMut(R) -> Option<R>) -> Option<R> {
    let mut known = |x: R| f(x).filter(|value| value.is_finite());
    let zero = R::constant(0.0);
    let mut last: Option<(R, R)> = None;
    for k in 0..=SAMPLES {
        let part = R::constant(k as f64 / SAMPLES as f64);
        let place = R::fused(high - low, part, low);
        let Some(value) = known(place) else {
            last = None;
            continue;
        };
        if value == zero {
            return Some(place);
        }
        match last {
            Some(before) if (before.1 < zero) != (value < zero) => {
                return Some(narrowed(known, before, (place, value)));
            }
            _ => last = Some((place, value)),
        }
    }
    None
}

/// Regula falsi with halved weights (Illinois), then halving.
fn narrowed<R: Scalar>(mut f: impl FnMut(R) -> Option<R>, mut a: (R, R), mut b: (R, R)) -> R {
    let (zero, half) = (R::constant(0.0), R::constant(0.5));
    // Weights of both ends: that of the one which stays is halved.
    let (mut left, mut right) = (a.1, b.1);
    for round in 0..ROUNDS {
        let middle = half * (a.0 + b.0);
        let secant = a.0 + (b.0 - a.0) * left / (left - right);
        let inside = secant > a.0 && secant < b.0;
        let place = if inside && round < ROUNDS / 2 { secant } else { middle };
        if !(place > a.0 && place < b.0) {
            break;
        }
        let Some(value) = f(place) else { break };
        if value == zero {
            return place;
        }
        if (value < zero) == (a.1 < zero) {
            (a, left, right) = ((place, value), value, half * right);
        } else {
            (b, right, left) = ((place, value), value, half * left);
        }
    }
    if a.1.abs() < b.1.abs() { a.0 } else { b.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_zero_is_found_to_rounding() {
        let found = first_zero([0.0, 7.0], |x: f64| Some(x.cos())).unwrap();
        assert!((found - core::f64::consts::FRAC_PI_2).abs() < 1e-15, "{found}");
        let steep = first_zero([-1.0, 1.0], |x: f64| Some((x - 0.3).powi(9))).unwrap();
        assert!((steep - 0.3).abs() < 1e-12, "{steep}");
        let short = first_zero([0.0, 2.0f32], |x| Some(x * x - 2.0)).unwrap();
        assert!((short - core::f32::consts::SQRT_2).abs() < 2e-7, "{short}");
        assert_eq!(first_zero([0.0, 1.0], |x: f64| Some(x - 1.0)), Some(1.0));
    }

    #[test]
    fn where_there_is_no_value_there_is_no_sign() {
        assert_eq!(first_zero([0.0, 1.0], |x: f64| Some(x + 1.0)), None);
        assert_eq!(first_zero([0.0, 1.0], |_: f64| Some(f64::NAN)), None);
        // The sign changes across the gap alone.
        let gap = |x: f64| (!(0.4..0.6).contains(&x)).then_some(x - 0.5);
        assert_eq!(first_zero([0.0, 1.0], gap), None);
    }
}
