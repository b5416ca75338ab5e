//! Numbers with one exact derivative.
use bipedc_runtime::Real;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Value and derivative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual(pub f64, pub f64);

impl Add for Dual {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self(self.0 + b.0, self.1 + b.1)
    }
}
impl Sub for Dual {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self(self.0 - b.0, self.1 - b.1)
    }
}
impl Mul for Dual {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Self(self.0 * b.0, self.1 * b.0 + self.0 * b.1)
    }
}
impl Div for Dual {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let quotient = self.0 / b.0;
        Self(quotient, (self.1 - quotient * b.1) / b.0)
    }
}
impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Real for Dual {
    fn constant(value: f64) -> Self {
        Self(value, 0.0)
    }
    fn fused(a: Self, b: Self, c: Self) -> Self {
        a * b + c
    }
    fn sqrt(self) -> Self {
        let root = self.0.sqrt();
        Self(root, 0.5 * self.1 / root)
    }
    fn exp(self) -> Self {
        Self(self.0.exp(), self.1 * self.0.exp())
    }
    fn tanh(self) -> Self {
        let tanh = self.0.tanh();
        Self(tanh, self.1 * (1.0 - tanh * tanh))
    }
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1 * self.0.sign())
    }
    fn sign(self) -> Self {
        Self(self.0.sign(), 0.0)
    }
    fn larger(self, other: Self) -> Self {
        if self.0 > other.0 { self } else { other }
    }
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
        (angles.map(|x| Self(x.0.sin(), x.1 * x.0.cos())), angles.map(|x| Self(x.0.cos(), -x.1 * x.0.sin())))
    }
}
