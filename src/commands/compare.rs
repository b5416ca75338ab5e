//! `bipedc compare`: what the model predicts against what was measured, and where they differ.
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::{Failure, Outcome};
use crate::terminal::next::Typed;
use crate::terminal::output;
use crate::terminal::pages::Pages;
use bipedc::Workbench;
use bipedc::comparison::{Compared, Options};
use bipedc_analysis::compare::Channel;
use bipedc_analysis::diagnose::AT_NOISE;
use bipedc_analysis::log::Mapping;
use bipedc_analysis::measure::{self, VelocitySource};
use bipedc_analysis::report::{NextStep, Report};
use clap::Args;
use std::path::PathBuf;
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

A log is CSV (or gzip CSV) with a column `time` (s), `<joint>/position` (rad) and `<joint>/effort` (N m). Other names: `bipedc log` \
tells what a log has and proposes a mapping file; docs/logs.md has every column.
Where a log has `<joint>/motor_current` (A) instead, a stiff drive under [drives.JOINT] of biped.toml tells the effort: gear \
ratio times torque constant times current, of which rotor inertia and friction of the drive take their part.
Positions are filtered (zero-phase 4th-order Butterworth) and differentiated; without --cutoff the cut-off with \
the smallest errors (geometric mean over the joints) among 4, 6.3, 10, 16, 25, 40, 60 and 90 Hz is taken.
Logs with the motion of the base and forces at the feet are compared in the rows that no actuator drives, and in the \
joints' efforts under these forces if they are logged; everything passes the same filter (5 Hz, or more for fast motions, unless --cutoff says \
otherwise). Tables of postures (centre of pressure) and of impacts (velocities just after) are compared row by row.
The effects of the description are part of the prediction.
--free-run S also integrates the model ahead for S seconds at a time, from measured states and under the logged efforts, and \
compares positions (rad, m): over all samples, at the ends of the windows, and relative to the measured way from a window's \
start (100 %: as bad as a joint that is said to stand still). The base must be held, position and effort of every joint logged.

JSON: {\"channels\": [{\"name\", \"kind\", \"unit\", \"rms\", \"max\", \"noise\", \"relative\", \"samples\"}], \"kinds\": {kind:
{\"unit\", \"rms\"}}, \"rms\", \"unit\", \"abscissa\", \"cutoff_hz\", \"cutoffs\", \"trim_s\", \"from_s\", \"to_s\", \"samples\", \
\"sampling_hz\", \"segments\", \"missing\", \"assumptions\", \"warnings\"}; with --where also \"where\": [{\"name\", \"kind\", \
\"unit\", \"rms\", \"max\", \"noise\", \"beyond_noise\" (fraction of the squared error), \"samples\", \"motion\", \"direction\", \
\"phases\": [{\"name\", \"samples\", \"rms\"}], \"windows\": [{\"from\", \"to\", \"samples\", \"rms\"}], \"signature\": [{\"name\", \
\"correlation\", \"share\", \"slope\"}], \"words\": [sentence]}]; with --free-run also \"free_run\": {\"window\" (s), \"windows\", \"diverged\", \
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
    #[arg(long, value_name = "S", default_value_t = measure::Options::default().trim_s)]
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
    pages: Pages,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl Compare {
    /// A whole log, with all defaults.
    pub fn of_log(robot: RobotArguments, log: PathBuf) -> Self {
        let trim = measure::Options::default().trim_s;
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
            pages: Pages::NONE,
            json: false,
        }
    }

    /// Reads, compares, prints.
    pub fn run(self) -> Outcome {
        let bench = self.robot.open()?;
        self.check_files(&bench)?;
        let log = bench.log_with(&self.log, self.mapping()?)?;
        let compared = bench.compare_with(&log, &self.options())?;
        if let Some(report) = &compared.report {
            self.pages.write(&Report { next: vec![self.next(&compared)], ..report.clone() })?;
        }
        output::diagnostics(&compared.warnings);
        if self.json {
            output::print_json(&compared)?;
        } else {
            output::print(&compared.to_string())?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Before anything is computed: outputs must not be inputs.
    fn check_files(&self, bench: &Workbench) -> Result<(), Failure> {
        let mut ledger = bench.ledger();
        ledger.reads("the log", &self.log);
        self.mapping.iter().for_each(|file| ledger.reads("the mapping file", file));
        Ok(self.pages.note(&mut ledger)?)
    }

    /// What one does after this.
    fn next(&self, compared: &Compared) -> NextStep {
        let is_noise = |channel: &Channel| channel.told() <= AT_NOISE * channel.noise;
        if compared.channels.iter().all(is_noise) {
            let generate = Typed::command("generate").path(&self.robot.path).words(&self.robot.overrides());
            return generate.because("The model explains this log down to its noise. Its equations as code:");
        }
        Typed::command("diagnose")
            .path(&self.robot.path)
            .path(&self.log)
            .words(&self.robot.overrides())
            .file("--mapping", self.mapping.as_deref())
            .option("--from", self.from.as_ref())
            .option("--to", self.to.as_ref())
            .option("--foot", self.foot.as_ref())
            .words(" --report diagnosis.html")
            .because(
                "Find out what the model lacks, where and how large (--validate OTHER.csv: judged on a log of another motion):",
            )
    }

    fn mapping(&self) -> Result<Mapping, Failure> {
        Ok(self.mapping.as_deref().map(Mapping::open).transpose()?.unwrap_or_default())
    }

    fn options(&self) -> Options {
        Options {
            reading: self.reading(),
            places: self.places,
            free_run: self.free_run,
            foot: self.foot.clone(),
            report: self.pages.wanted(),
        }
    }

    fn reading(&self) -> measure::Options {
        let (from_s, to_s, trim_s) = (self.from, self.to, self.trim);
        let mut reading = measure::Options { from_s, to_s, trim_s, ..measure::Options::default() };
        match self.cutoff.as_slice() {
            [] => {}
            [only] => reading.cutoff_hz = Some(*only),
            several => reading.candidates = several.to_vec(),
        }
        if self.logged_velocity {
            reading.velocity = VelocitySource::Logged;
        }
        reading
    }
}
