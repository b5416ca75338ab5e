//! Zeros and smallest values of functions of one variable.

/// Places asked for, after which nothing is left of an interval.
const ROUNDS: usize = 200;

/// A zero between two places of different sign, to the last bits: bisection, with the inverse parabola through three places where
/// that is safe (Chandrupatla 1997).
pub fn zero(mut f: impl FnMut(f64) -> f64, (a, fa): (f64, f64), (b, fb): (f64, f64)) -> f64 {
    let (mut a, mut fa, mut b, mut fb) = (b, fb, a, fa);
    let mut part = 0.5;
    for _ in 0..ROUNDS {
        let least = f64::EPSILON * a.abs().max(b.abs());
        if fa == 0.0 || fb == 0.0 || (b - a).abs() <= least {
            break;
        }
        let x = a + part * (b - a);
        let fx = f(x);
        if fx.is_nan() {
            break;
        }
        // The zero lies between x, from now on a, and b; c is the place before.
        let (c, fc);
        if (fx < 0.0) == (fa < 0.0) {
            (c, fc) = (a, fa);
        } else {
            (c, fc) = (b, fb);
            (b, fb) = (a, fa);
        }
        (a, fa) = (x, fx);
        let (place, value) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        let safe = value * value < place && (1.0 - value) * (1.0 - value) < 1.0 - place;
        let parabola = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb);
        // Never closer to an end than the last bit.
        let edge = (0.5 * least / (b - a).abs()).min(0.5);
        part = if safe && parabola.is_finite() { parabola.clamp(edge, 1.0 - edge) } else { 0.5 };
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
