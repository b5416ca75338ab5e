//! What happens between the torque that is reported and the link: motors, gears, and the effects in joints.
//!
//! Laws come from the library's formulas where they are smooth. Dry friction is set-valued here (a joint can stick), not
//! the library's smoothed sign: it goes into the contact problem. Where a spring or play lies between motor and joint, the
//! motor turns on its own and friction, rotor and ripple are on its side (4.26), (4.31).
use super::actuator::{Actuator, Given};
use super::ground::JointLaw;
use super::motors::MotorLaw;
use super::plant::Plant;
use super::resistance::{Resistance, Smooth, Variables};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{self, Effect, Law, Location, Simulation};
use std::collections::VecDeque;

/// Dry friction of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Dry {
    /// Against positive and against negative motion, N m.
    Constant([f64; 2]),
    /// Larger near rest.
    Stribeck { coulomb: f64, at_rest: f64, speed: f64 },
    /// A part of the torque that the gear transmits.
    Load(f64),
}

/// The true torque from the reported one: `gain · reported + offset`, between two limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reading {
    pub gain: f64,
    /// N m
    pub offset: f64,
    /// N m
    pub limits: [f64; 2],
}

impl Reading {
    const TRUE: Self = Self { gain: 1.0, offset: 0.0, limits: [f64::NEG_INFINITY, f64::INFINITY] };

    /// The true torque.
    pub fn torque(&self, reported: f64) -> f64 {
        (self.gain * reported + self.offset).max(self.limits[0]).min(self.limits[1])
    }

    /// What a sensor on the link's side reports of a torque: limits are those of the motor.
    fn reported(&self, torque: f64) -> f64 {
        (torque - self.offset) / self.gain
    }

    /// Then through a further effect.
    fn then(self, effect: &Effect) -> Self {
        let value = |name: &str| effect.value(name);
        match effect.kind.simulation {
            Simulation::Gain(name) => {
                let gain = value(name);
                let limits = self.limits.map(|limit| limit * gain);
                Self { gain: self.gain * gain, offset: self.offset * gain, limits }
            }
            Simulation::Bias(name) => {
                let bias = value(name);
                let limits = self.limits.map(|limit| limit - bias);
                Self { offset: self.offset - bias, limits, ..self }
            }
            Simulation::Limit(name) => {
                let most = value(name);
                Self { limits: self.limits.map(|limit| limit.clamp(-most, most)), ..self }
            }
            // `Drive::add` keeps no others as readings.
            _ => self,
        }
    }
}

/// Everything at one joint.
#[derive(Debug, Clone)]
struct Drive {
    actuator: Option<Actuator>,
    /// Index among the motors that turn on their own.
    motor: Option<usize>,
    rotor_inertia: f64,
    damping: f64,
    dry: Vec<Dry>,
    smooth: Vec<Smooth>,
    /// Of effects, in the order of the file.
    readings: Vec<Effect>,
    reading: Reading,
    /// 1/stiffness of springs in series, rad/(N m).
    yielding: f64,
    spring_damping: f64,
    gap: f64,
    /// Whole steps and the rest of one.
    delay: (usize, f64),
    /// Reported torques of the last steps, the latest first.
    past: VecDeque<f64>,
    encoder_offset: f64,
}

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
    joints: Vec<Drive>,
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
        let at = |j: usize| Drive::new(actuators.get(j).copied().flatten());
        let mut joints: Vec<Drive> = (0..plant.subject.joints.len()).map(at).collect();
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
        for (drive, joint) in joints.iter_mut().zip(&plant.subject.joints) {
            drive.reading = drive.readings.iter().rev().fold(Reading::TRUE, Reading::then);
            drive.past = VecDeque::from(vec![0.0; drive.delay.0 + 2]);
            if drive.yielding > 0.0 || drive.gap > 0.0 {
                drive.has_inertia(&joint.name)?;
                drive.motor = Some(motors);
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
        let law = |(drive, limits): (&Drive, &Option<[f64; 2]>)| {
            let passive = drive.actuator.and_then(|actuator| actuator.passive).unwrap_or_default();
            let limits = limits.filter(|_| stops);
            match drive.motor {
                Some(_) => JointLaw { limits, damping: passive[1], ..JointLaw::default() },
                None => JointLaw {
                    rotor_inertia: drive.rotor_inertia,
                    damping: drive.damping + passive[1],
                    limits,
                    ..JointLaw::default()
                },
            }
        };
        self.joints.iter().zip(&plant.position_limits).map(law).collect()
    }

    /// Laws of the motors that turn on their own.
    pub fn motors(&self) -> Vec<MotorLaw> {
        let own = self.joints.iter().enumerate().filter(|(_, drive)| drive.motor.is_some());
        own.map(|(joint, drive)| MotorLaw {
            joint,
            inertia: drive.rotor_inertia,
            damping: drive.damping,
            dry: [0.0; 2],
            stiffness: if drive.yielding > 0.0 { 1.0 / drive.yielding } else { f64::INFINITY },
            spring_damping: drive.spring_damping,
            gap: drive.gap,
        })
        .collect()
    }

    /// Viscous friction and inertia of the rotor, without what changes from step to step.
    pub fn constant(&self, joint: usize) -> (f64, f64) {
        let drive = &self.joints[joint];
        (drive.damping, drive.rotor_inertia)
    }

    /// What the motor gives when this is asked for, late by the delay.
    pub fn give(&mut self, joint: usize, asked: f64, speed: f64) -> (Given, f64) {
        let drive = &mut self.joints[joint];
        let given = match &drive.actuator {
            Some(actuator) => actuator.give(asked, speed),
            None => Given { torque: asked, ..Given::default() },
        };
        drive.past.pop_back();
        drive.past.push_front(given.torque);
        let (steps, part) = drive.delay;
        let late = (1.0 - part) * drive.past[steps] + part * drive.past[steps + 1];
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
        let drive = &mut self.joints[joint];
        let split = drive.motor.is_some();
        let mut sum = Resistance::default();
        for smooth in drive.smooth.iter_mut().filter(|smooth| (smooth.on_motor && split) == motor) {
            let other = smooth.other.map_or([0.0; 2], state);
            let one = smooth.at(&Variables { other, ..own });
            sum.value += one.value;
            sum.velocity += one.velocity;
            sum.acceleration += one.acceleration;
        }
        if let Some([stiffness, _]) = drive.actuator.and_then(|actuator| actuator.passive).filter(|_| !motor)
        {
            sum.value += stiffness * own.own[0];
        }
        sum
    }

    /// Largest dry friction against positive and against negative motion at this speed, with this torque on the link.
    pub fn dry(&self, joint: usize, velocity: f64, load: f64) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for dry in &self.joints[joint].dry {
            let limits = match *dry {
                Dry::Constant(limits) => limits,
                Dry::Stribeck { coulomb, at_rest, speed } => {
                    let x = velocity / speed;
                    [coulomb + (at_rest - coulomb) * (-x * x).exp(); 2]
                }
                Dry::Load(part) => [part * load.abs(); 2],
            };
            sum = [sum[0] + limits[0], sum[1] + limits[1]];
        }
        sum
    }

    /// Whether the torque acts later than it is asked for.
    pub fn is_late(&self, joint: usize) -> bool {
        self.joints[joint].delay != (0, 0.0)
    }
}

impl Drive {
    fn new(actuator: Option<Actuator>) -> Self {
        let mut drive = Self {
            actuator,
            motor: None,
            rotor_inertia: 0.0,
            damping: 0.0,
            dry: Vec::new(),
            smooth: Vec::new(),
            readings: Vec::new(),
            reading: Reading::TRUE,
            yielding: 0.0,
            spring_damping: 0.0,
            gap: 0.0,
            delay: (0, 0.0),
            past: VecDeque::new(),
            encoder_offset: 0.0,
        };
        if let Some(actuator) = actuator.filter(|actuator| actuator.passive.is_none()) {
            let turns = actuator.turns.abs();
            drive.rotor_inertia = actuator.rotor_inertia * turns * turns;
            drive.damping = actuator.viscous_friction * turns * turns;
            if actuator.coulomb_friction > 0.0 {
                drive.dry.push(Dry::Constant([actuator.coulomb_friction * turns; 2]));
            }
            drive.yielding = actuator.stiffness.recip();
            drive.spring_damping = actuator.spring_damping;
            drive.gap = actuator.gap;
        }
        drive
    }

    fn add(&mut self, effect: &Effect, other: Option<usize>, step: f64) -> Result<(), Diagnostic> {
        let value = |name: &str| effect.value(name);
        match effect.kind.simulation {
            Simulation::Damping(name) => self.damping += value(name),
            Simulation::Inertia(name) => self.rotor_inertia += value(name),
            Simulation::Dry(law) => self.dry.push(dry(law, effect)),
            Simulation::Gain(_) | Simulation::Bias(_) | Simulation::Limit(_) => {
                self.readings.push(effect.clone());
            }
            Simulation::Formula | Simulation::MotorFormula | Simulation::Coupling { .. } => {
                self.smooth.push(Smooth::new(effect, other)?);
            }
            Simulation::Law => self.add_by_law(effect, step)?,
        }
        Ok(())
    }

    /// What is neither a torque nor its reading.
    fn add_by_law(&mut self, effect: &Effect, step: f64) -> Result<(), Diagnostic> {
        let value = |name: &str| effect.value(name);
        match effect.kind.law {
            Law::SeriesElasticity => self.yielding += value("stiffness").recip(),
            Law::Backlash => self.gap += value("gap"),
            Law::EncoderOffset => self.encoder_offset += value("offset"),
            Law::Delay => {
                let steps = self.delay.0 as f64 + self.delay.1 + value("delay") / step;
                if !(0.0..1e7).contains(&steps) {
                    return Err(Diagnostic::error(format!(
                        "an actuator delay of {} s cannot be simulated",
                        value("delay")
                    ))
                    .help("delays are not negative and not longer than the run"));
                }
                self.delay = (steps.floor() as usize, steps.fract());
            }
            _ => {
                return Err(Diagnostic::error(format!("`{effect}` cannot be simulated at a joint"))
                    .help("take it out of the description or the scenario"));
            }
        }
        Ok(())
    }

    /// Limits of the motor's torque alone.
    fn limits(&self) -> [f64; 2] {
        let most =
            self.readings.iter().filter(|effect| matches!(effect.kind.simulation, Simulation::Limit(_)));
        let most = most.map(|effect| effect.value("limit")).fold(f64::INFINITY, f64::min);
        [-most, most]
    }

    /// A motor that turns on its own needs an inertia.
    fn has_inertia(&self, joint: &str) -> Result<(), Diagnostic> {
        if self.rotor_inertia > 0.0 {
            return Ok(());
        }
        Err(Diagnostic::error(format!(
            "`{joint}` has a spring or play behind its motor, but nothing says the motor's inertia"
        ))
        .help(format!(
            "add an [[effect]] `rotor_inertia` at `{joint}` (kg m² at the joint: rotor times gear ratio squared, 0.01 to 0.1 for a leg), or [motor.{joint}] with `rotor_inertia` and `gear_ratio`"
        )))
    }
}

/// The set-valued law of an effect.
fn dry(law: effect::Dry, effect: &Effect) -> Dry {
    match law {
        effect::Dry::Constant { positive, negative } => {
            Dry::Constant([effect.value(positive), effect.value(negative)])
        }
        effect::Dry::Stribeck { coulomb, at_rest, speed } => Dry::Stribeck {
            coulomb: effect.value(coulomb),
            at_rest: effect.value(at_rest),
            speed: effect.value(speed),
        },
        effect::Dry::Load(coefficient) => Dry::Load(effect.value(coefficient)),
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
