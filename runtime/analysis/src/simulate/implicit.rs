//! Springs and dampers within a step: stable however stiff they are.
//!
//! Over a step of length h the torque of a spring that is stretched by δ is held at
//!
//! ```text
//! F = k (δ_M + a h γ⁺ − b h γ⁻) + d (c γ⁺ + (1 − c) γ⁻),   δ_M = δ + ½ h γ⁻
//! ```
//!
//! with `a = b = ¼`, `c = ½` the means over the step (trapezoidal rule, second order, no energy is lost), and `a = c = 1`, `b = 0` the
//! torque to which a stiff spring or damper has come at the end: eigenvalues of the step are then zero in the limit, so
//! that nothing rings from step to step. A part β of the latter is taken, `β = x/(x + 10)` with
//! `x = h² k G + (h d G)²` and G the velocity per impulse: it vanishes with h², so that the rule stays of second order. Every β is
//! stable for all k and d.

/// Where half of the stiff rule is taken: at a spring that turns by √10 rad per step.
const HALFWAY: f64 = 10.0;

/// What multiplies stretch, velocity after and velocity before in the held torque of a spring with a damper.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ImplicitSpring {
    /// k, N m/rad; infinite: rigid.
    stiffness: f64,
    /// Factor of γ⁺, N m s/rad.
    next: f64,
    /// Factor of γ⁻, N m s/rad.
    last: f64,
    /// h
    time: f64,
}

/// The same as a relaxed constraint: `γ⁺ + softness Λ + offset = 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Relaxed {
    /// Velocity per impulse.
    pub softness: f64,
    /// Velocity.
    pub offset: f64,
}

impl ImplicitSpring {
    /// `mobility`: velocity per impulse of what the spring holds, about.
    pub fn new(stiffness: f64, damping: f64, mobility: f64, time: f64) -> Self {
        let (turn, fade) = (time * time * stiffness * mobility, time * damping * mobility);
        let x = turn + fade * fade;
        let part = if x.is_finite() { x / (x + HALFWAY) } else { 1.0 };
        let (a, b, c) = (0.25 + 0.75 * part, 0.25 * (1.0 - part), 0.5 * (1.0 + part));
        let last = if b == 0.0 { 0.0 } else { -stiffness * b * time };
        Self { stiffness, next: stiffness * a * time + damping * c, last: last + damping * (1.0 - c), time }
    }

    /// Change of impulse per change of velocity, to be added to inertia.
    pub fn inertia(&self) -> f64 {
        self.time * self.next
    }

    /// Impulse against a stretch and its velocity if that did not change over the step.
    pub fn impulse(&self, stretch: f64, velocity: f64) -> f64 {
        self.time * (self.stiffness * stretch + (self.next + self.last) * velocity)
    }

    /// ImplicitSpring torque against the stretch.
    pub fn torque(&self, stretch: f64, [last, next]: [f64; 2]) -> f64 {
        self.stiffness * stretch + self.next * next + self.last * last
    }

    /// As a row of the contact problem, for springs that only push or are limited. `None`: neither spring nor damper.
    pub fn relaxed(&self, stretch: f64, velocity: f64) -> Option<Relaxed> {
        if self.stiffness.is_infinite() {
            return Some(Relaxed { softness: 0.0, offset: stretch / self.time });
        }
        (self.next > 0.0).then(|| Relaxed {
            softness: 1.0 / (self.time * self.next),
            offset: (self.stiffness * stretch + self.last * velocity) / self.next,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest eigenvalue of a step of a unit mass on a spring.
    fn growth(stiffness: f64, damping: f64, time: f64) -> f64 {
        let held = ImplicitSpring::new(stiffness, damping, 1.0, time);
        let step = |stretch: f64, velocity: f64| {
            let middle = stretch + 0.5 * time * velocity;
            let next = velocity - held.impulse(middle, velocity) / (1.0 + held.inertia());
            [middle + 0.5 * time * next, next]
        };
        let ([a, c], [b, d]) = (step(1.0, 0.0), step(0.0, 1.0));
        let (half, product) = (0.5 * (a + d), a * d - b * c);
        let root = half * half - product;
        if root < 0.0 { product.sqrt() } else { half.abs() + root.sqrt() }
    }

    #[test]
    fn stable_for_any_spring_and_damper() {
        for k in -12..=14 {
            for d in -12..=14 {
                let found = growth(10f64.powi(k), 10f64.powi(d), 1e-3);
                // A double eigenvalue is known to the root of the rounding only.
                assert!(found <= 1.0 + 1e-7, "1e{k} N m/rad, 1e{d} N m s/rad: {found}");
            }
        }
        assert!(growth(1e12, 0.0, 1e-3) < 1e-2, "stiff springs do not ring");
    }

    #[test]
    fn soft_springs_lose_nothing() {
        // 100 rad/s at 1 kHz: the amplitude falls by a factor e within 100 s.
        let found = growth(1e4, 0.0, 1e-3);
        assert!((1.0 - found).abs() < 1e-5, "{found}");
    }
}
