//! `bipedc history`: what was done to a description, and how the error fell.
use crate::terminal::failure::{Failure, Outcome};
use crate::terminal::output;
use bipedc::amendment::history::{Action, HistoryState, Stair, Step};
use bipedc::amendment::{self, comments, open, picture, svg};
use bipedc::report;
use bipedc_analysis::report::{Report, write};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::{Ledger, write_with_folders};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc history robots/tulip
  bipedc history robots/tulip --json
  bipedc history robots/tulip --svg staircase.svg

Every `bipedc amend` is a step. Errors are root mean squares on held-out data, else on the training data; they are \
known for effects that a diagnosis or an estimate brought. `bipedc amend ROBOT --undo` takes the last step back.
JSON: {\"description\", \"state\": \"agrees\", \"last_step_missing\" or \"edited\", \"steps\": [as in history.json, without the \
kept text], \"stairs\": [{\"step\", \"label\", \"date\", \"channel\", \"unit\", \"before\", \"after\", \"noise\", \"held_out\"}]}.";

/// Show what was added to a robot's description and how its error fell
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct History {
    /// Folder with `biped.toml`, or that file
    #[arg(value_name = "ROBOT")]
    path: PathBuf,
    /// Also write the falling error as a picture
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// Also write it as a page to look at, which opens in any browser
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Json {
    description: String,
    state: &'static str,
    steps: Vec<serde_json::Value>,
    stairs: Vec<Stair>,
}

impl History {
    /// Reads and prints.
    pub fn run(self) -> Outcome {
        let (description, text, history) = open(&self.path)?;
        self.check_files(&description)?;
        let standing = history.state(&text);
        let stairs = history.stairs();
        if let Some(file) = &self.svg {
            write_with_folders(file, &svg::staircase(&stairs))?;
        }
        self.write_page(&description, &history)?;
        if self.json {
            let steps = history.steps.iter().map(without_text).collect();
            let state = state(standing);
            output::print_json(&Json {
                description: description.display().to_string(),
                state,
                steps,
                stairs,
            })?;
            return Ok(ExitCode::SUCCESS);
        }
        if history.steps.is_empty() {
            output::print(&format!(
                "{} was never amended; bipedc amend --help shows how\n",
                description.display()
            ))?;
            return Ok(ExitCode::SUCCESS);
        }
        let mut out = table(&history.steps) + &remarks(&history.steps, standing);
        let picture = picture::staircase(&stairs);
        if !picture.is_empty() {
            out += &format!("\n{picture}");
        }
        if let Some(file) = &self.svg {
            out += &format!("wrote {}\n", file.display());
        }
        output::print(&out)?;
        Ok(ExitCode::SUCCESS)
    }

    fn write_page(&self, description: &Path, history: &amendment::history::History) -> Result<(), Failure> {
        let Some(file) = &self.report else { return Ok(()) };
        let robot = description.parent().and_then(Path::file_name).unwrap_or_default();
        let robot = robot.to_string_lossy().into_owned();
        let title = format!("{}: what was added, and how the error fell", description.display());
        let (history, changes) = (report::steps(history), report::changes(history));
        write(&Report { title, robot, history, changes, ..Report::default() }, file)?;
        output::remark(&format!("wrote {}", file.display()));
        Ok(())
    }

    /// Pictures and pages must not replace what belongs to the robot.
    fn check_files(&self, description: &Path) -> Result<(), Diagnostic> {
        let mut ledger = Ledger::default();
        ledger.reads("the robot's description", description);
        ledger.reads("the description's history", &amendment::history::History::path(description));
        if let Ok(robot) = Robot::read(description) {
            robot.note(&mut ledger);
        }
        self.svg.as_ref().map_or(Ok(()), |file| ledger.writes("--svg", file))?;
        self.report.as_ref().map_or(Ok(()), |file| ledger.writes("--report", file))
    }
}

fn state(standing: HistoryState) -> &'static str {
    match standing {
        HistoryState::Agree => "agrees",
        HistoryState::LastStepMissing => "last_step_missing",
        HistoryState::Edited => "edited",
    }
}

/// A step without the description's text, which serves undoing alone.
fn without_text(step: &Step) -> serde_json::Value {
    let mut value = serde_json::to_value(step).unwrap_or_default();
    if let Some(object) = value.as_object_mut() {
        object.remove("previous_text");
    }
    value
}

fn table(steps: &[Step]) -> String {
    let head = ["step", "date (UTC)", "effect", "parameters", "held-out error", "training error"];
    let mut rows = Vec::new();
    for step in steps {
        for (index, change) in step.changes.iter().enumerate() {
            let error = change.error.as_ref();
            let error = error.or(if index == 0 { step.main_error() } else { None });
            let fall = |fall: Option<_>| match (fall, error) {
                (Some(fall), Some(error)) => comments::fall(&fall, &error.unit),
                _ => "—".to_owned(),
            };
            let action = match change.action {
                Action::Added => "+ ",
                Action::Replaced => "~ ",
                Action::Removed => "- ",
            };
            let taken_back = if step.stands() { "" } else { " (taken back)" };
            rows.push(vec![
                if index == 0 { step.step.to_string() } else { String::new() },
                if index == 0 { minute(&step.date) } else { String::new() },
                format!("{action}{}{taken_back}", comments::title(&change.effect)),
                comments::one_line(&comments::noticeable(change)),
                fall(error.and_then(|error| error.held_out)),
                fall(error.and_then(|error| error.training)),
            ]);
        }
    }
    bipedc::table::table(&head, rows, 4)
}

/// `2026-01-31 12:30`
fn minute(date: &str) -> String {
    comments::one_line(&date.get(..16).unwrap_or(date).replace('T', " "))
}

fn remarks(steps: &[Step], standing: HistoryState) -> String {
    let mut text = String::new();
    let standing_steps: Vec<&Step> = steps.iter().filter(|step| step.stands()).collect();
    for pair in standing_steps.windows(2) {
        if pair[0].after != pair[1].before {
            text += &format!(
                "between steps {} and {} the description was edited by hand\n",
                pair[0].step, pair[1].step
            );
        }
    }
    for step in &standing_steps {
        if let (Some(hz), false) = (step.cutoff_hz, step.errors.is_empty()) {
            text += &format!(
                "errors of step {}: behind a filter of {hz} Hz (`bipedc compare --cutoff {hz}`)\n",
                step.step
            );
        }
    }
    if let Some(last) = standing_steps.last() {
        text += &match standing {
            HistoryState::Agree => String::new(),
            HistoryState::LastStepMissing => format!(
                "step {} is not in the description: it was interrupted, or the file restored by other means; the \
                 next amend marks it\n",
                last.step
            ),
            HistoryState::Edited => format!("the description was edited by hand since step {}\n", last.step),
        };
    }
    text
}
