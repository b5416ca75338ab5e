//! `[imu]` of a scenario.
use super::file::Inertial;
use super::reading::{NOT_NEGATIVE, Reading};
use crate::robot::BaseKind;
use crate::simulate::{Imu, Plant};
use toml::Spanned;

impl Reading<'_> {
    /// The unit on the base.
    pub(super) fn imu(&mut self, table: &Spanned<Inertial>, plant: &Plant) -> Option<Imu> {
        if plant.layout.base == BaseKind::Fixed {
            let help = "leave it out: the base does not move";
            return self.wrong(table.span().start, "[imu] has no meaning on a fixed base", help);
        }
        let own = table.get_ref();
        let mut three = |name: &str, found: &Option<Spanned<Vec<f64>>>, words: &str| {
            let values = self.vector(name, found.as_ref(), 3, words);
            [values[0], values[1], values[2]]
        };
        let (position, rotation) = (
            three("position", &own.position, "[x, y, z] in m"),
            three("rotation", &own.rotation, "[roll, pitch, yaw] in rad"),
        );
        let acceleration_bias = three("acceleration_bias", &own.acceleration_bias, "[x, y, z] in m/s²");
        let angular_velocity_bias =
            three("angular_velocity_bias", &own.angular_velocity_bias, "[x, y, z] in rad/s");
        let noise = own.acceleration_noise.as_ref();
        let acceleration_noise = self.number("acceleration_noise", noise, 0.0, NOT_NEGATIVE, "m/s²");
        let noise = own.angular_velocity_noise.as_ref();
        let angular_velocity_noise = self.number("angular_velocity_noise", noise, 0.0, NOT_NEGATIVE, "rad/s");
        Some(Imu {
            position,
            rotation,
            acceleration_noise,
            angular_velocity_noise,
            acceleration_bias,
            angular_velocity_bias,
        })
    }
}
