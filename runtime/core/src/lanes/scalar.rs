//! `f64` and `f32`: numbers of one lane.
use super::arrays;
use crate::Real;
use crate::math::{exponential, scalar};

impl Real for f64 {
    type Faster = super::FusedF64;
    type Two = super::TwoF64;
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn fused(a: Self, b: Self, c: Self) -> Self {
        scalar::fused_f64(a, b, c)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        scalar::sqrt_f64(self)
    }
    #[inline(always)]
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
        arrays::all_f64(angles)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        exponential::exp_f64(self)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        exponential::tanh_f64(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self::from(i8::from(self > 0.0) - i8::from(self < 0.0))
    }
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

impl Real for f32 {
    type Faster = super::FusedF32;
    type Two = super::Twice<Self>;
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn fused(a: Self, b: Self, c: Self) -> Self {
        scalar::fused_f32(a, b, c)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        scalar::sqrt_f32(self)
    }
    #[inline(always)]
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
        arrays::all_f32(angles)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        exponential::exp_f32(self)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        exponential::tanh_f32(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self::from(i8::from(self > 0.0) - i8::from(self < 0.0))
    }
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}
