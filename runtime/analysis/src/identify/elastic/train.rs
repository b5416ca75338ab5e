//! What is known of the motors before anything is measured.
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::Diagnostic;

/// Motor, gear and transmission of one joint (4.26)–(4.33).
#[derive(Debug, Clone, PartialEq)]
pub struct Train {
    /// Index of the joint.
    pub joint: usize,
    /// Between gear and joint.
    pub transmission: Transmission,
    /// Motor turns per turn of the gear's output; negative where the motor turns the other way.
    pub gear_ratio: f64,
    /// Of the motor shaft, kg m².
    pub rotor_inertia: f64,
    /// N m/A; passive joints have none.
    pub torque_constant: f64,
    /// Described value at the motor shaft, N m s/rad.
    pub viscous_friction: f64,
    /// Described value at the motor shaft, N m.
    pub coulomb_friction: f64,
}

/// Between gear and joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transmission {
    /// Motor angle = gear ratio × joint angle.
    Stiff,
    /// Pulleys with a spring in the cable (4.28).
    SeriesElastic {
        /// r_M, m
        motor_radius: f64,
        /// r_L, m
        load_radius: f64,
        /// Described value, N/m.
        stiffness: f64,
    },
    /// No motor: a spring and damper beside the joint, taken as described.
    Passive {
        /// N m/rad
        stiffness: f64,
        /// N m s/rad
        damping: f64,
    },
}

impl Train {
    /// `series_elastic`, `stiff`, `passive`: as in the description.
    pub fn kind(&self) -> &'static str {
        match self.transmission {
            Transmission::Stiff => "stiff",
            Transmission::SeriesElastic { .. } => "series_elastic",
            Transmission::Passive { .. } => "passive",
        }
    }

    /// Whether a spring lies between motor and joint.
    pub fn is_elastic(&self) -> bool {
        matches!(self.transmission, Transmission::SeriesElastic { .. })
    }

    /// Whether a motor drives the joint.
    pub fn has_motor(&self) -> bool {
        !matches!(self.transmission, Transmission::Passive { .. })
    }

    /// r_M / N, m per radian of the motor shaft: from motor angle to cable, and from cable force to motor torque.
    pub fn lever(&self) -> f64 {
        match self.transmission {
            Transmission::SeriesElastic { motor_radius, .. } => motor_radius / self.gear_ratio,
            _ => 0.0,
        }
    }

    /// r_L, m per radian of the joint.
    pub fn load_radius(&self) -> f64 {
        match self.transmission {
            Transmission::SeriesElastic { load_radius, .. } => load_radius,
            _ => 0.0,
        }
    }

    /// Described stiffness of the spring in the cable, N/m.
    pub fn stiffness(&self) -> f64 {
        match self.transmission {
            Transmission::SeriesElastic { stiffness, .. } => stiffness,
            _ => 0.0,
        }
    }

    /// Motor turns per turn of the joint while the spring does not give: N r_L / r_M, or N.
    pub fn turns(&self) -> f64 {
        match self.transmission {
            Transmission::SeriesElastic { .. } => self.load_radius() / self.lever(),
            _ => self.gear_ratio,
        }
    }

    /// Refuses numbers with which nothing can be computed.
    ///
    /// # Errors
    /// A missing torque constant, gears or radii that are zero or no number.
    pub fn check(&self, subject: &JointLayout) -> Result<(), Diagnostic> {
        let joint = &subject.joints[self.joint];
        let refuse = |what: String, help: &str| Err(Diagnostic::error(what).help(help.to_owned()));
        let table = format!("[drives.{}]", joint.name);
        if self.is_elastic() && joint.prismatic {
            return refuse(
                format!("{table} is series elastic, but the joint slides"),
                "pulleys turn: give the drive to a revolute joint",
            );
        }
        if !self.has_motor() {
            return Ok(());
        }
        let known = [
            (self.gear_ratio != 0.0 && self.gear_ratio.is_finite(), "gear_ratio"),
            (self.torque_constant > 0.0 && self.torque_constant.is_finite(), "torque_constant"),
            (self.rotor_inertia >= 0.0 && self.rotor_inertia.is_finite(), "rotor_inertia"),
            (!self.is_elastic() || self.lever().abs() > 0.0, "motor_pulley_radius"),
            (!self.is_elastic() || self.load_radius() > 0.0, "load_pulley_radius"),
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
