//! Numbers of one lane that compute with fused multiply-adds though the target has none: for functions that are compiled for
//! processors that have them, see the module `dispatch`.
use super::x86::FusedF64x2;
use super::{Two, arrays};
use crate::Real;
use crate::math::kernel::{Element, Kernel, any};
use crate::math::{exponential, large, scalar};
use core::ops::{Add, Div, Mul, Neg, Sub};

macro_rules! operators {
    ($name:ident: $($trait:ident $method:ident)*) => {
        $(impl $trait for $name {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        })*

        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }
    };
}

macro_rules! fused {
    ($(#[$doc:meta])* $name:ident of $scalar:ident, two $two:ty: $fused:ident $sqrt:ident $sines:ident $exp:ident $tanh:ident $large:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, Default, PartialEq)]
        #[repr(transparent)]
        pub struct $name($scalar);

        operators!($name: Add add Sub sub Mul mul Div div);

        impl Real for $name {
            type Faster = Self;
            type Two = $two;
            const IS_FASTER: bool = true;
            #[inline(always)]
            fn constant(value: f64) -> Self {
                Self(value as $scalar)
            }
            #[inline(always)]
            fn fused(a: Self, b: Self, c: Self) -> Self {
                Self(scalar::$fused(a.0, b.0, c.0))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(scalar::$sqrt(self.0))
            }
            #[inline(always)]
            fn sin_cos_all<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
                arrays::$sines(angles)
            }
            #[inline(always)]
            fn exp(self) -> Self {
                Self(exponential::$exp(self.0))
            }
            #[inline(always)]
            fn tanh(self) -> Self {
                Self(exponential::$tanh(self.0))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(self.0.abs())
            }
            #[inline(always)]
            fn sign(self) -> Self {
                Self(Real::sign(self.0))
            }
            #[inline(always)]
            fn larger(self, other: Self) -> Self {
                Self(Real::larger(self.0, other.0))
            }
        }

        impl Kernel for $name {
            type Element = Self;
            #[inline(always)]
            fn within(self) -> bool {
                self.0.within()
            }
            #[inline(always)]
            fn rotate(turns: Self, sine: Self, cosine: Self) -> (Self, Self) {
                let (sine, cosine) = Kernel::rotate(turns.0, sine.0, cosine.0);
                (Self(sine), Self(cosine))
            }
            #[inline(always)]
            fn lane_by_lane(self) -> (Self, Self) {
                let (sine, cosine) = $large(self.0);
                (Self(sine), Self(cosine))
            }
        }

        impl Element for $name {
            const SHIFT: f64 = <$scalar as Element>::SHIFT;
            const PARTS: &'static [f64] = <$scalar as Element>::FUSED_PARTS;
            const FUSED_PARTS: &'static [f64] = <$scalar as Element>::FUSED_PARTS;
            const COEFFICIENTS: &'static [f64] = <$scalar as Element>::COEFFICIENTS;
            #[inline(always)]
            fn polynomials<V: Kernel>(y: V) -> (V, V) {
                <$scalar as Element>::polynomials(y)
            }
        }
    };
}

fused! {
    /// `f64` with fused multiply-adds, for functions that are compiled with them.
    FusedF64 of f64, two FusedF64x2: instruction_f64 sqrt_f64 all_fused_f64 fused_exp_f64 fused_tanh_f64 sin_cos_f64
}
fused! {
    /// `f32` with fused multiply-adds, for functions that are compiled with them.
    FusedF32 of f32, two super::Twice<Self>: instruction_f32 sqrt_f32 all_fused_f32 fused_exp_f32 fused_tanh_f32 sin_cos_f32
}

/// Two in one register.
impl Two<FusedF64> for FusedF64x2 {
    #[inline(always)]
    fn of(first: FusedF64, second: FusedF64) -> Self {
        Self::from_array([first, second])
    }
    #[inline(always)]
    fn first(self) -> FusedF64 {
        self.to_array()[0]
    }
    #[inline(always)]
    fn second(self) -> FusedF64 {
        self.to_array()[1]
    }
    #[inline(always)]
    fn fused(a: Self, b: Self, c: Self) -> Self {
        Real::fused(a, b, c)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Real::sqrt(self)
    }
    #[inline(always)]
    fn store(self, to: &mut [FusedF64; 2]) {
        *to = self.to_array();
    }
}

/// Any `f64` outside the common range.
fn sin_cos_f64(x: f64) -> (f64, f64) {
    large::sin_cos_by(x, |y: FusedF64| y.0)
}

/// Any `f32` outside the common range, by way of the longer number.
#[cold]
#[inline(never)]
fn sin_cos_f32(x: f32) -> (f32, f32) {
    let (sine, cosine) = any(FusedF64(f64::from(x)));
    (sine.0 as f32, cosine.0 as f32)
}
