//! The drive of a joint: motor, gear, and what lies between gear and joint (thesis 4.6).
//!
//! Numbers are where a data sheet has them: friction and inertia at the motor shaft, pulleys and spring in the cable. What
//! they are at the joint follows from them here and nowhere else.

/// Motor, gear and transmission of one joint (4.26)–(4.33).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Between gear and joint.
    pub transmission: Transmission,
    /// N: motor turns per turn of the gear's output; negative where the motor turns the other way. Not zero.
    pub gear_ratio: f64,
    /// I_M, of the motor shaft, kg m².
    pub rotor_inertia: f64,
    /// K_M, N m/A, positive; `None`: not known, or no motor.
    pub torque_constant: Option<f64>,
    /// F_v, at the motor shaft, N m s/rad.
    pub viscous_friction: f64,
    /// F_c, at the motor shaft, N m.
    pub coulomb_friction: f64,
    /// Counts per motor turn, positive; `None`: not stated.
    pub motor_encoder_counts: Option<f64>,
    /// Counts per joint turn, positive; `None`: not stated.
    pub joint_encoder_counts: Option<f64>,
}

/// What lies between gear and joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transmission {
    /// Nothing that gives: motor angle = gear ratio × joint angle.
    Stiff,
    /// Pulleys with a spring in the cable (4.28).
    SeriesElastic {
        /// r_M, of the pulley at the gear's output, m.
        motor_pulley_radius: f64,
        /// r_L, of the pulley at the joint, m.
        load_pulley_radius: f64,
        /// k, of the spring in the cable, N/m.
        spring_stiffness: f64,
    },
    /// No motor: a spring and a damper parallel to the joint.
    Passive {
        /// N m/rad
        stiffness: f64,
        /// N m s/rad
        damping: f64,
    },
}

impl Transmission {
    /// `stiff`, `series_elastic`, `passive`: `kind` of `[drives.JOINT]`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Stiff => "stiff",
            Self::SeriesElastic { .. } => "series_elastic",
            Self::Passive { .. } => "passive",
        }
    }
}

impl Default for Drive {
    /// A motor on the joint itself, without inertia, friction and encoders.
    fn default() -> Self {
        Self {
            transmission: Transmission::Stiff,
            gear_ratio: 1.0,
            rotor_inertia: 0.0,
            torque_constant: None,
            viscous_friction: 0.0,
            coulomb_friction: 0.0,
            motor_encoder_counts: None,
            joint_encoder_counts: None,
        }
    }
}

impl Drive {
    /// Whether a motor drives the joint.
    pub fn has_motor(&self) -> bool {
        !matches!(self.transmission, Transmission::Passive { .. })
    }

    /// Whether a spring lies between motor and joint.
    pub fn is_elastic(&self) -> bool {
        matches!(self.transmission, Transmission::SeriesElastic { .. })
    }

    /// Whether motor and joint turn as one.
    pub fn is_stiff(&self) -> bool {
        self.transmission == Transmission::Stiff
    }

    /// Motor turns per turn of the joint while the spring does not give: N, or N r_L / r_M behind pulleys.
    pub fn turns(&self) -> f64 {
        match self.transmission {
            Transmission::SeriesElastic { motor_pulley_radius, load_pulley_radius, .. } => {
                self.gear_ratio * (load_pulley_radius / motor_pulley_radius)
            }
            _ => self.gear_ratio,
        }
    }

    /// Torque at the joint per current while the spring does not give, N m/A (4.26), (4.33); also back-EMF per speed of the
    /// joint, V s/rad.
    pub fn torque_per_ampere(&self) -> Option<f64> {
        self.torque_constant.map(|constant| constant * self.turns())
    }

    /// Rotor inertia as seen at the joint, N² I_M with N = [`turns`](Self::turns), kg m². Only the rotor's spin relative to
    /// the link that carries the motor counts; its mass belongs to that link.
    pub fn rotor_inertia_at_joint(&self) -> f64 {
        self.through_gear(self.rotor_inertia)
    }

    /// Viscous friction of the motor as seen at the joint, N² F_v with N = [`turns`](Self::turns), N m s/rad.
    pub fn viscous_friction_at_joint(&self) -> f64 {
        self.through_gear(self.viscous_friction)
    }

    /// Coulomb friction of the motor as seen at the joint, |N| F_c with N = [`turns`](Self::turns), N m.
    pub fn coulomb_friction_at_joint(&self) -> f64 {
        self.coulomb_friction * self.turns().abs()
    }

    /// Torque at the shaft per acceleration or velocity of the shaft, as torque at the joint per that of the joint.
    fn through_gear(&self, at_shaft: f64) -> f64 {
        let turns = self.turns();
        at_shaft * (turns * turns)
    }

    /// Stiffness between motor and joint as seen at the joint, k r_L² (4.29), N m/rad; infinite where nothing gives.
    pub fn stiffness_at_joint(&self) -> f64 {
        match self.transmission {
            Transmission::SeriesElastic { load_pulley_radius, spring_stiffness, .. } => {
                spring_stiffness * load_pulley_radius * load_pulley_radius
            }
            _ => f64::INFINITY,
        }
    }

    /// r_M / N, m per radian of the motor shaft: from motor angle to cable, and from cable force to motor torque (4.28),
    /// (4.29); 0 without a cable.
    pub fn lever(&self) -> f64 {
        match self.transmission {
            Transmission::SeriesElastic { motor_pulley_radius, .. } => motor_pulley_radius / self.gear_ratio,
            _ => 0.0,
        }
    }

    /// r_L, m per radian of the joint: from joint angle to cable, and from cable force to joint torque (4.28), (4.29); 0
    /// without a cable.
    pub fn load_radius(&self) -> f64 {
        match self.transmission {
            Transmission::SeriesElastic { load_pulley_radius, .. } => load_pulley_radius,
            _ => 0.0,
        }
    }

    /// k of the spring in the cable, N/m; 0 without a cable.
    pub fn cable_stiffness(&self) -> f64 {
        match self.transmission {
            Transmission::SeriesElastic { spring_stiffness, .. } => spring_stiffness,
            _ => 0.0,
        }
    }

    /// Stiffness (N m/rad) and damping (N m s/rad) parallel to a joint without a motor.
    pub fn passive(&self) -> Option<[f64; 2]> {
        match self.transmission {
            Transmission::Passive { stiffness, damping } => Some([stiffness, damping]),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12 * expected.abs(), "{found} instead of {expected}");
    }

    /// A motor of 0.02 N m/A that turns the other way.
    const STIFF: Drive = Drive {
        transmission: Transmission::Stiff,
        gear_ratio: -100.0,
        rotor_inertia: 5e-6,
        torque_constant: Some(0.02),
        viscous_friction: 2e-5,
        coulomb_friction: 0.004,
        motor_encoder_counts: None,
        joint_encoder_counts: None,
    };

    #[test]
    fn a_gear_makes_motors_strong_and_heavy() {
        near(STIFF.torque_per_ampere().unwrap(), -2.0);
        near(STIFF.rotor_inertia_at_joint(), 0.05);
        near(STIFF.viscous_friction_at_joint(), 0.2);
        near(STIFF.coulomb_friction_at_joint(), 0.4);
        assert_eq!(STIFF.stiffness_at_joint(), f64::INFINITY);
        assert_eq!((STIFF.lever(), STIFF.passive()), (0.0, None));
    }

    #[test]
    fn pulleys_are_a_gear_too() {
        let transmission = Transmission::SeriesElastic {
            motor_pulley_radius: 0.02,
            load_pulley_radius: 0.04,
            spring_stiffness: 5e4,
        };
        let drive = Drive { transmission, ..STIFF };
        near(drive.turns(), -200.0);
        near(drive.torque_per_ampere().unwrap(), -4.0);
        near(drive.rotor_inertia_at_joint(), 0.2);
        near(drive.stiffness_at_joint(), 80.0);
        // A cable held at the joint: the motor's angle times its lever is what the joint's angle times the radius would be.
        near(drive.lever() * drive.turns(), drive.load_radius());
    }

    #[test]
    fn passive_joints_have_no_motor() {
        let drive = Drive {
            transmission: Transmission::Passive { stiffness: 12.0, damping: 0.05 },
            ..Drive::default()
        };
        assert!(!drive.has_motor() && !drive.is_stiff() && !drive.is_elastic());
        assert_eq!((drive.passive(), drive.torque_per_ampere()), (Some([12.0, 0.05]), None));
    }
}
