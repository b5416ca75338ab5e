//! Lanes, arrays and scalars give the same bits, operation by operation.

use bipedc_runtime::Real;
use bipedc_runtime::lanes::{
    F32_NATIVE_LANES, F32Native, F32x4, F32x8, F32x16, F64_NATIVE_LANES, F64Native, F64x2, F64x4, F64x8,
};
use bipedc_runtime::math::{FUSED, sin_cos};

/// A reproducible stream of numbers, most of them like angles, some huge, tiny or not finite.
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
    fn number(&mut self) -> f64 {
        match self.bits() % 64 {
            0 => f64::from_bits(self.bits()),
            1 => self.unit() * 1e9,
            2 => self.unit() * 1e-300,
            3 => 0.0,
            4..8 => self.unit() * 1e4,
            _ => self.unit() * 4.0,
        }
    }
}

/// The same bits, or both not a number.
fn same(left: f64, right: f64) -> bool {
    left.to_bits() == right.to_bits() || (left.is_nan() && right.is_nan())
}

/// One expression with every operation.
#[inline(never)]
fn every_operation<R: Real>(a: R, b: R, c: R) -> [R; 13] {
    let k = R::constant(0.63);
    let sums = [a + b, a - b, a * b, a / b, -c, R::fused(a, b, -c), R::fused(-a, k, c)];
    let [s0, s1, s2, s3, s4, s5, s6] = sums;
    let functions = [(a * a + b * b).sqrt(), a.exp(), b.tanh(), c.abs(), a.sign(), a.larger(b)];
    let [f0, f1, f2, f3, f4, f5] = functions;
    [s0, s1, s2, s3, s4, s5, s6, f0, f1, f2, f3, f4, f5]
}

macro_rules! lanes_equal_scalars {
    ($test:ident, $lanes:ident, $scalar:ident, $count:literal) => {
        #[test]
        fn $test() {
            let mut random = Random($count);
            for _ in 0..2000 {
                let mut next =
                    || -> [$scalar; $count] { std::array::from_fn(|_| random.number() as $scalar) };
                let (a, b, c) = (next(), next(), next());
                let pack = $lanes::from_array;
                let wide = every_operation(pack(a), pack(b), pack(c));
                let (sines, cosines) = $lanes::sin_cos_all([pack(a), pack(b), pack(c)]);
                for lane in 0..$count {
                    let narrow = every_operation(a[lane], b[lane], c[lane]);
                    for (w, n) in wide.iter().zip(narrow) {
                        assert!(same(w.to_array()[lane].into(), n.into()), "{a:?} {b:?} {c:?}: {w:?} {n:?}");
                    }
                    for (index, x) in [a, b, c].iter().enumerate() {
                        let (s, c) = sin_cos(x[lane]);
                        assert!(same(sines[index].to_array()[lane].into(), s.into()), "sin {}", x[lane]);
                        assert!(same(cosines[index].to_array()[lane].into(), c.into()), "cos {}", x[lane]);
                    }
                }
                assert_eq!(pack(a).to_array().map($scalar::to_bits), a.map($scalar::to_bits));
                assert_eq!($lanes::constant(0.63).to_array(), [0.63; $count]);
            }
        }
    };
}

lanes_equal_scalars!(f64x2, F64x2, f64, 2);
lanes_equal_scalars!(f64x4, F64x4, f64, 4);
lanes_equal_scalars!(f64x8, F64x8, f64, 8);
lanes_equal_scalars!(f32x4, F32x4, f32, 4);
lanes_equal_scalars!(f32x8, F32x8, f32, 8);
lanes_equal_scalars!(f32x16, F32x16, f32, 16);

#[inline(never)]
fn array_equals_scalars<const N: usize>(random: &mut Random) {
    for _ in 0..500 {
        let angles: [f64; N] = std::array::from_fn(|_| random.number());
        let singles = angles.map(|x| x as f32);
        let (s, c) = f64::sin_cos_all(angles);
        let (t, d) = f32::sin_cos_all(singles);
        for i in 0..N {
            let (sine, cosine) = sin_cos(angles[i]);
            assert!(same(s[i], sine) && same(c[i], cosine), "{} of {N}: {}", i, angles[i]);
            let (sine, cosine) = sin_cos(singles[i]);
            assert!(same(t[i].into(), sine.into()) && same(d[i].into(), cosine.into()), "{}", singles[i]);
        }
    }
}

#[test]
fn arrays_of_any_length() {
    let mut random = Random(3);
    macro_rules! lengths {
        ($($n:literal)*) => { $(array_equals_scalars::<$n>(&mut random);)* };
    }
    // Around every number of lanes, and sums of two of them.
    lengths!(0 1 2 3 4 5 7 8 9 12 15 16 17 31 45);
}

#[test]
fn fused_rounds_as_the_target_says() {
    let mut random = Random(5);
    let mut differences = 0;
    for _ in 0..10_000 {
        let (a, b, c) = (random.unit(), random.unit(), random.unit());
        let expected = if FUSED { a.mul_add(b, c) } else { a * b + c };
        assert_eq!(f64::fused(a, b, c).to_bits(), expected.to_bits());
        differences += usize::from(a.mul_add(b, c) != a * b + c);
        let (a, b, c) = (a as f32, b as f32, c as f32);
        let expected = if FUSED { a.mul_add(b, c) } else { a * b + c };
        assert_eq!(f32::fused(a, b, c).to_bits(), expected.to_bits());
        assert_eq!(Real::sqrt(a * a).to_bits(), (a * a).sqrt().to_bits());
    }
    assert!(differences > 1000, "the sample tells the two apart");
}

#[test]
fn native_lanes_know_their_number() {
    assert_eq!(F64Native::constant(1.0).to_array(), [1.0; F64_NATIVE_LANES]);
    assert_eq!(F32Native::constant(1.0).to_array(), [1.0; F32_NATIVE_LANES]);
}
