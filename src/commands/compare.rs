//! `bipedc compare`: what the model predicts against what was measured, and where they differ.
mod places;

use crate::arguments::RobotArguments;
use crate::currents::{self, Prepared};
use crate::failure::{Failure, Outcome};
use crate::measurements::{Content, Measured, content, subject};
use crate::reporting::{self, Outputs};
use crate::{free_running, output};
use bipedc::ProgramTorques;
use bipedc_analysis::compare::{Comparison, FreeRun, Reading, channels_of, compare_file};
use bipedc_analysis::diagnose::{Breakdown, breakdowns};
use bipedc_analysis::log::Mapping;
use bipedc_analysis::measure::{Options, VelocitySource};
use bipedc_analysis::report::Report;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::FunctionRequest;
use bipedc_effects::effect::{Effect, Law};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc compare robots/tulip tests/data/examples/null/validation.csv.gz
  bipedc compare robots/tulip log.csv --from 2 --to 8 --cutoff 25
  bipedc compare robots/tulip log.csv --mapping columns.toml --json
  bipedc compare robots/tulip log.csv --where --report report.html
  bipedc compare robots/tulip tests/data/examples/coulomb/validation.csv.gz --free-run 0.5
  bipedc compare robots/tulip tests/data/examples/postures/train.csv.gz --foot right_foot
  record | bipedc compare robots/tulip /dev/stdin

A log is CSV (or gzip CSV) with a column `time` (s), `<joint>/position` (rad) and `<joint>/effort` (N m).
Where a log has `<joint>/motor_current` (A) instead, a stiff drive under [drives.JOINT] of biped.toml tells the effort: gear
ratio times torque constant times current, of which rotor inertia and friction of the drive take their part.
Positions are filtered (zero-phase 4th-order Butterworth) and differentiated; without --cutoff the cut-off with
the smallest error among 10, 16, 25, 40, 60 and 90 Hz is taken.
Logs with the motion of the base and forces at the feet are compared in the rows that no actuator drives, and in the
joints' efforts under these forces if they are logged; everything passes the same filter (5 Hz unless --cutoff says
otherwise). Tables of postures (centre of pressure) and of impacts (velocities just after) are compared row by row.
The effects of the description are part of the prediction.
--free-run S also integrates the model ahead for S seconds at a time, from measured states and under the logged efforts, and
compares positions (rad, m): over all samples, at the ends of the windows, and relative to the measured way from a window's
start (100 %: as bad as a joint that is said to stand still). The base must be held, position and effort of every joint logged.

JSON: {\"channels\": [{\"name\", \"kind\", \"unit\", \"rms\", \"max\", \"noise\", \"relative\", \"samples\"}], \"kinds\": {kind:
{\"unit\", \"rms\"}}, \"rms\", \"unit\", \"abscissa\", \"cutoff_hz\", \"cutoffs\", \"trim_s\", \"from_s\", \"to_s\", \"samples\",
\"sampling_hz\", \"segments\", \"missing\", \"assumptions\", \"warnings\"}; with --where also \"where\": [{\"name\", \"kind\",
\"unit\", \"rms\", \"max\", \"noise\", \"beyond_noise\" (fraction of the squared error), \"samples\", \"motion\", \"direction\",
\"phases\": [{\"name\", \"samples\", \"rms\"}], \"windows\": [{\"from\", \"to\", \"samples\", \"rms\"}], \"signature\": [{\"name\",
\"correlation\", \"share\", \"slope\"}], \"words\": [sentence]}]; with --free-run also \"free_run\": {\"window\" (s), \"windows\", \"diverged\",
\"capped\" (too stiff), \"channels\": [{\"name\", \"unit\", \"rms\", \"rms_end\", \"relative\"}], \"rms\", \"unit\", \"assumptions\"}.";

/// Compare the model's prediction with measurements
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Compare {
    #[command(flatten)]
    robot: RobotArguments,
    /// The log, or a table of postures or impacts
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
    /// Also say where the model fails: when moving, reversing or standing, in which direction, when, on which feet,
    /// and what the residual goes with
    #[arg(long = "where")]
    places: bool,
    /// Also let the model run ahead under the logged efforts, for so many seconds from one measured state to the next
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    free_run: Option<f64>,
    /// Stance foot of postures, striking foot of impacts; default: the right one
    #[arg(long, value_name = "FOOT")]
    foot: Option<String>,
    #[command(flatten)]
    outputs: Outputs,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl Compare {
    /// A whole log, with all defaults.
    pub fn of_log(robot: RobotArguments, log: PathBuf) -> Self {
        let trim = Options::default().trim_s;
        let (from, to, cutoff, mapping) = (None, None, Vec::new(), None);
        Self {
            robot,
            log,
            from,
            to,
            cutoff,
            trim,
            logged_velocity: false,
            mapping,
            places: false,
            free_run: None,
            foot: None,
            outputs: Outputs::NONE,
            json: false,
        }
    }

    /// Reads, compares, prints.
    pub fn run(self) -> Outcome {
        let described = self.robot.read()?;
        self.check_files(&described)?;
        let prepared = currents::prepare(&described, &[&self.log], &self.mapping()?)?;
        let Prepared { robot, mapping, assumptions, warnings, .. } = prepared;
        let content = content(&subject(&robot.tree()?)?, &self.log, &mapping)?;
        if self.free_run.is_some() {
            free_running::refuse(&robot, content, &self.log, &mapping)?;
        }
        let (comparison, loaded_at) = match content {
            Content::Efforts => {
                let comparison = compare_efforts(&robot, &self.log, &mapping, &self.options())?;
                let cutoff = comparison.cutoff_hz;
                (Some(comparison), Some(cutoff))
            }
            _ => (None, None),
        };
        let detailed = self.places || self.outputs.wanted();
        let (mut comparison, places) = match comparison {
            Some(comparison) if !detailed => (comparison, None),
            comparison => {
                let options = Options { cutoff_hz: loaded_at.or(self.options().cutoff_hz), ..self.options() };
                self.look_closer(&robot, &mapping, &options, comparison)?
            }
        };
        let options = Options { cutoff_hz: Some(comparison.cutoff_hz), ..self.options() };
        let run = |seconds| free_running::predict(&robot, &self.log, &mapping, &options, seconds);
        let free_run = self.free_run.map(run).transpose()?;
        comparison.assumptions.extend(assumptions);
        comparison.warnings.extend(warnings);
        output::diagnostics(&comparison.warnings);
        if self.json {
            let (places, free_run) = (places.as_deref(), free_run.as_ref());
            output::print_json(&Json { comparison: &comparison, places, free_run })?;
        } else {
            let more = places.map(|places| places::text(&places)).unwrap_or_default();
            let run = free_run.as_ref().map(free_running::text).unwrap_or_default();
            output::print(&format!("{comparison}{more}{run}"))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Loads the file as an experiment: for what only that knows, and for files that are no logs of efforts.
    fn look_closer(
        &self,
        robot: &Robot,
        mapping: &Mapping,
        options: &Options,
        comparison: Option<Comparison>,
    ) -> Result<(Comparison, Option<Vec<Breakdown>>), Failure> {
        let mut measured = output::progress("deriving", || Measured::new(robot))?;
        measured.with_joints = true;
        let cutoff = measured.cutoff(&self.log, mapping, options)?;
        let cutoff_hz = (cutoff > 0.0).then_some(cutoff);
        let options = Options { cutoff_hz, ..options.clone() };
        let foot = self.foot.as_deref();
        let loaded = output::progress("reading", || measured.load(&self.log, mapping, &options, foot))?;
        let comparison = comparison.unwrap_or_else(|| {
            let reading = Reading {
                abscissa: loaded.content.abscissa(),
                cutoff_hz: loaded.cutoff_hz,
                trim_s: if loaded.content == Content::Contacts { options.trim_s } else { 0.0 },
                missing: Vec::new(),
                assumptions: loaded.assumptions.clone(),
                warnings: loaded.warnings.clone(),
            };
            Comparison::of_experiment(&*loaded.experiment, reading)
        });
        if self.outputs.wanted() {
            let report = reporting::of_measurements(robot, &measured, &loaded, None)?;
            self.outputs.write(&Report { history: reporting::steps_of(&self.robot.path), ..report })?;
        }
        Ok((comparison, self.places.then(|| breakdowns(&*loaded.experiment))))
    }

    /// Before anything is computed: outputs must not be inputs.
    fn check_files(&self, robot: &Robot) -> Result<(), Failure> {
        let mut ledger = self.robot.ledger(robot);
        ledger.reads("the log", &self.log);
        self.mapping.iter().for_each(|file| ledger.reads("the mapping file", file));
        Ok(self.outputs.note(&mut ledger)?)
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

/// Logged efforts against the compiled model with the effects of its description.
///
/// Effects that no function of one state contains (delays, saturated drives) are applied to the whole log instead.
fn compare_efforts(
    robot: &Robot,
    log: &Path,
    mapping: &Mapping,
    options: &Options,
) -> Result<Comparison, Failure> {
    let subject = subject(&robot.tree()?)?;
    let request = FunctionRequest::of_robot("inverse_dynamics");
    let compiled = output::progress("deriving", || robot.compile_only(&[request]))?;
    let mut torques = ProgramTorques::new(&compiled)?;
    let mut comparison = output::progress("reading and comparing", || {
        compare_file(&mut torques, &subject, log, mapping, options)
    })?;
    let outside = |effect: &Effect| matches!(effect.kind.law, Law::Delay | Law::TrueTorque(_));
    if !robot.description.effects.iter().any(outside) {
        return Ok(comparison);
    }
    let measured = output::progress("deriving", || Measured::new(robot))?;
    let mut all = Vec::new();
    for cutoff in comparison.cutoffs.iter().map(|c| c.cutoff_hz) {
        let options = Options { cutoff_hz: Some(cutoff), ..options.clone() };
        let experiment = output::progress("reading and comparing", || {
            measured.efforts(log, mapping, &options, usize::MAX)
        })?;
        all.push((cutoff, channels_of(&experiment)));
    }
    comparison.judged_again(all);
    Ok(comparison)
}

/// A comparison and, if asked, where it fails.
#[derive(Serialize)]
struct Json<'a> {
    #[serde(flatten)]
    comparison: &'a Comparison,
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    places: Option<&'a [Breakdown]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    free_run: Option<&'a FreeRun>,
}
