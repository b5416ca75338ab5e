//! Zeros and smallest values of functions of one variable.

/// Halvings of an interval after which nothing is left of it.
const HALVINGS: usize = 200;

/// A zero between two places of different sign, to the last bits: bisection, with the secant where it is better.
pub(super) fn zero(
    mut f: impl FnMut(f64) -> f64,
    (mut a, mut fa): (f64, f64),
    (mut b, mut fb): (f64, f64),
) -> f64 {
    for round in 0..HALVINGS {
        if fa == 0.0 || fb == 0.0 || (b - a).abs() <= f64::EPSILON * a.abs().max(b.abs()) {
            break;
        }
        let secant = b - fb * (b - a) / (fb - fa);
        let middle = 0.5 * (a + b);
        // The secant alone may keep one end for ever.
        let inside = secant > a.min(b) && secant < a.max(b);
        let x = if inside && round % 3 != 2 { secant } else { middle };
        let fx = f(x);
        if fx.is_nan() {
            break;
        }
        if (fx < 0.0) == (fa < 0.0) {
            (a, fa) = (x, fx);
        } else {
            (b, fb) = (x, fx);
        }
    }
    if fa.abs() <= fb.abs() { a } else { b }
}

/// Where a function is smallest in an interval, and its value there: the best of `count` samples, then golden sections around it.
/// What is no number counts as larger than all.
pub(super) fn least(f: impl Fn(f64) -> f64, [low, high]: [f64; 2], count: usize) -> (f64, f64) {
    let value = |x: f64| {
        let y = f(x);
        if y.is_nan() { f64::INFINITY } else { y }
    };
    let place = |k: usize| low + (high - low) * k as f64 / count as f64;
    let (mut best, mut least) = (0, f64::INFINITY);
    for k in 0..=count {
        let y = value(place(k));
        if y < least {
            (best, least) = (k, y);
        }
    }
    let (mut a, mut b) = (place(best.saturating_sub(1)), place((best + 1).min(count)));
    let part = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..60 {
        let (x, y) = (b - part * (b - a), a + part * (b - a));
        if value(x) < value(y) { b = y } else { a = x }
    }
    let x = 0.5 * (a + b);
    if value(x) < least { (x, value(x)) } else { (place(best), least) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_are_found_to_the_last_bits() {
        let f = |x: f64| x.cos() - x;
        assert!((zero(f, (0.0, f(0.0)), (1.0, f(1.0))) - 0.739_085_133_215_160_6).abs() < 2e-16);
        let steep = |x: f64| x.powi(9) - 1e-9;
        assert!((zero(steep, (0.0, steep(0.0)), (5.0, steep(5.0))) - 0.1).abs() < 1e-16);
    }

    #[test]
    fn the_least_value_lies_inside_or_at_an_end() {
        let (x, y) = least(|x| (x - 0.3).powi(2) + 2.0, [-1.0, 1.0], 20);
        assert!((x - 0.3).abs() < 1e-7 && (y - 2.0).abs() < 1e-14);
        assert_eq!(least(|x| x, [-1.0, 1.0], 20), (-1.0, -1.0));
    }
}
