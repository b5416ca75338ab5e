//! What is left of torques above their noise: of an effect, or of fast motion that the filter took off?
use super::filtered::{QUIETER, Request};
use super::judged::{judging, mean_error};
use super::stated::said;
use crate::measurements::{Content, Measured, SAMPLES};
use bipedc_analysis::diagnose::{Diagnosis, errors, left_alike};
use bipedc_analysis::experiments::{Experiment, MotionExperiment};
use bipedc_analysis::measure::{self, CANDIDATES, HELD};
use bipedc_analysis::parallel::parallel;
use bipedc_effects::effect::Effect;

/// Part of a squared error behind a slow filter that has to be left behind a faster one alike, in the mean over the joints, where nothing of the
/// motion is taken off; and at each of them.
const KEPT: f64 = 0.93;
const KEPT_AT_LEAST: f64 = 0.75;
/// The next cut-off is faster by this factor at least.
const FASTER: f64 = 1.2;

/// The slowest filter's cut-off (Hz), below that at which a search begins, behind which much less is left and nothing of the motion is taken off, or less and
/// nothing but noise: then what is left behind the faster one is the encoders' noise, which looks like inertias. Else that cut-off.
pub(super) fn slower_where_safe(measured: &Measured, request: &Request<'_>, cutoff: f64) -> f64 {
    let chosen = request.options.reading.cutoff_hz.is_some();
    if chosen || measured.content(&request.log) != Content::Efforts {
        return cutoff;
    }
    let at = |cutoff: f64| {
        let reading = measure::Options { cutoff_hz: Some(cutoff), ..request.options.reading.clone() };
        measured.efforts(&request.log, &reading, SAMPLES).ok()
    };
    let slower: Vec<f64> = CANDIDATES.into_iter().take_while(|other| *other < cutoff).collect();
    let mut logs = parallel(slower.len() + 1, |i| at(slower.get(i).copied().unwrap_or(cutoff)));
    let Some(here) = logs.pop().flatten() else { return cutoff };
    let is_safe = |slower: &MotionExperiment<'_>| {
        let told = errors(slower, Some(slower), [&[], &[]]).rows;
        let less = mean_error(slower, &[]) / mean_error(&here, &[]);
        if told.values().all(|fall| fall.above_noise().is_none()) {
            return less < 1.0;
        }
        let alike = left_alike((slower, &here), &[], false);
        let parts = told.iter().filter_map(|(row, fall)| Some((alike.get(row)? / fall.told()).powi(2)));
        let parts: Vec<f64> = parts.filter(|part| part.is_finite()).collect();
        let mean = parts.iter().sum::<f64>() / parts.len().max(1) as f64;
        less < QUIETER && mean > KEPT && parts.iter().all(|part| *part > KEPT_AT_LEAST)
    };
    let safe = logs.iter().position(|log| log.as_ref().is_some_and(is_safe));
    safe.map_or(cutoff, |i| slower[i])
}

/// Holds rows above their noise against what is left behind the next faster filter too, as [`Diagnosis::look_behind`] does, at the cut-off at
/// which the errors of the answer stand. Without effect where there is no faster filter, or no row is above its noise.
pub(super) fn look_behind(
    measured: &Measured,
    request: &Request<'_>,
    reading: &measure::Options,
    answer: &mut Diagnosis,
) {
    let loud = answer.rows.values().any(|fall| fall.above_noise().is_some());
    let (log, whole) = judging(request, reading);
    let cutoff = answer.judged_at_hz.unwrap_or(answer.cutoff_hz);
    let Some(faster) = CANDIDATES.into_iter().find(|other| *other > FASTER * cutoff) else { return };
    if measured.content(log) != Content::Efforts || !loud {
        return;
    }
    // Of as many samples as the errors are of.
    let judged = answer.validation.as_ref().unwrap_or(&answer.training);
    let held = answer.judged_at_hz.is_some() || answer.training.samples.max(judged.samples) > SAMPLES / 2;
    let at = |cutoff: f64| {
        let reading = measure::Options { cutoff_hz: Some(cutoff), ..whole.clone() };
        // A cut-off beyond half the sampling rate is not one.
        measured.efforts(log, &reading, if held { HELD } else { SAMPLES }).ok()
    };
    let (Some(here), Some(closer)) = (at(cutoff), at(faster)) else { return };
    let effects: Vec<Effect> = answer.estimated().cloned().collect();
    let logs: (&dyn Experiment, &dyn Experiment) = (&here, &closer);
    let both = left_alike(logs, &effects, request.validate.is_none());
    let settled = answer.look_behind(&both);
    answer.conclude();
    answer.summary = said(answer);
    if !settled.is_empty() {
        answer.assumptions.push(format!(
            "what is left above the noise at {} is what the filter of {cutoff} Hz takes off fast motion: it is not left behind one of {faster} Hz as well",
            settled.join(", ")
        ));
    }
}
