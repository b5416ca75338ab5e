//! The scenario file as TOML has it, before anything is checked.
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

pub(super) type Number = Spanned<f64>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub duration: Option<Number>,
    pub step: Option<Number>,
    pub log_step: Option<Number>,
    pub method: Option<Spanned<String>>,
    #[serde(default)]
    pub seed: u64,
    pub residual: Option<Number>,
    pub initial: Option<Spanned<Start>>,
    pub control: Option<Control>,
    #[serde(default)]
    pub joint: BTreeMap<String, Spanned<Joint>>,
    pub ground: Option<Spanned<Soil>>,
    pub sensors: Option<Senses>,
    pub drives: Option<Spanned<String>>,
    #[serde(default)]
    pub motor: BTreeMap<String, Spanned<Motor>>,
    pub imu: Option<Spanned<Inertial>>,
    #[serde(default)]
    pub effect: Vec<Spanned<BTreeMap<String, Spanned<toml::Value>>>>,
    pub steps: Option<Spanned<u32>>,
    pub relative_tolerance: Option<Number>,
    pub assumptions: Option<Spanned<Checks>>,
    pub gravity: Option<Number>,
    pub slope: Option<Number>,
    #[serde(default)]
    pub push: Vec<Spanned<Push>>,
    pub footholds: Option<Spanned<Vec<f64>>>,
    #[serde(default)]
    pub payload: Vec<Spanned<PutOn>>,
    pub walking: Option<Spanned<Walking>>,
}

/// A robot that walks by footsteps.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Walking {
    pub velocity: Vec<Spanned<Speed>>,
    pub settings: Option<Spanned<String>>,
    pub model: Option<Spanned<String>>,
    pub state: Option<Spanned<String>>,
    pub learn_payload: Option<bool>,
    pub delay: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Speed {
    pub time: Number,
    pub forward: Option<Number>,
    pub left: Option<Number>,
    pub turning: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Push {
    pub time: Number,
    pub duration: Option<Number>,
    pub impulse: Number,
    pub direction: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PutOn {
    pub time: Number,
    pub mass: Number,
    pub position: Option<Spanned<Vec<f64>>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Start {
    pub base_position: Option<Spanned<Vec<f64>>>,
    pub base_rotation: Option<Spanned<Vec<f64>>>,
    pub base_velocity: Option<Spanned<Vec<f64>>>,
    pub base_angular_velocity: Option<Spanned<Vec<f64>>>,
    pub clearance: Option<Number>,
    pub phase: Option<Spanned<String>>,
    pub mid_stance_speed: Option<Number>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Control {
    pub gait: Option<Spanned<String>>,
    pub model: Option<Spanned<String>>,
    pub stiffness: Option<Number>,
    pub damping: Option<Number>,
    pub effort_limits: Option<bool>,
    pub joint_stops: Option<bool>,
    pub trajectory: Option<Spanned<String>>,
    pub feedback: Option<Spanned<Law>>,
    pub parameters: BTreeMap<String, Number>,
    pub quantities: BTreeMap<String, Spanned<String>>,
    pub output: Vec<Spanned<Output>>,
    pub servo: Option<Spanned<String>>,
    pub speeds: Option<Spanned<toml::Value>>,
    pub choice: Option<Spanned<Choice>>,
}

/// What may be chosen for each step of a gait.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Choice {
    pub parameters: BTreeMap<String, Spanned<toml::Value>>,
    pub keep: Option<Vec<Spanned<String>>>,
    pub friction: Option<Number>,
    pub reserve: Option<Number>,
    pub values: Option<Spanned<i64>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Joint {
    pub position: Option<Number>,
    pub velocity: Option<Number>,
    pub stiffness: Option<Number>,
    pub damping: Option<Number>,
    pub reference: Option<Number>,
    pub sines: Option<Spanned<Vec<[f64; 3]>>>,
    pub points: Option<Spanned<Vec<[f64; 2]>>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Soil {
    pub friction: Option<Number>,
    pub restitution: Option<Number>,
    pub tangential_restitution: Option<Number>,
    pub cone: Option<Spanned<String>>,
    pub stiffness: Option<Number>,
    pub damping: Option<Number>,
    pub recovery: Option<Number>,
    pub shapes: Option<Spanned<toml::Value>>,
    pub heights: Option<Spanned<Uneven>>,
}

/// Heights of the ground.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Uneven {
    pub kind: Option<Spanned<String>>,
    pub height: Option<Number>,
    pub size: Option<Number>,
    pub level: Option<Number>,
    pub list: Option<Spanned<Vec<f64>>>,
    pub seed: Option<u64>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Senses {
    pub encoder_counts: Option<Number>,
    pub position_noise: Option<Number>,
    pub velocity_noise: Option<Number>,
    pub effort_noise: Option<Number>,
    pub force_noise: Option<Number>,
    pub base_position_noise: Option<Number>,
    pub base_orientation_noise: Option<Number>,
    pub base_velocity_noise: Option<Number>,
    pub force_limit: Option<Number>,
    pub velocities: Option<bool>,
    pub effort: Option<Spanned<String>>,
    pub current_noise: Option<Number>,
    pub current_step: Option<Number>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Motor {
    pub gear_ratio: Option<Number>,
    pub rotor_inertia: Option<Number>,
    pub viscous_friction: Option<Number>,
    pub coulomb_friction: Option<Number>,
    pub torque_constant: Option<Number>,
    pub resistance: Option<Number>,
    pub voltage_limit: Option<Number>,
    pub current_limit: Option<Number>,
    pub command: Option<Spanned<String>>,
    pub stiffness: Option<Number>,
    pub spring_damping: Option<Number>,
    pub gap: Option<Number>,
    pub encoder_counts: Option<Number>,
    pub joint_encoder_counts: Option<Number>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Inertial {
    pub position: Option<Spanned<Vec<f64>>>,
    pub rotation: Option<Spanned<Vec<f64>>>,
    pub acceleration_noise: Option<Number>,
    pub angular_velocity_noise: Option<Number>,
    pub acceleration_bias: Option<Spanned<Vec<f64>>>,
    pub angular_velocity_bias: Option<Spanned<Vec<f64>>>,
}

/// What is assumed in event-driven walking; `false`: it is not checked.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Checks {
    pub friction: Option<Spanned<toml::Value>>,
    pub scuffing: Option<Spanned<toml::Value>>,
    pub pushing: Option<bool>,
    pub shortest_step: Option<Number>,
    pub step_length: Option<Spanned<toml::Value>>,
    pub second_impact: Option<bool>,
    pub level: Option<Number>,
    pub light: Option<Number>,
    pub order: Option<Spanned<String>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Law {
    pub law: Option<Spanned<String>>,
    pub stiffness: Option<Number>,
    pub damping: Option<Number>,
    pub exponent: Option<Number>,
    pub time_scale: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Output {
    pub formula: Spanned<String>,
    pub phase: Option<Spanned<String>>,
}
