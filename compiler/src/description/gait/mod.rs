//! Gaits: virtual constraints of a phase as formulas of a phase variable and of gait parameters (thesis 6.2.1), read from
//! `gaits/<name>.toml` beside a robot's description. `docs/gaits.md` lists all keys.
mod curve;
mod dimension;
mod form;
mod joint_names;
mod legs;
mod names;
mod phase;
mod phased;
mod read;

pub use curve::Curve;
pub use form::{DoubleSupport, FormWishes, gait_form};
pub use joint_names::JointNames;
pub use legs::{hip_height, knees, usual_speed};
pub use phased::{Feedforward, PhasedGait, SupportPhase};
pub(crate) use read::NOT_PLANAR;
pub use read::{AnyGait, gait_path, parse_any_gait, parse_gait, read_any_gait, read_gait};

use bipedc_effects::effect::Effect;
use bipedc_effects::effect::formula::Formula;
use std::collections::BTreeMap;

/// The phase variable φ, in formulas of what is wanted.
pub const PHASE: &str = "phase";
/// φ at the beginning of the step, φ₊.
pub const PHASE_START: &str = "phase_start";
/// φ at the end of the step, φ₋.
pub const PHASE_END: &str = "phase_end";

/// Line and column in a gait file, from 1, for messages about what is only seen later.
#[derive(Clone, Copy)]
pub struct FilePlace {
    /// From 1.
    pub line: usize,
    /// From 1.
    pub column: usize,
}

impl PartialEq for FilePlace {
    /// Gaits are the same wherever their lines stand.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl std::fmt::Debug for FilePlace {
    /// Without numbers: what is computed from a gait does not depend on them, and is known again by this text after a line was added.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("FilePlace")
    }
}

/// A gait file, checked against its robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Gait {
    /// The file's name without its ending.
    pub name: String,
    /// Size of gravity, m/s²; `None`: that of the description.
    pub gravity: Option<f64>,
    /// In the order of the file.
    pub parameters: Vec<GaitParameter>,
    /// Formulas that other formulas name.
    pub quantities: BTreeMap<String, Formula>,
    /// The phase that makes a step.
    pub phase: GaitPhase,
    /// Makes another body of the description, as the published robot has it.
    pub effects: Vec<Effect>,
    /// What the margins of a step are measured against.
    pub limits: GaitLimits,
}

/// A number that is chosen anew for each step.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitParameter {
    /// As formulas call it.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// What it is, for people.
    pub meaning: String,
    /// Where nothing else is asked for.
    pub default: f64,
    /// Smallest and largest value that is meant.
    pub bounds: [f64; 2],
}

/// Virtual constraints of one phase, h = h₀(q) − h_d(φ, p) − h_p(φ) (6.2).
#[derive(Debug, Clone, PartialEq)]
pub struct GaitPhase {
    /// Phase of the description.
    pub name: String,
    /// φ(q), which grows along the step.
    pub variable: Formula,
    /// Where φ stands in the file.
    pub variable_at: FilePlace,
    /// Unit of φ.
    pub unit: String,
    /// Whether the cubic h_p takes up what the impact leaves of h and its rate (below 6.2).
    pub impact_matching: bool,
    /// As many as joints with actuators.
    pub outputs: Vec<GaitOutput>,
    /// Where the step ends.
    pub guard: Guard,
    /// Joint positions where the search for a posture on the constraints begins, rad or m; those that are missing are 0.
    pub posture: BTreeMap<String, f64>,
}

/// One virtual constraint.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitOutput {
    /// For messages and tables.
    pub name: String,
    /// Of both formulas.
    pub unit: String,
    /// h₀(q): what is controlled.
    pub controlled: Formula,
    /// h_d(φ, p): what it is to be.
    pub wanted: Curve,
    /// Where the output begins in the file.
    pub at: FilePlace,
}

/// The step ends where a formula of q and p vanishes.
#[derive(Debug, Clone, PartialEq)]
pub struct Guard {
    /// Zero at the end of the step.
    pub formula: Formula,
    /// Smallest and largest φ at which it is looked for.
    pub between: [f64; 2],
}

/// What margins are measured against; `None`: not at all.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GaitLimits {
    /// Coulomb's coefficient.
    pub friction: Option<f64>,
}
