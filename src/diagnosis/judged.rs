//! Errors as a comparison with the amended model states them: at its cut-off, of all samples.
use super::filtered::Request;
use super::stated::state;
use crate::measurements::{Content, Log, Measured, SAMPLES};
use bipedc_analysis::compare::geometric_mean;
use bipedc_analysis::diagnose::{Diagnosis, errors, root_mean_squares};
use bipedc_analysis::experiments::{Channel, Experiment};
use bipedc_analysis::measure::{self, HELD};
use bipedc_analysis::parallel::parallel;
use bipedc_effects::diagnostic::Diagnostics;
use bipedc_effects::effect::Effect;

/// Errors at the cut-off that fits the judging log best once everything is in: the one that a comparison of that log with the
/// amended model chooses, so that both state the same ([`quietest`]). False if it is the one of the search.
pub(super) fn best_filter(
    measured: &Measured,
    request: &Request<'_>,
    reading: &measure::Options,
    answer: &mut Diagnosis,
    quietest: Option<(f64, f64)>,
) -> Result<bool, Diagnostics> {
    let on_feet = measured.content(&request.log) == Content::Contacts;
    let cutoff = match quietest {
        Some((cutoff, _)) => cutoff,
        None if on_feet && request.options.channels.is_empty() => {
            let effects: Vec<Effect> = answer.estimated().cloned().collect();
            let (log, reading) = judging(request, reading);
            measured.compared_at(log, &measure::Options { cutoff_hz: None, ..reading }, &effects)?
        }
        None => return Ok(false),
    };
    if cutoff != answer.cutoff_hz {
        answer.judged_at_hz = Some(cutoff);
        return as_compared(measured, request, reading, answer);
    }
    of_all_samples(measured, request, reading, answer)
}

/// The cut-off (Hz) at which the judging log fits best with all that was found, and the error there; `None` where that is given, or not
/// all torques count.
pub(super) fn quietest(
    measured: &Measured,
    request: &Request<'_>,
    reading: &measure::Options,
    answer: &Diagnosis,
) -> Option<(f64, f64)> {
    let efforts = measured.content(&request.log) == Content::Efforts;
    if !efforts || request.options.reading.cutoff_hz.is_some() || !request.options.channels.is_empty() {
        return None;
    }
    let effects: Vec<Effect> = answer.estimated().cloned().collect();
    let (log, whole) = judging(request, reading);
    let at = |cutoff: f64| {
        let reading = measure::Options { cutoff_hz: Some(cutoff), ..whole.clone() };
        // A cut-off beyond half the sampling rate is not one.
        let experiment = measured.efforts_alone(log, &reading, SAMPLES).ok()?;
        Some((cutoff, mean_error(&experiment, &effects)))
    };
    let tried = parallel(measure::CANDIDATES.len(), |i| at(measure::CANDIDATES[i]));
    tried.into_iter().flatten().min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The log that judges, and how it is read: another log than the one that teaches from beginning to end.
pub(super) fn judging<'r>(
    request: &'r Request<'_>,
    reading: &measure::Options,
) -> (&'r Log, measure::Options) {
    match &request.validate {
        Some(log) => (log, measure::Options { from_s: None, to_s: None, ..reading.clone() }),
        None => (&request.log, reading.clone()),
    }
}

/// Geometric mean of the errors of all torques, all samples.
pub(super) fn mean_error(experiment: &dyn Experiment, effects: &[Effect]) -> f64 {
    let rows = experiment.rows().iter().zip(root_mean_squares(experiment, effects));
    geometric_mean(rows.filter(|(row, _)| row.channel == Channel::Effort).map(|(_, left)| left))
}

/// The errors of a log that the search saw a part of only: of all its samples, as `compare` measures them.
pub(super) fn of_all_samples(
    measured: &Measured,
    request: &Request<'_>,
    reading: &measure::Options,
    answer: &mut Diagnosis,
) -> Result<bool, Diagnostics> {
    let efforts = measured.content(&request.log) == Content::Efforts;
    let judged = answer.validation.as_ref().unwrap_or(&answer.training);
    // Of a longer log more than half of the most are left when it was thinned.
    let long = answer.training.samples.max(judged.samples) > SAMPLES / 2;
    if !efforts || !long || !request.options.channels.is_empty() {
        return Ok(false);
    }
    as_compared(measured, request, reading, answer)
}

/// The errors of all samples that are held, at the cut-off at which a comparison judges.
fn as_compared(
    measured: &Measured,
    request: &Request<'_>,
    reading: &measure::Options,
    answer: &mut Diagnosis,
) -> Result<bool, Diagnostics> {
    let effects: Vec<Effect> = answer.estimated().cloned().collect();
    let described = answer.described.clone();
    let cutoff = answer.judged_at_hz.unwrap_or(answer.cutoff_hz);
    let at = measure::Options { cutoff_hz: Some(cutoff), ..reading.clone() };
    let whole = measure::Options { from_s: None, to_s: None, ..at.clone() };
    let held = |log: &Log, reading: &measure::Options| -> Result<Box<dyn Experiment + '_>, Diagnostics> {
        match measured.content(log) {
            Content::Efforts => Ok(Box::new(measured.efforts(log, reading, HELD)?)),
            _ => Ok(measured.load(log, reading, None)?.experiment),
        }
    };
    let train = held(&request.log, &at)?;
    let judge = request.validate.as_ref().map(|log| held(log, &whole)).transpose()?;
    let judge = judge.as_deref();
    answer.take(errors(&*train, judge, [&described, &effects]));
    state(answer, &*train, judge);
    for (step, errors) in answer.steps.iter_mut().zip(&answer.step_errors) {
        [step.before, step.after] = errors.held_out.get("effort").copied().unwrap_or_default();
    }
    Ok(true)
}
