//! Exact fractions: reading them from the numbers of a description and recovering them from residues.
use num_bigint::{BigInt, Sign};
use num_integer::Integer;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// A reduced fraction with positive denominator.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fraction {
    numerator: BigInt,
    denominator: BigInt,
}

/// A number of a description is meant to be the fraction this many units of its last place away.
///
/// Undoes the rounding of the few sums of lengths that are formed before the analysis.
const ULPS: u32 = 4;

impl Fraction {
    /// `numerator / denominator`
    ///
    /// # Panics
    /// When the denominator is 0.
    pub fn new(numerator: BigInt, denominator: BigInt) -> Self {
        assert!(!denominator.is_zero(), "a fraction needs a denominator");
        let divisor = numerator.gcd(&denominator) * denominator.signum();
        Self { numerator: numerator / &divisor, denominator: denominator / divisor }
    }

    /// The number that was meant: the decimal of at most 12 digits, else the simplest fraction, within 4 ulp.
    ///
    /// # Panics
    /// On NaN and infinity.
    pub fn read(value: f64) -> Self {
        assert!(value.is_finite(), "only finite numbers have fractions, got {value}");
        if value == 0.0 {
            return Self { numerator: BigInt::zero(), denominator: BigInt::one() };
        }
        if value < 0.0 {
            let positive = Self::read(-value);
            return Self { numerator: -positive.numerator, denominator: positive.denominator };
        }
        decimal(value).unwrap_or_else(|| simplest_near(value))
    }

    /// From a residue: the only fraction `n/d ≡ residue (mod modulus)` with `2 n², 2 d² ≤ modulus`, if any.
    ///
    /// Half of all residues have one by chance; what decides is the check with another prime.
    pub fn from_residue(residue: &BigInt, modulus: &BigInt) -> Option<Self> {
        let bound = (modulus >> 1_u32).sqrt();
        let (mut r, mut next_r) = (modulus.clone(), residue.mod_floor(modulus));
        let (mut t, mut next_t) = (BigInt::zero(), BigInt::one());
        while next_r > bound {
            let quotient = &r / &next_r;
            (r, next_r) = (next_r.clone(), r - &quotient * &next_r);
            (t, next_t) = (next_t.clone(), t - quotient * next_t);
        }
        let good = next_t.abs() <= bound && next_r.gcd(&next_t).is_one();
        good.then(|| Self::new(next_r, next_t))
    }

    /// Numerator and denominator modulo a prime.
    pub fn modulo(&self, prime: u64) -> (u64, u64) {
        let residue = |n: &BigInt| n.mod_floor(&BigInt::from(prime)).to_u64().unwrap_or(0);
        (residue(&self.numerator), residue(&self.denominator))
    }

    /// Whether it is 0.
    pub fn is_zero(&self) -> bool {
        self.numerator.is_zero()
    }

    /// The nearest number, up to one rounding.
    pub fn to_f64(&self) -> f64 {
        // Both are cut to 200 bits first, lest they overflow.
        let excess = |n: &BigInt| i64::try_from(n.bits()).unwrap_or(i64::MAX).saturating_sub(200).max(0);
        let (a, b) = (excess(&self.numerator), excess(&self.denominator));
        let ratio = (&self.numerator >> a).to_f64().unwrap_or(0.0)
            / (&self.denominator >> b).to_f64().unwrap_or(f64::INFINITY);
        ratio * 2.0_f64.powi(i32::try_from(a - b).unwrap_or(0))
    }
}

impl std::fmt::Display for Fraction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.denominator.is_one() {
            return write!(f, "{}", self.numerator);
        }
        write!(f, "{}/{}", self.numerator, self.denominator)
    }
}

/// The decimal of at most 12 digits within 4 ulp.
fn decimal(value: f64) -> Option<Fraction> {
    let text = format!("{value:.11e}");
    let read: f64 = text.parse().ok()?;
    let steps = read.to_bits().abs_diff(value.to_bits());
    if steps > u64::from(ULPS) {
        return None;
    }
    let (digits, exponent) = text.split_once('e')?;
    let digits: BigInt = digits.replace('.', "").parse().ok()?;
    let exponent = exponent.parse::<i32>().ok()? - 11;
    let scale = BigInt::from(10).pow(exponent.unsigned_abs());
    Some(if exponent < 0 {
        Fraction::new(digits, scale)
    } else {
        Fraction::new(digits * scale, BigInt::one())
    })
}

/// The fraction with the smallest denominator within 4 ulp.
fn simplest_near(value: f64) -> Fraction {
    let bits = value.to_bits();
    let exponent = (bits >> 52) as i32;
    let mantissa =
        if exponent == 0 { (bits & ((1 << 52) - 1)) << 1 } else { bits & ((1 << 52) - 1) | 1 << 52 };
    let shift = exponent - 1075;
    let scale = BigInt::one() << shift.unsigned_abs();
    let at = |m: u64| {
        let m = BigInt::from(m);
        if shift < 0 { (m, scale.clone()) } else { (m * &scale, BigInt::one()) }
    };
    let lower = at(mantissa.saturating_sub(u64::from(ULPS)));
    let (numerator, denominator) = simplest_between(lower, at(mantissa + u64::from(ULPS)));
    Fraction::new(numerator, denominator)
}

/// The fraction with the smallest denominator in a closed interval, by its continued fraction.
fn simplest_between(low: (BigInt, BigInt), high: (BigInt, BigInt)) -> (BigInt, BigInt) {
    let (whole, rest) = low.0.div_mod_floor(&low.1);
    if rest.is_zero() {
        return (whole, BigInt::one());
    }
    let next: BigInt = &whole + 1;
    if &next * &high.1 <= high.0 {
        return (next, BigInt::one());
    }
    let high_rest = high.0 - &whole * &high.1;
    let (n, d) = simplest_between((high.1, high_rest), (low.1, rest));
    (whole * &n + d, n)
}

/// Joins `x ≡ a (mod m)` and `x ≡ b (mod p)` into one residue modulo `m p`.
pub fn chinese_remainder(a: &BigInt, m: &BigInt, b: u64, p: u64, inverse_of_m: u64) -> BigInt {
    let a_mod = a.mod_floor(&BigInt::from(p)).to_u64().unwrap_or(0);
    let difference = if b >= a_mod { b - a_mod } else { b + (p - a_mod) };
    let steps = u128::from(difference) * u128::from(inverse_of_m) % u128::from(p);
    a + m * BigInt::new(Sign::Plus, vec![steps as u32, (steps >> 32) as u32])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(value: f64) -> String {
        Fraction::read(value).to_string()
    }

    #[test]
    fn numbers_are_read_as_meant() {
        assert_eq!(text(0.0764), "191/2500");
        assert_eq!(text(0.1 + 0.2), "3/10");
        assert_eq!(text(-1.0 / 3.0), "-1/3");
        assert_eq!(text(1e20), "100000000000000000000");
        assert_eq!(text(12.0), "12");
        for value in [std::f64::consts::PI, 0.123_456_789_123_456_78, 3e-9 / 7.0, 1e-300 / 3.0, 2e300 / 3.0] {
            let error = (Fraction::read(value).to_f64() - value).abs() / value;
            assert!(error < 1e-15, "{value}: {error}");
        }
    }

    #[test]
    fn residues_give_fractions_back() {
        let (p, q) = (2_305_843_009_213_693_951_u64, 4_611_686_018_427_387_847_u64);
        let modulus = BigInt::from(p) * q;
        let wanted =
            Fraction::new(BigInt::from(-123_456_789_012_345_i64), BigInt::from(98_765_432_100_001_i64));
        let inverse = |d: u64, p: u64| BigInt::from(d).modpow(&BigInt::from(p - 2), &BigInt::from(p));
        let residue = |p: u64| {
            let (n, d) = wanted.modulo(p);
            ((inverse(d, p) * n) % p).to_u64().unwrap()
        };
        let m_inverse = inverse(p % q, q).to_u64().unwrap();
        let joined = chinese_remainder(&BigInt::from(residue(p)), &BigInt::from(p), residue(q), q, m_inverse);
        assert_eq!(Fraction::from_residue(&joined, &modulus), Some(wanted.clone()));
        assert_ne!(Fraction::from_residue(&BigInt::from(residue(p)), &BigInt::from(p)), Some(wanted));
    }
}
