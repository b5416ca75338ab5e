//! The scalar that generated code computes with.
use crate::lanes::Two;
use core::fmt::Debug;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// `f64`, `f32` or a lane type of [`crate::lanes`] holding several states.
///
/// The other signs of a fused operation are those with negated arguments: `fused(-a, b, c)` is `c - a * b` in
/// one instruction.
pub trait Real:
    Copy
    + Debug
    + PartialEq
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// What generated functions compute with where the processor has more than the target, see the module `dispatch`; the type
    /// itself where there is no such number.
    type Faster: Real;
    /// Two of them side by side, see [`crate::lanes::two`].
    type Two: Two<Self>;
    /// Whether this is the faster one of two types.
    const IS_FASTER: bool = false;
    /// The constant in every lane.
    fn constant(value: f64) -> Self;
    /// `a * b + c`: one rounding where the target has fused multiply-add, two elsewhere.
    fn fused(a: Self, b: Self, c: Self) -> Self;
    /// Square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// Sine and cosine of `N` angles (rad), computed together so that they share vector instructions.
    ///
    /// The same bits as [`crate::math::sin_cos`] of each.
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]);
    /// `e^x`: 0 or infinity where it is out of range.
    fn exp(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// 1, -1, or 0 of zero.
    fn sign(self) -> Self;
    /// The larger of the two.
    fn larger(self, other: Self) -> Self;
}

/// One number, which can be compared: `f64` or `f32`. What decides needs it; what only computes takes any [`Real`].
pub trait Scalar: Real + PartialOrd {
    /// Distance from 1 to the next larger number.
    const EPSILON: f64;
    /// Natural logarithm: −∞ of 0, NaN of negative numbers.
    fn ln(self) -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;
}
