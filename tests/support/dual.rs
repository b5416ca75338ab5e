//! Numbers that carry their exact derivative; nested, they carry second and third ones.
use bipedc_runtime::Real;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Value and derivative along one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<T>(pub T, pub T);

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
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
        let pairs = angles.map(|x| {
            let ([s], [c]) = T::sin_cos_all([x.0]);
            (Self(s, x.1 * c), Self(c, -(x.1 * s)))
        });
        (pairs.map(|p| p.0), pairs.map(|p| p.1))
    }
}
