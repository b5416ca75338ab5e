//! Two numbers of one state that compute side by side: what generated code does for one leg and for the other at once.

use crate::Real;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// Two numbers that compute as one: each has the bits that it has alone.
pub trait Two<R: Real>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Of one number for each.
    fn of(first: R, second: R) -> Self;
    /// The first number.
    fn first(self) -> R;
    /// The second number.
    fn second(self) -> R;
    /// [`Real::fused`] of each.
    fn fused(a: Self, b: Self, c: Self) -> Self;
    /// [`Real::sqrt`] of each.
    fn sqrt(self) -> Self;
    /// Both, one behind the other: one instruction where one register holds them.
    #[inline(always)]
    fn store(self, to: &mut [R; 2]) {
        *to = [self.first(), self.second()];
    }
    /// The second number first.
    #[inline(always)]
    fn swapped(self) -> Self {
        Self::of(self.second(), self.first())
    }
}

/// One number for each of two.
#[inline(always)]
pub fn two<R: Real>(first: R, second: R) -> R::Two {
    <R::Two as Two<R>>::of(first, second)
}

/// The same number for both.
#[inline(always)]
pub fn both<R: Real>(x: R) -> R::Two {
    two(x, x)
}

/// Two elements of a result, of which `at` is the first, counted from column to column: one instruction where one register holds them.
#[inline(always)]
pub fn store<R: Real, const ROWS: usize, const COLUMNS: usize>(
    out: &mut [[R; ROWS]; COLUMNS],
    at: usize,
    values: R::Two,
) {
    if let Some(to) = out.as_flattened_mut().get_mut(at..).and_then(|rest| rest.first_chunk_mut()) {
        values.store(to);
    }
}

/// Where no register holds two: one after the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twice<R>(R, R);

macro_rules! operator {
    ($trait:ident $method:ident) => {
        impl<R: Real> $trait for Twice<R> {
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

impl<R: Real> Neg for Twice<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl<R: Real> Two<R> for Twice<R> {
    #[inline(always)]
    fn of(first: R, second: R) -> Self {
        Self(first, second)
    }
    #[inline(always)]
    fn first(self) -> R {
        self.0
    }
    #[inline(always)]
    fn second(self) -> R {
        self.1
    }
    #[inline(always)]
    fn fused(a: Self, b: Self, c: Self) -> Self {
        Self(R::fused(a.0, b.0, c.0), R::fused(a.1, b.1, c.1))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }
}

/// Two `f64` in a register of the target.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
impl Two<f64> for super::F64x2 {
    #[inline(always)]
    fn of(first: f64, second: f64) -> Self {
        Self::from_array([first, second])
    }
    #[inline(always)]
    fn first(self) -> f64 {
        self.to_array()[0]
    }
    #[inline(always)]
    fn second(self) -> f64 {
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
    fn store(self, to: &mut [f64; 2]) {
        *to = self.to_array();
    }
}

/// What two `f64` are, side by side.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub type TwoF64 = super::F64x2;
/// What two `f64` are, side by side.
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub type TwoF64 = Twice<f64>;
