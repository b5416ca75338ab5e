//! What a list of effects changes: world, masses, force sensors, level of the model.
use super::foot::SIGNALS;
use super::soles::Soil;
use super::{ContactExperiment, World};
use crate::experiments::motion::Hidden;
use crate::experiments::postures::is_clipped;
use crate::robot::InertialParameters;
use crate::robot::Robot;
use crate::robot::feet::Sole;
use crate::robot::world::is_meant;
use bipedc_effects::effect::{Effect, Law};
use nalgebra::Vector3;

/// Readings within this part of a limit count as clipped; readings above it by ten times as much contradict it.
const CLIPPED: f64 = 1e-3;

/// Which assumptions of thesis 4.2 hold.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Level {
    pub point_feet: bool,
    pub no_impact: bool,
    pub single_mass: bool,
    pub decoupled_planes: bool,
}

impl Level {
    pub fn is_simpler(self) -> bool {
        self != Self::default()
    }
}

/// What a reading has to be corrected by.
#[derive(Debug, Clone, Copy)]
enum Fault {
    Gain(f64),
    /// N, world axes.
    Bias(Vector3<f64>),
}

/// All that effects change.
#[derive(Debug, Clone)]
pub(super) struct Change {
    pub world: World,
    pub parameters: InertialParameters,
    pub level: Level,
    pub soil: Option<Soil>,
    faults: Vec<(Option<String>, Fault)>,
    /// Places and limits of saturated sensors.
    pub limits: Vec<(Option<String>, f64)>,
    /// Links that move behind their motors.
    pub behind: Vec<Hidden>,
}

impl Change {
    pub fn of(effects: &[Effect], robot: &Robot<'_>) -> Self {
        let mut change = Self {
            world: World::of(effects, robot.layout),
            parameters: robot.link_inertias.change(effects),
            level: Level::default(),
            soil: None,
            faults: Vec::new(),
            limits: Vec::new(),
            behind: Vec::new(),
        };
        for effect in effects {
            let place = || effect.location.sensor.clone();
            match effect.kind.law {
                Law::ForceSensorGain => change.faults.push((place(), Fault::Gain(effect.value("gain")))),
                Law::ForceSensorBias => {
                    let bias = ["x", "y", "z"].map(|axis| effect.value(axis));
                    change.faults.push((place(), Fault::Bias(Vector3::from(bias))));
                }
                Law::ForceSensorSaturation => change.limits.push((place(), effect.value("limit"))),
                Law::GroundCompliance => {
                    let [stiffness, damping] = ["stiffness", "damping"].map(|name| effect.value(name));
                    // No stiffness would be no ground.
                    change.soil = (stiffness > 0.0).then_some(Soil { stiffness, damping });
                }
                Law::PointFeet => change.level.point_feet = true,
                Law::NoImpact => change.level.no_impact = true,
                Law::SingleMass => change.level.single_mass = true,
                Law::DecoupledPlanes => change.level.decoupled_planes = true,
                // In the world and in the bodies, above; or nothing here, see `spares_contact`.
                _ => {}
            }
        }
        change
    }

    /// The same with links behind their motors.
    pub fn with_links(self, behind: Vec<Hidden>) -> Self {
        Self { behind, ..self }
    }
}

/// Whether an effect shows in no wrench and no sole, whatever its size: it acts on torques, or on what happens at impacts. Springs and play
/// do where the motor's angle alone is measured, see [`Change::behind`].
pub(super) fn spares_contact(effect: &Effect) -> bool {
    match effect.kind.law {
        Law::Torque(_)
        | Law::Formula
        | Law::Reading(_)
        | Law::TrueTorque(_)
        | Law::Delay
        | Law::SeriesElasticity
        | Law::Backlash
        | Law::Restitution
        | Law::Slip
        | Law::SpinFriction => true,
        Law::EncoderOffset
        | Law::GravityTilt
        | Law::GroundSlope
        | Law::Payload
        | Law::CenterOfMassOffset
        | Law::InertiaError
        | Law::InertialCorrection
        | Law::ForceSensorGain
        | Law::ForceSensorBias
        | Law::ForceSensorSaturation
        | Law::GroundCompliance
        | Law::PointFeet
        | Law::NoImpact
        | Law::SingleMass
        | Law::DecoupledPlanes => false,
    }
}

impl ContactExperiment<'_> {
    /// Foot, sensor (0: the whole foot, 1…: its corners) and name of all force sensors.
    pub(super) fn sensors(&self) -> Vec<(usize, usize, String)> {
        let mut out = Vec::new();
        for (f, (foot, record)) in self.robot.feet.iter().zip(&self.recording.feet).enumerate() {
            if record.is_logged && !record.from_corners {
                out.push((f, 0, foot.name.clone()));
            }
            let corners = foot.corners.iter().take(record.corners.len()).enumerate();
            out.extend(corners.map(|(k, corner)| (f, k + 1, format!("{}/{}", foot.name, corner.name))));
        }
        out
    }

    /// The limit at which a sensor seems to stay.
    pub(super) fn clipped(&self, foot: usize, sensor: usize) -> Option<f64> {
        is_clipped(self.recording.feet[foot].peaks.get(sensor)?)
    }

    /// Places where a force of unknown size is missing at a sample, in the sole frame of a foot.
    pub(super) fn missing_forces(&self, sample: usize, change: &Change) -> Vec<(usize, Vector3<f64>)> {
        let mut out = Vec::new();
        for (place, limit) in &change.limits {
            for (f, sensor, name) in self.sensors() {
                let meant = place.as_deref().is_none_or(|p| p == name);
                let peaks = &self.recording.feet[f].peaks[sensor];
                let contradicted = peaks.iter().any(|p| *p > limit * (1.0 + 10.0 * CLIPPED));
                if !meant || contradicted || peaks[sample] < limit * (1.0 - CLIPPED) {
                    continue;
                }
                let foot = &self.robot.feet[f];
                let signals = &self.recording.feet[f].signals[sample];
                let at = match sensor {
                    0 => Vector3::new(signals[12], signals[13], 0.0),
                    corner => foot.corner(corner - 1),
                };
                out.push((f, at));
            }
        }
        out
    }

    /// The signals of a foot as they would be without the sensors' faults.
    pub(super) fn true_signals(
        &self,
        foot: usize,
        sample: usize,
        sole: &Sole,
        change: &Change,
    ) -> [f64; SIGNALS] {
        let record = &self.recording.feet[foot];
        let mut signals = record.signals[sample];
        let name = &self.robot.feet[foot].name;
        let mut corners: Vec<f64> = record.corners.iter().map(|c| c[sample]).collect();
        for (place, fault) in &change.faults {
            let place = place.as_deref();
            if !record.from_corners && is_meant(place, name, None) {
                whole(&mut signals, *fault, sole, (record.in_sole(), record.has_moment()));
                continue;
            }
            let all = record.from_corners;
            for (force, corner) in corners.iter_mut().zip(&self.robot.feet[foot].corners) {
                if is_meant(place, name, Some(&corner.name)) && (all || place.is_some_and(|p| p != name)) {
                    match fault {
                        Fault::Gain(gain) => *force /= gain,
                        Fault::Bias(bias) => *force -= bias.z,
                    }
                }
            }
        }
        for (k, force) in corners.iter().enumerate() {
            let more = force - record.corners[k][sample];
            if more != 0.0 {
                self.add_normal(&mut signals, foot, sole, &self.robot.feet[foot].corner(k), more);
            }
        }
        signals
    }

    /// Adds a force along the sole's normal at a point of the sole frame.
    fn add_normal(
        &self,
        signals: &mut [f64; SIGNALS],
        foot: usize,
        sole: &Sole,
        at: &Vector3<f64>,
        force: f64,
    ) {
        let mut vector = Vector3::z() * force;
        let mut moment = at.cross(&vector);
        if !self.recording.feet[foot].in_sole() {
            (vector, moment) = (sole.rotation * vector, sole.rotation * moment);
        }
        for k in 0..3 {
            signals[k] += vector[k];
            signals[9 + k] += moment[k];
        }
    }
}

/// Undoes a fault of a sensor of the whole foot.
fn whole(signals: &mut [f64; SIGNALS], fault: Fault, sole: &Sole, (in_sole, has_moment): (bool, bool)) {
    match fault {
        // All but the centre of pressure.
        Fault::Gain(gain) => signals[..12].iter_mut().for_each(|s| *s /= gain),
        Fault::Bias(bias) => {
            let bias = if in_sole { sole.rotation.transpose() * bias } else { bias };
            for k in 0..3 {
                signals[k] -= bias[k];
                // A logged moment has nothing of it; one that is made of the force and its place has.
                if has_moment {
                    continue;
                }
                signals[3 + k] -= signals[12] * bias[k];
                signals[6 + k] -= signals[13] * bias[k];
            }
        }
    }
}
