//! Writing a proposal into a description.
use super::files::{Lock, prepared, read_text};
use super::history::{Action, BeforeAfter, Change, ChannelError, History, HistoryState, Step, Version, pack};
use super::text::{self, Written};
use super::{Proposal, Proposed, Request, comments, description_path, is_same, now};
use crate::robot::link_inertias::by_itself;
use bipedc_analysis::diagnose::rises;
use bipedc_analysis::number::counting;
use bipedc_compiler::description::SourceFiles;
use bipedc_compiler::description::model::RobotDescription;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, Severity};
use bipedc_effects::effect::{Effect, Law};
use bipedc_effects::files::Batch;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What was done.
#[derive(Debug)]
pub struct Amended {
    /// As noted in the history.
    pub step: Step,
    /// The description.
    pub description: PathBuf,
    /// Its text before.
    pub before: String,
    /// And after.
    pub after: String,
    /// What became known on the way, in words.
    pub remarks: Vec<String>,
    /// What is odd about the new effects.
    pub warnings: Vec<Diagnostic>,
}

/// Amends a description and notes the step in its history; with `dry_run` nothing is written.
///
/// # Errors
/// A description that does not read, before or after; effects that are not there; files that cannot be written. Then
/// nothing was changed.
pub fn amend(path: &Path, proposal: &Proposal, dry_run: bool) -> Result<Amended, Diagnostics> {
    let description = description_path(path)?;
    let _lock = Lock::of_folder(&description, &[&description, &History::path(&description)])?;
    let sources = SourceFiles::load(&description)?;
    let read = sources.parse()?;
    let mut history = History::open(&description)?;
    let amended = entered(&sources, read, &mut history, proposal)?;
    if !dry_run {
        write(&description, &amended.before, &amended.after, &history)?;
    }
    Ok(amended)
}

/// Amends a description that stays in memory: nothing is read, nothing is written, no history is kept.
///
/// # Errors
/// As [`amend`], without those of files.
pub fn amend_in_memory(sources: &SourceFiles, proposal: &Proposal) -> Result<Amended, Diagnostics> {
    entered(sources, sources.parse()?, &mut History::default(), proposal)
}

/// What a proposal makes of a description, entered into its history.
fn entered(
    sources: &SourceFiles,
    (robot, old_warnings): (RobotDescription, Vec<Diagnostic>),
    history: &mut History,
    proposal: &Proposal,
) -> Result<Amended, Diagnostics> {
    let description = sources.toml_path.clone();
    let (date, before) = (now(), sources.toml_text.clone());
    let remarks = settle(history, &before, &date);

    let mut step = new_step(proposal, history.steps.len() + 1, date, &before);
    let mut after = before.clone();
    for proposed in &proposal.effects {
        let (text, change) = put(&after, proposed, &step, &robot).map_err(|e| e.in_file(&description))?;
        (after, step.changes) = (text, pushed(std::mem::take(&mut step.changes), change));
    }
    let (amended, warnings) = read_amended(sources, &after)?;
    verify(&robot, amended, &mut step.changes).map_err(|e| e.in_file(&description))?;
    step.after = Version::of(&after);

    history.steps.push(step.clone());
    let is_new = |warning: &Diagnostic| old_warnings.iter().all(|old| old.message != warning.message);
    let warnings = warnings.into_iter().filter(is_new).map(unplaced).chain(risen(&proposal.errors)).collect();
    Ok(Amended { step, description, before, after, remarks, warnings })
}

/// Errors that are larger with what is written, though others may fall.
fn risen(errors: &[ChannelError]) -> Option<Diagnostic> {
    let risen = |error: &ChannelError, which: &str, fall: Option<BeforeAfter>| {
        let BeforeAfter { before, after } = fall?;
        let channel = error.channel.replace('_', " ");
        let [was, is] = [before, after].map(|x| counting(x, 4));
        rises(before, after, error.noise)
            .then(|| format!("the {which} error of the {channel} rises from {was} to {is} {}", error.unit))
    };
    let of = |error: &ChannelError| {
        [risen(error, "held-out", error.held_out), risen(error, "training", error.training)]
    };
    let all: Vec<String> = errors.iter().flat_map(of).flatten().collect();
    (!all.is_empty()).then(|| {
        Diagnostic::warning(format!("with what is written {}", all.join(", ")))
            .help("compare it on another log; `bipedc amend ROBOT --undo` takes it back")
    })
}

fn pushed(mut list: Vec<Change>, change: Change) -> Vec<Change> {
    list.push(change);
    list
}

/// Brings the history up to what the description is; says what was found.
fn settle(history: &mut History, text: &str, date: &str) -> Vec<String> {
    let Some(last) = history.last().map(|step| step.step) else { return Vec::new() };
    match history.state(text) {
        HistoryState::Agree => Vec::new(),
        HistoryState::LastStepMissing => {
            history.take_back(date);
            vec![format!(
                "step {last} is not in the description (interrupted, or restored by other means): marked as taken back"
            )]
        }
        HistoryState::Edited => vec![format!("the description was edited by hand since step {last}: noted")],
    }
}

fn new_step(proposal: &Proposal, number: usize, date: String, before: &str) -> Step {
    Step {
        step: number,
        date,
        tool: format!("bipedc {}", env!("CARGO_PKG_VERSION")),
        origin: proposal.origin.clone(),
        changes: Vec::new(),
        training: proposal.training.clone(),
        more_training: proposal.more_training.clone(),
        validation: proposal.validation.clone(),
        errors: proposal.errors.clone(),
        cutoff_hz: proposal.cutoff_hz,
        note: proposal.note.clone(),
        before: Version::of(before),
        after: Version::of(before),
        previous_text: pack(before),
        undone: None,
    }
}

/// The text with one effect put, added or removed.
fn put(
    text: &str,
    proposed: &Proposed,
    step: &Step,
    robot: &RobotDescription,
) -> Result<(String, Change), Diagnostic> {
    let previous = robot.effects.iter().find(|effect| is_same(effect, &proposed.effect)).cloned();
    let mut effect = proposed.effect.clone();
    effect.sliding = robot.slides(&effect.location);
    if let Some(previous) = previous.as_ref().filter(|_| effect.own.is_empty()) {
        effect.own.clone_from(&previous.own);
    }
    let mut ci95 = proposed.ci95.clone();
    if let Some(previous) = previous.as_ref().filter(|_| proposed.request == Request::Increase) {
        increase(&mut effect, &mut ci95, previous, robot);
    }
    let is_twin = |change: &Change| is_same(&change.effect, &effect);
    let action = match proposed.request {
        Request::Remove => Action::Removed,
        Request::Increase if previous.is_some() => Action::Replaced,
        Request::Increase => Action::Added,
        // Of two alike in one proposal (two ripples, say) the second comes beside the first.
        Request::Put if !step.changes.iter().any(is_twin) && text::count(text, &effect)? > 0 => {
            Action::Replaced
        }
        Request::Put | Request::Add => Action::Added,
    };
    let comment = comments::above(&effect, proposed, step);
    let written = Written { effect: &effect, ci95: &ci95, comment: &comment };
    let text = match action {
        Action::Added => text::add(text, &written)?,
        Action::Replaced => text::replace(text, &written)?,
        Action::Removed => text::remove(text, &effect)?,
    };
    if let Some(previous) = previous.as_ref().filter(|_| action == Action::Removed) {
        effect.clone_from(previous);
    }
    let previous = previous.filter(|_| action == Action::Replaced);
    let error = proposed.error.clone();
    Ok((text, Change { action, effect, ci95, previous, error }))
}

/// What a change of an effect makes of what stands: values move by the latter's, those of a link's correction so that its
/// parameters are what was judged; intervals move along.
fn increase(
    effect: &mut Effect,
    ci95: &mut BTreeMap<String, [f64; 2]>,
    previous: &Effect,
    robot: &RobotDescription,
) {
    let found = effect.parameters.clone();
    let link =
        effect.location.link.as_deref().and_then(|name| robot.links.iter().find(|link| link.name == name));
    match link.filter(|_| effect.kind.law == Law::InertialCorrection) {
        Some(link) => {
            let joined = by_itself(link).joined([previous, effect]);
            let kept = |name: &str| previous.parameters.contains_key(name) || found.contains_key(name);
            let values = joined.into_iter().filter(|(name, value)| *value != 0.0 || kept(name));
            effect.parameters.extend(values.map(|(name, value)| (name.to_owned(), value)));
        }
        None => {
            for (name, value) in &previous.parameters {
                *effect.parameters.entry(name.clone()).or_insert(0.0) += value;
            }
        }
    }
    for (name, interval) in ci95 {
        let moved = effect.value(name) - found.get(name).copied().unwrap_or(0.0);
        *interval = interval.map(|end| end + moved);
    }
}

/// Reads the amended text as the description's reader does. Places are left out of messages: they are those of a
/// text that nobody sees.
fn read_amended(
    sources: &SourceFiles,
    text: &str,
) -> Result<(RobotDescription, Vec<Diagnostic>), Diagnostics> {
    let amended = SourceFiles { toml_text: text.to_owned(), ..sources.clone() };
    amended.parse().map_err(|errors| {
        let errors = errors.0.into_iter().filter(|error| error.severity == Severity::Error);
        Diagnostics(errors.map(unplaced).collect())
    })
}

fn unplaced(diagnostic: Diagnostic) -> Diagnostic {
    Diagnostic { file: None, position: None, ..diagnostic }
}

/// The amended description must hold the effects of the changes, and everything else as before. The changes get the
/// effects as they were read: with the settings that a replaced one kept.
fn verify(
    before: &RobotDescription,
    after: RobotDescription,
    changes: &mut [Change],
) -> Result<(), Diagnostic> {
    let wrong = |what: String| {
        Diagnostic::error(format!("{what}; nothing was written"))
            .help("edit the description by hand, and report this: it should not happen")
    };
    for change in changes.iter_mut().filter(|change| change.action != Action::Removed) {
        let found = after.effects.iter().rev().find(|effect| holds(effect, &change.effect));
        let found = found.ok_or_else(|| {
            wrong(format!("the amended description does not hold {}", comments::title(&change.effect)))
        })?;
        change.effect = found.clone();
    }
    let count = |action: Action| changes.iter().filter(|change| change.action == action).count();
    let expected =
        before.effects.len() + count(Action::Added) - count(Action::Removed).min(before.effects.len());
    if after.effects.len() != expected {
        return Err(wrong(format!("{} effects instead of {expected}", after.effects.len())));
    }
    if after.without_effects() != before.clone().without_effects() {
        return Err(wrong("the change would alter more than effects".to_owned()));
    }
    Ok(())
}

/// Whether an effect that was read is the one that was written, to the last bit; it may have more settings.
fn holds(read: &Effect, written: &Effect) -> bool {
    is_same(read, written)
        && read.location == written.location
        && read.torque == written.torque
        && written.parameters.iter().all(|(name, value)| read.parameters.get(name) == Some(value))
}

/// History first: see [`super::history`].
fn write(description: &Path, before: &str, after: &str, history: &History) -> Result<(), Diagnostic> {
    let history_path = History::path(description);
    let mut both = Batch::default();
    both.add(prepared(&history_path, &history.to_text()?)?);
    both.add(prepared(description, after)?);
    if read_text(description)?.as_deref() != Some(before) {
        return Err(Diagnostic::error(
            "the description changed while it was being amended: nothing was written",
        )
        .in_file(description)
        .help("save or close it in your editor, then amend again"));
    }
    both.commit().map_err(|error| {
        error.help(
            "if the history notes a step that the description does not have, the next amend puts that right",
        )
    })
}
