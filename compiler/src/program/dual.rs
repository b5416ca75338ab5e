//! Numbers that carry their exact derivative; nested, they carry second and third ones. Programs run on them as on
//! any scalar: what the symbolic derivatives are checked with.
use bipedc_runtime::Real;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Value and derivative along one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<T = f64>(pub T, pub T);

impl<T: Real> Add for Dual<T> {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self(self.0 + b.0, self.1 + b.1)
    }
}
impl<T: Real> Sub for Dual<T> {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self(self.0 - b.0, self.1 - b.1)
    }
}
impl<T: Real> Mul for Dual<T> {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Self(self.0 * b.0, self.1 * b.0 + self.0 * b.1)
    }
}
impl<T: Real> Div for Dual<T> {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let quotient = self.0 / b.0;
        Self(quotient, (self.1 - quotient * b.1) / b.0)
    }
}
impl<T: Real> Neg for Dual<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl<T: Real> Real for Dual<T> {
    type Faster = Self;
    type Two = bipedc_runtime::lanes::Twice<Self>;
    fn constant(value: f64) -> Self {
        Self(T::constant(value), T::constant(0.0))
    }
    fn fused(a: Self, b: Self, c: Self) -> Self {
        a * b + c
    }
    fn sqrt(self) -> Self {
        let root = self.0.sqrt();
        Self(root, self.1 / (root + root))
    }
    fn exp(self) -> Self {
        let exp = self.0.exp();
        Self(exp, self.1 * exp)
    }
    fn tanh(self) -> Self {
        let tanh = self.0.tanh();
        Self(tanh, self.1 * (T::constant(1.0) - tanh * tanh))
    }
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1 * self.0.sign())
    }
    fn sign(self) -> Self {
        Self(self.0.sign(), T::constant(0.0))
    }
    fn larger(self, other: Self) -> Self {
        // Half of each where both are equal.
        let first = (T::constant(1.0) + (self.0 - other.0).sign()) * T::constant(0.5);
        Self(self.0.larger(other.0), other.1 + first * (self.1 - other.1))
    }
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
        let pairs = angles.map(|x| {
            let ([s], [c]) = T::sin_cos_all([x.0]);
            (Self(s, x.1 * c), Self(c, -(x.1 * s)))
        });
        (pairs.map(|p| p.0), pairs.map(|p| p.1))
    }
}
