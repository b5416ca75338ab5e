//! Parts of an answer that make the error larger behind the filter at which it is told.
//!
//! A search looks behind a faster filter than the one behind which least is left. There the encoders' noise makes up a part of the model's torque: lighter
//! links, and torques that come late, lower the error because they let less of it through. Behind the slower filter that noise is gone, and what
//! was nothing else makes the error larger.
use super::filtered::{Filtered, Request, filtered};
use super::judged::mean_error;
use crate::measurements::{Content, Measured};
use bipedc_analysis::diagnose::{Diagnosis, ErrorFall, FoundEffect, Options, errors, root_mean_squares};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::robot::link_inertias::CadError;
use bipedc_effects::effect::{Effect, Kind, Location, kinds};

/// Squares of a row that rise by more than this part rise.
const RISES: f64 = 0.01;
/// Slower filters on feet, in parts of the cut-off.
const SLOWER: [f64; 2] = [0.5, 0.25];
/// Errors of less than so many times their noise are noise.
const HEARD: f64 = 1.15;
/// Another answer may leave so many times as much.
const ALIKE: f64 = 1.01;

/// What a search should do without.
pub(super) struct Raised {
    /// Masses, centres of mass and inertias are as described.
    corrections: bool,
    /// These effects are nowhere.
    effects: Vec<(&'static Kind, Location)>,
    /// That is not seen in the errors where the answer is told, but behind a slower filter, or beside the noise.
    by_slower: bool,
}

impl Raised {
    /// What of an answer only raises errors of the judging log behind the filter at which it is told, or behind a slower one which leaves less, as it does of robots
    /// on their feet that move slowly.
    pub fn by(measured: &Measured, request: &Request<'_>, answer: &Diagnosis) -> Option<Self> {
        if !answer.inertial_corrections.is_empty() && is_noise_without_corrections(measured, request, answer)
        {
            return Some(Self { corrections: true, effects: Vec::new(), by_slower: true });
        }
        let here = answer.judged_at_hz.unwrap_or(answer.cutoff_hz);
        let told = answer
            .judged_at_hz
            .and_then(|cutoff| Self::behind(&filtered(measured, request, cutoff).ok()?, answer));
        if told.is_some() || measured.content(&request.log) != Content::Contacts {
            return told;
        }
        let all: Vec<Effect> = answer.estimated().cloned().collect();
        let left = |logs: &Filtered<'_>| mean_error(logs.judging().unwrap_or(&*logs.train.experiment), &all);
        let first = filtered(measured, request, here).ok()?;
        let slower = SLOWER.into_iter().filter_map(|part| filtered(measured, request, part * here).ok());
        let raised =
            slower.filter(|logs| left(logs) < left(&first)).find_map(|logs| Self::behind(&logs, answer));
        raised.map(|raised| Self { by_slower: true, ..raised })
    }

    /// What of an answer only raises errors of the judging log: corrections, each effect, or all effects on links together, where each makes up for the others.
    fn behind(logs: &Filtered<'_>, answer: &Diagnosis) -> Option<Self> {
        let alone = |found: &&FoundEffect| raises(logs, answer, std::slice::from_ref(*found));
        let of_links: Vec<FoundEffect> =
            answer.effects.iter().filter(|found| found.effect.location.link.is_some()).cloned().collect();
        let mut raised: Vec<FoundEffect> = answer.effects.iter().filter(alone).cloned().collect();
        if raised.is_empty() && raises(logs, answer, &of_links) {
            raised = of_links;
        }
        let places = raised.into_iter().map(|found| (found.effect.kind, found.effect.location));
        let raised = Self {
            corrections: raises(logs, answer, &answer.inertial_corrections),
            effects: places.collect(),
            by_slower: false,
        };
        (raised.corrections || !raised.effects.is_empty()).then_some(raised)
    }

    /// The same search without it.
    pub fn without(&self, search: &Options) -> Options {
        let mut search = search.clone();
        if self.corrections {
            search.cad = CadError::NONE;
        }
        search.barred.extend(self.effects.iter().cloned());
        search
    }

    /// Whether an answer without it stands in the place of the first: it explains as much, and leaves no more where that is told.
    pub fn is_answered(&self, second: &Diagnosis, first: &Diagnosis) -> bool {
        let as_little = self.by_slower || second.rms_after <= ALIKE * first.rms_after;
        as_little && (first.unexplained || !second.unexplained)
    }
}

/// Whether nothing but noise is left of any row without corrections of masses: what they lower then is the noise that the motion brings with it, which
/// lighter links let less through of.
fn is_noise_without_corrections(measured: &Measured, request: &Request<'_>, answer: &Diagnosis) -> bool {
    let here = answer.judged_at_hz.unwrap_or(answer.cutoff_hz);
    let Ok(logs) = filtered(measured, request, here) else { return false };
    let is_effect = |effect: &&Effect| effect.kind != &kinds::INERTIAL_CORRECTION;
    let effects: Vec<Effect> = answer.estimated().filter(is_effect).cloned().collect();
    let rows = errors(&*logs.train.experiment, logs.judging(), [&[], &effects]).rows;
    let is_noise = |fall: &ErrorFall| fall.noises().is_some_and(|times| times < HEARD);
    !rows.is_empty() && rows.values().all(is_noise)
}

/// Whether some of what was found makes the squares of rows larger beside all the rest, in their geometric mean too.
fn raises(logs: &Filtered<'_>, answer: &Diagnosis, some: &[FoundEffect]) -> bool {
    if some.is_empty() {
        return false;
    }
    let experiment = logs.judging().unwrap_or(&*logs.train.experiment);
    let is_one = |effect: &&Effect| {
        !some.iter().any(|found| found.effect.kind == effect.kind && found.effect.location == effect.location)
    };
    let all: Vec<Effect> = answer.estimated().cloned().collect();
    let others: Vec<Effect> = all.iter().filter(is_one).cloned().collect();
    let [with, without] = [&all, &others].map(|effects| squares(experiment, effects));
    let changes =
        with.iter().zip(&without).map(|(with, without)| (with / without.max(f64::MIN_POSITIVE)).ln());
    let (most, sum) = changes.fold((0.0_f64, 0.0), |(most, sum), x| (most.max(x), sum + x));
    most > RISES && sum > 0.0
}

fn squares(experiment: &dyn Experiment, effects: &[Effect]) -> Vec<f64> {
    root_mean_squares(experiment, effects).into_iter().map(|rms| rms * rms).collect()
}
