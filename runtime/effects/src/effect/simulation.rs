//! How a simulation takes an effect.

/// How a simulation takes an effect, by the names of its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Simulation {
    /// By its formula, a smooth torque at the middle of the step.
    Formula,
    /// The same at the motor's angle, where a motor turns on its own.
    MotorFormula,
    /// By its formula; what belongs to the other joint's acceleration joins the mass matrix.
    Coupling {
        /// kg m²
        inertia: &'static str,
    },
    /// Damping, N m s/rad.
    Damping(&'static str),
    /// Inertia that turns with the joint, kg m².
    Inertia(&'static str),
    /// Dry friction, a set-valued force law: it holds a joint at rest.
    Dry(Dry),
    /// True torque per reported torque.
    Gain(&'static str),
    /// Reported less true torque, N m.
    Bias(&'static str),
    /// Largest true torque, N m.
    Limit(&'static str),
    /// As its law says: bodies, springs, play, delay, ground, sensors.
    Law,
}

/// Dry friction, by the names of its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dry {
    /// One torque per direction, N m.
    Constant {
        /// At positive velocity.
        positive: &'static str,
        /// At negative velocity.
        negative: &'static str,
    },
    /// Larger near rest.
    Stribeck {
        /// At speed, N m.
        coulomb: &'static str,
        /// At rest, N m.
        at_rest: &'static str,
        /// Where the excess has faded, rad/s.
        speed: &'static str,
    },
    /// In proportion to the load.
    Load(&'static str),
}

impl Simulation {
    /// Whether it is a smooth torque at one joint: all that a motion between events can take.
    pub fn is_smooth(self) -> bool {
        matches!(self, Self::Formula | Self::MotorFormula | Self::Damping(_) | Self::Inertia(_))
    }

    /// Whether it turns with the motor where a spring or play lies between motor and link: rotor, friction, ripple.
    pub fn is_on_motor(self) -> bool {
        matches!(self, Self::MotorFormula | Self::Damping(_) | Self::Inertia(_) | Self::Dry(_))
    }
}
