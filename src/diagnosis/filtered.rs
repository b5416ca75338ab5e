//! The logs that teach and judge at one cut-off, and a second look at a higher one.
use super::Options;
use crate::measurements::{Content, Loaded, Log, Measured};
use crate::progress::Progress;
use bipedc_analysis::diagnose::{self, Diagnosis, Selected, errors};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::measure;
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::Effect;
use std::path::Path;

/// Higher cut-offs at which a second look is taken.
const SECOND_LOOKS: usize = 2;

/// Two logs, and what is asked of them.
pub(super) struct Request<'a> {
    pub robot: &'a Robot,
    pub log: Log,
    pub validate: Option<Log>,
    pub options: &'a Options,
    pub search: diagnose::Options,
    pub progress: &'a dyn Progress,
}

/// A search, told what teaches, what judges and how.
pub(super) type Work<'w> =
    &'w dyn Fn(&dyn Experiment, Option<&dyn Experiment>, &diagnose::Options) -> Diagnosis;

/// Logs, filtered alike.
pub(super) struct Filtered<'m> {
    pub reading: measure::Options,
    pub train: Loaded<'m>,
    pub judge: Option<Loaded<'m>>,
}

impl Filtered<'_> {
    /// The log that judges, if it is another.
    pub fn judging(&self) -> Option<&dyn Experiment> {
        self.judge.as_ref().map(|judge| &*judge.experiment)
    }
}

/// Both logs at a cut-off, Hz; 0 for tables.
pub(super) fn filtered<'m>(
    measured: &'m Measured,
    request: &Request<'_>,
    cutoff: f64,
) -> Result<Filtered<'m>, Diagnostics> {
    let options = request.options;
    let mut reading = options.reading.clone();
    if cutoff > 0.0 {
        reading.cutoff_hz = Some(cutoff);
    }
    let load = |log: &Log, reading: &measure::Options| -> Result<Loaded<'m>, Diagnostics> {
        let loaded = measured.load(log, reading, options.foot.as_deref())?;
        Ok(selected(loaded, &options.channels).map_err(|e| e.in_file(log.path()))?)
    };
    let mut train = load(&request.log, &reading)?;
    let judging = measure::Options { from_s: None, to_s: None, ..reading.clone() };
    let mut judge = request.validate.as_ref().map(|log| load(log, &judging)).transpose()?;
    if let (Some(alone), Some(log)) = (judge.take(), &request.validate) {
        let both;
        (train, both) = alike(train, alone, log.path())?;
        judge = Some(both);
    }
    Ok(Filtered { reading, train, judge })
}

/// Where something is left that nothing explains, the same search at a higher cut-off, if that explains it: what friction does within
/// a few degrees of a reversal is over before a slow filter shows it.
pub(super) fn second_look<'m>(
    measured: &'m Measured,
    request: &Request<'_>,
    (slow, first): (&Filtered<'m>, &Diagnosis),
    work: Work<'_>,
) -> Option<(Filtered<'m>, Diagnosis)> {
    let efforts = measured.content(&request.log) == Content::Efforts;
    if request.options.reading.cutoff_hz.is_some() || !efforts || !first.unexplained {
        return None;
    }
    let error = |answer: &Diagnosis, logs: &Filtered<'_>| {
        let effects: Vec<Effect> = answer.estimated().cloned().collect();
        let rows = errors(&*logs.train.experiment, logs.judging(), &effects).rows;
        let told = |row: &String| {
            rows.get(row).map_or(f64::INFINITY, |fall| fall.after_moving.unwrap_or(fall.after))
        };
        first.suspects.iter().map(told).fold(0.0, f64::hypot)
    };
    let look = |higher: f64| {
        // A cut-off beyond half the sampling rate is not one.
        let fast = filtered(measured, request, higher).ok()?;
        let second = work(&*fast.train.experiment, fast.judging(), &request.search);
        let better = |logs: &Filtered<'_>| error(&second, logs) < error(first, logs);
        (!second.unexplained && better(slow) && better(&fast)).then_some((fast, second))
    };
    let higher = measure::CANDIDATES.into_iter().filter(|cutoff| *cutoff > slow.train.cutoff_hz);
    higher.take(SECOND_LOOKS).find_map(look)
}

/// The same with the rows of some channels only.
fn selected<'m>(mut loaded: Loaded<'m>, channels: &[String]) -> Result<Loaded<'m>, Diagnostic> {
    if !channels.is_empty() {
        loaded.experiment = Box::new(Selected::new(loaded.experiment, channels)?);
    }
    Ok(loaded)
}

/// Both files show the same rows: those that one of them alone shows are left out.
fn alike<'m>(
    mut train: Loaded<'m>,
    mut judge: Loaded<'m>,
    file: &Path,
) -> Result<(Loaded<'m>, Loaded<'m>), Diagnostic> {
    if train.source.hash == judge.source.hash {
        let message = "the validation log is the training log: it cannot judge what was fitted to it";
        return Err(Diagnostic::error(message)
            .help("record another motion, or leave --validate out: then blocks of the log judge")
            .in_file(file));
    }
    let names = |loaded: &Loaded<'_>| -> Vec<String> {
        loaded.experiment.rows().iter().map(|row| row.name.clone()).collect()
    };
    let (a, b) = (names(&train), names(&judge));
    let (both, mut single): (Vec<String>, Vec<String>) = a.iter().cloned().partition(|name| b.contains(name));
    single.extend(b.iter().filter(|name| !a.contains(name)).cloned());
    if single.is_empty() {
        return Ok((train, judge));
    }
    if both.is_empty() {
        let message =
            format!("the validation log measures nothing that the training log does: {}", single.join(", "));
        return Err(Diagnostic::error(message).help("use logs with the same columns").in_file(file));
    }
    train.assumptions.push(format!("left out, because one log alone shows them: {}", single.join(", ")));
    train.experiment = Box::new(Selected::named(train.experiment, &both));
    judge.experiment = Box::new(Selected::named(judge.experiment, &both));
    Ok((train, judge))
}
