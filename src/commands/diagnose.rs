//! `bipedc diagnose`: which physical effect is missing, where, how large, how sure.
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::{Failure, Outcome};
use crate::terminal::next::Typed;
use crate::terminal::output;
use crate::terminal::pages::Pages;
use bipedc::amendment::history::Step;
use bipedc::amendment::{Amended, comments, description_path};
use bipedc::diagnosis::{self, Diagnosed, Options};
use bipedc::workbench::{Event, Explained};
use bipedc::{Diagnostic, Diagnostics, Log, Workbench};
use bipedc_analysis::diagnose::{Diagnosis, FoundEffect};
use bipedc_analysis::log::Mapping;
use bipedc_analysis::measure;
use bipedc_analysis::report::{NextStep, Report};
use bipedc_compiler::description::model::Base;
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc diagnose robots/tulip train.csv --validate other.csv
  bipedc diagnose robots/tulip train.csv --validate other.csv --json > diagnosis.json
  bipedc diagnose robots/tulip train.csv --validate other.csv --report report.html --svg figures
  bipedc diagnose my_arm log.csv --inertial free --cutoff 25
  bipedc diagnose robots/tulip train.csv --validate other.csv --until-explained && bipedc history robots/tulip

Candidates (see `bipedc effects`) are fitted to the log, judged on the other one, and enter one after the other as \
long as each lowers the held-out error by more than its price. Without --validate, blocks of the log itself judge.
--inertial says what may happen to masses and inertias meanwhile: `prior` lets them move as far as CAD data usually \
are off (masses by 2 %, centres of mass by 2 % of a link's size, inertias by 4 %), `none` keeps them, \
`free` estimates them (for robots whose URDF is a guess).
--refit does the same for the effects that the description has: their values there are forgotten and estimated again.
Currents of stiff drives (<joint>/motor_current, A) stand in for efforts that a log lacks, as in `bipedc compare`; the drives' \
friction and rotor inertia are then effects of the model, and --refit estimates them too.

The data are checked first: swapped columns, wrong signs and units are named and stop the search (--anyway goes on); \
joints that hardly move, clipped torques and motions that repeat are warnings. --until-explained writes what it finds \
into the description, one step of its history per effect, and looks again until nothing is missing.

`bipedc log` tells what a log has and proposes names for its columns; docs/logs.md has every column, docs/diagnosis.md every key of \
--json.";

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
    /// Most effects that are looked for [default: 12, or two for every joint and two more; at most 24]
    #[arg(long, value_name = "N")]
    most: Option<usize>,
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
    #[arg(long)]
    until_explained: bool,
    /// What is the case without it, too: joints' efforts are explained wherever they are logged, beside forces at the feet;
    /// `--channels base_force,base_moment` leaves them out
    #[arg(long, hide = true)]
    with_joints: bool,
    /// Only rows of these kinds count: effort, transmission, base_force, base_moment, sole, cop, post_impact_velocity
    #[arg(long, value_name = "KIND,…", value_delimiter = ',')]
    channels: Vec<String>,
    #[command(flatten)]
    pages: Pages,
    /// Print the answer as JSON (docs/diagnosis.md explains every key)
    #[arg(long)]
    json: bool,
}

/// What `--until-explained --json` prints.
#[derive(Serialize)]
struct Explanation<'a> {
    /// As in the history, in their order.
    steps: &'a [Step],
    searches: usize,
    /// Whether the last search found nothing more.
    complete: bool,
    /// Its answer.
    last: &'a Diagnosed,
}

/// An estimate that leaves more of the error than this part says nothing new.
const LOWER: f64 = 0.99;

impl Diagnose {
    /// Reads, searches, prints.
    pub fn run(self) -> Outcome {
        let bench = self.robot.open_quietly()?;
        self.check_files(&bench)?;
        if self.until_explained {
            return self.explain(&bench);
        }
        output::diagnostics(&bench.robot().warnings);
        let (log, judge) = self.logs(&bench, self.mapping()?)?;
        let found = bench.diagnose_with(&log, judge.as_ref(), &self.options())?;
        if let Some(report) = &found.report {
            self.pages.write(&Report { next: self.next(&bench, &found), ..report.clone() })?;
        }
        output::diagnostics(&found.warnings);
        if self.json {
            output::print_json(&found)?;
        } else {
            output::print(&found.to_string())?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Diagnoses and amends in turn.
    fn explain(&self, bench: &Workbench) -> Outcome {
        let mapping = self.mapping()?;
        // Better now than after the search.
        description_path(bench.path())?;
        output::diagnostics(&bench.robot().warnings);
        let (log, judge) = self.logs(bench, mapping)?;
        let options = self.options();
        let mut steps = Vec::new();
        let explained = bench.explain((&log, judge.as_ref()), &options, &mut |event| {
            let text = match event {
                Event::Warnings(warnings) => {
                    output::diagnostics(warnings);
                    return Ok(());
                }
                Event::Step(amended) => {
                    output::diagnostics(&amended.warnings);
                    steps.push(amended.step.clone());
                    step(amended)
                }
            };
            if self.json {
                return Ok(());
            }
            output::print(&text).map_err(|error| Diagnostics::from(Diagnostic::error(error.to_string())))
        })?;
        if let Some(report) = &explained.last.report {
            self.pages.write(&Report { next: self.next(bench, &explained.last), ..report.clone() })?;
        }
        if self.json {
            let (complete, searches) = (explained.is_complete(), explained.searches);
            output::print_json(&Explanation { steps: &steps, searches, complete, last: &explained.last })?;
        } else {
            output::print(&end(&explained))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Before anything is computed: outputs must not be inputs.
    fn check_files(&self, bench: &Workbench) -> Result<(), Failure> {
        let mut ledger = bench.ledger();
        ledger.reads("the log", &self.log);
        self.validate.iter().for_each(|log| ledger.reads("the log of --validate", log));
        self.mapping.iter().for_each(|file| ledger.reads("the mapping file", file));
        Ok(self.pages.note(&mut ledger)?)
    }

    /// What one does after this.
    fn next(&self, bench: &Workbench, found: &Diagnosis) -> Vec<NextStep> {
        let robot = &self.robot.path;
        let mut steps = Vec::new();
        // Of the description, estimated again: other values with which less is left.
        let is_better = !found.standing.is_empty() && found.rms_after < LOWER * found.rms_before;
        if is_better || !(found.effects.is_empty() && found.inertial_corrections.is_empty()) {
            let amend = Typed::command("amend").path(robot).words(" --from diagnosis.json").because("");
            let again = self.again().words(" --json > diagnosis.json && ").words(&amend.command);
            steps.push(
                again.because(
                    "Write what was found into the description; `bipedc amend --undo` takes it back:",
                ),
            );
        }
        steps.extend(found.indistinguishable.iter().find_map(|group| self.separate(bench, group)));
        if found.unexplained {
            let compare = self.compare(found);
            let why = match found.leaves_structure() {
                true => {
                    "Something is left that no effect of the library explains. When it happens, and what it goes with:"
                }
                false => {
                    "What is left is above the noise, or noise of a slow filter. When it is largest, and what it goes with:"
                }
            };
            steps.push(compare.words(" --where").because(why));
        }
        if steps.is_empty() {
            let generate = Typed::command("generate").path(robot).words(&self.robot.overrides());
            steps.push(generate.because("Nothing is missing that these logs could show. The model as code:"));
        }
        steps
    }

    /// What the answer leaves, on the log that judged and behind the same filter.
    fn compare(&self, found: &Diagnosis) -> Typed {
        let cutoff_hz = Some(found.judged_at_hz.unwrap_or(found.cutoff_hz)).filter(|hz| *hz > 0.0);
        // All of a log of its own judges.
        let taught = |_: &&f64| self.validate.is_none();
        Typed::command("compare")
            .path(&self.robot.path)
            .path(self.validate.as_ref().unwrap_or(&self.log))
            .words(&self.robot.overrides())
            .file("--mapping", self.mapping.as_deref())
            .option("--cutoff", cutoff_hz.as_ref())
            .option("--from", self.from.as_ref().filter(taught))
            .option("--to", self.to.as_ref().filter(taught))
            .option("--foot", self.foot.as_ref())
    }

    /// The same search.
    fn again(&self) -> Typed {
        let inertial = self.inertial.to_possible_value().map(|value| value.get_name().to_owned());
        let inertial = inertial.filter(|_| self.inertial != Inertial::Prior);
        let flags =
            [(self.refit, " --refit"), (self.anyway, " --anyway"), (self.with_joints, " --with-joints")];
        let flags: String = flags.iter().filter(|(given, _)| *given).map(|(_, flag)| *flag).collect();
        let channels = (!self.channels.is_empty()).then(|| self.channels.join(","));
        Typed::command("diagnose")
            .path(&self.robot.path)
            .path(&self.log)
            .words(&self.robot.overrides())
            .file("--validate", self.validate.as_deref())
            .file("--mapping", self.mapping.as_deref())
            .option("--cutoff", self.cutoff.as_ref())
            .option("--from", self.from.as_ref())
            .option("--to", self.to.as_ref())
            .option("--foot", self.foot.as_ref())
            .option("--inertial", inertial.as_ref())
            .option("--most", self.most.as_ref())
            .option("--channels", channels.as_ref())
            .words(&flags)
    }

    /// A motion that tells two effects of one joint apart.
    fn separate(&self, bench: &Workbench, group: &[Vec<FoundEffect>]) -> Option<NextStep> {
        let ([first], [second]) = (group.first()?.as_slice(), group.get(1)?.as_slice()) else { return None };
        let (first, second) = (&first.effect, &second.effect);
        let joint =
            first.location.joint.as_ref().filter(|joint| second.location.joint.as_ref() == Some(joint))?;
        // Motions are designed for robots that are held.
        let is_held = matches!(bench.robot().description.base, Base::Fixed { .. });
        let excite = Typed::command("excite")
            .path(&self.robot.path)
            .words(if is_held { "" } else { " --base fixed" })
            .words(&format!(" --separate {} {}", first.kind.name, second.kind.name))
            .option("--joint", Some(joint))
            .words(" --out apart.csv");
        Some(excite.because("This log cannot tell two explanations apart. A motion that can:"))
    }

    fn mapping(&self) -> Result<Mapping, Failure> {
        Ok(self.mapping.as_deref().map(Mapping::open).transpose()?.unwrap_or_default())
    }

    fn logs(&self, bench: &Workbench, mapping: Mapping) -> Result<(Log, Option<Log>), Failure> {
        let log = bench.log_with(&self.log, mapping.clone())?;
        let judge = self.validate.as_ref().map(|log| bench.log_with(log, mapping)).transpose()?;
        Ok((log, judge))
    }

    fn options(&self) -> Options {
        Options {
            reading: measure::Options {
                cutoff_hz: self.cutoff,
                from_s: self.from,
                to_s: self.to,
                ..measure::Options::default()
            },
            foot: self.foot.clone(),
            with_joints: self.with_joints
                || self.channels.is_empty()
                || self.channels.iter().any(|c| c == "effort"),
            channels: self.channels.clone(),
            inertial: match self.inertial {
                Inertial::Prior => diagnosis::Inertial::Prior,
                Inertial::None => diagnosis::Inertial::Known,
                Inertial::Free => diagnosis::Inertial::Free,
            },
            most: self.most,
            anyway: self.anyway,
            refit: self.refit,
            report: self.pages.wanted(),
        }
    }
}

/// After a step.
fn step(amended: &Amended) -> String {
    let mut text = format!("step {}\n", amended.step.step);
    for change in &amended.step.changes {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {}: {}", comments::title(&change.effect), comments::estimates(change));
    }
    if let Some(error) = amended.step.errors.first() {
        let _ = writeln!(text, "  error: {}{}", comments::error(error), amended.step.filter());
    }
    text
}

/// After the last.
fn end(explained: &Explained) -> String {
    if !explained.is_complete() {
        return "something more was found in every search: look at the report before going on\n".to_owned();
    }
    let head = if explained.searches == 1 { "nothing was added" } else { "nothing more earns its place" };
    format!("{head}\n{}\n", explained.last.summary)
}
