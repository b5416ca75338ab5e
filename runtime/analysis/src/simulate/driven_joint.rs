//! One joint as it is driven: its motor and drive, and the effects at it.
use super::actuator::Actuator;
use super::resistance::Smooth;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{self, Effect, Law, Simulation};
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
    pub const TRUE: Self = Self { gain: 1.0, offset: 0.0, limits: [f64::NEG_INFINITY, f64::INFINITY] };

    /// The true torque.
    pub fn torque(&self, reported: f64) -> f64 {
        (self.gain * reported + self.offset).max(self.limits[0]).min(self.limits[1])
    }

    /// What a sensor on the link's side reports of a torque: limits are those of the motor.
    pub fn reported(&self, torque: f64) -> f64 {
        (torque - self.offset) / self.gain
    }

    /// Then through a further effect.
    pub fn then(self, effect: &Effect) -> Self {
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
            // `DrivenJoint::add` keeps no others as readings.
            _ => self,
        }
    }
}

/// Everything at one joint.
#[derive(Debug, Clone)]
pub(super) struct DrivenJoint {
    pub actuator: Option<Actuator>,
    /// Index among the motors that turn on their own.
    pub motor: Option<usize>,
    /// kg m² at the joint.
    pub rotor_inertia: f64,
    /// N m s/rad at the joint.
    pub damping: f64,
    dry: Vec<Dry>,
    pub smooth: Vec<Smooth>,
    /// Of effects, in the order of the file.
    pub readings: Vec<Effect>,
    pub reading: Reading,
    /// 1/stiffness of springs in series, rad/(N m).
    pub yielding: f64,
    /// Beside them, N m s/rad.
    pub spring_damping: f64,
    /// Play from stop to stop, rad.
    pub gap: f64,
    /// Whole steps and the rest of one.
    pub delay: (usize, f64),
    /// Reported torques of the last steps, the latest first.
    pub past: VecDeque<f64>,
    /// rad
    pub encoder_offset: f64,
}

impl DrivenJoint {
    /// Without effects.
    pub fn new(actuator: Option<Actuator>) -> Self {
        let mut driven = Self {
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
        if let Some(actuator) = actuator.filter(|actuator| actuator.drive.has_motor()) {
            driven.rotor_inertia = actuator.drive.rotor_inertia_at_joint();
            driven.damping = actuator.drive.viscous_friction_at_joint();
            if actuator.drive.coulomb_friction > 0.0 {
                driven.dry.push(Dry::Constant([actuator.drive.coulomb_friction_at_joint(); 2]));
            }
            driven.yielding = actuator.series_stiffness().recip();
            driven.spring_damping = actuator.spring_damping;
            driven.gap = actuator.gap;
        }
        driven
    }

    /// Spring and damper of a joint without a motor.
    pub fn passive(&self) -> Option<[f64; 2]> {
        self.actuator.and_then(|actuator| actuator.drive.passive())
    }

    /// Adds an effect at this joint; `other`: the joint that it comes from, if any; `step` of the simulation, s.
    pub fn add(&mut self, effect: &Effect, other: Option<usize>, step: f64) -> Result<(), Diagnostic> {
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
                    .help("it is no longer than the run, and not negative: logs of simulations report torques when they act"));
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

    /// Largest dry friction against positive and against negative motion at this speed, with this torque on the link, N m.
    pub fn dry_limits(&self, velocity: f64, load: f64) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for dry in &self.dry {
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

    /// Limits of the motor's torque alone.
    pub fn limits(&self) -> [f64; 2] {
        let most =
            self.readings.iter().filter(|effect| matches!(effect.kind.simulation, Simulation::Limit(_)));
        let most = most.map(|effect| effect.value("limit")).fold(f64::INFINITY, f64::min);
        [-most, most]
    }

    /// A motor that turns on its own needs an inertia.
    pub fn has_inertia(&self, joint: &str) -> Result<(), Diagnostic> {
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
