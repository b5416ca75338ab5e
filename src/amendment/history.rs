//! What was done to a description, kept beside it as JSON: `history.json` for `biped.toml`, else
//! `NAME.history.json`.
//!
//! The history is never behind the description: amending writes the history first, taking back writes it last. So
//! an interruption between the two leaves one state only, a last step that the description does not have yet (or no
//! longer), and [`History::state`] sees it by the hashes.
use super::files::read_text;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bipedc_analysis::measure::DataSource;
use bipedc_compiler::description::model::RobotDescription;
use bipedc_compiler::robot::fnv1a;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::Effect;
use flate2::Compression;
use flate2::read::{DeflateDecoder, DeflateEncoder};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Form of the file; another number is another form.
const FORMAT: u32 = 1;
/// No description is larger.
const TEXT_LIMIT: u64 = 64 << 20;

/// All steps, the oldest first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct History {
    /// Form of the file.
    pub format: u32,
    /// For those who open the file.
    #[serde(default)]
    pub about: String,
    /// What was done. Steps that were taken back stay, marked.
    pub steps: Vec<Step>,
}

/// One `amend`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// From 1.
    pub step: usize,
    /// UTC, ISO 8601.
    pub date: String,
    /// What wrote it: `bipedc 0.1.0`.
    pub tool: String,
    /// Where the numbers come from, in words.
    pub origin: String,
    /// In the order in which they were made.
    pub changes: Vec<Change>,
    /// The data that parameters were estimated from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub training: Option<DataSource>,
    /// More of it, where several logs taught.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub more_training: Vec<DataSource>,
    /// The data that judged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation: Option<DataSource>,
    /// Root mean square errors of the step as a whole, the channel that matters most first. Empty: unknown.
    #[serde(default)]
    pub errors: Vec<ChannelError>,
    /// The filter of efforts and motion behind which they hold: its cut-off, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cutoff_hz: Option<f64>,
    /// What to know about the errors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// The description before.
    pub before: Version,
    /// And after.
    pub after: Version,
    /// The whole text before: deflate, base64.
    pub previous_text: String,
    /// When it was taken back; absent while it stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub undone: Option<String>,
}

/// What became of one effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Added, replaced or removed.
    pub action: Action,
    /// As it is now; of a removed one, as it was.
    pub effect: Effect,
    /// 95 % confidence intervals by parameter, where known.
    #[serde(
        default,
        skip_serializing_if = "BTreeMap::is_empty",
        deserialize_with = "bipedc_analysis::diagnose::intervals"
    )]
    pub ci95: BTreeMap<String, [f64; 2]>,
    /// Of a replaced one, as it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub previous: Option<Effect>,
    /// Of this change alone, where known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<ChannelError>,
}

/// What was done to an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// It was not there.
    Added,
    /// It has other numbers now.
    Replaced,
    /// It is no longer there.
    Removed,
}

/// An error of one kind of channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChannelError {
    /// `effort`, `cop`, …
    pub channel: String,
    /// Of all numbers.
    pub unit: String,
    /// On held-out data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_out: Option<BeforeAfter>,
    /// On the training data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub training: Option<BeforeAfter>,
    /// Noise of the measurement; 0 if unknown.
    #[serde(default)]
    pub noise: f64,
}

/// Before and after.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BeforeAfter {
    /// The error without the change.
    pub before: f64,
    /// And with it.
    pub after: f64,
}

/// A state of the description's file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Version {
    /// FNV-1a of the bytes, 16 hex digits.
    pub hash: String,
    /// Size.
    pub bytes: usize,
}

/// How the description and its history stand to each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HistoryState {
    /// The description is what the last step made of it, or there are no steps.
    Agree,
    /// The description is as before the last step: interrupted, or restored by other means.
    LastStepMissing,
    /// It is neither.
    Edited,
}

/// One stair of the falling error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stair {
    /// Number of the step.
    pub step: usize,
    /// What entered.
    pub label: String,
    /// UTC, ISO 8601.
    pub date: String,
    /// `effort`, …
    pub channel: String,
    /// Of the errors.
    pub unit: String,
    /// Error before, on held-out data where known, else on the training data.
    pub before: f64,
    /// And after.
    pub after: f64,
    /// Noise of the measurement; 0 if unknown.
    pub noise: f64,
    /// Whether the errors are on held-out data.
    pub held_out: bool,
}

impl Version {
    /// Of a text.
    pub fn of(text: &str) -> Self {
        Self { hash: format!("{:016x}", fnv1a(text)), bytes: text.len() }
    }
}

impl ChannelError {
    /// The error that counts, and whether it is on held-out data.
    pub fn judged(&self) -> Option<(BeforeAfter, bool)> {
        self.held_out.map(|fall| (fall, true)).or(self.training.map(|fall| (fall, false)))
    }
}

impl Step {
    /// Whether it was not taken back.
    pub fn stands(&self) -> bool {
        self.undone.is_none()
    }

    /// The error that matters most.
    pub fn main_error(&self) -> Option<&ChannelError> {
        self.errors.first()
    }

    /// `, behind a filter of 10 Hz`; nothing where that is not known, or there is no error.
    pub fn filter(&self) -> String {
        let known = self.cutoff_hz.filter(|_| !self.errors.is_empty());
        known.map_or(String::new(), |hz| format!(", behind a filter of {hz} Hz"))
    }

    /// The description before the step, byte for byte.
    ///
    /// # Errors
    /// A history that was damaged: says so.
    pub fn text_before(&self) -> Result<String, Diagnostic> {
        let damaged = |what: String| {
            Diagnostic::error(format!("the text kept in step {} is damaged: {what}", self.step))
                .help("restore the description and its history from your version control")
        };
        let packed = STANDARD.decode(&self.previous_text).map_err(|e| damaged(e.to_string()))?;
        let mut text = String::new();
        let mut reader = DeflateDecoder::new(packed.as_slice()).take(TEXT_LIMIT);
        reader.read_to_string(&mut text).map_err(|e| damaged(e.to_string()))?;
        if Version::of(&text) != self.before {
            return Err(damaged("its hash is another".to_owned()));
        }
        Ok(text)
    }
}

/// A text as a step keeps it.
pub fn pack(text: &str) -> String {
    let mut packed = Vec::new();
    // Reading from memory into memory does not fail.
    let _ = DeflateEncoder::new(text.as_bytes(), Compression::best()).read_to_end(&mut packed);
    STANDARD.encode(packed)
}

impl Default for History {
    fn default() -> Self {
        let about = "Changes of the description by `bipedc amend`. `bipedc history` shows them, `bipedc amend \
                     --undo` takes the last one back: keep this file beside the description.";
        Self { format: FORMAT, about: about.to_owned(), steps: Vec::new() }
    }
}

impl History {
    /// Where the history of a description is kept.
    pub fn path(description: &Path) -> PathBuf {
        let stem = description.file_stem().unwrap_or_default().to_string_lossy();
        let name = if stem == "biped" { "history.json".to_owned() } else { format!("{stem}.history.json") };
        description.with_file_name(name)
    }

    /// Reads the history of a description; empty if there is none.
    ///
    /// # Errors
    /// An unreadable or damaged file, or one of a newer form.
    pub fn open(description: &Path) -> Result<Self, Diagnostic> {
        let path = Self::path(description);
        let Some(text) = read_text(&path)? else { return Ok(Self::default()) };
        let help = "restore it from your version control, or move it away to begin a new history";
        let history: Self = serde_json::from_str(&text).map_err(|error| {
            Diagnostic::error(format!("the history is damaged: {error}"))
                .in_file(&path)
                .at(error.line(), error.column())
                .help(help)
        })?;
        let problem = |what: String| Err(Diagnostic::error(what).in_file(&path).help(help));
        if history.format != FORMAT {
            let message = format!("the history has form {}, expected {FORMAT}", history.format);
            return problem(message + ": was it written by another bipedc?");
        }
        match history.steps.iter().zip(1..).find(|(step, number)| step.step != *number) {
            Some((step, number)) => {
                problem(format!("step {number} of the history is numbered {}", step.step))
            }
            None => Ok(history),
        }
    }

    /// Takes from the robot which joints slide, so that units are theirs.
    pub fn know(&mut self, robot: &RobotDescription) {
        for change in self.steps.iter_mut().flat_map(|step| &mut step.changes) {
            for effect in [Some(&mut change.effect), change.previous.as_mut()].into_iter().flatten() {
                effect.sliding |= robot.slides(&effect.location);
            }
        }
    }

    /// The last step that was not taken back.
    pub fn last(&self) -> Option<&Step> {
        self.steps.iter().rev().find(|step| step.stands())
    }

    /// Whether the description is what the history says.
    pub fn state(&self, text: &str) -> HistoryState {
        let now = Version::of(text);
        match self.last() {
            None => HistoryState::Agree,
            Some(step) if step.after == now => HistoryState::Agree,
            Some(step) if step.before == now => HistoryState::LastStepMissing,
            Some(_) => HistoryState::Edited,
        }
    }

    /// Marks the last step as taken back.
    pub fn take_back(&mut self, date: &str) {
        if let Some(step) = self.steps.iter_mut().rev().find(|step| step.stands()) {
            step.undone = Some(date.to_owned());
        }
    }

    /// The file's text.
    pub fn to_text(&self) -> Result<String, Diagnostic> {
        let text = serde_json::to_string_pretty(self);
        Ok(text.map_err(|error| Diagnostic::error(format!("the history cannot be written: {error}")))? + "\n")
    }

    /// The falling error: one stair for each change of standing steps whose effect on the error is known, else for
    /// the step as a whole.
    pub fn stairs(&self) -> Vec<Stair> {
        self.steps.iter().filter(|step| step.stands()).flat_map(stairs_of).collect()
    }
}

fn stairs_of(step: &Step) -> Vec<Stair> {
    let stair = |label: String, error: &ChannelError| {
        let (fall, held_out) = error.judged()?;
        Some(Stair {
            step: step.step,
            label,
            date: step.date.clone(),
            channel: error.channel.clone(),
            unit: error.unit.clone(),
            before: fall.before,
            after: fall.after,
            noise: error.noise,
            held_out,
        })
    };
    let label = |change: &Change| {
        let title = super::comments::title(&change.effect);
        if change.action == Action::Removed { format!("without {title}") } else { title }
    };
    let single = step.changes.iter().filter_map(|change| stair(label(change), change.error.as_ref()?));
    let single: Vec<Stair> = single.collect();
    if !single.is_empty() {
        return single;
    }
    let all: Vec<String> = step.changes.iter().map(label).collect();
    step.main_error().and_then(|error| stair(all.join(", "), error)).into_iter().collect()
}
