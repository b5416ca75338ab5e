//! What a walk lacks of what was wished, and what the next search is asked for instead.
use super::closed_loop::ClosedLoop;
use super::optimised_text::fixed;
use crate::gait::optimise::{Demands, Optimum, size, slides};
use bipedc_compiler::compile::Collocation;

/// What a walk lacks of what was wished, as parts of it; 0: nothing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lack {
    pub walks: bool,
    missing: Vec<(String, f64)>,
}

/// Part of what is wished that may be missing.
const ENOUGH: f64 = 0.01;

impl Lack {
    /// Of a motion that was not found.
    pub fn everything() -> Self {
        Self { walks: false, missing: vec![("a motion".to_owned(), f64::INFINITY)] }
    }

    pub fn of((wished, largest): (&Demands, f64), tried: &ClosedLoop) -> Self {
        let mut found = Self { walks: tried.walks, missing: Vec::new() };
        if !tried.walks {
            found.missing.push(("a walk".to_owned(), f64::INFINITY));
        }
        if let Some(speed) = tried.walking_speed {
            // Half as much may be missing of the speed.
            let off = 2.0 * (speed / wished.speed - 1.0).abs();
            found.add("the walking speed", speed, wished.speed, off);
        }
        if let Some(multiplier) = tried.multiplier {
            found.add("the multiplier", multiplier, largest, multiplier.abs() / largest - 1.0);
        }
        let Some(margins) = &tried.margins else { return found };
        let friction = margins.friction.max(margins.impact_friction.unwrap_or(0.0));
        found.add("friction", friction, wished.friction, friction / wished.friction - 1.0);
        let least = [
            ("the impulse of an impact", margins.impulse, wished.impulse),
            ("the centre of pressure", margins.zmp, wished.zmp),
            ("clearance", margins.clearance, wished.clearance),
            ("torque", margins.torque.map(|torque| torque.min(1e-3)), 1e-3),
        ];
        for (name, value, wished) in least {
            if let Some(value) = value {
                found.add(name, value, wished, if wished > 0.0 { 1.0 - value / wished } else { 0.0 });
            }
        }
        if let Some(joint) = margins.joint.filter(|_| wished.joint > 0.0) {
            // A twentieth may be missing.
            let part = 0.2 * (1.0 - joint / wished.joint);
            found.add("distance of a joint from its stop", joint, wished.joint, part);
        }
        if let Some(velocity) = margins.velocity {
            // At its limit a joint may be: rad/s (m/s) beyond it are what is missing.
            found.add("velocity below its limit by", velocity, 0.0, -velocity);
        }
        found
    }

    fn add(&mut self, name: &str, value: f64, wished: f64, part: f64) {
        // What is no number is no fulfilment.
        let met = part <= ENOUGH;
        if !met {
            self.missing.push((format!("{name} ({} of {wished:.4})", fixed(value, 4)), part));
        }
    }

    pub fn is_met(&self) -> bool {
        self.walks && self.missing.is_empty()
    }

    fn worst(&self) -> f64 {
        self.missing
            .iter()
            .fold(0.0, |worst: f64, (_, part)| if part.is_nan() { f64::INFINITY } else { worst.max(*part) })
    }

    pub fn is_less_than(&self, other: &Self) -> bool {
        (!self.walks, self.worst()) < (!other.walks, other.worst())
    }

    /// For people.
    pub fn names(&self) -> Vec<String> {
        self.missing.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Asks for as much more as is missing.
    pub fn tighten(
        &self,
        (wished, largest): (&Demands, f64),
        (tried, optimum, of): (&ClosedLoop, &Optimum, &Collocation),
        demands: &mut Demands,
    ) {
        if let Some(speed) = tried.walking_speed {
            demands.speed =
                (demands.speed * wished.speed / speed).clamp(0.7 * wished.speed, 1.4 * wished.speed);
        }
        if tried.multiplier.is_some_and(|multiplier| multiplier.abs() > largest) {
            if slides(of) {
                // However hard a foot lands, a leg that slides gives way: what takes of a deviation is the fall of the body itself. About the foot that
                // lands its momentum is m v h less m w L, sinking at w.
                let [_, height, _] = size(of);
                let needed = (1.0 - (0.97 * largest).sqrt()) * height * wished.speed / optimum.step_length();
                demands.sinking = needed.max(1.25 * demands.sinking);
            } else {
                // Harder landings take more of a deviation away.
                demands.landing[0] = (1.4 * demands.landing[0]).min(0.7 * demands.landing[1]);
            }
        }
        let Some(margins) = &tried.margins else { return };
        // Other motions lie far from this one: not everything that is missing is asked for at once.
        let more = |now: &mut f64, value: Option<f64>, wished: f64, most: f64| {
            if let Some(value) = value {
                *now = (*now + (wished - value).clamp(0.0, 0.5 * wished)).min((most * wished).max(*now));
            }
        };
        more(&mut demands.impulse, margins.impulse, wished.impulse, 4.0);
        more(&mut demands.zmp, margins.zmp, wished.zmp, 1.8);
        more(&mut demands.clearance, margins.clearance, wished.clearance, 1.8);
        if let Some(joint) = margins.joint.filter(|joint| *joint < 0.95 * wished.joint) {
            demands.joint += (wished.joint - joint).min(wished.joint);
        }
        // Friction of the feet that stand is the controller's to keep: only impacts are asked for again.
        let excess = (margins.impact_friction.unwrap_or(0.0) - wished.friction).clamp(0.0, 0.1);
        demands.impact_friction = (demands.impact_friction - 1.2 * excess).max(0.5 * wished.friction);
        if margins.torque.is_some_and(|torque| torque < 1e-3) {
            demands.effort = (demands.effort - 0.1).max(0.5);
        }
        if margins.velocity.is_some_and(|velocity| velocity < 0.0) {
            demands.velocity = (demands.velocity - 0.1).max(0.5);
        }
    }
}
