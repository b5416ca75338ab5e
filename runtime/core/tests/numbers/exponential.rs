//! Errors of exp and tanh over their whole range, against a table computed with mpmath
//! (`data/exponential.py`) and against the standard library.
use super::unpacked;
use bipedc_runtime::Real;
use bipedc_runtime::math::ERROR_BOUND_EXPONENTIAL_ULP;

/// A reproducible stream of numbers.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// In [-1, 1).
    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2f64.powi(-52) - 1.0
    }
    /// Of any magnitude: tiny, usual, beyond every range.
    fn argument(&mut self) -> f64 {
        let scale = 10f64.powf(self.unit() * 4.0 - 1.0);
        match self.bits() % 32 {
            0 => self.unit() * 1e-300,
            1 => self.unit() * 1e300,
            2 => f64::from_bits(self.bits() & !(0x7ff << 52)),
            _ => self.unit() * scale,
        }
    }
}

/// Distance to the next `f64` of larger magnitude.
fn ulp64(x: f64) -> f64 {
    let x = x.abs();
    f64::from_bits(x.to_bits() + 1) - x
}

/// Distance to the next `f32` of larger magnitude.
fn ulp32(x: f64) -> f64 {
    let x = (x as f32).abs();
    f64::from(f32::from_bits(x.to_bits() + 1)) - f64::from(x)
}

/// The larger of the worst error so far and this one, in last places.
fn worse(worst: f64, got: f64, exact: f64, ulp: f64) -> f64 {
    if got == exact {
        return worst;
    }
    assert!(got.is_finite() && exact.is_finite(), "{got:e} {exact:e}");
    worst.max((got - exact).abs() / ulp)
}

#[test]
fn table_of_exact_values() {
    let (mut exp, mut tanh) = (0.0f64, 0.0f64);
    for line in unpacked(include_bytes!("../data/exponential.csv.gz")) {
        let mut fields = line.split(',').map(|bits| f64::from_bits(u64::from_str_radix(bits, 16).unwrap()));
        let mut next = || fields.next().unwrap();
        let (x, [grown, grown_rest, bent, bent_rest]) = (next(), [next(), next(), next(), next()]);
        exp = exp.max(((Real::exp(x) - grown) - grown_rest).abs() / ulp64(grown));
        tanh = tanh.max(((Real::tanh(x) - bent) - bent_rest).abs() / ulp64(bent));
    }
    println!("f64: exp {exp:.3} ulp, tanh {tanh:.3} ulp");
    assert!(exp < ERROR_BOUND_EXPONENTIAL_ULP && tanh < ERROR_BOUND_EXPONENTIAL_ULP, "{exp} {tanh}");
}

#[test]
fn doubles() {
    let mut random = Random(1);
    let (mut exp, mut tanh) = (0.0, 0.0);
    for _ in 0..2_000_000 {
        let x = random.argument();
        exp = worse(exp, Real::exp(x), x.exp(), ulp64(x.exp()));
        tanh = worse(tanh, Real::tanh(x), x.tanh(), ulp64(x.tanh()));
        assert_eq!(Real::tanh(-x), -Real::tanh(x));
        assert!(Real::tanh(x).abs() <= 1.0);
    }
    // The standard library's tanh is off by two units itself.
    println!("f64 against the standard library: exp {exp:.3} ulp, tanh {tanh:.3} ulp");
    assert!(exp < ERROR_BOUND_EXPONENTIAL_ULP && tanh < ERROR_BOUND_EXPONENTIAL_ULP + 2.0, "{exp} {tanh}");
}

#[test]
fn floats() {
    let (mut exp, mut tanh) = (0.0, 0.0);
    // Every 101st float of both signs.
    for bits in (0..0x7f80_0000u32).step_by(101) {
        for x in [f32::from_bits(bits), -f32::from_bits(bits)] {
            let exact = f64::from(x).exp();
            if exact < f64::from(f32::MAX) {
                exp = worse(exp, f64::from(Real::exp(x)), exact, ulp32(exact));
            } else {
                assert_eq!(Real::exp(x), f32::INFINITY);
            }
            let exact = f64::from(x).tanh();
            tanh = worse(tanh, f64::from(Real::tanh(x)), exact, ulp32(exact));
        }
    }
    println!("f32: exp {exp:.3} ulp, tanh {tanh:.3} ulp");
    assert!(exp < ERROR_BOUND_EXPONENTIAL_ULP && tanh < ERROR_BOUND_EXPONENTIAL_ULP, "{exp} {tanh}");
}

#[test]
fn limits() {
    for x in [710.0, 1e4, f64::MAX, f64::INFINITY] {
        assert_eq!((Real::exp(x), Real::exp(-x * 1.1), Real::tanh(x)), (f64::INFINITY, 0.0, 1.0));
    }
    assert_eq!((Real::exp(0.0), Real::exp(-0.0), Real::tanh(0.0)), (1.0, 1.0, 0.0));
    assert!(Real::tanh(-0.0f64).is_sign_negative());
    assert!(Real::exp(f64::NAN).is_nan() && Real::tanh(f64::NAN).is_nan() && Real::exp(f32::NAN).is_nan());
    // Gradual underflow, and the last finite values.
    assert!(Real::exp(-744.0) > 0.0 && Real::exp(709.78f64).is_finite());
    assert_eq!([Real::sign(-3.0), Real::sign(0.0), Real::sign(1e-300)], [-1.0, 0.0, 1.0]);
    assert_eq!((Real::abs(-2.0), Real::larger(1.0, 2.0)), (2.0, 2.0));
}
