//! `bipedc diagnose`: which physical effect is missing, where, how large, how sure.
use crate::arguments::RobotArguments;
use crate::diagnosing::{Request, diagnose_files};
use crate::explaining::until_explained;
use crate::failure::{Failure, Outcome};
use crate::measurements::{Loaded, Measured};
use crate::output;
use crate::reporting::{self, Outputs};
use bipedc_analysis::diagnose::{Diagnosis, Found, Options};
use bipedc_analysis::log::Mapping;
use bipedc_analysis::measure;
use bipedc_analysis::report::Report;
use bipedc_analysis::robot::link_inertias::CadError;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc diagnose robots/tulip train.csv --validate other.csv
  bipedc diagnose robots/tulip train.csv --validate other.csv --json > diagnosis.json
  bipedc diagnose robots/tulip train.csv --validate other.csv --report report.html --svg figures
  bipedc diagnose my_arm log.csv --inertial free --cutoff 25
  bipedc diagnose robots/tulip train.csv --validate other.csv --until-explained && bipedc history robots/tulip

Candidates (see `bipedc effects`) are fitted to the log, judged on the other one, and enter one after the other as
long as each lowers the held-out error by more than its price. Without --validate, blocks of the log itself judge.
--inertial says what may happen to masses and inertias meanwhile: `prior` lets them move as far as CAD data usually
are off (2 % of mass, 2 mm, 4 % of inertia), `none` keeps them, `free` estimates them (for robots whose URDF is a guess).
--refit does the same for the effects that the description has: their values there are forgotten and estimated again.
Currents of stiff drives (<joint>/motor_current, A) stand in for efforts that a log lacks, as in `bipedc compare`; the drives'
friction and rotor inertia are then effects of the model, and --refit estimates them too.

The data are checked first: swapped columns, wrong signs and units are named and stop the search (--anyway goes on);
joints that hardly move, clipped torques and motions that repeat are warnings. --until-explained writes what it finds
into the description, one step of its history per effect, and looks again until nothing is missing.";

/// How far inertial parameters may move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Inertial {
    /// As far as CAD data usually are off
    Prior,
    /// Not at all
    None,
    /// As far as the data say
    Free,
}

/// Find out which physical effect a model is missing
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Diagnose {
    #[command(flatten)]
    robot: RobotArguments,
    /// The log to find and estimate effects in
    #[arg(value_name = "LOG.csv")]
    log: PathBuf,
    /// Another log, that judges
    #[arg(long, value_name = "OTHER.csv")]
    validate: Option<PathBuf>,
    /// Cut-off of the filter, Hz; default: the one with the smallest error
    #[arg(long, value_name = "HZ")]
    cutoff: Option<f64>,
    /// Samples before this time of the log's clock (s) do not count
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    from: Option<f64>,
    /// Samples after this time of the log's clock (s) do not count
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    to: Option<f64>,
    /// What may happen to masses, centres of mass and inertias
    #[arg(long, value_enum, default_value = "prior")]
    inertial: Inertial,
    /// Most effects that are looked for
    #[arg(long, value_name = "N", default_value_t = Options::default().most)]
    most: usize,
    /// Estimate the effects of the description again, beside what is found
    #[arg(long)]
    refit: bool,
    /// TOML file with other column names, factors and signs
    #[arg(long, value_name = "FILE.toml")]
    mapping: Option<PathBuf>,
    /// Stance foot of postures, striking foot of impacts; default: the right one
    #[arg(long, value_name = "FOOT")]
    foot: Option<String>,
    /// Search even if channels of the log seem to be mixed up
    #[arg(long)]
    anyway: bool,
    /// Amend the description effect by effect until nothing more earns its place
    #[arg(long, conflicts_with = "json")]
    until_explained: bool,
    /// In logs with foot forces also explain the joints' efforts, not only what acts on the base; takes minutes
    #[arg(long)]
    with_joints: bool,
    /// Only rows of these kinds count: effort, transmission, base_force, base_moment, sole, cop, post_impact_velocity
    #[arg(long, value_name = "KIND,…", value_delimiter = ',')]
    channels: Vec<String>,
    #[command(flatten)]
    outputs: Outputs,
    /// Print the answer as JSON (docs/diagnosis.md explains every key)
    #[arg(long)]
    json: bool,
}

impl Diagnose {
    /// Reads, searches, prints.
    pub fn run(self) -> Outcome {
        self.check_files()?;
        if self.until_explained {
            return until_explained(&self.robot, &self.request()?);
        }
        let robot = self.robot.read()?;
        let report = |measured: &Measured, judge: &Loaded<'_>, answer: &Diagnosis| {
            if !self.outputs.wanted() {
                return Ok(());
            }
            let report = reporting::of_measurements(&robot, measured, judge, Some(answer))?;
            self.outputs.write(&Report { history: reporting::steps_of(&self.robot.path), ..report })
        };
        let (answer, warnings) = diagnose_files(&robot, &self.request()?, &report)?;
        output::diagnostics(&warnings);
        if self.json {
            output::print_json(&answer)?;
        } else {
            output::print(&text(&answer))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Before anything is computed: outputs must not be inputs.
    fn check_files(&self) -> Result<(), Failure> {
        let mut ledger = self.robot.ledger(&self.robot.read_quietly()?);
        ledger.reads("the log", &self.log);
        self.validate.iter().for_each(|log| ledger.reads("the log of --validate", log));
        self.mapping.iter().for_each(|file| ledger.reads("the mapping file", file));
        Ok(self.outputs.note(&mut ledger)?)
    }

    fn request(&self) -> Result<Request, Failure> {
        let nothing = CadError { mass: 0.0, center: 0.0, inertia: 0.0 };
        Ok(Request {
            log: self.log.clone(),
            validate: self.validate.clone(),
            mapping: self.mapping.as_deref().map(Mapping::open).transpose()?.unwrap_or_default(),
            reading: measure::Options {
                cutoff_hz: self.cutoff,
                from_s: self.from,
                to_s: self.to,
                ..measure::Options::default()
            },
            foot: self.foot.clone(),
            with_joints: self.with_joints,
            channels: self.channels.clone(),
            search: Options {
                cad: if self.inertial == Inertial::None { nothing } else { CadError::default() },
                widening: if self.inertial == Inertial::Free { 50.0 } else { 1.0 },
                most: self.most,
                standing: Vec::new(),
            },
            anyway: self.anyway,
            refit: self.refit,
        })
    }
}

/// The answer for people: words, then tables.
fn text(d: &Diagnosis) -> String {
    let mut out = format!("{}\n", d.summary);
    if !d.effects.is_empty() {
        out.push('\n');
        out.push_str(&output::table(
            &["effect", "where", "parameter", "value", "95 % from", "to", "unit", "share"],
            d.effects.iter().flat_map(effect_rows).collect(),
            3,
        ));
    }
    out.push('\n');
    let rows = d
        .rows
        .iter()
        .map(|(name, fall)| {
            let number = |x: f64| format!("{x:.4}");
            vec![name.clone(), number(fall.before), number(fall.after), number(fall.noise), fall.unit.clone()]
        })
        .collect();
    out.push_str(&output::table(&["held-out rms", "before", "after", "noise", "unit"], rows, 1));
    out
}

fn bound(x: f64) -> String {
    if x.is_finite() { format!("{x:.5}") } else { "unknown".to_owned() }
}

fn effect_rows(found: &Found) -> Vec<Vec<String>> {
    let effect = &found.effect;
    found
        .ci95
        .iter()
        .enumerate()
        .map(|(k, (name, [low, high]))| {
            let first = |text: String| if k == 0 { text } else { String::new() };
            vec![
                first(effect.kind.name.to_owned()),
                first(effect.location.to_string()),
                name.clone(),
                format!("{:.5}", effect.value(name)),
                bound(*low),
                bound(*high),
                effect.unit(name).to_owned(),
                first(format!("{:.1} %", 100.0 * found.share)),
            ]
        })
        .collect()
}
