//! `bipedc amend`: adds effects to a robot's description, and takes them back.
mod parse;
mod text;

use crate::terminal::assignments;
use crate::terminal::failure::{Failure, Outcome};
use crate::terminal::output;
use crate::terminal::progress::Bars;
use bipedc::Workbench;
use bipedc::amendment::answer::Answer;
use bipedc::amendment::diagnosis::{self, Selection};
use bipedc::amendment::{Proposal, Proposed, Request, amend, description_path, undo};
use bipedc::kinds::demand_kind;
use bipedc_analysis::diagnose::{Diagnosis, ErrorFall, rises};
use bipedc_analysis::number::counting;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Effect, Location, kinds};
use clap::{ArgGroup, Args};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

/// As clap has it, but broken where a terminal of 80 columns ends.
const USAGE: &str = "bipedc amend [OPTIONS] <ROBOT> [LOG.csv] --effect <KIND>\n       bipedc amend [OPTIONS] <ROBOT> [LOG.csv] --formula <TEXT>\n       bipedc amend [OPTIONS] <ROBOT> --from <FILE.json>\n       bipedc amend [OPTIONS] <ROBOT> --undo";

const EXAMPLES: &str = "\
Examples:
  bipedc amend robots/tulip --effect coulomb_friction --joint left_knee_pitch --set torque=0.43
  bipedc amend robots/tulip --effect payload --link torso --set mass=1.2,x=0.05,y=0,z=0.3
  bipedc amend robots/tulip --formula \"k * sin(3 * position)\" --name cable --joint left_knee_pitch \\
         --param \"k=0.1,unit=N m,min=0,max=2\"
  bipedc amend robots/tulip --from diagnosis.json           all that it found
  bipedc amend robots/tulip --from diagnosis.json --only 1  the most important
  bipedc amend robots/tulip --from identified.json          an identification's
  bipedc amend robots/tulip --effect coulomb_friction --joint left_knee_pitch --remove
  bipedc amend robots/tulip --undo                          as it was before

An effect stands as an [[effect]] table in biped.toml; `bipedc effects` lists the kinds with their parameters and \
units (SI). Comments and order of the file stay. An effect of the same kind at the same place gets the new parameters, \
unless --add. Nothing is written unless the amended description reads. Every amend is a step in history.json beside \
the description: `bipedc history` shows them.
JSON: the step {\"step\", \"date\", \"tool\", \"origin\", \"changes\": [{\"action\", \"effect\", \"ci95\", \"previous\", \"error\"}], \"training\", \"validation\", \"errors\", \"note\", \
\"before\", \"after\": {\"hash\", \"bytes\"}, \"previous_text\", \"undone\"}; what is not known is left out.";

/// Add an effect to a robot's description, or take the last step back
#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = USAGE)]
#[command(group(ArgGroup::new("what").required(true).args(["effect", "formula", "from", "undo"])))]
pub struct Amend {
    /// Folder with `biped.toml`, or that file
    #[arg(value_name = "ROBOT")]
    path: PathBuf,
    /// Estimate from this log the parameters that --set does not give
    #[arg(value_name = "LOG.csv", conflicts_with_all = ["from", "undo", "remove"])]
    log: Option<PathBuf>,
    /// Kind of the effect; `bipedc effects` lists them
    #[arg(long, value_name = "KIND")]
    effect: Option<String>,
    /// A law of your own: the torque (N m) as a formula in position, velocity, acceleration, load and parameters
    #[arg(long, value_name = "TEXT", conflicts_with_all = ["link", "sensor"])]
    formula: Option<String>,
    /// Take what a diagnosis or an identification found (their JSON)
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["joint", "other_joint", "link", "sensor", "set"])]
    from: Option<PathBuf>,
    /// Take the last step back, byte for byte
    #[arg(long, conflicts_with_all = ["joint", "other_joint", "link", "sensor", "set", "add", "dry_run"])]
    undo: bool,
    /// The joint whose torque changes
    #[arg(long, value_name = "JOINT")]
    joint: Option<String>,
    /// The joint whose motion causes it
    #[arg(long, value_name = "JOINT", requires = "joint")]
    other_joint: Option<String>,
    /// The link whose inertia changes
    #[arg(long, value_name = "LINK")]
    link: Option<String>,
    /// Foot force sensor, FOOT or FOOT/CORNER; without it all of them
    #[arg(long, value_name = "SENSOR")]
    sensor: Option<String>,
    /// A parameter in its SI unit; several times or with commas
    #[arg(long, value_name = "NAME=VALUE", value_delimiter = ',')]
    set: Vec<String>,
    /// Name of the formula
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// A parameter of the formula: value, and if you like unit and bounds of the estimator
    #[arg(long, value_name = "NAME=VALUE[,unit=U][,min=A][,max=B]", requires = "formula")]
    param: Vec<String>,
    /// The log that judges an estimate
    #[arg(long, value_name = "LOG.csv", requires = "log")]
    validate: Option<PathBuf>,
    /// Of a diagnosis only this: its number from 1, KIND or KIND:PLACE; several times or with commas
    #[arg(long, value_name = "WHICH", value_delimiter = ',', requires = "from")]
    only: Vec<String>,
    /// Also the corrections of masses and inertias, which were estimated beside all effects: with --only, or where nothing else was found
    #[arg(long, requires = "from")]
    with_corrections: bool,
    /// Add the effect even where one of its kind stands
    #[arg(long)]
    add: bool,
    /// Take the effect out instead
    #[arg(long, conflicts_with_all = ["from", "undo", "set", "param", "add"])]
    remove: bool,
    /// With --undo: also when the description was edited since. The edits go, a copy of them is kept in a file
    #[arg(long, requires = "undo")]
    force: bool,
    /// Show what would change, and write nothing
    #[arg(long)]
    dry_run: bool,
    /// Print the step as JSON
    #[arg(long)]
    json: bool,
}

impl Amend {
    /// Amends or takes back, and says what was done.
    pub fn run(self) -> Outcome {
        if self.undo {
            return self.take_back();
        }
        self.log.as_deref().map_or(Ok(()), assignments::refuse)?;
        let proposal = self.proposal()?;
        if proposal.effects.is_empty() {
            output::print("the diagnosis found no missing effect: nothing to add\n")?;
            return Ok(ExitCode::SUCCESS);
        }
        let amended = amend(&self.path, &proposal, self.dry_run)?;
        output::diagnostics(&amended.warnings);
        if self.json {
            output::print_json(&amended.step)?;
        } else if self.dry_run {
            output::print(&text::difference(&amended))?;
        } else {
            output::print(&text::amended(&amended, &self.path))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn take_back(&self) -> Outcome {
        let undone = undo(&self.path, self.force)?;
        if self.json {
            output::print_json(&undone.step)?;
        } else {
            output::print(&text::undone(&undone))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn proposal(&self) -> Result<Proposal, Failure> {
        if let Some(file) = &self.from {
            return self.proposal_of(file);
        }
        let effect = self.stated()?;
        if let Some(log) = &self.log {
            return self.estimated(effect, log);
        }
        if effect.parameters.is_empty() && !self.remove {
            parse::demand_parameters(&effect)?;
        }
        let request = match (self.remove, self.add) {
            (true, _) => Request::Remove,
            (_, true) => Request::Add,
            _ => Request::Put,
        };
        let origin = if self.remove { "taken out" } else { "values given" }.to_owned();
        let effects = vec![Proposed { effect, ci95: BTreeMap::new(), error: None, request }];
        Ok(Proposal { effects, origin, ..Proposal::default() })
    }

    fn proposal_of(&self, file: &Path) -> Result<Proposal, Failure> {
        let named = |error: Diagnostic| error.in_file(file);
        match Answer::read(file)? {
            Answer::Diagnosis(found) => {
                let origin = format!("diagnosis {}", file.display());
                Ok(diagnosis::propose(&found, &self.selection(), &origin).map_err(named)?)
            }
            Answer::Identification(found) => {
                if !self.only.is_empty() || self.add {
                    let message = "an identification is taken as a whole: its parameters belong together";
                    return Err(named(Diagnostic::error(message).help("leave out --only and --add")).into());
                }
                let bench =
                    Workbench::open(description_path(&self.path)?)?.watched(Arc::new(Bars::default()));
                let origin = format!("identification {}", file.display());
                Ok(bench.proposal_of(&found, &origin).map_err(named)?)
            }
        }
    }

    fn selection(&self) -> Selection {
        Selection { only: self.only.clone(), corrections: self.with_corrections, add: self.add }
    }

    /// The effect as the arguments state it, with the parameters that they give.
    fn stated(&self) -> Result<Effect, Diagnostic> {
        let kind = self.effect.as_deref().map(demand_kind).transpose()?.unwrap_or(&kinds::FORMULA);
        let location = Location {
            joint: self.joint.clone(),
            other_joint: self.other_joint.clone(),
            link: self.link.clone(),
            sensor: self.sensor.clone(),
        };
        let mut effect = Effect::new(kind, location, &[]);
        effect.name.clone_from(&self.name);
        effect.torque.clone_from(&self.formula);
        for text in &self.set {
            let (name, value) = parse::assignment(text, "--set torque=0.43")?;
            effect.parameters.insert(name, value);
        }
        for text in &self.param {
            let (name, value, own) = parse::own_parameter(text)?;
            effect.parameters.insert(name.clone(), value);
            effect.own.insert(name, own);
        }
        Ok(effect)
    }

    fn estimated(&self, effect: Effect, log: &Path) -> Result<Proposal, Failure> {
        let bench = Workbench::open(description_path(&self.path)?)?.watched(Arc::new(Bars::default()));
        let log = bench.log(log)?;
        let judge = self.validate.as_ref().map(|log| bench.log(log)).transpose()?;
        let is_given = effect.kind.estimated().all(|known| effect.parameters.contains_key(known.name));
        let found = bench.estimate(&[effect], &log, judge.as_ref())?;
        output::diagnostics(&found.warnings);
        if let Some(risen) = risen(&found.diagnosis).filter(|_| !is_given) {
            return Err(risen.in_file(log.path()).into());
        }
        Ok(diagnosis::propose(&found, &self.selection(), "estimated")?)
    }
}

/// An estimate with which errors rise is none: where it began, nothing lowered them.
fn risen(found: &Diagnosis) -> Option<Diagnostic> {
    let kind = found.telling_channel()?;
    let fall = |falls: &BTreeMap<String, ErrorFall>| falls.get(kind).cloned();
    let told = [("held-out", fall(&found.rms)), ("training", fall(&found.rms_training))];
    let rises = |fall: &ErrorFall| rises(fall.before, fall.after, 0.0);
    let (which, fall) = told.into_iter().find_map(|(which, fall)| Some((which, fall.filter(rises)?)))?;
    let message = format!(
        "with what the log estimates of this effect its {which} error of the {} rises from {} to {} {}: nothing was written",
        kind.replace('_', " "),
        counting(fall.before, 4),
        counting(fall.after, 4),
        fall.unit
    );
    Some(Diagnostic::error(message).help(
        "give some of its parameters with --set, so that the others are estimated beside them, or all of them without a log",
    ))
}
