//! What sits between the reported torque and the link, one joint at a time.
use super::outside::{self, Outsider};
use super::{Failure, failure};
use bipedc_effects::effect::Effect;

/// Dry friction: how much of it the joint can show in either direction, N m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Dry {
    /// The same at all speeds.
    Constant {
        /// Against positive velocity.
        positive: f64,
        /// Against negative velocity.
        negative: f64,
    },
    /// Larger near rest.
    Stribeck {
        /// At speed.
        coulomb: f64,
        /// At rest.
        at_rest: f64,
        /// rad/s
        speed: f64,
    },
    /// A part of the load on the gear.
    Load(f64),
}

impl Dry {
    /// Largest friction torques against positive and negative motion.
    pub fn limits(self, velocity: f64, load: f64) -> [f64; 2] {
        match self {
            Self::Constant { positive, negative } => [positive, negative],
            Self::Stribeck { coulomb, at_rest, speed } => {
                let x = velocity / speed;
                [coulomb + (at_rest - coulomb) * (-x * x).exp(); 2]
            }
            Self::Load(part) => [part * load.abs(); 2],
        }
    }
}

/// A gear that gives way: a spring behind a play.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elastic {
    /// N m/rad
    pub stiffness: f64,
    /// From stop to stop, rad.
    pub gap: f64,
    /// Of the motor as seen from the joint: the effect `rotor_inertia` there, kg m².
    pub motor_inertia: f64,
    /// N m s/rad, in contact.
    pub damping: f64,
}

impl Elastic {
    /// Torque on the link for an angle and a speed of the motor relative to it.
    pub fn torque(&self, angle: f64, speed: f64) -> f64 {
        let half = 0.5 * self.gap;
        let pressed = if angle > half {
            angle - half
        } else if angle < -half {
            angle + half
        } else {
            return 0.0;
        };
        let torque = self.stiffness * pressed + self.damping * speed;
        // Stops push; they do not hold back.
        if self.gap > 0.0 && torque * pressed < 0.0 { 0.0 } else { torque }
    }
}

/// Everything at one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Proportional and differential gain of the controller.
    pub gains: [f64; 2],
    pub viscous: f64,
    /// N m s²/rad²
    pub drag: f64,
    pub rotor: f64,
    /// Stiffness and rest angle.
    pub spring: [f64; 2],
    /// Amplitude, periods per turn, phase.
    pub ripple: [f64; 3],
    pub dry: Vec<Dry>,
    pub gain: f64,
    pub bias: f64,
    pub limit: f64,
    pub delay: f64,
    pub encoder_offset: f64,
    pub elastic: Option<Elastic>,
    /// Other joint; inertia, damping, coulomb, stiffness.
    pub coupling: Option<(usize, [f64; 4])>,
    pub outsiders: Vec<Outsider>,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            gains: [0.0; 2],
            viscous: 0.0,
            drag: 0.0,
            rotor: 0.0,
            spring: [0.0; 2],
            ripple: [0.0; 3],
            dry: Vec::new(),
            gain: 1.0,
            bias: 0.0,
            limit: f64::INFINITY,
            delay: 0.0,
            encoder_offset: 0.0,
            elastic: None,
            coupling: None,
            outsiders: Vec::new(),
        }
    }
}

/// The drives of all joints.
pub type Mechanism = Vec<Drive>;

/// The drives of a robot with these effects. Effects of other places are ignored.
///
/// # Errors
/// A joint that the robot does not have.
pub fn mechanism(joints: &[String], effects: &[Effect]) -> Result<Mechanism, Failure> {
    let find = |name: &str| {
        let index = joints.iter().position(|joint| joint == name);
        index.ok_or_else(|| failure(format!("no joint `{name}`")))
    };
    let mut drives = vec![Drive::default(); joints.len()];
    for effect in effects {
        let Some(joint) = &effect.location.joint else { continue };
        let other = effect.location.other_joint.as_deref().map(find).transpose()?;
        install(&mut drives[find(joint)?], effect, other)?;
    }
    // The rotor turns with its motor, once.
    for drive in &mut drives {
        if let Some(elastic) = &mut drive.elastic {
            elastic.motor_inertia = std::mem::take(&mut drive.rotor);
        }
    }
    Ok(drives)
}

/// Stiffness of the stops of a play, N m/rad.
pub const STOPS: f64 = 4000.0;

fn install(drive: &mut Drive, effect: &Effect, other: Option<usize>) -> Result<(), Failure> {
    let value = |name: &str| effect.value(name);
    match effect.kind.name {
        "viscous_friction" => drive.viscous += value("damping"),
        "quadratic_drag" => drive.drag += value("drag"),
        "coulomb_friction" => {
            let torque = value("torque");
            drive.dry.push(Dry::Constant { positive: torque, negative: torque });
        }
        "asymmetric_coulomb_friction" => {
            drive.dry.push(Dry::Constant { positive: value("positive"), negative: value("negative") });
        }
        "stribeck_friction" => drive.dry.push(Dry::Stribeck {
            coulomb: value("coulomb"),
            at_rest: value("static"),
            speed: value("stribeck_velocity"),
        }),
        "load_dependent_friction" => drive.dry.push(Dry::Load(value("coefficient"))),
        "rotor_inertia" => drive.rotor += value("inertia"),
        "parallel_spring" => drive.spring = [value("stiffness"), value("rest_angle")],
        "series_elasticity" => {
            // Beside play: how its stops give way.
            let play = drive.elastic.unwrap_or(Elastic {
                stiffness: 0.0,
                gap: 0.0,
                motor_inertia: 0.0,
                damping: 0.0,
            });
            drive.elastic = Some(Elastic { stiffness: value("stiffness"), ..play });
        }
        "backlash" => {
            let gap = value("gap");
            let stiffness = drive.elastic.map_or(STOPS, |spring| spring.stiffness);
            drive.elastic = Some(Elastic { stiffness, gap, motor_inertia: 0.0, damping: 1.0 });
        }
        "torque_gain" => drive.gain = value("gain"),
        "torque_bias" => drive.bias += value("bias"),
        "torque_saturation" => drive.limit = value("limit"),
        "torque_ripple" => drive.ripple = ["amplitude", "periods_per_turn", "phase"].map(value),
        "actuator_delay" => drive.delay = value("delay"),
        "encoder_offset" => drive.encoder_offset = value("offset"),
        "coupling" => {
            let other = other.ok_or_else(|| failure("a coupling without another joint"))?;
            drive.coupling = Some((other, ["inertia", "damping", "coulomb", "stiffness"].map(value)));
        }
        kind => match outside::outsider(effect, other) {
            Some(outsider) => drive.outsiders.push(outsider),
            None => return Err(failure(format!("the simulator has no `{kind}`"))),
        },
    }
    Ok(())
}

/// Inertia of motors whose rotors are drawn behind a play or spring, kg m² at the joint.
pub const MOTOR_INERTIA: f64 = 0.004;

/// Position and velocity of all joints.
#[derive(Debug, Clone, Copy)]
pub struct Moving<'a> {
    pub q: &'a [f64],
    pub v: &'a [f64],
}

/// Torque on the joint from everything that is smooth: as added to the inverse dynamics. Without what multiplies
/// accelerations.
pub fn smooth_torque(drive: &Drive, joint: usize, state: &Moving<'_>) -> f64 {
    let (q, v) = (state.q[joint], state.v[joint]);
    let [stiffness, rest] = drive.spring;
    let [amplitude, periods, phase] = drive.ripple;
    let mut torque = (drive.viscous + drive.drag * v.abs()) * v
        + stiffness * (q - rest)
        + amplitude * (periods * q + phase).sin();
    if let Some((other, [_, damping, coulomb, stiffness])) = drive.coupling {
        let w = state.v[other];
        // Sharper than the diagnosis' sign, and of another shape.
        torque += damping * w + coulomb * w / (w * w + 1e-5).sqrt() + stiffness * state.q[other];
    }
    torque + drive.outsiders.iter().map(|outsider| outsider.torque(joint, state)).sum::<f64>()
}
