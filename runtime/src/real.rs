//! The scalar that generated code computes with.
use core::fmt::Debug;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// `f64`, `f32` or a lane type holding several states.
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
    /// The constant in every lane.
    fn constant(value: f64) -> Self;
    /// `a * b + c`: one rounding where the target has fused multiply-add, two elsewhere.
    fn fused(a: Self, b: Self, c: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine and cosine of `N` angles (rad), computed together so that they share vector instructions.
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]);
}

impl Real for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn fused(a: Self, b: Self, c: Self) -> Self {
        a * b + c
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        nalgebra::ComplexField::sqrt(self)
    }
    #[inline(always)]
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
        (angles.map(nalgebra::ComplexField::sin), angles.map(nalgebra::ComplexField::cos))
    }
}
