//! Sums and products of numbers as people write them: 0.1 + 0.2 is 0.3.
//!
//! A number of a description is a short decimal; the nearest binary number stands for it. As long as numbers are short, what is
//! folded here is computed from the decimals and rounded once, so that no binary dust gathers in constants. Numbers of more
//! digits (sines, quotients) are added and multiplied as they are.

/// More digits than this may be the binary number's own.
const SHORT: u32 = 15;

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
    nearest(digits, exponent).filter(|value| value.is_finite())
}

/// The binary number nearest to digits · 10^exponent.
fn nearest(digits: i128, exponent: i32) -> Option<f64> {
    // Both factors are exact up to here, so that one operation rounds once.
    let power = POWERS.get(exponent.unsigned_abs() as usize);
    match power.filter(|_| digits.unsigned_abs() <= 1 << f64::MANTISSA_DIGITS) {
        Some(power) if exponent < 0 => Some(digits as f64 / power),
        Some(power) => Some(digits as f64 * power),
        None => format!("{digits}e{exponent}").parse().ok(),
    }
}

/// Powers of ten that are binary numbers.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// The shortest decimal that is nearest to this number alone, if it is short.
fn short(x: f64) -> Option<Decimal> {
    if !x.is_finite() {
        return None;
    }
    let mut buffer = zmij::Buffer::new();
    let text = buffer.format_finite(x);
    let (text, mut exponent) = match text.split_once('e') {
        Some((text, exponent)) => (text, exponent.parse::<i32>().ok()?),
        None => (text, 0),
    };
    let (whole, places) = text.split_once('.').unwrap_or((text, ""));
    exponent -= places.len() as i32;
    // At most 17 digits and the zeros between them and the point.
    let mut digits = 0_i128;
    for digit in whole.bytes().chain(places.bytes()).filter(u8::is_ascii_digit) {
        digits = 10 * digits + i128::from(digit - b'0');
    }
    while digits != 0 && digits % 10 == 0 {
        digits /= 10;
        exponent += 1;
    }
    (digits < 10_i128.pow(SHORT)).then_some((if x < 0.0 { -digits } else { digits }, exponent))
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
    fn numbers_are_taken_apart_into_their_shortest_digits() {
        let known = [
            (0.0102, (102, -4)),
            (-9.81, (-981, -2)),
            (1200.0, (12, 2)),
            (1e300, (1, 300)),
            (-2.5e-310, (-25, -311)),
            (123_456_789_012_345.0, (123_456_789_012_345, 0)),
        ];
        for (number, decimal) in known {
            assert_eq!(short(number), Some(decimal), "{number}");
            assert_eq!(nearest(decimal.0, decimal.1), Some(number), "{number}");
        }
        assert_eq!(short(std::f64::consts::PI), None);
        assert_eq!(short(1.0 / 3.0 * 1e-7), None);
        // More digits than one rounding can take.
        assert_eq!(nearest(123_456_789_012_345_678_901, -20), Some(1.234_567_890_123_456_8));
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
