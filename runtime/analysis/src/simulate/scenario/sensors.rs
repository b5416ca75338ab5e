//! `[sensors]` of a scenario.
use super::Sensors;
use super::file::{Number, Senses};
use super::reading::{NOT_NEGATIVE, Reading};
use crate::simulate::EffortSensor;

impl Reading<'_> {
    pub(super) fn sensors(&mut self, senses: Option<&Senses>) -> Sensors {
        let none = Senses::default();
        let s = senses.unwrap_or(&none);
        let encoder_counts = self.counts("encoder_counts", s.encoder_counts.as_ref());
        let mut of = |name: &str, found: &Option<Number>, unit: &str| {
            self.number(name, found.as_ref(), 0.0, NOT_NEGATIVE, unit)
        };
        Sensors {
            encoder_counts,
            position: of("position_noise", &s.position_noise, "rad"),
            velocity: of("velocity_noise", &s.velocity_noise, "rad/s"),
            effort: of("effort_noise", &s.effort_noise, "N m"),
            force: of("force_noise", &s.force_noise, "N"),
            base_position: of("base_position_noise", &s.base_position_noise, "m"),
            base_orientation: of("base_orientation_noise", &s.base_orientation_noise, "rad"),
            base_velocity: of("base_velocity_noise", &s.base_velocity_noise, "m/s"),
            force_limit: of("force_limit", &s.force_limit, "N"),
            velocities: s.velocities.unwrap_or(true),
            current: of("current_noise", &s.current_noise, "A"),
            current_step: of("current_step", &s.current_step, "A"),
            torque: match self.choice("effort", s.effort.as_ref(), ["motor", "joint"]) {
                0 => EffortSensor::Motor,
                _ => EffortSensor::Joint,
            },
        }
    }
}
