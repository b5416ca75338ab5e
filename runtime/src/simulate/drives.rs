//! Effects in joints: what happens between the torque that is reported and the link.
//!
//! Laws come from the library's formulas where they are smooth. Dry friction is set-valued here (a joint can stick), not
//! the library's smoothed sign: it goes into the contact problem.
use super::ground::JointLaw;
use super::plant::Plant;
use crate::diagnostic::Diagnostic;
use crate::effect::formula::{Bound, Formula};
use crate::effect::{Effect, Law, VARIABLES};
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

/// What a reported torque is, seen from the true one.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Reading {
    Gain(f64),
    Bias(f64),
    Limit(f64),
}

/// A smooth law: its formula and its values (variables, then parameters).
#[derive(Debug, Clone)]
struct Smooth {
    law: Bound,
    values: Vec<f64>,
    other: Option<usize>,
}

/// Everything at one joint.
#[derive(Debug, Clone, Default)]
struct Drive {
    rotor_inertia: f64,
    damping: f64,
    dry: Vec<Dry>,
    smooth: Vec<Smooth>,
    readings: Vec<Reading>,
    /// Whole steps and the rest of one.
    delay: (usize, f64),
    /// Reported torques of the last steps, the latest first.
    past: VecDeque<f64>,
    encoder_offset: f64,
}

/// The drives of all joints.
#[derive(Debug, Clone)]
pub(super) struct Drives {
    joints: Vec<Drive>,
    work: Vec<f64>,
}

impl Drives {
    /// From the effects at joints; others are passed over.
    pub fn new(plant: &Plant, effects: &[&Effect], step: f64) -> Result<Self, Diagnostic> {
        let mut joints = vec![Drive::default(); plant.subject.joints.len()];
        for effect in effects {
            let Some(name) = &effect.location.joint else { continue };
            let find = |name: &str| {
                plant.joint(name).ok_or_else(|| Diagnostic::error(format!("the robot has no joint `{name}`")))
            };
            let other = effect.location.other_joint.as_deref().map(find).transpose()?;
            joints[find(name)?].add(effect, other, step)?;
        }
        for drive in &mut joints {
            drive.past = VecDeque::from(vec![0.0; drive.delay.0 + 2]);
        }
        Ok(Self { joints, work: Vec::with_capacity(64) })
    }

    /// Where joint encoders read more than the truth, rad.
    pub fn encoder_offset(&self, joint: usize) -> f64 {
        self.joints[joint].encoder_offset
    }

    /// Laws that do not change, with the stops of the plant if wanted.
    pub fn laws(&self, plant: &Plant, stops: bool) -> Vec<JointLaw> {
        let law = |(drive, limits): (&Drive, &Option<[f64; 2]>)| JointLaw {
            rotor_inertia: drive.rotor_inertia,
            damping: drive.damping,
            limits: limits.filter(|_| stops),
            ..JointLaw::default()
        };
        self.joints.iter().zip(&plant.position_limits).map(law).collect()
    }

    /// The true torque of the next step when `reported` is asked for.
    pub fn transmit(&mut self, joint: usize, reported: f64) -> f64 {
        let drive = &mut self.joints[joint];
        drive.past.pop_back();
        drive.past.push_front(reported);
        let (steps, part) = drive.delay;
        let mut torque = (1.0 - part) * drive.past[steps] + part * drive.past[steps + 1];
        // The last effect of the file is the last that the true torque passed on its way to the report.
        for reading in drive.readings.iter().rev() {
            torque = match *reading {
                Reading::Gain(gain) => torque * gain,
                Reading::Bias(bias) => torque - bias,
                Reading::Limit(limit) => torque.clamp(-limit, limit),
            };
        }
        torque
    }

    /// Torque of the smooth laws at a joint, as added to the inverse dynamics; `q`, `v` of all joints.
    pub fn resistance(&mut self, joint: usize, q: &[f64], v: &[f64]) -> f64 {
        let mut sum = 0.0;
        for smooth in &mut self.joints[joint].smooth {
            smooth.values[0] = q[joint];
            smooth.values[1] = v[joint];
            if let Some(other) = smooth.other {
                smooth.values[4] = q[other];
                smooth.values[5] = v[other];
            }
            sum += smooth.law.run(&smooth.values, &mut self.work);
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
}

impl Drive {
    fn add(&mut self, effect: &Effect, other: Option<usize>, step: f64) -> Result<(), Diagnostic> {
        let value = |name: &str| effect.value(name);
        match effect.kind.as_str() {
            "viscous_friction" => self.damping += value("damping"),
            "coulomb_friction" => self.dry.push(Dry::Constant([value("torque"); 2])),
            "asymmetric_coulomb_friction" => {
                self.dry.push(Dry::Constant([value("positive"), value("negative")]));
            }
            "stribeck_friction" => self.dry.push(Dry::Stribeck {
                coulomb: value("coulomb"),
                at_rest: value("static"),
                speed: value("stribeck_velocity"),
            }),
            "load_dependent_friction" => self.dry.push(Dry::Load(value("coefficient"))),
            "rotor_inertia" => self.rotor_inertia += value("inertia"),
            "torque_gain" => self.readings.push(Reading::Gain(value("gain"))),
            "torque_bias" => self.readings.push(Reading::Bias(value("bias"))),
            "torque_saturation" => self.readings.push(Reading::Limit(value("limit"))),
            "actuator_delay" => {
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
            "encoder_offset" => self.encoder_offset += value("offset"),
            _ => self.smooth.push(Smooth::new(effect, other)?),
        }
        Ok(())
    }
}

impl Smooth {
    fn new(effect: &Effect, other: Option<usize>) -> Result<Self, Diagnostic> {
        let refuse = |why: &str| {
            Err(Diagnostic::error(format!("`{}` cannot be simulated: {why}", effect.kind))
                .help("take it out of the description or the scenario"))
        };
        let Some(kind) = effect.definition() else { return refuse("it is unknown") };
        let Law::Torque(text) = kind.law else {
            return refuse("joints have no motors of their own here");
        };
        if kind.name == "coupling" && effect.value("inertia") != 0.0 {
            return refuse("its inertia makes the mass matrix unsymmetric");
        }
        let Ok(formula) = Formula::parse(text) else { return refuse("its formula does not read") };
        let names: Vec<&str> =
            VARIABLES.iter().copied().chain(kind.parameters.iter().map(|p| p.name)).collect();
        let Ok(law) = formula.bind(&names) else { return refuse("its formula has unknown names") };
        let mut values = vec![0.0; VARIABLES.len()];
        values.extend(kind.parameters.iter().map(|parameter| effect.value(parameter.name)));
        Ok(Self { law, values, other })
    }
}
