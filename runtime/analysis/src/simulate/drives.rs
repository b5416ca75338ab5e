//! What happens between the torque that is reported and the link: motors, gears, and the effects in joints.
//!
//! Laws come from the library's formulas where they are smooth. Dry friction is set-valued here (a joint can stick), not
//! the library's smoothed sign: it goes into the contact problem. Where a spring or play lies between motor and joint, the
//! motor turns on its own and friction, rotor and ripple are on its side (4.26), (4.31).
use super::actuator::{Actuator, Given};
use super::driven_joint::{DrivenJoint, Reading};
use super::ground::JointLaw;
use super::motors::MotorLaw;
use super::plant::Plant;
use super::resistance::{Resistance, Variables};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Effect, Location, Simulation};
use std::collections::VecDeque;

/// Two joints whose accelerations act on each other: kg m².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupled {
    /// Indices of the joints.
    pub joints: [usize; 2],
    /// kg m²
    pub inertia: f64,
}

/// The drives of all joints.
#[derive(Debug, Clone)]
pub(super) struct Drives {
    joints: Vec<DrivenJoint>,
    coupled: Vec<Coupled>,
}

impl Drives {
    /// From motors and the effects at joints; others are passed over.
    pub fn new(
        plant: &Plant,
        actuators: &[Option<Actuator>],
        effects: &[&Effect],
        step: f64,
    ) -> Result<Self, Diagnostic> {
        let at = |j: usize| DrivenJoint::new(actuators.get(j).copied().flatten());
        let mut joints: Vec<DrivenJoint> = (0..plant.layout.joints.len()).map(at).collect();
        let mut pairs = Vec::new();
        for effect in effects {
            let Some(name) = &effect.location.joint else { continue };
            let find = |name: &str| {
                plant.joint(name).ok_or_else(|| Diagnostic::error(format!("the robot has no joint `{name}`")))
            };
            let (joint, other) = (find(name)?, effect.location.other_joint.as_deref().map(find).transpose()?);
            if let (Some(other), Simulation::Coupling { inertia }) = (other, effect.kind.simulation)
                && effect.value(inertia) != 0.0
            {
                pairs.push((Coupled { joints: [joint, other], inertia: effect.value(inertia) }, *effect));
            }
            joints[joint].add(effect, other, step)?;
        }
        let mut motors = 0;
        for (driven, joint) in joints.iter_mut().zip(&plant.layout.joints) {
            driven.reading = driven.readings.iter().rev().fold(Reading::TRUE, Reading::then);
            driven.past = VecDeque::from(vec![0.0; driven.delay.0 + 2]);
            if driven.yielding > 0.0 || driven.gap > 0.0 {
                driven.has_inertia(&joint.name)?;
                driven.motor = Some(motors);
                motors += 1;
            }
        }
        Ok(Self { joints, coupled: symmetric(&pairs)? })
    }

    /// Where encoders of a joint and its motor read more than the truth, rad.
    pub fn encoder_offset(&self, joint: usize) -> f64 {
        self.joints[joint].encoder_offset
    }

    /// The motor's data.
    pub fn actuator(&self, joint: usize) -> Option<&Actuator> {
        self.joints[joint].actuator.as_ref()
    }

    /// Index among the motors that turn on their own.
    pub fn motor(&self, joint: usize) -> Option<usize> {
        self.joints[joint].motor
    }

    /// The axis that the motor turns: its own, or the joint.
    pub fn axis(&self, joint: usize) -> usize {
        self.joints[joint].motor.map_or(joint, |motor| self.joints.len() + motor)
    }

    /// Pairs of joints whose accelerations act on each other.
    pub fn coupled(&self) -> &[Coupled] {
        &self.coupled
    }

    /// Laws of the joints that do not change, with the stops of the plant if wanted.
    pub fn laws(&self, plant: &Plant, stops: bool) -> Vec<JointLaw> {
        let law = |(driven, limits): (&DrivenJoint, &Option<[f64; 2]>)| {
            let passive = driven.passive().unwrap_or_default();
            let limits = limits.filter(|_| stops);
            match driven.motor {
                Some(_) => JointLaw { limits, damping: passive[1], ..JointLaw::default() },
                None => JointLaw {
                    rotor_inertia: driven.rotor_inertia,
                    damping: driven.damping + passive[1],
                    limits,
                    ..JointLaw::default()
                },
            }
        };
        self.joints.iter().zip(&plant.position_limits).map(law).collect()
    }

    /// Laws of the motors that turn on their own.
    pub fn motors(&self) -> Vec<MotorLaw> {
        let own = self.joints.iter().enumerate().filter(|(_, driven)| driven.motor.is_some());
        own.map(|(joint, driven)| MotorLaw {
            joint,
            inertia: driven.rotor_inertia,
            damping: driven.damping,
            dry: [0.0; 2],
            stiffness: if driven.yielding > 0.0 { 1.0 / driven.yielding } else { f64::INFINITY },
            spring_damping: driven.spring_damping,
            gap: driven.gap,
        })
        .collect()
    }

    /// Viscous friction and inertia of the rotor, without what changes from step to step.
    pub fn constant(&self, joint: usize) -> (f64, f64) {
        let driven = &self.joints[joint];
        (driven.damping, driven.rotor_inertia)
    }

    /// What the motor gives when this is asked for, late by the delay.
    pub fn give(&mut self, joint: usize, asked: f64, speed: f64) -> (Given, f64) {
        let driven = &mut self.joints[joint];
        let given = match &driven.actuator {
            Some(actuator) => actuator.give(asked, speed),
            None => Given { torque: asked, ..Given::default() },
        };
        driven.past.pop_back();
        driven.past.push_front(given.torque);
        let (steps, part) = driven.delay;
        let late = (1.0 - part) * driven.past[steps] + part * driven.past[steps + 1];
        (given, late)
    }

    /// Torques that the motor can be asked for, and its damping by back-EMF.
    pub fn range(&self, joint: usize, speed: f64) -> ([f64; 2], f64) {
        let whole = ([f64::NEG_INFINITY, f64::INFINITY], 0.0);
        self.joints[joint].actuator.map_or(whole, |actuator| actuator.range(speed))
    }

    /// The true torque from the reported one. Where a sensor at the joint reports it, only limits are the motor's.
    pub fn reading(&self, joint: usize, sensor: bool) -> Reading {
        let reading = self.joints[joint].reading;
        if sensor { Reading { limits: self.joints[joint].limits(), ..Reading::TRUE } } else { reading }
    }

    /// What a torque sensor at the joint reports.
    pub fn sensed(&self, joint: usize, torque: f64) -> f64 {
        self.joints[joint].reading.reported(torque)
    }

    /// Smooth laws at a joint (`motor`: at its motor), added to the inverse dynamics. `state` gives the state of a joint.
    pub fn resistance(
        &mut self,
        joint: usize,
        motor: bool,
        own: Variables,
        state: &dyn Fn(usize) -> [f64; 2],
    ) -> Resistance {
        let driven = &mut self.joints[joint];
        let split = driven.motor.is_some();
        let mut sum = Resistance::default();
        for smooth in driven.smooth.iter_mut().filter(|smooth| (smooth.on_motor && split) == motor) {
            let other = smooth.other.map_or([0.0; 2], state);
            let one = smooth.at(&Variables { other, ..own });
            sum.value += one.value;
            sum.velocity += one.velocity;
            sum.acceleration += one.acceleration;
        }
        if let Some([stiffness, _]) = driven.passive().filter(|_| !motor) {
            sum.value += stiffness * own.own[0];
        }
        sum
    }

    /// Largest dry friction against positive and against negative motion at this speed, with this torque on the link.
    pub fn dry(&self, joint: usize, velocity: f64, load: f64) -> [f64; 2] {
        self.joints[joint].dry_limits(velocity, load)
    }

    /// Whether the torque acts later than it is asked for.
    pub fn is_late(&self, joint: usize) -> bool {
        self.joints[joint].delay != (0, 0.0)
    }
}

/// Couplings with an inertia, each once; the other joint must feel the same.
fn symmetric(pairs: &[(Coupled, &Effect)]) -> Result<Vec<Coupled>, Diagnostic> {
    let mut kept: Vec<Coupled> = Vec::new();
    for (pair, effect) in pairs {
        let [joint, other] = pair.joints;
        let back = |(p, _): &&(Coupled, &Effect)| p.joints == [other, joint] && p.inertia == pair.inertia;
        if !pairs.iter().any(|p| back(&p)) {
            let Location { joint, other_joint, .. } = &effect.location;
            let (joint, other) =
                (joint.as_deref().unwrap_or_default(), other_joint.as_deref().unwrap_or_default());
            return Err(Diagnostic::error(format!(
                "`{effect}` cannot be simulated alone: the acceleration of `{other}` would act on `{joint}` and not the other way round, which makes energy"
            ))
            .help(format!(
                "add a `coupling` of joint `{other}` from `{joint}` with the same `inertia`, {} kg m²",
                pair.inertia
            )));
        }
        if kept.iter().all(|other| other.joints != [pair.joints[1], pair.joints[0]]) {
            kept.push(*pair);
        }
    }
    Ok(kept)
}
