//! What is known of the motors before anything is measured.
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::drive::Drive;

/// A joint and its described drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Driven<'d> {
    /// Index of the joint.
    pub joint: usize,
    /// As described.
    pub drive: &'d Drive,
}

impl Driven<'_> {
    /// Refuses numbers with which nothing can be computed.
    ///
    /// # Errors
    /// A missing torque constant, gears or radii that are zero or no number.
    pub fn check(&self, layout: &JointLayout) -> Result<(), Diagnostic> {
        let (joint, drive) = (&layout.joints[self.joint], self.drive);
        let refuse = |what: String, help: &str| Err(Diagnostic::error(what).help(help.to_owned()));
        let table = format!("[drives.{}]", joint.name);
        if drive.is_elastic() && joint.prismatic {
            return refuse(
                format!("{table} is series elastic, but the joint slides"),
                "pulleys turn: give the drive to a revolute joint",
            );
        }
        if !drive.has_motor() {
            return Ok(());
        }
        let constant = drive.torque_constant.unwrap_or(0.0);
        let known = [
            (drive.gear_ratio != 0.0 && drive.gear_ratio.is_finite(), "gear_ratio"),
            (constant > 0.0 && constant.is_finite(), "torque_constant"),
            (drive.rotor_inertia >= 0.0 && drive.rotor_inertia.is_finite(), "rotor_inertia"),
            (!drive.is_elastic() || drive.lever().abs() > 0.0, "motor_pulley_radius"),
            (!drive.is_elastic() || drive.load_radius() > 0.0, "load_pulley_radius"),
        ];
        match known.iter().find(|(good, _)| !good) {
            Some((_, key)) => refuse(
                format!("{table} has no usable `{key}`"),
                "write it into biped.toml: torques at the motor follow from it (thesis 5.3.1 takes it as known)",
            ),
            None => Ok(()),
        }
    }
}
