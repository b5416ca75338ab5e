//! Sums and products of numbers as people write them: 0.1 + 0.2 is 0.3.
//!
//! A number of a description is a short decimal; the nearest binary number stands for it. As long as numbers are short, what is
//! folded here is computed from the decimals and rounded once, so that no binary dust gathers in constants. Numbers of more
//! digits (sines, quotients) are added and multiplied as they are.

/// More digits than this may be the binary number's own.
const SHORT: usize = 15;

/// `x + y`
pub fn sum(x: f64, y: f64) -> f64 {
    // Most numbers of an inertia are zeros, and most rotations are by right angles: nothing is rounded then.
    if x == 0.0 || y == 0.0 || x == -y {
        return x + y;
    }
    exactly(x, y, |(a, p), (b, q)| {
        let least = p.min(q);
        let scaled = |digits: i128, exponent: i32| {
            // With the 15 digits that there are, this keeps below 2^127.
            let zeros = u32::try_from(exponent - least).ok().filter(|&zeros| zeros <= 20)?;
            Some(digits * 10_i128.pow(zeros))
        };
        Some((scaled(a, p)? + scaled(b, q)?, least))
    })
    .unwrap_or(x + y)
}

/// `x · y`
pub fn product(x: f64, y: f64) -> f64 {
    let plain = |x: f64| [0.0, 1.0, 2.0].contains(&x.abs());
    if plain(x) || plain(y) {
        return x * y;
    }
    exactly(x, y, |(a, p), (b, q)| Some((a * b, p + q))).unwrap_or(x * y)
}

/// `Σ xᵢ yᵢ`
pub fn dot(x: [f64; 3], y: [f64; 3]) -> f64 {
    (0..3).fold(0.0, |total, k| sum(total, product(x[k], y[k])))
}

/// Digits and power of ten.
type Decimal = (i128, i32);

fn exactly(x: f64, y: f64, operation: impl Fn(Decimal, Decimal) -> Option<Decimal>) -> Option<f64> {
    let (digits, exponent) = operation(short(x)?, short(y)?)?;
    format!("{digits}e{exponent}").parse().ok().filter(|value: &f64| value.is_finite())
}

/// The shortest decimal that is nearest to this number alone, if it is short.
fn short(x: f64) -> Option<Decimal> {
    let text = format!("{x:e}");
    let (digits, exponent) = text.split_once('e')?;
    let places = digits.split_once('.').map_or(0, |(_, places)| places.len());
    let digits = digits.replace('.', "");
    if digits.trim_start_matches('-').len() > SHORT {
        return None;
    }
    Some((digits.parse().ok()?, exponent.parse::<i32>().ok()? - places as i32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_numbers_have_no_binary_dust() {
        assert_eq!(sum(0.1, 0.2), 0.3);
        assert_ne!(0.1 + 0.2, 0.3);
        assert_eq!(sum(product(6.8, 0.11), product(3.2, 0.4)), 2.028);
        assert_ne!(6.8 * 0.11 + 3.2 * 0.4, 2.028);
        assert_eq!(product(2.028, 9.81), 19.89468);
        assert_eq!(sum(0.3, -0.3).to_bits(), 0.0_f64.to_bits());
        assert_eq!(sum(1e12, 1e-3), 1_000_000_000_000.001);
    }

    #[test]
    fn what_is_not_short_is_computed_as_it_is() {
        let third = 1.0_f64 / 3.0;
        assert_eq!(sum(third, 0.1), third + 0.1);
        assert_eq!(product(0.7_f64.sin(), third), 0.7_f64.sin() * third);
        // So far apart that the digits of one are below the other's.
        assert_eq!(sum(1e12, 1e-99), 1e12);
        assert_eq!(product(1e300, 1e300), f64::INFINITY);
        assert_eq!(sum(f64::INFINITY, 1.0), f64::INFINITY);
        assert!(product(f64::NAN, 1.0).is_nan());
    }
}
