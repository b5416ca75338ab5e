//! What a log holds: how it is sampled, what its columns are, what is missing for a robot, and how other names could be mapped.
//!
//! ```no_run
//! # fn main() -> Result<(), bipedc::Diagnostics> {
//! use bipedc::inventory::{Robot, examine};
//! let bench = bipedc::Workbench::open("robots/tulip")?;
//! let robot = Robot::of(bench.robot())?;
//! let found = examine("log.csv", &bipedc_analysis::log::Mapping::default(), Some(&robot))?;
//! println!("{found}");
//! println!("{}", found.mapping());
//! # Ok(())
//! # }
//! ```
mod found;
mod joint_state;
mod matching;
mod pass;
mod plan;
mod proposal;
mod rewrite;
mod robot;
mod statistics;
mod text;
mod words;

pub use proposal::{Entry, Proposal};
pub use rewrite::{Rewritten, rewrite};
pub use robot::{JointChannels, Robot, RobotChannels, Unknown};
pub use statistics::{Gap, Sampling, Unusable};

use bipedc_analysis::log::Mapping;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use found::Found;
use pass::Stamp;
use serde::{Serialize, Serializer};
use std::path::Path;

/// What a file holds. Its JSON keys are its field names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inventory {
    /// As it was given.
    pub file: String,
    /// `time`, `posture` or `impact`: what a row is.
    pub kind: &'static str,
    /// Rows behind the header.
    pub rows: usize,
    /// Whether the first line names the columns; if not, they are those of a `sensor_msgs/JointState`.
    pub has_header: bool,
    /// Of a log over time.
    pub sampling: Option<Sampling>,
    /// In the order of the file.
    pub columns: Vec<ColumnFound>,
    /// What the joints of the robot have, if one was given.
    pub robot: Option<RobotChannels>,
    /// What a mapping file would say about columns with other names.
    pub proposal: Proposal,
    /// As texts in JSON.
    #[serde(serialize_with = "as_texts")]
    pub warnings: Vec<Diagnostic>,
    #[serde(skip)]
    stamp: Stamp,
    #[serde(skip)]
    sources: Vec<Source>,
}

/// A column that can be written under our name: value = factor · field + offset.
#[derive(Debug, Clone, PartialEq)]
struct Source {
    name: String,
    field: usize,
    factor: f64,
    offset: f64,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColumnFound {
    /// In the file.
    pub name: String,
    /// Its place in the file, from 1.
    pub number: usize,
    /// The column of ours that it is: by its own name or by the mapping; `null`: none.
    pub taken_as: Option<String>,
    /// The column of ours that it could be.
    pub proposed: Option<String>,
    /// Of `least` and `most`: that of what it is or could be.
    pub unit: Option<String>,
    /// Smallest value; `null` without any number.
    pub least: Option<f64>,
    /// Largest value.
    pub most: Option<f64>,
    /// Whether it has one value all along.
    pub constant: bool,
    /// Rows in which it is empty or NaN.
    pub missing: usize,
    /// The first such line.
    pub first_missing: Option<usize>,
    /// Values that are no numbers, or none that are possible.
    pub unusable: Option<Unusable>,
}

/// Reads a file once and tells what is in it. Where columns have other names than ours, `robot` is whose joints they could be
/// of; `mapping` says what is known already.
///
/// # Errors
/// No file of text, empty, no rows or only one, names that stand twice; no header row, unless rows are joint states as
/// `ros2 topic echo --csv` prints them; a mapping of columns that do not exist.
pub fn examine(
    path: impl AsRef<Path>,
    mapping: &Mapping,
    robot: Option<&Robot>,
) -> Result<Inventory, Diagnostics> {
    let path = path.as_ref();
    let (names, has_header) = plan::column_names(path)?;
    let plans = plan::plans(path, &names, mapping)?;
    let kind = plan::kind_of(&plans);
    let mut proposal = Proposal::default();
    if let Some(robot) = robot {
        let guesses = proposal::joints(&plans, &robot.names(), &robot.actuated);
        for guess in guesses.found {
            proposal.entries.push(Entry {
                name: format!("{}/{}", robot.joints[guess.joint].name, guess.quantity),
                column: names[guess.field].clone(),
                scale: guess.scale,
                unit: guess.unit.filter(|_| guess.scale != 1.0).map(str::to_owned),
                field: guess.field,
            });
        }
        (proposal.assumptions, proposal.doubts) = (guesses.assumptions, guesses.doubts);
    }
    let stamp = pass::stamp_of(&plans, kind, has_header);
    let seen = pass::read(path, names.len(), stamp, (!has_header).then_some(&names))?;
    let found = Found { path, plans, kind, has_header, proposal, robot };
    Ok(found.finish(seen, stamp))
}

impl Inventory {
    /// The mapping file that is proposed, as text; without entries only a comment.
    pub fn mapping(&self) -> String {
        let file = Path::new(&self.file).file_name().unwrap_or_default().to_string_lossy();
        match &self.robot {
            Some(robot) => self.proposal.toml(&format!("{file}, for {}", robot.robot)),
            None => self.proposal.toml(&file),
        }
    }
}

fn as_texts<S: Serializer>(warnings: &[Diagnostic], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(warnings.iter().map(Diagnostic::to_string))
}
