//! Motors as a scenario or a description gives them (thesis 4.6).
use bipedc_effects::drive::Drive;

/// The drive of a joint with its electronics: what a description says of it, and what only a scenario says.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(into = "Written")]
pub struct Actuator {
    /// Motor, gear, transmission, encoders. Without a torque constant the motor gives the torque that it is asked for.
    pub drive: Drive,
    /// Ω; 0: the drive gives the current that it is asked for, whatever the speed.
    pub resistance: f64,
    /// V; infinite: none.
    pub voltage_limit: f64,
    /// A; infinite: none.
    pub current_limit: f64,
    /// The drive is given a voltage, not a current: back-EMF brakes the motor.
    pub voltage_command: bool,
    /// Of a spring in series in the place of the drive's, N m/rad at the joint; infinite: none. `None`: that of the drive.
    pub stiffness: Option<f64>,
    /// Beside the spring in series, N m s/rad at the joint.
    pub spring_damping: f64,
    /// Play between motor and joint from stop to stop, rad at the joint.
    pub gap: f64,
    /// Whether the robot's description has it: angles of the motor are logged at the shaft then, and currents instead of
    /// efforts.
    pub described: bool,
}

impl Default for Actuator {
    fn default() -> Self {
        Self {
            drive: Drive::default(),
            resistance: 0.0,
            voltage_limit: f64::INFINITY,
            current_limit: f64::INFINITY,
            voltage_command: false,
            stiffness: None,
            spring_damping: 0.0,
            gap: 0.0,
            described: false,
        }
    }
}

/// Keys of a motor in the file of what was hidden: everything as seen from the joint, but what is at the shaft.
#[derive(serde::Serialize)]
struct Written {
    turns: f64,
    rotor_inertia: f64,
    viscous_friction: f64,
    coulomb_friction: f64,
    torque_constant: Option<f64>,
    resistance: f64,
    voltage_limit: f64,
    current_limit: f64,
    voltage_command: bool,
    stiffness: f64,
    spring_damping: f64,
    gap: f64,
    motor_counts: f64,
    joint_counts: f64,
    passive: Option<[f64; 2]>,
    described: bool,
}

impl From<Actuator> for Written {
    fn from(actuator: Actuator) -> Self {
        let drive = actuator.drive;
        Self {
            turns: drive.turns(),
            rotor_inertia: drive.rotor_inertia,
            viscous_friction: drive.viscous_friction,
            coulomb_friction: drive.coulomb_friction,
            torque_constant: drive.torque_constant,
            resistance: actuator.resistance,
            voltage_limit: actuator.voltage_limit,
            current_limit: actuator.current_limit,
            voltage_command: actuator.voltage_command,
            stiffness: actuator.series_stiffness(),
            spring_damping: actuator.spring_damping,
            gap: actuator.gap,
            motor_counts: drive.motor_encoder_counts.unwrap_or(0.0),
            joint_counts: drive.joint_encoder_counts.unwrap_or(0.0),
            passive: drive.passive(),
            described: actuator.described,
        }
    }
}

/// What a motor gives at the joint: `torque − damping × speed`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Given {
    /// N m
    pub torque: f64,
    /// Of the back-EMF, N m s/rad.
    pub damping: f64,
    /// Not what was asked for.
    pub clipped: bool,
}

impl Actuator {
    /// A drive of the robot's description, without limits.
    pub fn described(drive: Drive) -> Self {
        Self { drive, described: true, ..Self::default() }
    }

    /// Stiffness of the spring between motor and joint, N m/rad at the joint (4.29); infinite: none.
    pub fn series_stiffness(&self) -> f64 {
        self.stiffness.unwrap_or_else(|| self.drive.stiffness_at_joint())
    }

    /// For a torque (N m) that is asked for at a speed of the joint (rad/s).
    pub(super) fn give(&self, asked: f64, speed: f64) -> Given {
        let Some(constant) = self.drive.torque_per_ampere() else {
            return Given { torque: asked, ..Given::default() };
        };
        let (resistance, most) = (self.resistance, self.current_limit);
        let wanted = asked / constant;
        // A resistor behind a voltage: i = (u − c q̇)/R.
        let behind = |voltage: f64, clipped| Given {
            torque: constant * voltage / resistance,
            damping: constant * constant / resistance,
            clipped,
        };
        let limited = |current: f64| Given { torque: constant * current, damping: 0.0, clipped: true };
        if self.voltage_command && resistance > 0.0 {
            let wanted = wanted * resistance;
            let voltage = wanted.clamp(-self.voltage_limit, self.voltage_limit);
            let current = (voltage - constant * speed) / resistance;
            if current.abs() > most {
                return limited(most.copysign(current));
            }
            return behind(voltage, voltage != wanted);
        }
        let current = wanted.clamp(-most, most);
        let voltage = resistance * current + constant * speed;
        if resistance > 0.0 && voltage.abs() > self.voltage_limit {
            return behind(self.voltage_limit.copysign(voltage), true);
        }
        Given { torque: constant * current, damping: 0.0, clipped: current != wanted }
    }

    /// Smallest and largest torque that it can be asked for at a speed, with the damping that comes with it.
    pub(super) fn range(&self, speed: f64) -> ([f64; 2], f64) {
        let Some(constant) = self.drive.torque_per_ampere() else {
            return ([f64::NEG_INFINITY, f64::INFINITY], 0.0);
        };
        let size = constant.abs();
        let (most, resistance) = (size * self.current_limit, self.resistance);
        if resistance == 0.0 {
            return ([-most, most], 0.0);
        }
        let (brake, volts) = (constant * constant / resistance, size * self.voltage_limit / resistance);
        if self.voltage_command {
            // The current's limits move with the speed.
            let shift = brake * speed;
            return ([f64::max(-volts, shift - most), f64::min(volts, shift + most)], brake);
        }
        let shift = -brake * speed;
        let (low, high) = (f64::max(-most, shift - volts), f64::min(most, shift + volts));
        // Faster than the voltage can brake: what the resistor leaves.
        (if low <= high { [low, high] } else { [0.5 * (low + high); 2] }, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motor() -> Actuator {
        Actuator {
            drive: Drive { gear_ratio: -100.0, torque_constant: Some(0.02), ..Drive::default() },
            resistance: 0.5,
            voltage_limit: 24.0,
            current_limit: 10.0,
            ..Actuator::default()
        }
    }

    #[test]
    fn current_and_voltage_are_limited() {
        // 2 N m/A at the joint, 2 V s/rad: 20 N m at most, and 24 V at 12 rad/s without current.
        let at = |asked: f64, speed: f64| {
            let given = motor().give(asked, speed);
            (given.torque - given.damping * speed, given.clipped)
        };
        assert_eq!(at(6.0, 0.0), (6.0, false));
        assert_eq!(at(-60.0, 0.0), (-20.0, true));
        // 10 A need 5 V: 9.5 rad/s are left.
        assert_eq!(at(20.0, 9.4), (20.0, false));
        // 2 V over 0.5 Ω are left at 11 rad/s.
        assert!((at(20.0, 11.0).0 - 8.0).abs() < 1e-12);
        assert!((at(20.0, 13.0).0 + 8.0).abs() < 1e-12, "the motor brakes beyond its idle speed");
        assert_eq!(motor().range(0.0), ([-20.0, 20.0], 0.0));
        assert!((motor().range(11.0).0[1] - 8.0).abs() < 1e-12);
    }

    #[test]
    fn a_voltage_is_braked() {
        let motor = Actuator { voltage_command: true, ..motor() };
        // Asked for 6 N m at rest: 3 A, 1.5 V. At 0.5 rad/s 1 V of back-EMF are against it: 1 A.
        let given = motor.give(6.0, 0.5);
        assert!((given.torque - given.damping * 0.5 - 2.0).abs() < 1e-12 && !given.clipped);
        assert!(motor.give(100.0, 0.0).torque == 20.0 && motor.give(100.0, 0.0).clipped);
    }
}
