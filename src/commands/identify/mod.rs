//! `bipedc identify`: inertial parameters from logs, with error bars, physically possible, as a new URDF.
mod cop;
mod elastic;
mod ground;
mod parse;
mod say;
mod zmp;

use crate::arguments::RobotArguments;
use crate::failure::{Failure, Outcome};
use crate::identifying::{Identified, content, inspected, loaded, table_survey};
use crate::measurements::{Content, Measured};
use crate::output;
use crate::reporting::{Outputs, of_identification};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::identify::physical::Inertia;
use bipedc_analysis::identify::{Answer, Feed, Judge, Log, Method, Options, Survey, identify, survey};
use bipedc_analysis::log::Mapping;
use bipedc_analysis::measure;
use bipedc_compiler::Robot;
use bipedc_compiler::description::model::{Inertial, Pose};
use bipedc_compiler::description::with_inertials;
use bipedc_effects::diagnostic::{Diagnostic, Severity};
use bipedc_effects::files::write;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
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

Four steps: base parameters of what was measured (thesis 5.2), with friction and offset of every joint, by least squares
with each joint's own noise; their standard errors, which respect that errors last; the fewest of them that predict as
well; and parameters of every link that a body can have, near the description where the data do not tell. How near is
chosen on the logs alone, by folds that never share a motion. Nothing of --validate is used for any choice.

With series elastic drives (--method elastic) springs measure the torques: motor currents tell friction and stiffness of
every drive first, from the drive trains of biped.toml; then the springs' torques tell the bodies.

Where the base moves and forces at the feet are logged, the rows of the base tell instead of joint torques.

Without joint torques: --method cop takes tables of static postures on force plates (columns `<joint>/position`, `cop/x`,
`cop/y`; `bipedc excite ROBOT --postures 50` designs them), --method zmp logs of a robot that stands on --stance
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
    /// What joints add: viscous, coulomb, offset, or none
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "viscous,coulomb,offset")]
    friction: Vec<String>,
    /// Joints whose effort moves a rotor too: names, `all` or `none`
    #[arg(long, value_name = "JOINTS", value_delimiter = ',', default_value = "none")]
    rotor: Vec<String>,
    /// Two joints whose drives turn together, such as those of a wrist; may be repeated
    #[arg(long, value_name = "JOINT,JOINT")]
    coupled: Vec<String>,
    /// Cut-off of the filter of positions and efforts, Hz
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, default_value_t = 10.0)]
    cutoff: f64,
    /// Keep every N-th sample, after a low-pass over regressor and torque
    #[arg(long, value_name = "N", default_value_t = 1)]
    decimate: usize,
    /// Samples at which a joint is slower than this part of its largest speed do not count for it, per cent [default: 0;
    /// motors of --method elastic: 3]
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    slow: Option<f64>,
    /// Motors first, then bodies, or one regression for both (--method elastic)
    #[arg(long, value_enum, default_value = "two")]
    steps: elastic::Steps,
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
    outputs: Outputs,
    /// Print the answer as JSON (docs/identification.md explains every key)
    #[arg(long)]
    json: bool,
}

impl Identify {
    /// Reads, estimates, prints.
    pub fn run(self) -> Outcome {
        self.check()?;
        let robot = self.robot.read()?;
        self.check_files(&robot)?;
        let mapping = self.mapping.as_deref().map(Mapping::open).transpose()?.unwrap_or_default();
        let reading = zmp::reading(&self);
        // The judge is another recording: its clock has nothing to do with --from and --to.
        let whole = measure::Options { from_s: None, to_s: None, ..reading.clone() };
        let log =
            |path, options: &measure::Options| Log { path, mapping: &mapping, options: options.clone() };
        let logs: Vec<Log<'_>> = self.logs.iter().map(|path| log(path, &reading)).collect();
        let judge = self.validate.as_deref().map(|path| log(path, &whole));
        match self.method {
            By::Torque => {}
            By::Elastic => return elastic::run(&self, &robot, &logs, judge.as_ref()),
            By::Cop => return self.finish(&robot, cop::run(&self, &robot, &mapping)?),
            By::Zmp => return self.finish(&robot, zmp::run(&self, &robot, &logs, judge.as_slice())?),
        }
        let measured = output::progress("deriving", || Measured::new(&robot))?;
        let every: Vec<Log<'_>> = logs.iter().chain(&judge).cloned().collect();
        let answer = match content(&measured, &every)? {
            Content::Contacts => self.of_contacts(&robot, &measured, &logs, judge.as_slice())?,
            _ => self.of_torques(&robot, &measured, &logs, judge.as_slice())?,
        };
        if let Some(path) = &self.write_urdf {
            write_urdf(&robot, &answer.links, path)?;
        }
        if self.outputs.wanted() {
            let (identification, rows) = (&answer.identification, answer.pictures.clone());
            self.outputs.write(&of_identification(&robot, identification, None, rows)?)?;
        }
        if self.json {
            output::print_json(&answer.identification)?;
        } else {
            output::print(&say::text(&answer.identification))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Writes and prints the answer of the methods that use the ground's forces.
    fn finish(&self, robot: &Robot, (answer, whole): (Answer, ground::GroundAnswer)) -> Outcome {
        if let Some(path) = &self.write_urdf {
            write_urdf(robot, &answer.links, path)?;
        }
        if self.outputs.wanted() {
            let (identification, rows) = (&answer.identification, answer.pictures.clone());
            self.outputs.write(&of_identification(robot, identification, None, rows)?)?;
        }
        if self.json {
            output::print_json(&whole)?;
        } else {
            output::print(&whole.text())?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// From joint torques of a robot whose base is held or hangs.
    fn of_torques(
        &self,
        robot: &Robot,
        measured: &Measured,
        logs: &[Log<'_>],
        judge: &[Log<'_>],
    ) -> Result<Answer, Failure> {
        let found = Identified::of_torques(robot, logs)?;
        let options = self.options(&found)?;
        self.inspect(measured, logs)?;
        let surveys = judge.iter().map(|log| survey(log, &found.subject)).collect::<Result<Vec<_>, _>>()?;
        let judge = judge.first().zip(surveys.first()).map(|(log, survey)| Judge {
            feed: Feed::Logs(judge),
            survey,
            file: log.path,
        });
        let feed = Feed::Logs(logs);
        let work =
            |progress: &dyn Fn(f64)| identify(&found.parts(), &feed, judge.as_ref(), &options, progress);
        Ok(output::bar("identifying", work)?)
    }

    /// From the rows of a free base and forces at the feet.
    fn of_contacts(
        &self,
        robot: &Robot,
        measured: &Measured,
        logs: &[Log<'_>],
        judge: &[Log<'_>],
    ) -> Result<Answer, Failure> {
        let tables = output::progress("reading", || loaded(measured, logs))?;
        let judges = output::progress("reading", || loaded(measured, judge))?;
        let found = Identified::of_contacts(robot, logs, &tables)?;
        let options = self.options(&found)?;
        let experiments: Vec<&dyn Experiment> = tables.iter().map(|table| &*table.experiment).collect();
        let judging: Vec<&dyn Experiment> = judges.iter().map(|table| &*table.experiment).collect();
        let surveys: Vec<Survey> = judges.iter().map(|table| table_survey(table, &found.subject)).collect();
        let judge = judge.first().zip(surveys.first()).map(|(log, survey)| Judge {
            feed: Feed::Tables(&judging),
            survey,
            file: log.path,
        });
        let feed = Feed::Tables(&experiments);
        let work =
            |progress: &dyn Fn(f64)| identify(&found.parts(), &feed, judge.as_ref(), &options, progress);
        Ok(output::bar("identifying", work)?)
    }

    /// Before anything is computed: outputs must not be inputs.
    fn check_files(&self, robot: &Robot) -> Result<(), Diagnostic> {
        let mut ledger = self.robot.ledger(robot);
        self.logs.iter().for_each(|log| ledger.reads("a log", log));
        self.validate.iter().for_each(|log| ledger.reads("the log of --validate", log));
        self.mapping.iter().for_each(|file| ledger.reads("the mapping file", file));
        self.write_urdf.as_ref().map_or(Ok(()), |file| ledger.writes("--write-urdf", file))?;
        self.outputs.note(&mut ledger)
    }

    /// Numbers that have no meaning.
    fn check(&self) -> Result<(), Diagnostic> {
        let refuse = |what: &str, value: f64, help: &str| {
            Err(Diagnostic::error(format!("{what} is {value}")).help(help.to_owned()))
        };
        if !(self.cutoff.is_finite() && self.cutoff > 0.0) {
            return refuse("--cutoff", self.cutoff, "give a frequency in Hz");
        }
        let slow = self.slow.unwrap_or(0.0);
        if !(0.0..50.0).contains(&slow) {
            return refuse("--slow", slow, "give a part of the largest speed in per cent, below 50");
        }
        if !(self.trim.is_finite() && self.trim >= 0.0) {
            return refuse("--trim", self.trim, "give a time in s");
        }
        if self.steps == elastic::Steps::One && self.method != By::Elastic {
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

    fn options(&self, parts: &Identified) -> Result<Options, Diagnostic> {
        let extras = parse::extras(&parts.subject, &self.friction, &self.rotor, &self.coupled)?;
        Ok(Options { extras, ..self.estimation()? })
    }

    /// Options that all methods have.
    fn estimation(&self) -> Result<Options, Diagnostic> {
        Ok(Options {
            method: match self.estimator {
                Estimator::Ordinary => Method::Ordinary,
                Estimator::Weighted => Method::Weighted,
                Estimator::Huber => Method::Huber,
                Estimator::Instrumental => {
                    return Err(Diagnostic::error("--estimator instrumental is for --method elastic")
                        .help("choose ordinary, weighted or huber"));
                }
            },
            decimate: self.decimate,
            slow: self.slow.unwrap_or(0.0) / 100.0,
            weight: self.weight,
            bounds: parse::bounds(self.total_mass, &self.center, &self.mirror)?,
            pictures: self.outputs.wanted(),
            ..Options::default()
        })
    }

    /// Looks for mixed-up channels before anything is estimated.
    fn inspect(&self, measured: &Measured, logs: &[Log<'_>]) -> Result<(), Failure> {
        let mut found = output::progress("checking", || inspected(measured, logs))?;
        if self.anyway {
            found.iter_mut().for_each(|diagnostic| diagnostic.severity = Severity::Warning);
        }
        if found.iter().any(|diagnostic| diagnostic.severity == Severity::Error) {
            return Err(Failure(found));
        }
        output::diagnostics(&found);
        Ok(())
    }
}

/// The robot's URDF with the new inertias; whole or not at all.
fn write_urdf(robot: &Robot, links: &[(String, Inertia)], path: &Path) -> Result<(), Diagnostic> {
    let inertial = |inertia: &Inertia| {
        let i = &inertia.inertia;
        Inertial {
            mass: inertia.mass,
            origin: Pose { xyz: inertia.center.into(), rpy: [0.0; 3] },
            inertia: [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]],
        }
    };
    let links: Vec<(String, Inertial)> =
        links.iter().map(|(name, inertia)| (name.clone(), inertial(inertia))).collect();
    let text = with_inertials(&robot.sources.urdf_text, &robot.sources.urdf_path, &links)?;
    write(path, &text)
}
