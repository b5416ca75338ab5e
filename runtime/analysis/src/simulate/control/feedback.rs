//! What the second derivatives of the outputs shall be.

/// A feedback that makes an output `ÿ = v` vanish.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Feedback {
    /// `v = −stiffness y − damping ẏ`
    Linear {
        /// 1/s²
        stiffness: f64,
        /// 1/s
        damping: f64,
    },
    /// In finite time (Bhat and Bernstein, 1998; as Grizzle, Abba and Plestan use it, 2001):
    /// `v = ψ(y, ε ẏ)/ε²`, `ψ(x₁, x₂) = −sgn(x₂)|x₂|^α − sgn(φ)|φ|^(α/(2−α))`,
    /// `φ = x₁ + sgn(x₂)|x₂|^(2−α)/(2−α)`.
    FiniteTime {
        /// α, 0 < α < 1.
        exponent: f64,
        /// ε, s: smaller is faster.
        time_scale: f64,
    },
}

impl Default for Feedback {
    fn default() -> Self {
        Self::Linear { stiffness: 400.0, damping: 40.0 }
    }
}

/// `sgn(x)|x|^p`
fn signed_power(x: f64, p: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() * x.abs().powf(p) }
}

impl Feedback {
    /// v for an output and its rate.
    pub fn at(&self, y: f64, rate: f64) -> f64 {
        match *self {
            Self::Linear { stiffness, damping } => -stiffness * y - damping * rate,
            Self::FiniteTime { exponent, time_scale } => {
                let scaled = time_scale * rate;
                let rest = 2.0 - exponent;
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
}
