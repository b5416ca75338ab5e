//! Amending a robot's description, with a history of what was done, and the way back.
//!
//! [`amend`] writes `[[effect]]` tables into `biped.toml` and a step into the history beside it; [`undo()`] takes the
//! last step back, byte for byte. Nothing is written unless the amended description reads, holds exactly the effects
//! that were asked for and says otherwise the same as before.
pub mod answer;
mod apply;
pub mod comments;
pub mod diagnosis;
mod files;
pub mod history;
pub mod identification;
pub mod picture;
pub mod svg;
mod text;
mod undo;

pub use apply::{Amended, amend, amend_in_memory};
pub use undo::{Undone, undo};

use bipedc_analysis::measure::DataSource;
use bipedc_compiler::Robot;
use bipedc_compiler::description::DESCRIPTION_FILE;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::Effect;
use history::{ChannelError, History};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What somebody wants to do to a description.
#[derive(Debug, Clone, Default)]
pub struct Proposal {
    /// In this order.
    pub effects: Vec<Proposed>,
    /// Where the numbers come from, in words: `values given`.
    pub origin: String,
    /// The data that parameters were estimated from.
    pub training: Option<DataSource>,
    /// More of it, where several logs taught.
    pub more_training: Vec<DataSource>,
    /// The data that judged.
    pub validation: Option<DataSource>,
    /// Errors of the whole, the channel that matters most first; empty if unknown.
    pub errors: Vec<ChannelError>,
    /// The filter of efforts and motion behind which they hold: its cut-off, Hz.
    pub cutoff_hz: Option<f64>,
    /// What to know about the errors.
    pub note: Option<String>,
}

/// One effect of a [`Proposal`].
#[derive(Debug, Clone)]
pub struct Proposed {
    /// Kind, place and numbers.
    pub effect: Effect,
    /// 95 % confidence intervals by parameter, where known.
    pub ci95: BTreeMap<String, [f64; 2]>,
    /// Error before and after this effect alone, where known.
    pub error: Option<ChannelError>,
    /// What to do with it.
    pub request: Request,
}

/// What to do with an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// Replace the parameters of the effect of this kind at this place, or add it.
    Put,
    /// Add it whatever is there.
    Add,
    /// Add its parameters to those of the effect of this kind at this place, or add it.
    Increase,
    /// Take it out.
    Remove,
}

/// The description of a robot: `path` is its folder or the file itself.
///
/// # Errors
/// A bare URDF or a folder without a description: they must get one first.
pub fn description_path(path: &Path) -> Result<PathBuf, Diagnostic> {
    let missing = |urdf: &Path| {
        Err(Diagnostic::error("the robot has no description that could be amended")
            .in_file(path)
            .help(format!("write one first: bipedc init {}", urdf.display())))
    };
    if path.extension().is_some_and(|extension| extension == "urdf") {
        let beside = path.with_file_name(DESCRIPTION_FILE);
        if !beside.is_file() {
            return missing(path);
        }
        return Err(Diagnostic::error("a URDF cannot be amended, its description can")
            .in_file(path)
            .help(format!("give the description: {}", beside.display())));
    }
    if path.is_file() || !path.exists() {
        return Ok(path.to_path_buf());
    }
    if !path.is_dir() {
        return Err(Diagnostic::error("what comes through a pipe cannot be amended")
            .in_file(path)
            .help("give a robot's folder with `robot.urdf` and `biped.toml`"));
    }
    let description = path.join(DESCRIPTION_FILE);
    if description.is_file() { Ok(description) } else { missing(&path.join("robot.urdf")) }
}

/// Reads a robot's description and history.
///
/// # Errors
/// As [`description_path`]; files that cannot be read.
pub fn open(path: &Path) -> Result<(PathBuf, String, History), Diagnostic> {
    let description = description_path(path)?;
    let Some(text) = files::read_text(&description)? else {
        return Err(Diagnostic::error("there is no such file")
            .in_file(&description)
            .help("give a robot's folder with `robot.urdf` and `biped.toml`"));
    };
    let mut history = History::open(&description)?;
    // Histories of old do not say which joints slide. A description that does not read is none of their business.
    if let Ok(robot) = Robot::read(&description) {
        history.know(&robot.description);
    }
    Ok((description, text, history))
}

/// Now, UTC, to the second.
fn now() -> String {
    humantime::format_rfc3339_seconds(SystemTime::now()).to_string()
}

/// Whether two effects are of one kind at one place. Names of formulas are unique.
fn is_same(a: &Effect, b: &Effect) -> bool {
    a.kind == b.kind && a.name == b.name && (a.name.is_some() || a.location == b.location)
}
