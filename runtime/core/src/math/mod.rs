//! Sine and cosine, exponential and hyperbolic tangent, fused multiply-add and square root, the same in
//! scalars, arrays and lanes.
//!
//! `core` has none of them. Results depend on the target features the crate is compiled for (one rounding
//! or two in `a * b + c`; in generated functions with the feature `dispatch` on those of the processor) and on nothing else: not on the feature `std`, on the number of angles given
//! together, nor on the lane that holds a value.

pub(crate) mod exponential;
pub(crate) mod kernel;
pub(crate) mod large;
mod logarithm;
pub(crate) mod scalar;

use crate::Real;

/// Whether [`Real::fused`] rounds once: the target has a fused multiply-add instruction.
pub const FUSED: bool =
    cfg!(any(all(target_arch = "x86_64", target_feature = "fma"), target_arch = "aarch64"));

/// Arguments up to this magnitude (rad) take the branch-free path in `f64`.
pub const COMMON_RANGE_F64: f64 = 1_048_576.0;

/// Arguments up to this magnitude (rad) take the branch-free path in `f32`.
pub const COMMON_RANGE_F32: f32 = 1024.0;

/// Bound on the error of sine and cosine in `f64`, in units of 2⁻⁵³, over all finite arguments.
///
/// Tested in `tests/numbers/sin_cos.rs`: largest error seen 1.10 where [`FUSED`], 1.25 elsewhere.
pub const ERROR_BOUND_F64: f64 = 1.5;

/// Bound on the error of sine and cosine in `f32`, in units of 2⁻²⁴, over all finite arguments.
///
/// Largest error over every argument of the common range: 1.21 where [`FUSED`], 1.47 elsewhere.
pub const ERROR_BOUND_F32: f64 = 1.5;

/// Bound on the same errors relative to the result, in its units in the last place.
///
/// Values near zero (arguments near multiples of π/2) keep their relative accuracy too.
pub const ERROR_BOUND_ULP: f64 = if FUSED { 2.0 } else { 2.5 };

/// Bound on the error of [`Real::exp`] and [`Real::tanh`], in units in the last place of the result (of the
/// smallest normal number below it).
///
/// Tested in `tests/numbers/exponential.rs`.
pub const ERROR_BOUND_EXPONENTIAL_ULP: f64 = 3.0;

/// Sine and cosine of an angle (rad).
///
/// The error stays below [`ERROR_BOUND_F64`] and [`ERROR_BOUND_F32`]; infinity and NaN give NaN. The sine of
/// -0 is +0. For several angles at once [`Real::sin_cos_all`] is faster and gives the same bits.
#[inline]
pub fn sin_cos<R: Real>(x: R) -> (R, R) {
    let ([sine], [cosine]) = R::sin_cos_all([x]);
    (sine, cosine)
}
