//! What a case hides.
use bipedc_effects::effect::{Effect, Location};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What the robot does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Experiment {
    /// The torso is bolted to a stand, the joints follow sums of sines.
    Hanging,
    /// Sway on both feet, then a step in the air with one of them.
    Swaying,
    /// Averages over static postures on flat feet.
    Postures,
    /// Velocities just before and after impacts of the right foot.
    Impacts,
    /// The same in space, where the foot strikes flat and turns.
    FlatImpacts,
}

/// Why the case is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// One effect.
    Single,
    /// Two effects.
    Pair,
    /// None.
    Clean,
    /// Errors of the inertias alone.
    Cad,
    /// Errors of the inertias and one effect.
    CadAndEffect,
    /// A cause that the library does not have.
    Outside,
}

/// One hidden effect before its numbers are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Name of the kind; of an outsider: see `outside.rs`.
    pub kind: &'static str,
    /// Where.
    pub place: Location,
}

/// A case before its numbers are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Unique.
    pub name: String,
    /// What the random numbers follow from: the name, and a number that makes other cases of the same kinds.
    pub seed: String,
    /// Why it is there.
    pub group: Group,
    /// Folder of the robot.
    pub robot: &'static str,
    /// Lengths beside those of a robot of a metre.
    pub size: f64,
    /// What the robot does.
    pub experiment: Experiment,
    /// What is hidden.
    pub parts: Vec<Part>,
    /// Samples per second.
    pub rate: f64,
    /// Counts of the encoders per turn of the joint.
    pub counts: f64,
    /// Whether the log has velocities: late and noisy ones.
    pub velocities: bool,
    /// Whether all encoders sit on the motors, none on a link.
    pub motor_side: bool,
    /// Whether the joints stop again and again, under soft control: dry ones stick.
    pub rests: bool,
    /// Joints that move, by name, all others being held; empty: all.
    pub moving: &'static [&'static str],
}

impl Plan {
    /// The robot's description: one of `robots/`, or one that is only there to be scored.
    pub fn folder(&self, root: &Path) -> PathBuf {
        let shipped = root.join("robots").join(self.robot);
        if shipped.exists() { shipped } else { root.join("examples/hidden_effects/robots").join(self.robot) }
    }
}

/// How large a joint's signals are without the effects, root mean squares.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Scales {
    /// rad, about the mean.
    pub position: f64,
    /// rad
    pub mean_position: f64,
    /// rad/s
    pub velocity: f64,
    /// rad/s²
    pub acceleration: f64,
    /// N m
    pub torque: f64,
    /// Largest torque, N m.
    pub peak_torque: f64,
}

impl Scales {
    /// Of a joint's positions, velocities, accelerations and torques.
    pub fn of([q, v, a, u]: [&[f64]; 4]) -> Self {
        let rms =
            |values: &[f64]| (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt();
        let mean_position = q.iter().sum::<f64>() / q.len().max(1) as f64;
        let about: Vec<f64> = q.iter().map(|q| q - mean_position).collect();
        Self {
            position: rms(&about),
            mean_position,
            velocity: rms(v),
            acceleration: rms(a),
            torque: rms(u),
            peak_torque: u.iter().fold(0.0, |m: f64, u| m.max(u.abs())),
        }
    }
}

/// Another explanation that no data of this kind could tell from the truth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Alternative {
    /// It.
    pub effects: Vec<Effect>,
    /// Why it is the same.
    pub reason: String,
}

/// What a case hides, with numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Of the case.
    pub name: String,
    /// Why it is there.
    pub group: Group,
    /// Folder of the robot.
    pub robot: String,
    /// What the robot does.
    pub experiment: Experiment,
    /// Effects of the library.
    pub effects: Vec<Effect>,
    /// Exactly equivalent explanations, with reasons.
    pub alternatives: Vec<Alternative>,
    /// Small true effects that come along; finding them is no error, nor is missing them.
    pub also_present: Vec<Effect>,
    /// Causes that the library does not have.
    pub outsiders: Vec<Effect>,
    /// Whether the inertias are off.
    pub cad_errors: bool,
    /// Samples per second; 0 in tables.
    pub rate_hz: f64,
    /// Standard deviation of the noise by channel.
    pub noise: BTreeMap<String, f64>,
    /// What the nominal model misses, root mean square without sensor errors, by channel.
    pub size: BTreeMap<String, f64>,
    /// Signals of the joints without the effects.
    pub scales: BTreeMap<String, Scales>,
    /// Error of the nominal model and of the model with the true effects on the validation data, same unit.
    pub nominal: f64,
    /// See `nominal`.
    pub oracle: f64,
    /// Which kind of channel the two are about, as in the diagnosis' `rms`.
    pub metric: String,
}

impl Truth {
    /// Nothing known yet.
    pub fn new(plan: &Plan) -> Self {
        let cad = matches!(plan.group, Group::Cad | Group::CadAndEffect);
        Self {
            name: plan.name.clone(),
            group: plan.group,
            robot: plan.robot.to_owned(),
            experiment: plan.experiment,
            effects: Vec::new(),
            alternatives: Vec::new(),
            also_present: Vec::new(),
            outsiders: Vec::new(),
            cad_errors: cad,
            rate_hz: plan.rate,
            noise: BTreeMap::new(),
            size: BTreeMap::new(),
            scales: BTreeMap::new(),
            nominal: 0.0,
            oracle: 0.0,
            metric: String::new(),
        }
    }

    /// Everything that acts on the robot.
    pub fn acting(&self) -> Vec<Effect> {
        self.effects.iter().chain(&self.also_present).chain(&self.outsiders).cloned().collect()
    }
}
