//! Makes logs of robots that differ from their URDF in a known way.
//!
//! The rigid-body equations are those of the compiled model; everything else (friction, drives, springs, sensors,
//! impacts) is written by hand here and shares no formula with the diagnosis. The same plan gives the same bytes.
mod cases;
mod contact;
mod draw;
mod drive;
mod few;
mod flat_impacts;
mod hanging;
mod impacts;
mod inertia;
mod legs;
pub mod model;
mod motion;
pub mod oracle;
mod outside;
mod postures;
mod random;
mod sensors;
mod sway;
pub mod sway_sensors;
mod table;
mod truth;

pub use cases::all;
pub use table::write_text;
pub use truth::{Experiment, Group, Plan, Scales, Truth};

use std::fmt;
use std::path::Path;

/// Why a case could not be made or judged.
#[derive(Debug, Clone)]
pub struct Failure(pub String);

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Failure {}

/// A failure with this message.
pub fn failure(message: impl Into<String>) -> Failure {
    Failure(message.into())
}

/// No motion that is drawn comes near this speed, rad/s or m/s: a drive that is no longer in control does.
const FASTEST: f64 = 40.0;
/// Or this far, rad or m; logs need not have velocities.
const FARTHEST: f64 = 100.0;
/// Or makes an effort that is so many times what all but a hundredth of the log have; noise, friction and reversals make twice as much.
const SPIKE: f64 = 10.0;

/// Most further draws of a case.
const DRAWS: usize = 12;
/// What is hidden at impacts has to add this share to the error that is left under the true model: soles that never spin tell nothing of
/// their friction.
const SEEN: f64 = 0.01;

/// Writes a case into a folder, drawn again where what was drawn cannot be simulated (a joint so light that its friction makes the
/// integration unstable) or cannot be seen in what it measures.
///
/// # Errors
/// As [`generate`], after the last draw.
pub fn drawn(plan: &Plan, root: &Path, folder: &Path) -> Result<(Plan, Truth), Failure> {
    let draw = |plan: &Plan| {
        let truth = generate(plan, root, folder)?;
        let strikes = matches!(plan.experiment, Experiment::Impacts | Experiment::FlatImpacts);
        let seen = !strikes || truth.effects.is_empty() || truth.nominal > (1.0 + SEEN) * truth.oracle;
        seen.then_some(truth).ok_or_else(|| failure(format!("{}: what is hidden does not show", plan.name)))
    };
    let mut plan = plan.clone();
    let mut found = draw(&plan);
    for again in 1..=DRAWS {
        let Err(error) = &found else { break };
        eprintln!("{error}; drawn again");
        plan.seed = format!("{} again {again}", plan.seed);
        found = draw(&plan);
    }
    found.map(|truth| (plan, truth))
}

/// Writes `train.csv`, `validation.csv` and `truth.json` of a case into a folder.
///
/// `root` is the project's folder.
///
/// # Errors
/// Robots, joints and links that do not exist; files that cannot be written.
pub fn generate(plan: &Plan, root: &Path, folder: &Path) -> Result<Truth, Failure> {
    std::fs::create_dir_all(folder).map_err(|e| failure(format!("{}: {e}", folder.display())))?;
    let robot = plan.folder(root);
    let made = match plan.experiment {
        Experiment::Hanging => hanging::generate(plan, &robot)?,
        Experiment::Swaying => sway::generate(plan, &robot)?,
        Experiment::Postures => postures::generate(plan, &robot)?,
        Experiment::Impacts => impacts::generate(plan, &robot)?,
        Experiment::FlatImpacts => flat_impacts::generate(plan, &robot)?,
    };
    let spikes =
        |table: &table::Table| plan.experiment == Experiment::Hanging && table.peak("/effort") > SPIKE;
    let moderate = |table: &&table::Table| {
        table.largest("/velocity") < FASTEST && table.largest("/position") < FARTHEST && !spikes(table)
    };
    let calm = [&made.train, &made.validation].iter().all(moderate);
    if !(made.truth.nominal.is_finite() && made.truth.oracle.is_finite() && calm) {
        return Err(failure(format!("{}: the simulation is unstable", plan.name)));
    }
    made.train.write(&folder.join("train.csv"))?;
    made.validation.write(&folder.join("validation.csv"))?;
    let text = serde_json::to_string_pretty(&made.truth).map_err(|e| failure(e.to_string()))?;
    table::write_text(&folder.join("truth.json"), &(text + "\n"))?;
    Ok(made.truth)
}

/// A case before it is written.
pub struct Made {
    /// For finding and fitting.
    pub train: table::Table,
    /// For judging: another motion.
    pub validation: table::Table,
    /// What was hidden.
    pub truth: Truth,
}
