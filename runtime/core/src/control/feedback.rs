//! What the second derivatives of outputs shall be.
use crate::real::{Real, Scalar};

/// A feedback that makes an output `ÿ = v` vanish.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Feedback<T> {
    /// `v = −stiffness y − damping ẏ` (6.4)
    Linear {
        /// K_p, 1/s²
        stiffness: T,
        /// K_d, 1/s
        damping: T,
    },
    /// In finite time (Bhat and Bernstein, 1998; as Grizzle, Abba and Plestan use it, 2001):
    /// `v = ψ(y, ε ẏ)/ε²`, `ψ(x₁, x₂) = −sgn(x₂)|x₂|^α − sgn(φ)|φ|^(α/(2−α))`,
    /// `φ = x₁ + sgn(x₂)|x₂|^(2−α)/(2−α)`.
    FiniteTime {
        /// α, 0 < α < 1.
        exponent: T,
        /// ε, s: smaller is faster.
        time_scale: T,
    },
}

impl<T: Real> Default for Feedback<T> {
    fn default() -> Self {
        Self::Linear { stiffness: T::constant(400.0), damping: T::constant(40.0) }
    }
}

/// `sgn(x)|x|^p`
fn signed_power<T: Scalar>(x: T, p: T) -> T {
    let zero = T::constant(0.0);
    if x == zero { zero } else { x.sign() * (p * x.abs().ln()).exp() }
}

impl<T: Scalar> Feedback<T> {
    /// v for an output and its rate.
    pub fn at(&self, y: T, rate: T) -> T {
        match *self {
            Self::Linear { stiffness, damping } => -stiffness * y - damping * rate,
            Self::FiniteTime { exponent, time_scale } => {
                let scaled = time_scale * rate;
                let rest = T::constant(2.0) - exponent;
                let phi = y + signed_power(scaled, rest) / rest;
                let psi = -signed_power(scaled, exponent) - signed_power(phi, exponent / rest);
                psi / (time_scale * time_scale)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finite_time_means_finite_time() {
        // Steps of 10 µs from y = 0.3, ẏ = −1.
        let law = Feedback::FiniteTime { exponent: 0.9, time_scale: 0.1 };
        let (mut y, mut rate, h) = (0.3, -1.0, 1e-5);
        let mut at_rest = None;
        for step in 0..400_000 {
            rate += h * law.at(y, rate);
            y += h * rate;
            if y.abs() < 1e-7 && rate.abs() < 1e-6 {
                at_rest.get_or_insert(f64::from(step) * h);
            } else if at_rest.is_some() {
                assert!(y.abs() < 1e-5, "it leaves again: {y}");
            }
        }
        let at_rest = at_rest.unwrap();
        assert!(at_rest > 0.1 && at_rest < 2.5, "{at_rest}");
    }

    #[test]
    fn both_laws_push_back() {
        for law in [Feedback::default(), Feedback::FiniteTime { exponent: 0.9, time_scale: 0.1 }] {
            assert!(law.at(0.1, 0.0) < 0.0 && law.at(0.0, 0.1) < 0.0 && law.at(-0.1, -0.1) > 0.0);
            assert_eq!(law.at(0.0, 0.0), 0.0);
        }
    }

    #[test]
    fn single_precision_follows_double() {
        let law = Feedback::FiniteTime { exponent: 0.9, time_scale: 0.1 };
        let short = Feedback::FiniteTime { exponent: 0.9f32, time_scale: 0.1 };
        for (y, rate) in [(0.3, -1.0), (-1e-3, 0.02), (0.0, 0.5), (1e-7, -1e-7)] {
            let (long, short) = (law.at(y, rate), f64::from(short.at(y as f32, rate as f32)));
            assert!((long - short).abs() < 2e-5 * long.abs() + 1e-6, "{long} {short}");
        }
    }
}
