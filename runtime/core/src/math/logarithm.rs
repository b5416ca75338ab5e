//! Natural logarithm of scalars.
//!
//! x = 2ᵏ (1 + f) with 1/√2 ≤ 1 + f < √2; with s = f/(2 + f), ln(1 + f) = f − f²/2 + s (f²/2 + R), where
//! R = Σ 2 s²ⁿ/(2n + 1) is a series whose first left-out term is below a tenth of the last place.
use crate::Scalar;

/// Bits of a mantissa.
const MANTISSA: u32 = 52;
/// Of the exponent.
const BIAS: i32 = 1023;
/// ln 2 in two parts: products of the first with an exponent are exact.
const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// `ln x`: −∞ of 0, NaN of negative numbers and of NaN.
fn ln_f64(x: f64) -> f64 {
    if x.is_nan() || x < 0.0 {
        return f64::NAN;
    }
    if x == 0.0 {
        return f64::NEG_INFINITY;
    }
    if x == f64::INFINITY {
        return x;
    }
    // Numbers below the normal ones are made normal first.
    let (x, scaled) = if x < f64::MIN_POSITIVE { (x * 18_014_398_509_481_984.0, 54) } else { (x, 0) };
    let bits = x.to_bits();
    let exponent = (bits >> MANTISSA) as i32 - BIAS - scaled;
    let one_to_two = f64::from_bits((bits & ((1 << MANTISSA) - 1)) | ((BIAS as u64) << MANTISSA));
    let large = one_to_two > core::f64::consts::SQRT_2;
    let (f, k) = if large { (0.5 * one_to_two - 1.0, exponent + 1) } else { (one_to_two - 1.0, exponent) };
    let k = f64::from(k);
    let s = f / (2.0 + f);
    let z = s * s;
    let mut series = 0.0;
    for n in (1..=10).rev() {
        series = (series + 2.0 / f64::from(2 * n + 1)) * z;
    }
    let half = 0.5 * f * f;
    k * LN2_HIGH - ((half - (s * (half + series) + k * LN2_LOW)) - f)
}

/// `ln x` by the longer one, rounded.
fn ln_f32(x: f32) -> f32 {
    ln_f64(f64::from(x)) as f32
}

impl Scalar for f64 {
    const EPSILON: f64 = f64::EPSILON;
    #[inline]
    fn ln(self) -> Self {
        ln_f64(self)
    }
    #[inline]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
}

impl Scalar for f32 {
    const EPSILON: f64 = f32::EPSILON as f64;
    #[inline]
    fn ln(self) -> Self {
        ln_f32(self)
    }
    #[inline]
    fn is_finite(self) -> bool {
        f32::is_finite(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_are_those_of_the_library() {
        let mut worst = 0.0_f64;
        let mut x = 3e-320_f64;
        while x < 1e308 {
            let (own, known) = (ln_f64(x), x.ln());
            worst = worst.max((own - known).abs() / known.abs().max(f64::MIN_POSITIVE) / f64::EPSILON);
            x *= 1.000_7;
        }
        // And near 1, where the result vanishes.
        for k in 1..2000 {
            for x in [1.0 + f64::from(k) * 1e-6, 1.0 - f64::from(k) * 1e-6] {
                worst = worst.max((ln_f64(x) - x.ln()).abs() / x.ln().abs() / f64::EPSILON);
            }
        }
        println!("{worst} units in the last place at most");
        assert!(worst < 2.0, "{worst}");
    }

    #[test]
    fn what_has_no_logarithm_gives_none() {
        assert_eq!(
            (ln_f64(0.0), ln_f64(1.0), ln_f64(f64::INFINITY)),
            (f64::NEG_INFINITY, 0.0, f64::INFINITY)
        );
        assert!(ln_f64(-1.0).is_nan() && ln_f64(f64::NAN).is_nan() && ln_f32(-1e-40).is_nan());
        assert!((ln_f32(2.0) - core::f32::consts::LN_2).abs() <= f32::EPSILON);
    }
}
