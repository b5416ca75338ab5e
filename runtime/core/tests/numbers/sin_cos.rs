//! Error bounds of sine and cosine over the whole range, against a table computed with mpmath
//! (`data/sin_cos.py`) and against the standard library.

use super::unpacked;
use bipedc_runtime::Real;
use bipedc_runtime::math::{
    COMMON_RANGE_F32, COMMON_RANGE_F64, ERROR_BOUND_F32, ERROR_BOUND_F64, ERROR_BOUND_ULP, sin_cos,
};

/// A value and the small remainder that makes it exact.
#[derive(Clone, Copy)]
struct Exact(f64, f64);

impl Exact {
    fn error(self, actual: f64) -> f64 {
        ((actual - self.0) - self.1).abs()
    }
}

/// Argument, sine and cosine.
fn table() -> impl Iterator<Item = (f64, Exact, Exact)> {
    unpacked(include_bytes!("../data/sin_cos.csv.gz")).into_iter().map(|line| {
        let mut fields = line.split(',').map(|field| f64::from_bits(u64::from_str_radix(field, 16).unwrap()));
        let mut next = || fields.next().unwrap();
        (next(), Exact(next(), next()), Exact(next(), next()))
    })
}

/// The distance between a value and the next larger magnitude.
fn ulp(x: f64) -> f64 {
    let x = x.abs();
    f64::from_bits(x.to_bits() + 1) - x
}

/// Largest errors: absolute in units of 2^-53, and in units in the last place.
#[derive(Debug, Default)]
struct Worst {
    absolute: (f64, f64),
    relative: (f64, f64),
}

impl Worst {
    fn see(&mut self, x: f64, error: f64, exact: f64) {
        let (absolute, relative) = (error * 2f64.powi(53), error / ulp(exact));
        if absolute > self.absolute.0 {
            self.absolute = (absolute, x);
        }
        if relative > self.relative.0 {
            self.relative = (relative, x);
        }
    }
    fn check(&self, what: &str) {
        println!("{what}: {self:?}");
        assert!(self.absolute.0 < ERROR_BOUND_F64 && self.relative.0 < ERROR_BOUND_ULP, "{what}: {self:?}");
    }
}

#[test]
fn table_of_exact_values() {
    let (mut common, mut large) = (Worst::default(), Worst::default());
    for (x, sine, cosine) in table() {
        let worst = if x <= COMMON_RANGE_F64 { &mut common } else { &mut large };
        for x in [x, -x] {
            let (s, c) = sin_cos(x);
            worst.see(x, sine.error(if x < 0.0 { -s } else { s }), sine.0);
            worst.see(x, cosine.error(c), cosine.0);
        }
    }
    common.check("common range");
    large.check("beyond");
}

/// A reproducible stream of numbers.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}

#[test]
fn close_to_the_standard_library_on_random_bits() {
    let mut random = Random(7);
    // The library is itself within one unit in the last place.
    let tolerance = (ERROR_BOUND_F64 + 1.0) * 2f64.powi(-53);
    for _ in 0..1_000_000 {
        let x = f64::from_bits(random.bits());
        if !x.is_finite() {
            continue;
        }
        let (s, c) = sin_cos(x);
        assert!((s - x.sin()).abs() <= tolerance && (c - x.cos()).abs() <= tolerance, "{x:e}: {s:e} {c:e}");
        let x = (x.to_bits() as i64 as f64) * 2f64.powi(-43 - (random.bits() % 20) as i32);
        let (s, c) = sin_cos(x);
        assert!((s - x.sin()).abs() <= tolerance && (c - x.cos()).abs() <= tolerance, "{x:e}: {s:e} {c:e}");
    }
}

#[test]
fn not_finite_gives_nan() {
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let (s, c) = sin_cos(x);
        assert!(s.is_nan() && c.is_nan());
        let (s, c) = sin_cos(x as f32);
        assert!(s.is_nan() && c.is_nan());
        // Neighbours are not disturbed.
        let (s, c) = f64::sin_cos_all([0.5, x, 1e300]);
        assert!(s[1].is_nan() && c[1].is_nan());
        assert_eq!((s[0], c[2]), (sin_cos(0.5).0, sin_cos(1e300).1));
    }
}

/// Largest absolute error in units of 2^-24 and relative error in units in the last place, of these
/// positive `f32`.
fn worst_f32(patterns: impl Iterator<Item = u32>) -> ((f64, f32), (f64, f32)) {
    let (mut absolute, mut relative) = ((0.0, 0.0), (0.0, 0.0));
    for bits in patterns {
        let x = f32::from_bits(bits);
        let (s, c) = sin_cos(x);
        for (actual, exact) in [(s, f64::from(x).sin()), (c, f64::from(x).cos())] {
            let error = (f64::from(actual) - exact).abs();
            let unit = f64::from(f32::from_bits((exact as f32).abs().to_bits() + 1) - (exact as f32).abs());
            if error * 2f64.powi(24) > absolute.0 {
                absolute = (error * 2f64.powi(24), x);
            }
            if error / unit > relative.0 {
                relative = (error / unit, x);
            }
        }
    }
    (absolute, relative)
}

#[test]
fn single_precision_against_double() {
    let (absolute, relative) = worst_f32((0..=f32::MAX.to_bits()).step_by(997));
    println!("{absolute:?} {relative:?}");
    assert!(absolute.0 < ERROR_BOUND_F32 && relative.0 < ERROR_BOUND_ULP, "{absolute:?} {relative:?}");
}

/// Below 2^-30 sin x = x and cos x = 1 in `f32`; beyond the common range the result is that of `f64`, rounded.
/// Run with `--release -- --ignored` after changing the kernel.
#[test]
#[ignore = "336 million arguments"]
fn single_precision_exhaustively() {
    let (absolute, relative) = worst_f32(2f32.powi(-30).to_bits()..=COMMON_RANGE_F32.to_bits());
    println!("{absolute:?} {relative:?}");
    assert!(absolute.0 < ERROR_BOUND_F32 && relative.0 < ERROR_BOUND_ULP, "{absolute:?} {relative:?}");
}
