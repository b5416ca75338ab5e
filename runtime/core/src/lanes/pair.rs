//! Lanes twice as wide as the registers of the target.

use core::ops::{Add, Div, Mul, Neg, Sub};

use super::arrays;
use crate::Real;
use crate::math::kernel::{Kernel, any};

/// Two values that compute side by side; itself a lane type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair<V>(V, V);

macro_rules! operator {
    ($trait:ident $method:ident) => {
        impl<V: $trait<Output = V>> $trait for Pair<V> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0), self.1.$method(other.1))
            }
        }
    };
}

operator!(Add add);
operator!(Sub sub);
operator!(Mul mul);
operator!(Div div);

impl<V: Neg<Output = V>> Neg for Pair<V> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

#[allow(private_bounds)]
impl<V: Kernel> Real for Pair<V> {
    type Faster = Self;
    type Two = super::Twice<Self>;
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self(V::constant(value), V::constant(value))
    }
    #[inline(always)]
    fn fused(a: Self, b: Self, c: Self) -> Self {
        Self(V::fused(a.0, b.0, c.0), V::fused(a.1, b.1, c.1))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }
    #[inline(always)]
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
        arrays::each(angles)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        Self(self.0.exp(), self.1.exp())
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        Self(self.0.tanh(), self.1.tanh())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self(self.0.sign(), self.1.sign())
    }
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(self.0.larger(other.0), self.1.larger(other.1))
    }
}

impl<V: Kernel> Kernel for Pair<V> {
    type Element = V::Element;
    #[inline(always)]
    fn within(self) -> bool {
        self.0.within() & self.1.within()
    }
    #[inline(always)]
    fn rotate(turns: Self, sine: Self, cosine: Self) -> (Self, Self) {
        let low = V::rotate(turns.0, sine.0, cosine.0);
        let high = V::rotate(turns.1, sine.1, cosine.1);
        (Self(low.0, high.0), Self(low.1, high.1))
    }
    #[inline(always)]
    fn lane_by_lane(self) -> (Self, Self) {
        let (low, high) = (any(self.0), any(self.1));
        (Self(low.0, high.0), Self(low.1, high.1))
    }
}

/// Conversions of a pair with so many lanes in each half.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx512f")))]
macro_rules! lanes {
    ($half:ty, $scalar:ident $count:literal: $($low:ident)*; $($high:ident)*) => {
        impl Pair<$half> {
            /// The lanes in order.
            #[inline(always)]
            pub fn from_array([$($low,)* $($high,)*]: [$scalar; $count]) -> Self {
                Self(<$half>::from_array([$($low),*]), <$half>::from_array([$($high),*]))
            }
            /// The lanes in order.
            #[inline(always)]
            pub fn to_array(self) -> [$scalar; $count] {
                let ([$($low),*], [$($high),*]) = (self.0.to_array(), self.1.to_array());
                [$($low,)* $($high,)*]
            }
        }
    };
}

/// Conversions of a pair of scalars.
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
macro_rules! scalar_lanes {
    ($scalar:ident) => {
        impl Pair<$scalar> {
            /// The lanes in order.
            #[inline(always)]
            pub fn from_array([low, high]: [$scalar; 2]) -> Self {
                Self(low, high)
            }
            /// The lanes in order.
            #[inline(always)]
            pub fn to_array(self) -> [$scalar; 2] {
                [self.0, self.1]
            }
        }
    };
}

#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
scalar_lanes!(f64);
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
scalar_lanes!(f32);
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
lanes!(Pair<f32>, f32 4: a b; c d);

#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
lanes!(super::F64x2, f64 4: a b; c d);
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
lanes!(super::F32x4, f32 8: a b c d; e f g h);
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx512f")))]
lanes!(super::F64x4, f64 8: a b c d; e f g h);
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx512f")))]
lanes!(super::F32x8, f32 16: a b c d e f g h; i j k l m n o p);
