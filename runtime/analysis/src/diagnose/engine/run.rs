//! The diagnosis of a log: search, final estimate, what is left, in numbers and words.
use super::amended::Amended;
use super::block_equations::Spread;
use super::corrections::{Settled, settle};
use super::errors::errors;
use super::parsimony::{put_simpler, simplify};
use super::refinement::{Data, Refined, refine};
use super::regression::{Regression, is_held_out};
use super::rival::is_likelier;
use super::search::{Outcome, consider, search};
use super::significance::{Insignificant, insignificant, is_vague, says_no_more, uncertain};
use super::text;
use super::unexplained::{unexplained, untaught};
use crate::diagnose::{Diagnosis, FoundEffect, Rejected, Step};
use crate::experiments::Experiment;
use crate::robot::link_inertias::CadError;
use bipedc_effects::effect::{Effect, Kind, Location};
use std::collections::BTreeMap;

/// Effects with a smaller share of the main rows' error are there for other rows.
const ELSEWHERE: f64 = 0.01;
/// Most searches with a lower noise floor.
const WEIGHINGS: usize = 2;
/// Most searches with noise that what is left shows to be larger than it was taken.
const HEARINGS: usize = 2;
/// Most effects that are taken out again once everything was estimated.
const RECONSIDERED: usize = 6;

/// How to diagnose.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// How far CAD data are usually off.
    pub cad: CadError,
    /// CAD errors are taken this many times wider; large: inertial parameters are estimated freely.
    pub widening: f64,
    /// Most effects that are looked for.
    pub most: usize,
    /// Effects that stand from the start: they are estimated with the rest, are not judged, and do not count among
    /// what was found. The experiment must not have them already.
    pub standing: Vec<Effect>,
}

impl Default for Options {
    fn default() -> Self {
        Self { cad: CadError::default(), widening: 1.0, most: 12, standing: Vec::new() }
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
    let mut places = train.candidates();
    for (kind, place) in places_of(&options.standing) {
        if !places.iter().any(|(other, at)| *other == kind && *at == place) {
            places.push((kind, place));
        }
    }
    let mut regression = Regression::new(train, validation, &places, options, &|part| progress(0.5 * part));
    let left_out = regression.keep(&options.standing, regression.has_corrections());
    let entered = |count: usize| progress(0.5 + 0.3 * (count as f64 / (count as f64 + 2.0)));
    let Some(mut outcome) = search(&mut regression, options.most, &entered) else {
        return unanswered(train, validation);
    };
    reweighed(&mut regression, &mut outcome, (options.most, &entered));
    for _ in 0..HEARINGS {
        let effects = estimates(&regression, &outcome);
        if !regression.hear(&effects, &outcome.scored) {
            break;
        }
        let Some(again) = search(&mut regression, options.most, &entered) else { break };
        outcome = again;
        reweighed(&mut regression, &mut outcome, (options.most, &entered));
    }
    simplify(&regression, &mut outcome);
    progress(0.85);
    let own_blocks = regression.own_blocks;
    let teaches = move |sample: usize, n: usize| !own_blocks || !is_held_out(sample, n);
    let rival = outcome.rival.take();
    let how = (validation, options.most, &entered as &dyn Fn(usize));
    let mut diagnosis = concluded(&mut regression, &mut outcome, &teaches, how);
    progress(0.92);
    if let Some(mut simpler) = rival.map(|rival| rival.stand(&mut regression)) {
        simplify(&regression, &mut simpler);
        let other = concluded(&mut regression, &mut simpler, &teaches, how);
        if is_likelier(&regression, validation, &other, &diagnosis) {
            diagnosis = other;
        }
    }
    diagnosis.warnings.extend(left_out.into_iter().map(|effect| {
        format!("{effect} was left out: this data cannot tell it from the other effects of the description")
    }));
    if diagnosis.effects.len() >= options.most {
        diagnosis.warnings.push(format!(
            "as many effects were found as are looked for, {}: there may be more",
            options.most
        ));
    }
    diagnosis.conclude();
    diagnosis.summary = text::summary(&diagnosis);
    progress(1.0);
    diagnosis
}

/// What a search found, estimated and judged; effects that say nothing leave `outcome`.
fn concluded(
    regression: &mut Regression<'_>,
    outcome: &mut Outcome,
    teaches: &(dyn Fn(usize, usize) -> bool + Sync),
    (validation, most, entered): (Option<&dyn Experiment>, usize, &dyn Fn(usize)),
) -> Diagnosis {
    let mut left = RECONSIDERED;
    loop {
        let refined = estimated(regression, outcome, teaches, (most, entered));
        let settled = settle(data(regression, teaches), refined, &regression.spread, regression.free);
        let conclusion = Conclusion { regression, outcome, settled: &settled };
        let diagnosis = conclusion.write(regression.train, validation);
        let Some(k) = conclusion.idle(&diagnosis).filter(|_| left > 0) else { return diagnosis };
        left -= 1;
        if !drop_effect(regression, outcome, k) {
            return diagnosis;
        }
    }
}

/// Searches again as long as what was found does better than the noise floor.
fn reweighed(
    regression: &mut Regression<'_>,
    outcome: &mut Outcome,
    (most, entered): (usize, &dyn Fn(usize)),
) {
    for _ in 0..WEIGHINGS {
        if !regression.reweigh(&outcome.scored) {
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
        let refined = refine(data(regression, teaches), effects, &[], spread(regression, outcome.corrected));
        let Some(Insignificant { effect, impossible }) = insignificant(regression, &refined) else {
            let judged = regression.standing.len()..outcome.active.len();
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
        if !drop_effect(regression, outcome, effect) {
            return refined;
        }
    }
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
    diagnosis.take(errors(train, validation, &[]));
    let why = "no estimate could be made: the equations of this log are singular; nothing is said of what the model lacks";
    diagnosis.warnings.push(why.to_owned());
    diagnosis.unexplained = true;
    diagnosis.suspects = diagnosis.rows.keys().cloned().collect();
    diagnosis.summary = why.to_owned();
    diagnosis
}

/// Estimates parameters of given effects; those that are stated are where the search starts, others are found.
///
/// As [`diagnose`], but nothing else is tried and nothing is dropped.
pub fn estimate(
    train: &dyn Experiment,
    validation: Option<&dyn Experiment>,
    effects: &[Effect],
    options: &Options,
) -> Diagnosis {
    let mut regression = Regression::new(train, validation, &places_of(effects), options, &|_| ());
    regression.linearise(&[], regression.has_corrections());
    let starts: Vec<Effect> = effects.iter().map(|effect| start(&regression, effect)).collect();
    let corrected = regression.has_corrections();
    let Some(scored) = regression.scored_fit(&[], corrected) else { return Diagnosis::default() };
    let outcome = Outcome { active: Vec::new(), scored, corrected, reasons: BTreeMap::new(), rival: None };
    let teaches = |sample: usize, n: usize| !regression.own_blocks || !is_held_out(sample, n);
    let data = data(&regression, &teaches);
    let refined = refine(data, starts, &[], spread(&regression, corrected));
    let settled = settle(data, refined, &regression.spread, regression.free);
    let mut diagnosis =
        Conclusion { regression: &regression, outcome: &outcome, settled: &settled }.write(train, validation);
    diagnosis.conclude();
    diagnosis.summary = text::summary(&diagnosis);
    diagnosis
}

/// What the estimates of a regression are made from.
fn data<'r>(regression: &'r Regression<'_>, teaches: &'r (dyn Fn(usize, usize) -> bool + Sync)) -> Data<'r> {
    Data { experiment: regression.train, weights: &regression.weights, teaches }
}

/// How far inertial parameters may move, if they may.
fn spread<'r>(regression: &'r Regression<'_>, corrected: bool) -> Option<&'r Spread> {
    corrected.then_some(&regression.spread)
}

fn places_of(effects: &[Effect]) -> Vec<(&'static Kind, Location)> {
    effects.iter().map(|effect| (effect.kind, effect.location.clone())).collect()
}

/// Where the final estimate of an effect starts.
fn start(regression: &Regression<'_>, effect: &Effect) -> Effect {
    let stated = |name: &str| effect.parameters.get(name).copied();
    let forms = regression.candidates.iter().enumerate();
    let mine = forms.filter(|(_, c)| c.form.is_of(effect) && c.form.fixed.is_empty());
    let best = mine
        .filter_map(|(index, _)| {
            let scored = regression.scored_fit(&[index], regression.has_corrections())?;
            regression.impossible(&[index], &scored).is_none().then_some((index, scored))
        })
        .min_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    let mut start = match best {
        Some((index, scored)) => {
            regression.candidates[index].form.effect(regression.coefficients(&[index], &scored, 0))
        }
        None => effect.clone(),
    };
    (start.name, start.torque, start.own) = (effect.name.clone(), effect.torque.clone(), effect.own.clone());
    for (name, value) in &effect.parameters {
        start.parameters.entry(name.clone()).or_insert(*value);
    }
    // A kind that no column finds starts from what is stated, or from the middle of what is usual.
    for parameter in effect.kind.estimated() {
        let (low, high) = effect.plausible(parameter.name);
        let middle = 0.1 * (low + high);
        let value = stated(parameter.name).unwrap_or(middle);
        start.parameters.entry(parameter.name.to_owned()).or_insert(value);
    }
    start
}

/// The effects of a search, with the values of its fit.
fn estimates(regression: &Regression<'_>, outcome: &Outcome) -> Vec<Effect> {
    (0..outcome.active.len())
        .map(|k| {
            let coefficients = regression.coefficients(&outcome.active, &outcome.scored, k);
            regression.candidates[outcome.active[k]].form.effect(coefficients)
        })
        .collect()
}

pub(super) struct Conclusion<'s> {
    pub regression: &'s Regression<'s>,
    pub outcome: &'s Outcome,
    pub settled: &'s Settled,
}

impl Conclusion<'_> {
    /// An effect that the final estimate, with what was corrected, tells nothing of: all that it might be includes that it is nothing,
    /// or the held-out error does not fall with it.
    fn idle(&self, diagnosis: &Diagnosis) -> Option<usize> {
        let judged = self.regression.standing.len()..self.outcome.active.len();
        let share = |k: usize| {
            let effect = &self.settled.refined.effects[k];
            let same = |found: &&FoundEffect| {
                found.effect.kind == effect.kind && found.effect.location == effect.location
            };
            diagnosis.effects.iter().find(same).map_or(f64::INFINITY, |found| found.share)
        };
        let several = judged.len() > 1;
        judged.rev().find(|&k| uncertain(&self.settled.refined, k) || (several && share(k) <= 0.0))
    }

    fn write(&self, train: &dyn Experiment, validation: Option<&dyn Experiment>) -> Diagnosis {
        let judge = validation.unwrap_or(train);
        let counts = |sample: usize, n: usize| validation.is_some() || is_held_out(sample, n);
        let effects = &self.settled.refined.effects;
        let all = self.settled.all();
        let standing = self.regression.standing.len();
        let steps = self.sequence(judge, &counts);
        let order: Vec<usize> = {
            let mut order: Vec<usize> = (standing..effects.len()).collect();
            order.sort_by(|a, b| steps[b - standing].0.total_cmp(&steps[a - standing].0));
            order
        };
        let mut diagnosis = Diagnosis::default();
        diagnosis.take(errors(train, validation, &all));
        for &k in &order {
            diagnosis.effects.push(self.found(k, steps[k - standing].0));
        }
        diagnosis.standing = (0..standing).map(|k| self.found(k, 0.0)).collect();
        diagnosis.steps = steps.into_iter().map(|(_, step)| step).collect();
        diagnosis.inertial_corrections.clone_from(&self.settled.corrections);
        if self.settled.impossible {
            diagnosis.warnings.push(
                "inertial corrections were left out: no physically possible ones near the estimate were found"
                    .to_owned(),
            );
        }
        diagnosis.indistinguishable = self.alternatives(&diagnosis.effects, &order);
        let (final_train, final_judge) = (Amended::new(train, &all), Amended::new(judge, &all));
        if validation.is_some() {
            diagnosis.warnings.extend(untaught(&final_train, &final_judge, &self.regression.resolutions));
        }
        diagnosis.unexplained_parts =
            unexplained(&final_train, &final_judge, &counts, (effects, &self.regression.resolutions));
        diagnosis.unexplained = !diagnosis.unexplained_parts.is_empty();
        diagnosis.suspects = diagnosis.unexplained_parts.iter().map(|part| part.joint.clone()).collect();
        for found in &mut diagnosis.effects {
            if found.effect.location.joint.as_ref().is_some_and(|joint| diagnosis.suspects.contains(joint)) {
                found.doubts.push(
                    "something is left at this joint that no effect explains: this one may stand for a part of it"
                        .to_owned(),
                );
            }
        }
        diagnosis.rejected = self.rejected(&diagnosis);
        diagnosis
    }

    /// Shares of the held-out squared error, and errors, as the effects entered one after the other.
    fn sequence(&self, judge: &dyn Experiment, counts: &dyn Fn(usize, usize) -> bool) -> Vec<(f64, Step)> {
        let weights = &self.regression.weights;
        let main = main_rows(judge);
        let errors = |count: usize| -> (f64, f64) {
            let amended = Amended::new(judge, &self.settled.refined.effects[..count]);
            let (mut weighted, mut plain, mut n) = (0.0, 0.0, 0usize);
            for (row, weight) in weights.iter().enumerate() {
                let values = amended.residual(row);
                let kept: Vec<f64> =
                    (0..values.len()).filter(|&i| counts(i, values.len())).map(|i| values[i]).collect();
                let squares: f64 = kept.iter().map(|x| x * x).sum();
                weighted += weight * squares;
                if main.contains(&row) {
                    plain += squares;
                    n += kept.len();
                }
            }
            (weighted, (plain / n.max(1) as f64).sqrt())
        };
        let standing = self.regression.standing.len();
        let prefixes = standing..=self.settled.refined.effects.len();
        let all: Vec<(f64, f64)> = match prefixes.clone().map(|n| self.corrected(n, &main)).collect() {
            Some(all) => all,
            None => prefixes.map(errors).collect(),
        };
        let nominal = all[0].1.powi(2).max(f64::MIN_POSITIVE);
        let judged = 0..self.settled.refined.effects.len() - standing;
        let share = |k: usize| {
            let (before, after) = (all[k].1, all[k + 1].1);
            let share = (before * before - after * after) / nominal;
            if main.len() < judge.rows().len() && share < ELSEWHERE {
                // An effect that shows in another kind of row.
                return share.max((all[k].0 - all[k + 1].0) / all[0].0.max(f64::MIN_POSITIVE));
            }
            share
        };
        let effect = |k: usize| self.settled.refined.effects[standing + k].clone();
        let step = |k: usize| Step { effect: effect(k), before: all[k].1, after: all[k + 1].1 };
        let shares = shared(judged.clone().map(share).collect());
        shares.into_iter().zip(judged.map(step)).collect()
    }

    /// Held-out error of the first `count` effects with the inertial corrections that fit best beside them: all rows
    /// weighted, and root mean square of the main ones. `None` where nothing was corrected: then nothing but effects
    /// explains.
    fn corrected(&self, count: usize, main: &[usize]) -> Option<(f64, f64)> {
        let active = self.outcome.active.get(..count).filter(|_| !self.settled.corrections.is_empty())?;
        let errors = self.regression.scored_fit(active, true)?.errors;
        let weighted = errors.iter().zip(&self.regression.weights).map(|(e, w)| e * w).sum();
        let samples: usize = main.iter().map(|&row| self.regression.judge_sums.rows[row].count).sum();
        let plain: f64 = main.iter().map(|&row| errors[row]).sum();
        Some((weighted, (plain / samples.max(1) as f64).sqrt()))
    }

    fn found(&self, k: usize, share: f64) -> FoundEffect {
        let effect = self.settled.refined.effects[k].clone();
        let widths = &self.settled.refined.half_width[k];
        let ci95 = widths
            .iter()
            .map(|(name, half)| {
                let value = effect.value(name);
                (name.clone(), [value - half, value + half])
            })
            .collect();
        let doubts = doubts(&effect, widths);
        FoundEffect { effect, ci95, share, doubts }
    }

    /// Why other kinds at the places in question do not stand, one line per kind and place.
    fn rejected(&self, diagnosis: &Diagnosis) -> Vec<Rejected> {
        let places: Vec<&str> = diagnosis
            .effects
            .iter()
            .filter_map(|found| found.effect.location.joint.as_deref())
            .chain(diagnosis.suspects.iter().map(String::as_str))
            .collect();
        let (active, corrected) = (&self.outcome.active, self.outcome.corrected);
        let rough = self.regression.scored_fit(active, false);
        // Reasons of the search may speak of effects that have gone since.
        let reason = |c: usize| {
            let now = consider(self.regression, active, &self.outcome.scored, rough.as_ref()?, corrected, c);
            now.err().or_else(|| self.outcome.reasons.get(&c).cloned())
        };
        let mut list: Vec<Rejected> = Vec::new();
        for (c, candidate) in self.regression.candidates.iter().enumerate() {
            let form = &candidate.form;
            let asked = form.location.joint.as_deref().is_none_or(|joint| places.contains(&joint));
            let stands = diagnosis
                .effects
                .iter()
                .any(|f| f.effect.kind == form.kind && f.effect.location == form.location);
            let listed = list.iter().any(|r| r.kind == form.kind && r.place == form.location);
            if !asked || stands || listed || form.location.other_joint.is_some() {
                continue;
            }
            let why = reason(c).unwrap_or_else(|| "it was not needed".to_owned());
            list.push(Rejected { kind: form.kind, place: form.location.clone(), why });
        }
        list
    }
}

/// Shares of which none is below zero: effects that work against each other share equally what they remove together.
fn shared(shares: Vec<f64>) -> Vec<f64> {
    let mut groups: Vec<(f64, usize)> = Vec::new();
    for share in shares {
        match groups.last_mut() {
            Some((sum, count)) if *sum < -ELSEWHERE || share < -ELSEWHERE => {
                (*sum, *count) = (*sum + share, *count + 1);
            }
            _ => groups.push((share, 1)),
        }
    }
    groups.into_iter().flat_map(|(sum, count)| std::iter::repeat_n(sum / count as f64, count)).collect()
}

fn doubts(effect: &Effect, widths: &[(String, f64)]) -> Vec<String> {
    let mut doubts = Vec::new();
    for parameter in effect.kind.estimated() {
        let value = effect.value(parameter.name);
        let (low, high) = effect.plausible(parameter.name);
        if value < low || value > high {
            let (name, unit) = (parameter.name, effect.unit(parameter.name));
            doubts.push(format!(
                "{name} = {value:.4} {unit} is outside the usual range of {low} to {high} {unit}"
            ));
        }
        if let Some((_, half)) = widths.iter().find(|(name, _)| name == parameter.name)
            && !half.is_finite()
        {
            doubts.push(format!("this data does not determine {}", parameter.name));
        }
    }
    doubts
}

fn main_rows(experiment: &dyn Experiment) -> Vec<usize> {
    let rows = experiment.rows();
    let order = ["post_impact_velocity", "cop", "effort", "base_force", "base_moment", "transmission"];
    let main = order.into_iter().find(|name| rows.iter().any(|r| r.channel.name() == *name));
    (0..rows.len()).filter(|&r| Some(rows[r].channel.name()) == main).collect()
}

#[cfg(test)]
mod tests {
    use super::shared;

    #[test]
    fn what_works_against_each_other_shares_what_it_removes() {
        assert_eq!(shared(vec![0.5, -0.001, 0.2]), [0.5, -0.001, 0.2]);
        assert_eq!(shared(vec![1.5, -0.5, 0.0]), [0.5, 0.5, 0.0]);
        assert_eq!(shared(vec![-1.0, 1.5]), [0.25, 0.25]);
    }
}
