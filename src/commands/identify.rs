//! `bipedc identify`: inertial parameters from logs, with error bars, physically possible, as a new URDF.
mod parse;

use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use crate::terminal::pages::Pages;
use bipedc::identification::{self, Method, Options};
use bipedc::{Log, Workbench};
use bipedc_analysis::identify::elastic;
use bipedc_analysis::log::Mapping;
use bipedc_analysis::measure;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::write;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc identify my_arm run1.csv run2.csv --validate other.csv
  bipedc identify my_arm run1.csv --cutoff 8 --write-urdf identified.urdf
  bipedc identify my_arm run1.csv --rotor all --coupled joint_5,joint_6 --cutoff 100 --decimate 20 --slow 1 --json
  bipedc identify robots/tulip hanging.csv --total-mass 19.2 --mirror left_foot=right_foot
  bipedc identify robots/tulip_v1_leg leg.csv --method elastic --validate other.csv
  bipedc identify robots/tulip postures.csv --method cop --validate others.csv
  bipedc identify robots/tulip kicks.csv --method zmp --stance right_foot

Four steps: base parameters of what was measured (thesis 5.2), with friction and offset of every joint, by least squares \
with each joint's own noise; their standard errors, which respect that errors last; the fewest of them that predict as \
well; and parameters of every link that a body can have, near the description where the data do not tell. How near is \
chosen on the logs alone, by folds that never share a motion. Nothing of --validate is used for any choice.

With series elastic drives (--method elastic) springs measure the torques: motor currents tell friction and stiffness of \
every drive first, from the drive trains of biped.toml; then the springs' torques tell the bodies.

Where the base moves and forces at the feet are logged, the rows of the base tell instead of joint torques.

Without joint torques: --method cop takes tables of static postures on force plates (columns `<joint>/position`, `cop/x`, \
`cop/y`; `bipedc excite ROBOT --postures 50` designs them), --method zmp logs of a robot that stands on --stance \
(`<joint>/position`, `<foot>/force/z`, `<foot>/cop/x`, `/y`, or whole wrenches) or whose base is logged too.

docs/identification.md explains the method, every column and every key of --json.";

/// How parameters are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum By {
    /// From joint torques (thesis 5.2)
    Torque,
    /// From motor currents and springs of series elastic drives (thesis 5.3)
    Elastic,
    /// From centres of pressure of postures at rest (thesis 5.4.1)
    Cop,
    /// From the ground's forces on a robot in motion (thesis 5.4.2)
    Zmp,
}

/// How residuals count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Estimator {
    /// All alike
    Ordinary,
    /// Each joint by its own noise
    Weighted,
    /// As weighted, and large residuals less
    Huber,
    /// As weighted, with instruments against noisy regressors (--method elastic)
    Instrumental,
}

/// How both regressions are put together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Steps {
    /// Motors first, then bodies with the springs so found (5.13, 5.15)
    Two,
    /// One regression, every row by its own noise
    One,
}

/// Find out masses, centres of mass and inertias from logs
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Identify {
    #[command(flatten)]
    robot: RobotArguments,
    /// Logs that teach
    #[arg(value_name = "LOG.csv", required = true)]
    logs: Vec<PathBuf>,
    /// Which measurements tell
    #[arg(long, value_enum, default_value = "torque")]
    method: By,
    /// Foot that stands still, for cop and zmp [default: the right one]
    #[arg(long, value_name = "FOOT")]
    stance: Option<String>,
    /// cop: legs symmetric in x and y, feet in y: fewer parameters (thesis 8.3.2)
    #[arg(long)]
    symmetric: bool,
    /// A log of another motion, that only judges
    #[arg(long, value_name = "OTHER.csv")]
    validate: Option<PathBuf>,
    /// How residuals count
    #[arg(long, value_enum, default_value = "weighted")]
    estimator: Estimator,
    /// What joints add: viscous, coulomb, offset, quadratic_drag, rotor_inertia (at every joint), or none
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "viscous,coulomb,offset")]
    friction: Vec<String>,
    /// Joints whose effort moves a rotor too: names, `all` or `none`
    #[arg(long, value_name = "JOINTS", value_delimiter = ',', default_value = "none")]
    rotor: Vec<String>,
    /// Two joints whose drives turn together, such as those of a wrist; may be repeated
    #[arg(long, value_name = "JOINT,JOINT")]
    coupled: Vec<String>,
    /// Cut-off of the filter of positions and efforts, Hz [default: 10; of joint torques without --decimate twice that of the
    /// rows, 4 to 30]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    cutoff: Option<f64>,
    /// Keep every N-th sample, after a low-pass over regressor and torque
    #[arg(long, value_name = "N", default_value_t = 1)]
    decimate: usize,
    /// Cut-off of the low-pass over regressor and torque, Hz; without --decimate [default: as slow as the motion allows, where
    /// encoders are noisy]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    row_cutoff: Option<f64>,
    /// Samples at which a joint is slower than this part of its largest speed do not count for it, per cent [default: 10 of joints
    /// with dry friction, or a quarter of the usual speed; motors of --method elastic: 3]
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    slow: Option<f64>,
    /// Motors first, then bodies, or one regression for both (--method elastic)
    #[arg(long, value_enum, default_value = "two")]
    steps: Steps,
    /// Left out at both ends of a log and on both sides of gaps, s
    #[arg(long, value_name = "T", default_value_t = 0.5)]
    trim: f64,
    /// Samples before this time of the logs' clock (s) do not count
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    from: Option<f64>,
    /// Samples after this time of the logs' clock (s) do not count
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    to: Option<f64>,
    /// TOML file with other column names, factors and signs
    #[arg(long, value_name = "FILE.toml")]
    mapping: Option<PathBuf>,
    /// How much the description counts, instead of the choice by folds
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    weight: Option<f64>,
    /// What all moving links weigh together, kg
    #[arg(long, value_name = "KG", allow_negative_numbers = true)]
    total_mass: Option<f64>,
    /// Box in which a link's centre of mass lies, in its frame, m; may be repeated
    #[arg(long, value_name = "LINK=X0,X1,Y0,Y1,Z0,Z1", allow_hyphen_values = true)]
    center: Vec<String>,
    /// Two links that mirror each other; may be repeated
    #[arg(long, value_name = "LEFT=RIGHT")]
    mirror: Vec<String>,
    /// Go on although channels seem to be mixed up
    #[arg(long)]
    anyway: bool,
    /// Write the URDF with the physically possible parameters
    #[arg(long, value_name = "OUT.urdf")]
    write_urdf: Option<PathBuf>,
    #[command(flatten)]
    pages: Pages,
    /// Print the answer as JSON (docs/identification.md explains every key)
    #[arg(long)]
    json: bool,
}

impl Identify {
    /// Reads, estimates, prints.
    pub fn run(self) -> Outcome {
        self.check()?;
        let bench = self.robot.open()?;
        self.check_files(&bench)?;
        let mapping = self.mapping.as_deref().map(Mapping::open).transpose()?.unwrap_or_default();
        let options = self.options()?;
        let open = |file: &PathBuf| bench.log_with(file, mapping.clone());
        let logs = self.logs.iter().map(open).collect::<Result<Vec<Log>, _>>()?;
        let judge = self.validate.as_ref().map(open).transpose()?;
        let logs: Vec<&Log> = logs.iter().collect();
        let found = bench.identify_with(&logs, judge.as_ref(), &options)?;
        output::diagnostics(&found.warnings);
        if let Some(path) = &self.write_urdf {
            write(path, &found.urdf(bench.robot())?)?;
        }
        if let Some(report) = &found.report {
            self.pages.write(report)?;
        }
        if self.json {
            output::print_json(&found)?;
        } else {
            output::print(&found.to_string())?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Before anything is computed: outputs must not be inputs.
    fn check_files(&self, bench: &Workbench) -> Result<(), Diagnostic> {
        let mut ledger = bench.ledger();
        self.logs.iter().for_each(|log| ledger.reads("a log", log));
        self.validate.iter().for_each(|log| ledger.reads("the log of --validate", log));
        self.mapping.iter().for_each(|file| ledger.reads("the mapping file", file));
        self.write_urdf.as_ref().map_or(Ok(()), |file| ledger.writes_source("--write-urdf", file))?;
        self.pages.note(&mut ledger)
    }

    /// Numbers that have no meaning.
    fn check(&self) -> Result<(), Diagnostic> {
        let refuse = |what: &str, value: f64, help: &str| {
            Err(Diagnostic::error(format!("{what} is {value}")).help(help.to_owned()))
        };
        for (option, cutoff) in [("--cutoff", self.cutoff), ("--row-cutoff", self.row_cutoff)] {
            if let Some(cutoff) = cutoff.filter(|cutoff| !(cutoff.is_finite() && *cutoff > 0.0)) {
                return refuse(option, cutoff, "give a frequency in Hz");
            }
        }
        let slow = self.slow.unwrap_or(0.0);
        if !(0.0..50.0).contains(&slow) {
            return refuse("--slow", slow, "give a part of the largest speed in per cent, below 50");
        }
        if !(self.trim.is_finite() && self.trim >= 0.0) {
            return refuse("--trim", self.trim, "give a time in s");
        }
        if self.steps == Steps::One && self.method != By::Elastic {
            return Err(Diagnostic::error("--steps one has no meaning without --method elastic")
                .help("leave it out: joint torques are one regression"));
        }
        if self.symmetric && self.method != By::Cop {
            return Err(Diagnostic::error("--symmetric is about postures").help("add --method cop"));
        }
        if self.stance.is_some() && !matches!(self.method, By::Cop | By::Zmp) {
            return Err(
                Diagnostic::error("--stance is about forces of the ground").help("add --method cop or zmp")
            );
        }
        match self.weight {
            Some(weight) if !(weight.is_finite() && weight > 0.0) => {
                refuse("--weight", weight, "give a positive number; 0.01 is little, 100 is much")
            }
            _ => Ok(()),
        }
    }

    fn options(&self) -> Result<Options, Diagnostic> {
        Ok(Options {
            method: match self.method {
                By::Torque => Method::Torque,
                By::Elastic => Method::Elastic,
                By::Cop => Method::Cop,
                By::Zmp => Method::Zmp,
            },
            estimator: match self.estimator {
                Estimator::Ordinary => identification::Estimator::Ordinary,
                Estimator::Weighted => identification::Estimator::Weighted,
                Estimator::Huber => identification::Estimator::Huber,
                Estimator::Instrumental => identification::Estimator::Instrumental,
            },
            friction: parse::friction(&self.friction)?,
            rotors: parse::rotors(&self.rotor),
            coupled: parse::coupled(&self.coupled)?,
            reading: measure::Options {
                cutoff_hz: self.cutoff,
                trim_s: self.trim,
                from_s: self.from,
                to_s: self.to,
                ..measure::Options::default()
            },
            decimate: self.decimate,
            rows_hz: self.row_cutoff,
            slow: self.slow.map(|percent| percent / 100.0),
            steps: match self.steps {
                Steps::Two => elastic::Steps::Two,
                Steps::One => elastic::Steps::One,
            },
            weight: self.weight,
            total_mass: self.total_mass,
            bounds: parse::bounds(&self.center, &self.mirror)?,
            stance: self.stance.clone(),
            symmetric: self.symmetric,
            anyway: self.anyway,
            report: self.pages.wanted(),
        })
    }
}
