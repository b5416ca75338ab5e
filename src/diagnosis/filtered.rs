//! The logs that teach and judge at one cut-off, and a second look at a higher one.
use super::Options;
use super::judged::mean_error;
use crate::measurements::{Loaded, Log, Measured};
use crate::progress::Progress;
use bipedc_analysis::diagnose::support::fading;
use bipedc_analysis::diagnose::{self, Diagnosis, ErrorFall, Selected, errors};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::measure;
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::{Effect, Kind, Location};
use std::cell::LazyCell;
use std::path::Path;

/// Higher cut-offs at which a second look is taken.
const SECOND_LOOKS: usize = 2;
/// Part of the error that a slower filter must leave for a second look behind it.
pub(super) const QUIETER: f64 = 0.8;
/// Part of a log's samples in or next to which a joint must stick for a look behind a faster filter.
const STICKS: f64 = 0.1;
/// An answer that is better behind one filter may be so much worse behind another.
const ALIKE: f64 = 1.01;

/// Two logs, and what is asked of them.
#[derive(Clone)]
pub(super) struct Request<'a> {
    pub robot: &'a Robot,
    pub log: Log,
    pub validate: Option<Log>,
    /// A log that was to judge and does not show what acts in the one that teaches.
    pub passed_over: Option<Log>,
    pub options: &'a Options,
    pub search: diagnose::Options,
    /// Some of the first answer only raised errors: this search does without it.
    pub does_without: bool,
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
        let mut loaded = measured.load(log, reading, options.foot.as_deref())?;
        loaded.experiment = Box::new(Selected::within_steps(loaded.experiment));
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

/// An answer, and the logs at the cut-off behind which it was found.
type Found<'m> = (Filtered<'m>, Diagnosis);

/// A search of the same at another cut-off, if its answer is the better one. At a slower one, where with all that was found much less is
/// left behind it, because encoders are coarse, or where more than noise is left behind it, because encoders' noise hid what was taken for
/// something else; at a faster one, where joints stick and something is left above the noise; at faster ones, where something is left that
/// nothing explains, because what friction does within a few degrees of a reversal is over before a slow filter shows it. `quietest` is the
/// cut-off (Hz) behind which least is left, and how much; without it, as where the cut-off is given, there is no second look.
pub(super) fn second_look<'m>(
    measured: &'m Measured,
    request: &Request<'_>,
    (first, answer): (&Filtered<'m>, &Diagnosis),
    quietest: Option<(f64, f64)>,
    work: Work<'_>,
) -> Option<Found<'m>> {
    let (cutoff, error) = quietest?;
    let looks = Looks { measured, request, first, answer, work };
    let here = first.train.cutoff_hz;
    let slower = (cutoff < here).then(|| looks.behind_a_slower_one(cutoff, error)).flatten();
    // A description that as many effects as are looked for do not put right is another robot's, behind whatever filter.
    let is_full = answer.unexplained && answer.is_full();
    if slower.is_some() || is_full {
        return slower;
    }
    let found = (cutoff > here).then(|| looks.where_joints_stick(cutoff)).flatten();
    found.or_else(|| looks.near_reversals(here))
}

/// An answer, the logs that it came from, and how others are found.
struct Looks<'l, 'm> {
    measured: &'m Measured,
    request: &'l Request<'l>,
    first: &'l Filtered<'m>,
    answer: &'l Diagnosis,
    work: Work<'l>,
}

impl<'m> Looks<'_, 'm> {
    /// The same search at another cut-off (Hz); none beyond half the sampling rate, which is not one.
    fn at(&self, cutoff: f64) -> Option<Found<'m>> {
        let other = filtered(self.measured, self.request, cutoff).ok()?;
        let second = (self.work)(&*other.train.experiment, other.judging(), &self.request.search);
        Some((other, second))
    }

    /// At a slower cut-off: where it leaves much less, `error`, where what explains all behind this one leaves more than noise there, or where what is left
    /// here of joints whose torque fades in noise is noise there. What needs fewer numbers need not do as well behind a filter that lets the encoders' noise through:
    /// that looks like inertias.
    fn behind_a_slower_one(&self, cutoff: f64, error: f64) -> Option<Found<'m>> {
        let (first, answer) = (self.first, self.answer);
        let is_much_less = error < QUIETER * left(first, answer);
        let is_hidden = LazyCell::new(|| !answer.unexplained && !self.leaves_noise(cutoff));
        let fades = LazyCell::new(|| answer.unexplained && self.leaves_noise(cutoff) && self.suspects_fade());
        if !is_much_less && !*is_hidden && !*fades {
            return None;
        }
        self.at(cutoff).filter(|(other, second)| {
            let alike = || left(first, second) <= ALIKE * left(first, answer);
            let is_better = || {
                is_much_less
                    && (!second.leaves_structure() || answer.leaves_structure())
                    && (alike() || numbers(second) < numbers(answer))
            };
            let as_well = || left(other, second) <= ALIKE * left(other, answer);
            let needs_no_more = || numbers(second) <= numbers(answer);
            left(other, second) < left(other, answer) && (is_better() || !second.unexplained && *is_hidden)
                || *fades && !second.unexplained && as_well() && needs_no_more()
        })
    }

    /// Whether the torque of a joint in which something is left fades as the cut-off doubles: there the encoders' noise makes up the model's torque.
    fn suspects_fade(&self) -> bool {
        let Ok(faster) = filtered(self.measured, self.request, 2.0 * self.first.train.cutoff_hz) else {
            return false;
        };
        let fading = fading(&*self.first.train.experiment, &*faster.train.experiment, 1.0);
        self.answer.suspects.iter().any(|suspect| fading.iter().any(|joint| joint.joint == *suspect))
    }

    /// Whether the answer leaves nothing but noise at a cut-off (Hz).
    fn leaves_noise(&self, cutoff: f64) -> bool {
        let rows = |logs: &Filtered<'_>| -> Vec<String> {
            logs.train.experiment.rows().iter().map(|row| row.name.clone()).collect()
        };
        let other = filtered(self.measured, self.request, cutoff);
        other.is_ok_and(|other| is_noise(&other, self.answer, &rows(&other)))
    }

    /// At a faster cut-off, where something is left above the noise of joints that stick for a good part of the log.
    fn where_joints_stick(&self, cutoff: f64) -> Option<Found<'m>> {
        let answer = self.answer;
        if !answer.unexplained || answer.leaves_structure() || !sticks(self.first, answer) {
            return None;
        }
        self.at(cutoff).filter(|(other, second)| {
            (!second.unexplained || says_the_same(second, answer))
                && left(other, second) < left(other, answer)
        })
    }

    /// At faster cut-offs, where something is left that nothing explains.
    fn near_reversals(&self, here: f64) -> Option<Found<'m>> {
        let (first, answer) = (self.first, self.answer);
        if !answer.leaves_structure() {
            return None;
        }
        let structured: Vec<String> = answer.structured().map(|part| part.joint.clone()).collect();
        let suspects = if structured.is_empty() { &answer.suspects } else { &structured };
        let explains = |(other, second): &Found<'_>| {
            let fewer =
                |logs: &Filtered<'_>| left_in(logs, second, suspects) < left_in(logs, answer, suspects);
            !second.leaves_structure() && fewer(first) && fewer(other) && is_noise(first, second, suspects)
        };
        let faster = measure::CANDIDATES.into_iter().filter(|cutoff| *cutoff > here);
        faster.take(SECOND_LOOKS).find_map(|cutoff| self.closely(cutoff, suspects).filter(explains))
    }

    /// At a cut-off (Hz), for what acts on some rows alone.
    fn closely(&self, cutoff: f64, suspects: &[String]) -> Option<Found<'m>> {
        let other = filtered(self.measured, self.request, cutoff).ok()?;
        let barred = elsewhere(&*other.train.experiment, suspects, self.answer);
        let search = diagnose::Options { barred, ..self.request.search.clone() };
        let mut second = (self.work)(&*other.train.experiment, other.judging(), &search);
        // What else is seen there was not seen behind the slower filter.
        if !second.unexplained_parts.is_empty() {
            second.unexplained_parts.retain(|part| suspects.contains(&part.joint));
            second.unexplained = !second.unexplained_parts.is_empty();
        }
        Some((other, second))
    }
}

/// What a second look behind a faster filter is not for: other joints than the suspects, but for what was found there. What motions put
/// into effects is smoothed more than what they put into the model, so that behind a fast filter a delay may turn the encoders' noise
/// against itself.
fn elsewhere(
    experiment: &dyn Experiment,
    suspects: &[String],
    answer: &Diagnosis,
) -> Vec<(&'static Kind, Location)> {
    let concerns = |location: &Location| {
        let joints = [&location.joint, &location.other_joint];
        location.joint.is_none() || joints.into_iter().flatten().any(|joint| suspects.contains(joint))
    };
    let stands = |(kind, location): &(&'static Kind, Location)| {
        answer.effects.iter().any(|found| found.effect.kind == *kind && found.effect.location == *location)
    };
    let places = experiment.candidates().into_iter();
    places.filter(|place| !concerns(&place.1) && !stands(place)).collect()
}

/// Whether a joint in which something is left sticks for a good part of the log: a slow filter smears each start and stop over what
/// lies beside them.
fn sticks(logs: &Filtered<'_>, answer: &Diagnosis) -> bool {
    let experiment = &*logs.train.experiment;
    let part = |row: usize| {
        let flags = experiment.sticks(row);
        flags.iter().filter(|sticks| **sticks).count() as f64 / flags.len().max(1) as f64
    };
    let rows = experiment.rows().iter().enumerate();
    let mut suspects = rows.filter(|(_, row)| answer.suspects.contains(&row.name));
    suspects.any(|(row, _)| part(row) > STICKS)
}

/// What is left in a row, where its joint does not stick.
fn missed(fall: &ErrorFall) -> f64 {
    fall.after_moving.unwrap_or(fall.after)
}

/// What is left of all torques of the log that judges.
fn left(logs: &Filtered<'_>, answer: &Diagnosis) -> f64 {
    let effects: Vec<Effect> = answer.estimated().cloned().collect();
    mean_error(logs.judging().unwrap_or(&*logs.train.experiment), &effects)
}

/// Whether two answers name the same effects.
fn says_the_same(a: &Diagnosis, b: &Diagnosis) -> bool {
    let named = |answer: &Diagnosis, effect: &Effect| {
        answer.estimated().any(|other| other.kind == effect.kind && other.location == effect.location)
    };
    a.effects.len() == b.effects.len() && a.estimated().all(|effect| named(b, effect))
}

/// How many numbers an answer has estimated.
fn numbers(answer: &Diagnosis) -> usize {
    answer.estimated().map(|effect| effect.kind.estimated().count()).sum()
}

/// Whether what is left in some rows is no more than noise behind this filter too: a faster one lets so much through that it hides more.
fn is_noise(logs: &Filtered<'_>, answer: &Diagnosis, rows: &[String]) -> bool {
    let effects: Vec<Effect> = answer.estimated().cloned().collect();
    let falls = errors(&*logs.train.experiment, logs.judging(), [&[], &effects]).rows;
    rows.iter().all(|row| falls.get(row).is_none_or(|fall| fall.above_noise().is_none()))
}

/// What is left in some rows together, where joints do not stick.
fn left_in(logs: &Filtered<'_>, answer: &Diagnosis, rows: &[String]) -> f64 {
    let effects: Vec<Effect> = answer.estimated().cloned().collect();
    let falls = errors(&*logs.train.experiment, logs.judging(), [&[], &effects]).rows;
    let told = |row: &String| falls.get(row).map_or(f64::INFINITY, missed);
    rows.iter().map(told).fold(0.0, f64::hypot)
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
