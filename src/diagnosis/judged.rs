//! Errors as a comparison with the amended model states them: at its cut-off, of all samples.
use super::filtered::Request;
use super::stated::state;
use crate::measurements::{Content, Measured, SAMPLES};
use bipedc_analysis::diagnose::{Diagnosis, errors};
use bipedc_analysis::experiments::{Channel, Experiment};
use bipedc_analysis::measure::{self, HELD};
use bipedc_effects::diagnostic::Diagnostics;
use bipedc_effects::effect::Effect;

/// Errors at the cut-off that fits the judging log best once everything is in: the one that a comparison of that log with the
/// amended model chooses, so that both state the same. False if it is the one of the search.
pub(super) fn best_filter(
    measured: &Measured,
    request: &Request<'_>,
    reading: &measure::Options,
    answer: &mut Diagnosis,
) -> Result<bool, Diagnostics> {
    let efforts = measured.content(&request.log) == Content::Efforts;
    if !efforts || !request.options.channels.is_empty() {
        return Ok(false);
    }
    let effects: Vec<Effect> = answer.estimated().cloned().collect();
    let (log, mut whole) = match &request.validate {
        Some(log) => (log, measure::Options { from_s: None, to_s: None, ..reading.clone() }),
        None => (&request.log, reading.clone()),
    };
    let mut best: Option<(f64, f64)> = None;
    for cutoff in measure::CANDIDATES {
        whole.cutoff_hz = Some(cutoff);
        // A cut-off beyond half the sampling rate is not one.
        let Ok(loaded) = measured.load(log, &whole, None) else { continue };
        let error = geometric_mean(&*loaded.experiment, &effects);
        if best.is_none_or(|(_, least)| error < least) {
            best = Some((cutoff, error));
        }
    }
    let cutoff = best.map_or(answer.cutoff_hz, |(cutoff, _)| cutoff);
    if cutoff != answer.cutoff_hz {
        answer.judged_at_hz = Some(cutoff);
        return as_compared(measured, request, reading, answer);
    }
    of_all_samples(measured, request, reading, answer)
}

/// Geometric mean of the errors of all torques, all samples.
fn geometric_mean(experiment: &dyn Experiment, effects: &[Effect]) -> f64 {
    // Judged by itself a log shows all of its samples.
    let rows = errors(experiment, Some(experiment), effects).rows;
    let torques = experiment.rows().iter().filter(|row| row.channel == Channel::Effort);
    let logs: Vec<f64> = torques
        .filter_map(|row| rows.get(&row.name))
        .map(|fall| fall.after.ln())
        .filter(|x| x.is_finite())
        .collect();
    (logs.iter().sum::<f64>() / logs.len().max(1) as f64).exp()
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
    let cutoff = answer.judged_at_hz.unwrap_or(answer.cutoff_hz);
    let at = measure::Options { cutoff_hz: Some(cutoff), ..reading.clone() };
    let whole = measure::Options { from_s: None, to_s: None, ..at.clone() };
    let train = measured.efforts(&request.log, &at, HELD)?;
    let judge = request.validate.as_ref().map(|log| measured.efforts(log, &whole, HELD)).transpose()?;
    let judge = judge.as_ref().map(|judge| judge as &dyn Experiment);
    answer.take(errors(&train, judge, &effects));
    state(answer, &train, judge);
    for (step, errors) in answer.steps.iter_mut().zip(&answer.step_errors) {
        [step.before, step.after] = errors.held_out.get("effort").copied().unwrap_or_default();
    }
    Ok(true)
}
