//! `bipedc compare`: predicted against logged torques.
use crate::arguments::RobotArguments;
use crate::failure::{Failure, Outcome};
use crate::output;
use bipedc_compiler::compile::Wish;
use bipedc_compiler::program::ProgramTorques;
use bipedc_compiler::tree::{BaseKind, Tree};
use bipedc_runtime::compare::{self, Joint, Options, Subject, VelocitySource, compare_file};
use bipedc_runtime::diagnostic::Diagnostic;
use bipedc_runtime::log::Mapping;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc compare robots/tulip tests/data/examples/null/validation.csv.gz
  bipedc compare robots/tulip log.csv --from 2 --to 8 --cutoff 25
  bipedc compare robots/tulip log.csv --mapping columns.toml --json

A log is CSV (or gzip CSV) with a column `time` (s), `<joint>/position` (rad) and `<joint>/effort` (N m).
Positions are filtered (zero-phase 4th-order Butterworth) and differentiated; without --cutoff the cut-off with
the smallest error among 10, 16, 25, 40, 60 and 90 Hz is taken.";

/// Compare the model's torques with a log
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Compare {
    #[command(flatten)]
    robot: RobotArguments,
    /// The log
    #[arg(value_name = "LOG.csv")]
    log: PathBuf,
    /// Samples before this time of the log's clock (s) do not count
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    from: Option<f64>,
    /// Samples after this time of the log's clock (s) do not count
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    to: Option<f64>,
    /// Cut-off of the filter, Hz; given several times or with commas: the best of them
    #[arg(long, value_name = "HZ", value_delimiter = ',')]
    cutoff: Vec<f64>,
    /// Left out of the error at both ends and beside gaps, s
    #[arg(long, value_name = "S", default_value_t = Options::default().trim_s)]
    trim: f64,
    /// Take velocities from the log's velocity columns instead of filtered positions
    #[arg(long)]
    logged_velocity: bool,
    /// TOML file with other column names, factors and signs
    #[arg(long, value_name = "FILE.toml")]
    mapping: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl Compare {
    /// A whole log, with all defaults.
    pub fn of_log(robot: RobotArguments, log: PathBuf) -> Self {
        let trim = Options::default().trim_s;
        let (from, to, cutoff, mapping) = (None, None, Vec::new(), None);
        Self { robot, log, from, to, cutoff, trim, logged_velocity: false, mapping, json: false }
    }

    /// Reads, compares, prints.
    pub fn run(self) -> Outcome {
        let robot = self.robot.read()?;
        let mapping = self.mapping()?;
        let subject = subject(&robot.tree()?)?;
        let wish = Wish { family: "inverse_dynamics".to_owned(), subject: None };
        let compiled = output::progress("deriving", || robot.compile_only(&[wish]))?;
        let mut torques = ProgramTorques::new(&compiled)?;
        let options = self.options();
        let comparison = output::progress("reading and comparing", || {
            compare_file(&mut torques, &subject, &self.log, &mapping, &options)
        })?;
        output::diagnostics(&comparison.warnings);
        if self.json {
            output::print_json(&comparison)?;
        } else {
            output::print(&comparison.to_string())?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn mapping(&self) -> Result<Mapping, Failure> {
        Ok(self.mapping.as_deref().map(Mapping::open).transpose()?.unwrap_or_default())
    }

    fn options(&self) -> Options {
        let mut options =
            Options { from_s: self.from, to_s: self.to, trim_s: self.trim, ..Options::default() };
        match self.cutoff.as_slice() {
            [] => {}
            [only] => options.cutoff_hz = Some(*only),
            several => options.candidates = several.to_vec(),
        }
        if self.logged_velocity {
            options.velocity = VelocitySource::Logged;
        }
        options
    }
}

/// What the comparison has to know of the robot.
fn subject(tree: &Tree) -> Result<Subject, Diagnostic> {
    let base = match tree.base {
        BaseKind::Floating => compare::BaseKind::Floating,
        BaseKind::Planar => compare::BaseKind::Planar,
        BaseKind::Fixed => compare::BaseKind::Fixed,
        BaseKind::Pivot => {
            return Err(Diagnostic::error("a log does not tell the angle of a pivot")
                .help("choose another base with --base floating|planar|fixed"));
        }
    };
    let joints = tree.joints.iter();
    let joints = joints.map(|joint| Joint { name: joint.name.clone(), prismatic: joint.prismatic }).collect();
    Ok(Subject { joints, base })
}
