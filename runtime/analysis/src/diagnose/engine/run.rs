//! The diagnosis of a log: search, final estimate, what is left, in numbers and words.
use super::equations::regression::{Regression, is_held_out};
use super::judge::conclusion::Conclusion;
use super::judge::errors::errors;
use super::judge::own_blocks::unshown;
use super::judge::significance::{Insignificant, insignificant, is_vague, says_no_more};
use super::refine::behind_motors::stand_in_line;
use super::refine::curved_friction::curved;
use super::refine::estimates::{data, estimates, from_description, spread};
use super::refine::refinement::{Data, Refined, likelier, refine};
use super::refine::sharp_friction::{is_a_sharp_sign, put_dry, sharpened};
use super::search::corrections::settle;
use super::search::forward::{Outcome, search};
use super::search::own_friction::put_own;
use super::search::parsimony::{put_simpler, simplify};
use super::search::rival::{indistinguishable, is_likelier};
use super::search::weak_friction::beside_friction;
use super::words::text;
use crate::diagnose::Diagnosis;
use crate::experiments::{Channel, Experiment};
use crate::robot::link_inertias::CadError;
use bipedc_effects::effect::{Effect, Kind, Location, kinds};

/// Most searches with a lower noise floor.
const WEIGHINGS: usize = 2;
/// Most searches with noise that what is left shows to be larger than it was taken.
const HEARINGS: usize = 2;
/// Most effects that are taken out again once everything was estimated.
const RECONSIDERED: usize = 6;

/// Corrections whose squares, each in its standard deviations, add up to less are what descriptions usually are off: two standard deviations of one number.
const USUAL_ERRORS: f64 = 4.0;

/// How to diagnose.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// How far CAD data are usually off.
    pub cad: CadError,
    /// CAD errors are taken this many times wider; large: inertial parameters are estimated freely.
    pub widening: f64,
    /// Most effects that are looked for; `None`: twelve, or two for every joint and two more, at most 24.
    pub most: Option<usize>,
    /// Effects that stand from the start: they are estimated with the rest, are not judged, and do not count among
    /// what was found. The experiment must not have them already.
    pub standing: Vec<Effect>,
    /// What is not looked for, and where.
    pub barred: Vec<(&'static Kind, Location)>,
}

impl Options {
    /// Most effects that are looked for in this data.
    fn most(&self, train: &dyn Experiment) -> usize {
        /// Of a joint: dry and viscous friction.
        const OF_JOINT: usize = 2;
        let joints = train.rows().iter().filter(|row| row.channel == Channel::Effort).count();
        self.most.unwrap_or((OF_JOINT * joints + 2).clamp(12, 24))
    }
}

impl Default for Options {
    fn default() -> Self {
        Self { cad: CadError::default(), widening: 1.0, most: None, standing: Vec::new(), barred: Vec::new() }
    }
}

/// Finds what is missing. `train` is estimated from; `validation` judges, or blocks of `train` where there is none.
/// `progress` is told the fraction that is done.
///
/// Both experiments must have the same rows. The data sources, cut-off, warnings and assumptions of the answer are
/// left to the caller.
pub fn diagnose(
    train: &dyn Experiment,
    validation: Option<&dyn Experiment>,
    options: &Options,
    progress: &dyn Fn(f64),
) -> Diagnosis {
    let places = places(train, options);
    let mut regression = Regression::new(train, validation, &places, options, &|part| progress(0.5 * part));
    let left_out = regression.keep(&options.standing, regression.has_corrections());
    let entered = |count: usize| progress(0.5 + 0.3 * (count as f64 / (count as f64 + 2.0)));
    let most = options.most(train);
    let Some(mut outcome) = searched(&mut regression, (most, &entered)) else {
        return unanswered(train, validation);
    };
    simplify(&regression, &mut outcome);
    progress(0.85);
    let own_blocks = regression.own_blocks;
    let teaches = move |sample: usize, n: usize| !own_blocks || !is_held_out(sample, n);
    stand_in_line(&regression, &mut outcome, &teaches);
    let rival = outcome.rival.take();
    let how = (validation, most, &entered as &dyn Fn(usize));
    let mut diagnosis = concluded(&mut regression, &mut outcome, &teaches, how);
    progress(0.92);
    if let Some(mut rival) = rival.map(|rival| rival.stand(&mut regression)) {
        simplify(&regression, &mut rival);
        let mut other = concluded(&mut regression, &mut rival, &teaches, how);
        let usual = outcome.corrected && outcome.scored.fit.prior < USUAL_ERRORS;
        if !usual && is_likelier(&regression, validation, &other, &diagnosis) {
            std::mem::swap(&mut diagnosis, &mut other);
        }
        diagnosis.indistinguishable.extend(indistinguishable(&regression, validation, &diagnosis, &other));
    }
    if diagnosis.effects.len() >= most {
        diagnosis.warnings.push(format!("{}, {most}: there may be more", Diagnosis::AS_MANY));
    }
    finish(&mut diagnosis, (train, validation), options, &left_out);
    progress(1.0);
    diagnosis
}

/// What is looked for, and where: what stands too.
fn places(train: &dyn Experiment, options: &Options) -> Vec<(&'static Kind, Location)> {
    let mut places = train.candidates();
    places.retain(|place| !options.barred.contains(place));
    for (kind, place) in places_of(&options.standing) {
        if !places.iter().any(|(other, at)| *other == kind && *at == place) {
            places.push((kind, place));
        }
    }
    places
}

/// Searches until noise is taken for what it is found to be; `None` where no fit can be made.
fn searched(regression: &mut Regression<'_>, (most, entered): (usize, &dyn Fn(usize))) -> Option<Outcome> {
    let mut outcome = search(regression, most, entered)?;
    reweighed(regression, &mut outcome, (most, entered));
    for _ in 0..HEARINGS {
        let effects = estimates(regression, &outcome);
        if !regression.hear(&effects, &outcome.scored) {
            break;
        }
        let Some(again) = search(regression, most, entered) else { break };
        outcome = again;
        reweighed(regression, &mut outcome, (most, entered));
    }
    Some(outcome)
}

/// Warnings, errors beside what stood from the start, and words.
fn finish(
    diagnosis: &mut Diagnosis,
    (train, validation): (&dyn Experiment, Option<&dyn Experiment>),
    options: &Options,
    left_out: &[&Effect],
) {
    diagnosis.warnings.extend(left_out.iter().map(|effect| {
        format!("{effect} was left out: this data cannot tell it from the other effects of the description")
    }));
    if !options.standing.is_empty() {
        diagnosis.described.clone_from(&options.standing);
        let found: Vec<Effect> = diagnosis.estimated().cloned().collect();
        diagnosis.take(errors(train, validation, [&options.standing, &found]));
    }
    if validation.is_none() {
        diagnosis.warnings.extend(unshown(train));
    }
    diagnosis.conclude();
    diagnosis.summary = text::summary(diagnosis);
}

/// What a search found, estimated and judged; effects that say nothing leave `outcome`.
fn concluded(
    regression: &mut Regression<'_>,
    outcome: &mut Outcome,
    teaches: &(dyn Fn(usize, usize) -> bool + Sync),
    (validation, most, entered): (Option<&dyn Experiment>, usize, &dyn Fn(usize)),
) -> Diagnosis {
    let mut left = RECONSIDERED;
    let mut declined = Vec::new();
    loop {
        let refined = estimated(regression, outcome, teaches, (most, entered));
        let refined = beside_friction(regression, outcome, refined, (teaches, &declined));
        let refined = curved(regression, outcome, refined, teaches);
        let refined = sharpened(regression, refined);
        let settled = settle(data(regression, teaches), refined, &regression.spread, regression.free);
        let judged = regression.standing.len()..outcome.active.len();
        let no_more = |k: usize| says_no_more(&settled.refined, k);
        let put = |k: usize| put_own(regression, outcome, (&settled.refined, k), teaches);
        if judged.filter(|&k| no_more(k)).any(put) {
            continue;
        }
        let conclusion = Conclusion { regression, outcome, settled: &settled };
        let diagnosis = conclusion.write(regression.train, validation);
        let Some(k) = conclusion.idle(&diagnosis).filter(|_| left > 0) else {
            let better = if left > 0 { conclusion.surpassed() } else { None };
            if !better.is_some_and(|(k, c)| put_candidate(regression, outcome, k, c)) {
                return diagnosis;
            }
            left -= 1;
            continue;
        };
        left -= 1;
        declined.push(outcome.active[k]);
        if !put_dry_friction(regression, outcome, (&settled.refined, k))
            && !drop_effect(regression, outcome, k)
        {
            return diagnosis;
        }
    }
}

/// Searches again as long as what was found does better than the noise floor; not where as many effects were found as are looked for: what more would
/// do to it is not known.
fn reweighed(
    regression: &mut Regression<'_>,
    outcome: &mut Outcome,
    (most, entered): (usize, &dyn Fn(usize)),
) {
    for _ in 0..WEIGHINGS {
        if outcome.active.len() - regression.standing.len() >= most {
            break;
        }
        let effects = estimates(regression, outcome);
        if !regression.reweigh(&effects, &outcome.scored) {
            break;
        }
        let Some(again) = search(regression, most, entered) else { break };
        *outcome = again;
    }
}

/// The final estimate of what a search found; effects that it shows to be impossible or insignificant leave `outcome`.
fn estimated(
    regression: &mut Regression<'_>,
    outcome: &mut Outcome,
    teaches: &(dyn Fn(usize, usize) -> bool + Sync),
    (most, entered): (usize, &dyn Fn(usize)),
) -> Refined {
    let mut retries = 4;
    loop {
        let effects = estimates(regression, outcome);
        let refine = |effects: Vec<Effect>| {
            refine(data(regression, teaches), effects, &[], spread(regression, outcome.corrected))
        };
        let mut refined = refine(effects);
        if regression.described.iter().any(Option::is_some) {
            refined = from_what_is_described(regression, outcome, refined, teaches);
        }
        let Some(Insignificant { effect, impossible }) = insignificant(regression, outcome, &refined) else {
            let judged = regression.standing.len()..outcome.active.len();
            let sharp = judged.clone().find(|&k| is_a_sharp_sign(regression, &refined, k));
            if sharp.is_some_and(|k| put_dry(regression, outcome, k)) {
                continue;
            }
            if judged.clone().any(|k| put_own(regression, outcome, (&refined, k), teaches)) {
                continue;
            }
            let no_more = |k: usize| says_no_more(&refined, k);
            let vague: Vec<usize> = judged.filter(|&k| is_vague(&refined, k) || no_more(k)).collect();
            if vague.into_iter().any(|k| put_simpler(regression, outcome, k, no_more(k))) {
                continue;
            }
            return refined;
        };
        if impossible && retries > 0 {
            // What the exact estimate makes impossible hid something else: look again without it.
            retries -= 1;
            regression.ban(outcome.active[effect]);
            let Some(again) = search(regression, most, entered) else { return refined };
            *outcome = again;
            simplify(regression, outcome);
            continue;
        }
        if !put_dry_friction(regression, outcome, (&refined, effect))
            && !drop_effect(regression, outcome, effect)
        {
            return refined;
        }
    }
}

/// An estimate, or the one that begins with the description, whichever leaves less of the data that judge; parameters of the description that data do
/// not tell keep their values.
fn from_what_is_described(
    regression: &Regression<'_>,
    outcome: &Outcome,
    refined: Refined,
    teaches: &(dyn Fn(usize, usize) -> bool + Sync),
) -> Refined {
    let (data, spread) = (data(regression, teaches), spread(regression, outcome.corrected));
    let described = from_description(regression, outcome);
    let refined = likelier(data, spread, [refine(data, described.clone(), &[], spread), refined]);
    let of_effect = |(k, was): (usize, &Option<Effect>)| {
        let Some(was) = was else { return Vec::new() };
        let found = &refined.effects[k];
        let is_untold = |(name, half): &&(String, f64)| {
            let size = was.value(name).abs().max(found.value(name).abs());
            !half.is_finite() || (was.value(name) != 0.0 && *half > size)
        };
        let untold = refined.half_width[k].iter().filter(is_untold);
        untold.map(|(name, _)| (k, name.clone())).collect::<Vec<_>>()
    };
    let held: Vec<(usize, String)> = regression.described.iter().enumerate().flat_map(of_effect).collect();
    if held.is_empty() {
        return refined;
    }
    let mut start = refined.effects.clone();
    for (k, name) in &held {
        start[*k].parameters.insert(name.clone(), described[*k].value(name));
    }
    let mut kept = refine(Data { held: &held, ..data }, start, &[], spread);
    // They may be anything all the same.
    for (k, name) in held {
        kept.half_width[k].push((name, f64::INFINITY));
    }
    kept
}

/// A curve that says nothing where joints are fast may hide dry friction that says something. Tells whether that was put.
fn put_dry_friction(
    regression: &Regression<'_>,
    outcome: &mut Outcome,
    (refined, k): (&Refined, usize),
) -> bool {
    refined.effects[k].kind == &kinds::STRIBECK_FRICTION && put_dry(regression, outcome, k)
}

/// Puts a candidate in the place of the `k`-th effect of what a search found; tells whether all can be fitted.
fn put_candidate(regression: &Regression<'_>, outcome: &mut Outcome, k: usize, c: usize) -> bool {
    let mut set = outcome.active.clone();
    set[k] = c;
    let Some(scored) = regression.scored_fit(&set, outcome.corrected) else { return false };
    (outcome.active, outcome.scored) = (set, scored);
    true
}

/// Takes the `k`-th effect out of what a search found; tells whether the others can be fitted without it.
fn drop_effect(regression: &Regression<'_>, outcome: &mut Outcome, k: usize) -> bool {
    let mut fewer = outcome.active.clone();
    fewer.remove(k);
    let Some(scored) = regression.scored_fit(&fewer, outcome.corrected) else { return false };
    (outcome.active, outcome.scored) = (fewer, scored);
    true
}

/// What is said where no fit could be made at all: the errors as they are, and that nothing was found out.
fn unanswered(train: &dyn Experiment, validation: Option<&dyn Experiment>) -> Diagnosis {
    let mut diagnosis = Diagnosis::default();
    diagnosis.take(errors(train, validation, [&[], &[]]));
    let why = "no estimate could be made: the equations of this log are singular; nothing is said of what the model lacks";
    diagnosis.warnings.push(why.to_owned());
    diagnosis.unexplained = true;
    diagnosis.suspects = diagnosis.rows.keys().cloned().collect();
    diagnosis.summary = why.to_owned();
    diagnosis
}

pub(super) fn places_of(effects: &[Effect]) -> Vec<(&'static Kind, Location)> {
    effects.iter().map(|effect| (effect.kind, effect.location.clone())).collect()
}
