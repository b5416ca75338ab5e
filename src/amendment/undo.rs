//! Taking the last step back.
use super::files::{Lock, prepared};
use super::history::{History, HistoryState, Step};
use super::{now, open};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::Batch;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Lines of a user's text that messages show.
const SHOWN: usize = 8;

/// What was taken back.
#[derive(Debug)]
pub struct Undone {
    /// The step, as it was.
    pub step: Step,
    /// The description.
    pub description: PathBuf,
    /// Whether the description had to be changed: not if it was as before the step already.
    pub restored: bool,
    /// Where a text that was edited by hand is kept now.
    pub edited: Option<PathBuf>,
    /// Lines of that text that the restored one does not have.
    pub lost: Vec<String>,
}

/// Takes the last step back: the description becomes what it was before, byte for byte. The step stays in the
/// history, marked as taken back.
///
/// # Errors
/// Nothing to take back; a description that was edited since, unless `force`; files that cannot be written.
pub fn undo(path: &Path, force: bool) -> Result<Undone, Diagnostic> {
    let description = super::description_path(path)?;
    let _lock = Lock::of_folder(&description, &[&description, &History::path(&description)])?;
    let (description, text, mut history) = open(&description)?;
    let Some(step) = history.last().cloned() else { return Err(nothing(&description, &history)) };
    let standing = history.state(&text);
    let before = step.text_before().map_err(|error| error.in_file(&History::path(&description)))?;
    let lost = if standing == HistoryState::Edited { lines_only_in(&text, &before) } else { Vec::new() };
    if standing == HistoryState::Edited && !force {
        return Err(edited(&description, &step, &lost));
    }
    history.take_back(&now());
    let mut all = Batch::default();
    let mut kept = None;
    if standing != HistoryState::LastStepMissing {
        if standing == HistoryState::Edited {
            let copy = free_name(&description);
            all.add(prepared(&copy, &text)?);
            kept = Some(copy);
        }
        // The description first: see the module on histories.
        all.add(prepared(&description, &before)?);
    }
    all.add(prepared(&History::path(&description), &history.to_text()?)?);
    all.commit()?;
    let restored = standing != HistoryState::LastStepMissing;
    Ok(Undone { step, description, restored, edited: kept, lost })
}

fn nothing(description: &Path, history: &History) -> Diagnostic {
    let message = match history.steps.len() {
        0 => "there is nothing to take back: the description was never amended".to_owned(),
        n => format!("there is nothing to take back: all {n} steps were taken back already"),
    };
    Diagnostic::error(message)
        .in_file(description)
        .help("bipedc history shows the steps; to have an effect again, amend again")
}

fn edited(description: &Path, step: &Step, lost: &[String]) -> Diagnostic {
    let mut lines: String = lost.iter().take(SHOWN).map(|line| format!("\n  {line}")).collect();
    if lost.len() > SHOWN {
        lines += &format!("\n  … ({} lines in all)", lost.len());
    }
    let message = format!(
        "the description was edited since step {}: the text of before would lose these edits.\nLines that it does not \
         have (those of the step among them):{lines}",
        step.step
    );
    Diagnostic::error(message).in_file(description).help(
        "take the [[effect]] out with --remove or by hand; or --force restores the text of before the step and keeps \
         the edited one in a file beside it",
    )
}

/// Lines of `text` that `other` does not have, or has less often.
fn lines_only_in(text: &str, other: &str) -> Vec<String> {
    let mut count: HashMap<&str, usize> = HashMap::new();
    for line in other.lines() {
        *count.entry(line).or_default() += 1;
    }
    let mut extra = Vec::new();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        match count.get_mut(line) {
            Some(left) if *left > 0 => *left -= 1,
            _ => extra.push(super::comments::one_line(line)),
        }
    }
    extra
}

/// `biped.edited.toml`, or with a number where that exists.
fn free_name(description: &Path) -> PathBuf {
    let stem = description.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let first = description.with_file_name(format!("{stem}.edited.toml"));
    let numbered = |n: usize| description.with_file_name(format!("{stem}.edited.{n}.toml"));
    std::iter::once(first)
        .chain((2..).map(numbered))
        .find(|path| path.symlink_metadata().is_err())
        .unwrap_or_default()
}
