//! A number that carries its exact derivatives along eight directions: what [`super::Dual`] is of eight equal numbers, for half of the work.
use bipedc_runtime::Real;
use bipedc_runtime::lanes::F64x8;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Value and derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slopes(pub f64, pub F64x8);

/// In every lane.
fn all(value: f64) -> F64x8 {
    F64x8::constant(value)
}

impl Add for Slopes {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self(self.0 + b.0, self.1 + b.1)
    }
}
impl Sub for Slopes {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self(self.0 - b.0, self.1 - b.1)
    }
}
impl Mul for Slopes {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Self(self.0 * b.0, self.1 * all(b.0) + all(self.0) * b.1)
    }
}
impl Div for Slopes {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let quotient = self.0 / b.0;
        Self(quotient, (self.1 - all(quotient) * b.1) / all(b.0))
    }
}
impl Neg for Slopes {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Real for Slopes {
    type Faster = Self;
    type Two = bipedc_runtime::lanes::Twice<Self>;
    fn constant(value: f64) -> Self {
        Self(value, all(0.0))
    }
    fn fused(a: Self, b: Self, c: Self) -> Self {
        a * b + c
    }
    fn sqrt(self) -> Self {
        let root = Real::sqrt(self.0);
        Self(root, self.1 / all(root + root))
    }
    fn exp(self) -> Self {
        let exp = Real::exp(self.0);
        Self(exp, self.1 * all(exp))
    }
    fn tanh(self) -> Self {
        let tanh = Real::tanh(self.0);
        Self(tanh, self.1 * all(1.0 - tanh * tanh))
    }
    fn abs(self) -> Self {
        Self(Real::abs(self.0), self.1 * all(Real::sign(self.0)))
    }
    fn sign(self) -> Self {
        Self(Real::sign(self.0), all(0.0))
    }
    fn larger(self, other: Self) -> Self {
        // Half of each where both are equal.
        let first = (1.0 + Real::sign(self.0 - other.0)) * 0.5;
        Self(Real::larger(self.0, other.0), other.1 + all(first) * (self.1 - other.1))
    }
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
        let pairs = angles.map(|x| {
            let ([s], [c]) = f64::sin_cos_all([x.0]);
            (Self(s, x.1 * all(c)), Self(c, -(x.1 * all(s))))
        });
        (pairs.map(|p| p.0), pairs.map(|p| p.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::Dual;

    /// Everything a program does, of two numbers with slopes.
    fn everything<R: Real>(a: R, b: R) -> Vec<R> {
        let ([s], [c]) = R::sin_cos_all([a * b]);
        let calls = [a.exp(), a.tanh(), a.abs(), (-a).abs(), a.sign(), b.sqrt(), a.larger(b), b.larger(a)];
        let sums = [a + b, a - b, a * b, a / b, -a, R::fused(a, b, s), s, c, a.larger(a)];
        calls.into_iter().chain(sums).collect()
    }

    #[test]
    fn every_operation_gives_the_bits_of_eight_equal_numbers() {
        let slopes =
            [[0.3, -1.0, 0.0, 2.5, 1e-3, 7.0, -0.25, 1.0], [1.0, 0.5, -3.0, 0.0, 9.0, 1e3, 0.1, -2.0]];
        for values in [[0.7, 1.3], [-2.1, 0.4], [1.5, 1.5], [-1e-3, 60.0]] {
            let [a, b] = [0, 1].map(|k| Slopes(values[k], F64x8::from_array(slopes[k])));
            let [c, d] =
                [0, 1].map(|k| Dual(F64x8::from_array([values[k]; 8]), F64x8::from_array(slopes[k])));
            for (index, (one, other)) in everything(a, b).iter().zip(everything(c, d)).enumerate() {
                let bits = |of: F64x8| of.to_array().map(f64::to_bits);
                assert_eq!(bits(all(one.0)), bits(other.0), "{index} of {values:?}");
                assert_eq!(bits(one.1), bits(other.1), "{index} of {values:?}");
            }
        }
    }
}
