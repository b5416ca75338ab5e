//! What is left of torques above their noise: of an effect, or of fast motion that the filter took off?
use super::filtered::{QUIETER, Request};
use super::judged::{judging, mean_error};
use super::stated::said;
use crate::measurements::{Content, Log, Measured, SAMPLES};
use bipedc_analysis::diagnose::{Closer, Diagnosis, ErrorFall, errors, left_alike};
use bipedc_analysis::experiments::MotionExperiment;
use bipedc_analysis::measure::{self, CANDIDATES, HELD};
use bipedc_analysis::parallel::parallel;
use bipedc_effects::effect::Effect;
use std::cell::LazyCell;
use std::collections::BTreeMap;

/// Part of a squared error behind a slow filter that has to be left behind a faster one alike, in the mean over the joints, where nothing of the
/// motion is taken off; and at each of them.
const KEPT: f64 = 0.93;
const KEPT_AT_LEAST: f64 = 0.75;
/// Where nothing but noise is left, a filter takes motion off that leaves more than this part of the noise's squares behind it and not behind the next faster
/// one alike,
const TAKEN: f64 = 0.3;
/// and more than so many standard deviations of that.
const BEYOND_CHANCE: f64 = 3.0;
/// The next cut-off is faster by this factor at least.
const FASTER: f64 = 1.2;
/// So many faster filters are asked: behind still faster ones encoders' noise is all there is.
const CLOSER: usize = 3;

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
    let is_safe = |(i, slower): (usize, &MotionExperiment<'_>)| {
        let told = errors(slower, Some(slower), [&[], &[]]).rows;
        let less = mean_error(slower, &[]) / mean_error(&here, &[]);
        if told.values().all(|fall| fall.above_noise().is_none()) {
            let next = logs.get(i + 1).and_then(Option::as_ref).unwrap_or(&here);
            return less < 1.0 && !takes_motion_off((slower, next), &told);
        }
        let alike = left_alike((slower, &here), &[], false);
        let parts = told.iter().filter_map(|(row, fall)| Some((alike.get(row)? / fall.told()).powi(2)));
        let parts: Vec<f64> = parts.filter(|part| part.is_finite()).collect();
        let mean = parts.iter().sum::<f64>() / parts.len().max(1) as f64;
        less < QUIETER && mean > KEPT && parts.iter().all(|part| *part > KEPT_AT_LEAST)
    };
    let safe = logs.iter().enumerate().position(|(i, log)| log.as_ref().is_some_and(|log| is_safe((i, log))));
    safe.map_or(cutoff, |i| slower[i])
}

/// Whether a filter takes motion off of which a faster one leaves more, by what the description leaves behind it (`told`): too little of a row to be above
/// its noise, and what inertias look like.
fn takes_motion_off(
    (slower, faster): (&MotionExperiment<'_>, &MotionExperiment<'_>),
    told: &BTreeMap<String, ErrorFall>,
) -> bool {
    let closer = Closer::new((slower, faster), &[], false);
    told.iter().any(|(row, fall)| {
        let is_much =
            |[gone, deviation]: [f64; 2]| gone > (TAKEN * fall.noise.powi(2)).max(BEYOND_CHANCE * deviation);
        closer.gone(row, fall).is_some_and(is_much)
    })
}

/// Holds rows above their noise against what is left behind faster filters too, as [`Diagnosis::look_behind`] does, at the cut-off at
/// which the errors of the answer stand. Without effect where there is no faster filter, or no row is above its noise.
pub(super) fn look_behind(
    measured: &Measured,
    request: &Request<'_>,
    reading: &measure::Options,
    answer: &mut Diagnosis,
) {
    let (log, whole) = judging(request, reading);
    if measured.content(log) != Content::Efforts {
        return;
    }
    let judges = Look::new(measured, (log, whole), request.validate.is_none(), answer);
    let mut settled = Vec::new();
    let is_loud = |answer: &Diagnosis| loud(&answer.rows);
    judges.closer(answer, &is_loud, &mut |answer, closer| {
        let rows = answer.look_behind(closer);
        settled.extend(rows.into_iter().map(|row| (row, closer.cutoffs_hz[1])));
    });
    if request.validate.is_some() {
        let teaches = Look::new(measured, (&request.log, reading.clone()), false, answer);
        let is_missed = |answer: &Diagnosis| answer.unseen_by_judge().is_some();
        teaches.closer(answer, &is_missed, &mut Diagnosis::look_behind_training);
    }
    answer.conclude();
    answer.summary = said(answer);
    if let Some(words) = motion_taken_off(&settled, judges.cutoff) {
        answer.assumptions.push(words);
    }
}

fn loud(rows: &BTreeMap<String, ErrorFall>) -> bool {
    rows.values().any(|fall| fall.above_noise().is_some())
}

/// Which rows are noise once they are held against a faster filter (Hz).
fn motion_taken_off(settled: &[(String, f64)], cutoff: f64) -> Option<String> {
    let rows: Vec<String> =
        settled.iter().map(|(row, faster)| format!("{row} (behind {faster} Hz)")).collect();
    (!rows.is_empty()).then(|| {
        format!(
            "what is left above the noise at {} is what the filter of {cutoff} Hz takes off fast motion: it is not left behind a faster one as well",
            rows.join(", ")
        )
    })
}

/// One log behind a filter and faster ones, with all that was found.
struct Look<'l> {
    measured: &'l Measured,
    log: &'l Log,
    reading: measure::Options,
    /// Blocks of it judge.
    own_blocks: bool,
    cutoff: f64,
    /// Samples that are held.
    most: usize,
    effects: Vec<Effect>,
}

impl<'l> Look<'l> {
    fn new(
        measured: &'l Measured,
        (log, reading): (&'l Log, measure::Options),
        own_blocks: bool,
        answer: &Diagnosis,
    ) -> Self {
        // Of as many samples as the errors are of.
        let judged = answer.validation.as_ref().unwrap_or(&answer.training);
        let held = answer.judged_at_hz.is_some() || answer.training.samples.max(judged.samples) > SAMPLES / 2;
        let (most, cutoff) =
            (if held { HELD } else { SAMPLES }, answer.judged_at_hz.unwrap_or(answer.cutoff_hz));
        Self {
            measured,
            log,
            reading,
            own_blocks,
            cutoff,
            most,
            effects: answer.estimated().cloned().collect(),
        }
    }

    /// Shows an answer what is left behind faster filters, one after the other, as long as it asks for it.
    fn closer(
        &self,
        answer: &mut Diagnosis,
        asks: &dyn Fn(&Diagnosis) -> bool,
        show: &mut dyn FnMut(&mut Diagnosis, &Closer),
    ) {
        let here = LazyCell::new(|| self.at(self.cutoff));
        for faster in CANDIDATES.into_iter().filter(|other| *other > FASTER * self.cutoff).take(CLOSER) {
            if !asks(answer) {
                return;
            }
            let (Some(here), Some(closer)) = (&*here, self.at(faster)) else { return };
            show(answer, &Closer::new((here, &closer), &self.effects, self.own_blocks));
        }
    }

    /// `None`: a cut-off beyond half the sampling rate is not one.
    fn at(&self, cutoff: f64) -> Option<MotionExperiment<'l>> {
        let reading = measure::Options { cutoff_hz: Some(cutoff), ..self.reading.clone() };
        self.measured.efforts(self.log, &reading, self.most).ok()
    }
}
