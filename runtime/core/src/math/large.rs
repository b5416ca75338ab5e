//! Sine and cosine beyond the common range: reduction with as much of 2/π as the argument needs
//! (Payne and Hanek, Radian reduction for trigonometric functions, 1983), in integers.

use super::kernel::{Element, Kernel, any};

/// 2/π in binary after one word of zeros, so that the window below never starts before the table.
const TWO_OVER_PI: [u64; 20] = [
    0,
    0xa2f9_836e_4e44_1529,
    0xfc27_57d1_f534_ddc0,
    0xdb62_9599_3c43_9041,
    0xfe51_63ab_debb_c561,
    0xb724_6e3a_424d_d2e0,
    0x0649_2eea_09d1_921c,
    0xfe1d_eb1c_b129_a73e,
    0xe882_35f5_2ebb_4484,
    0xe99c_7026_b45f_7e41,
    0x3991_d639_8353_39f4,
    0x9c84_5f8b_bdf9_283b,
    0x1ff8_97ff_de05_980f,
    0xef2f_118b_5a0a_6d1f,
    0x6d36_7ecf_27cb_09b7,
    0x4f46_3f66_9e5f_ea2d,
    0x7527_bac7_ebe5_f17b,
    0x3d07_39f7_8a52_92ea,
    0x6bfb_5fb1_1f8d_5d08,
    0x5603_3046_fc7b_6bab,
];

/// π/2 · 2⁶³.
const HALF_PI: u64 = 0xc90f_daa2_2168_c235;

/// 64 bits of the table from this bit on.
fn word(bit: u32) -> u64 {
    let at = |index: u32| TWO_OVER_PI.get(index as usize).copied().unwrap_or(0);
    let (index, shift) = (bit / 64, bit % 64);
    // Two steps on the right, because a shift by 64 is not allowed.
    (at(index) << shift) | (at(index.wrapping_add(1)) >> 1 >> (63 - shift))
}

/// The quadrant and the remainder in [-π/4, π/4] of a finite positive number of at least 2²⁰.
fn reduce(x: f64) -> (u64, f64) {
    let bits = x.to_bits();
    let mantissa = u128::from((bits & ((1 << 52) - 1)) | (1 << 52));
    // x = mantissa · 2^(exponent - 1075); bits of 2/π that only add multiples of 4 quadrants are left out,
    // which puts the first one used at exponent - 1075 - 2, plus 64 for the zeros in front.
    let start = ((bits >> 52) as u32).saturating_sub(1075 + 2 - 64);
    let low = mantissa * u128::from(word(start + 128));
    let middle = mantissa * u128::from(word(start + 64)) + (low >> 64);
    let high = mantissa * u128::from(word(start)) + (middle >> 64);
    // Now x · 2/π mod 4 in units of 2^-126.
    let turns = (high << 64) | (middle & u128::from(u64::MAX));
    let quadrant = (turns >> 126).wrapping_add((turns >> 125) & 1) as u64;
    let fraction = ((turns << 2) | ((low & u128::from(u64::MAX)) >> 62)) as i128;
    let magnitude = fraction.unsigned_abs();
    // No double is this close to a multiple of π/2; the shift below must still be in range.
    let zeros = magnitude.leading_zeros().min(127);
    let leading = ((magnitude << zeros) >> 64) as u64;
    let product = ((u128::from(leading) * u128::from(HALF_PI)) >> 64) as u64;
    let scale = f64::from_bits(u64::from(1023 - 63 - zeros) << 52);
    let remainder = product as f64 * scale;
    (quadrant, if fraction < 0 { -remainder } else { remainder })
}

/// Any `f64` outside the common range, not finite ones included.
#[cold]
#[inline(never)]
pub(super) fn sin_cos_f64(x: f64) -> (f64, f64) {
    if !x.is_finite() {
        return (f64::NAN, f64::NAN);
    }
    let (quadrant, y) = signed(x);
    let (sine, cosine) = f64::polynomials(y);
    f64::rotate(f64::from_bits(quadrant), sine, cosine)
}

/// The quadrant and the remainder of a finite number.
fn signed(x: f64) -> (u64, f64) {
    let (quadrant, y) = reduce(x.abs());
    if x < 0.0 { (quadrant.wrapping_neg(), -y) } else { (quadrant, y) }
}

/// Any `f32` outside the common range, not finite ones included.
#[cold]
#[inline(never)]
pub(super) fn sin_cos_f32(x: f32) -> (f32, f32) {
    let (sine, cosine) = any(f64::from(x));
    (sine as f32, cosine as f32)
}

/// The same by way of another number of the same size.
#[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
#[cold]
#[inline(never)]
pub(crate) fn sin_cos_by<V: Kernel>(x: f64, number: impl Fn(V) -> f64) -> (f64, f64) {
    if !x.is_finite() {
        return (f64::NAN, f64::NAN);
    }
    let (quadrant, y) = signed(x);
    let (sine, cosine) = f64::polynomials(V::constant(y));
    f64::rotate(f64::from_bits(quadrant), number(sine), number(cosine))
}
