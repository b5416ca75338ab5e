//! The diagnosis of a log: search, final estimate, what is left, in numbers and words.
use super::form::{Form, within_reach};
use super::polish::{Amended, Polished, polish};
use super::search::{LEAST, Outcome, TRACE, consider, least, search};
use super::setting::{BLOCKS, MOST, Setting, Trial, parallel};
use super::smoother::{self, reach};
use super::words;
use crate::diagnose::anatomy::CadError;
use crate::diagnose::{Channel, Diagnosis, Experiment, Fall, Found, Rejected, Step, Unexplained};
use crate::effect::{Effect, Location, Role};
use std::collections::BTreeMap;

/// A smooth function must lower a row's held-out squared error by this to call something unexplained.
const UNEXPLAINED: f64 = 0.05;
/// A residual of which so much varies slowly is no noise, whatever it goes with.
const SLOW: f64 = 0.35;
/// So many times the noise of the measurement, what varies slowly is no noise of a narrow filter.
const LOUD: f64 = 2.0;
/// What varies over this time is slow, s.
const SLOW_TIME: f64 = 0.15;
/// Alternatives whose held-out error differs by less than this part of what the effect removes are named together.
const ALIKE: f64 = 0.01;

/// Most searches with a lower floor.
const WEIGHINGS: usize = 2;

/// They are as well if blocks of the judging data disagree about which is better, up to this part.
const SCATTER: f64 = 0.05;
/// The same for an effect with fewer parameters to stand in another one's place.
const AS_GOOD: f64 = 0.001;

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
        Self { cad: CadError::default(), widening: 1.0, most: 8, standing: Vec::new() }
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
    let mut setting = Setting::new(train, validation, &places, options, &|part| progress(0.5 * part));
    let left_out = setting.keep(&options.standing, setting.has_corrections());
    let entered = |count: usize| progress(0.5 + 0.3 * (count as f64 / (count as f64 + 2.0)));
    let Some(mut outcome) = search(&mut setting, options.most, &entered) else { return Diagnosis::default() };
    for _ in 0..WEIGHINGS {
        if !setting.reweigh(&outcome.trial) {
            break;
        }
        let Some(again) = search(&mut setting, options.most, &entered) else { break };
        outcome = again;
    }
    simplest(&setting, &mut outcome);
    progress(0.85);
    let mut retries = 4;
    let polished = loop {
        let effects = estimates(&setting, &outcome);
        let polished = polish(train, effects, &setting.spread, &setting.weights, outcome.corrected);
        let Some((idle, impossible)) = idle(&setting, &polished) else { break polished };
        if impossible && retries > 0 {
            // What the exact estimate makes impossible hid something else: look again without it.
            retries -= 1;
            setting.ban(outcome.active[idle]);
            let Some(again) = search(&mut setting, options.most, &entered) else { break polished };
            outcome = again;
            simplest(&setting, &mut outcome);
            continue;
        }
        let mut fewer = outcome.active.clone();
        fewer.remove(idle);
        let Some(trial) = setting.trial(&fewer, outcome.corrected) else { break polished };
        (outcome.active, outcome.trial) = (fewer, trial);
    };
    progress(0.95);
    let mut answer =
        Answer { setting: &setting, outcome: &outcome, polished: &polished }.write(train, validation);
    answer.warnings.extend(left_out.into_iter().map(|effect| {
        format!("{effect} was left out: this data cannot tell it from the other effects of the description")
    }));
    answer.summary = words::summary(&answer);
    progress(1.0);
    answer
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
    let setting = Setting::new(train, validation, &places_of(effects), options, &|_| ());
    let starts: Vec<Effect> = effects.iter().map(|effect| start(&setting, effect)).collect();
    let corrected = setting.has_corrections();
    let Some(trial) = setting.trial(&[], corrected) else { return Diagnosis::default() };
    let outcome = Outcome { active: Vec::new(), trial, corrected, reasons: BTreeMap::new() };
    let polished = polish(train, starts, &setting.spread, &setting.weights, corrected);
    let mut answer =
        Answer { setting: &setting, outcome: &outcome, polished: &polished }.write(train, validation);
    answer.summary = words::summary(&answer);
    answer
}

fn places_of(effects: &[Effect]) -> Vec<(&'static str, Location)> {
    let place = |effect: &Effect| Some((effect.definition()?.name, effect.location.clone()));
    effects.iter().filter_map(place).collect()
}

/// Root mean square errors by kind of channel, without and with effects.
pub fn errors(experiment: &dyn Experiment, effects: &[Effect]) -> BTreeMap<String, Fall> {
    grouped(experiment, &Amended::new(experiment, effects), &|_, _| true).1
}

/// Where the final estimate of an effect starts.
fn start(setting: &Setting<'_>, effect: &Effect) -> Effect {
    let stated = |name: &str| effect.parameters.get(name).copied();
    let forms = setting.candidates.iter().enumerate();
    let mine = forms.filter(|(_, c)| c.form.kind == effect.kind && c.form.location == effect.location);
    let best = mine
        .filter_map(|(index, _)| {
            let trial = setting.trial(&[index], setting.has_corrections())?;
            setting.impossible(&[index], &trial).is_none().then_some((index, trial))
        })
        .min_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    let mut start = match best {
        Some((index, trial)) => {
            setting.candidates[index].form.effect(setting.coefficients(&[index], &trial, 0))
        }
        None => effect.clone(),
    };
    (start.name, start.torque, start.own) = (effect.name.clone(), effect.torque.clone(), effect.own.clone());
    for (name, value) in &effect.parameters {
        start.parameters.entry(name.clone()).or_insert(*value);
    }
    // A kind that no column finds starts from what is stated, or from the middle of what is usual.
    if let Some(kind) = effect.definition() {
        for parameter in kind.estimated() {
            let middle = 0.1 * (parameter.plausible.0 + parameter.plausible.1);
            let value = stated(parameter.name).unwrap_or(middle);
            start.parameters.entry(parameter.name.to_owned()).or_insert(value);
        }
    }
    start
}

/// Of explanations that are as good, the one with fewer effects, and on the likelier link.
fn simplest(setting: &Setting<'_>, outcome: &mut Outcome) {
    with_fewer_parameters(setting, outcome);
    merge(setting, outcome);
    likeliest_links(setting, outcome);
}

/// Of effects in whose place another one with fewer parameters does as well, that one.
fn with_fewer_parameters(setting: &Setting<'_>, outcome: &mut Outcome) {
    let deviance = |t: &Trial, set: &[usize]| t.cost - setting.price(set);
    let count = |c: usize| setting.candidates[c].parameters;
    for k in setting.standing.len()..outcome.active.len() {
        let mut fewer = outcome.active.clone();
        fewer.remove(k);
        let (Some(bare), Some(rough)) =
            (setting.trial(&fewer, outcome.corrected), setting.trial(&fewer, false))
        else {
            continue;
        };
        let here = deviance(&outcome.trial, &outcome.active);
        let limit = here + (AS_GOOD * (deviance(&bare, &fewer) - here)).max(4.0);
        let mine = outcome.active[k];
        let tried = parallel(setting.candidates.len(), |c| {
            if count(c) >= count(mine)
                || consider(setting, &fewer, &bare, &rough, outcome.corrected, c).is_err()
            {
                return None;
            }
            let mut set = outcome.active.clone();
            set[k] = c;
            let trial = setting.trial(&set, outcome.corrected)?;
            (deviance(&trial, &set) <= limit).then_some((c, set, trial))
        });
        let least = |a: &(usize, Vec<usize>, Trial), b: &(usize, Vec<usize>, Trial)| {
            count(a.0).cmp(&count(b.0)).then(a.2.cost.total_cmp(&b.2.cost))
        };
        if let Some((_, set, trial)) = tried.into_iter().flatten().min_by(least) {
            (outcome.active, outcome.trial) = (set, trial);
        }
    }
}

/// Friction that differs by direction is, but for the moment of reversal, friction and a bias: one effect for two.
fn merge(setting: &Setting<'_>, outcome: &mut Outcome) {
    let form = |c: usize| &setting.candidates[c].form;
    let first = setting.standing.len();
    let judged: Vec<usize> = outcome.active[first..].to_vec();
    for &friction in judged.iter().filter(|&&c| form(c).kind == "coulomb_friction") {
        let place = &form(friction).location;
        let at = |kind: &str, c: usize| form(c).kind == kind && form(c).location == *place;
        let Some(&bias) = judged.iter().find(|&&c| at("torque_bias", c)) else { continue };
        let all = 0..setting.candidates.len();
        let Some(both) = all.into_iter().find(|&c| at("asymmetric_coulomb_friction", c)) else { continue };
        let bare: Vec<usize> =
            outcome.active.iter().copied().filter(|&c| c != friction && c != bias).collect();
        let set: Vec<usize> = bare.iter().copied().chain([both]).collect();
        let (Some(without), Some(trial)) =
            (setting.trial(&bare, outcome.corrected), setting.trial(&set, outcome.corrected))
        else {
            continue;
        };
        let deviance = |t: &Trial, set: &[usize]| t.cost - setting.price(set);
        let (here, merged) = (deviance(&outcome.trial, &outcome.active), deviance(&trial, &set));
        let removed = deviance(&without, &bare) - here;
        if merged <= here + (ALIKE * removed).max(4.0) && setting.impossible(&set, &trial).is_none() {
            (outcome.active, outcome.trial) = (set, trial);
        }
    }
}

/// Of links on which an effect explains as much, the heaviest is the likeliest to carry it; the others are named as
/// alternatives.
fn likeliest_links(setting: &Setting<'_>, outcome: &mut Outcome) {
    for k in setting.standing.len()..outcome.active.len() {
        let form = &setting.candidates[outcome.active[k]].form;
        let Some(mut mass) = setting.carrier(outcome.active[k]) else { continue };
        let mut fewer = outcome.active.clone();
        fewer.remove(k);
        let Some(bare) = setting.trial(&fewer, outcome.corrected) else { continue };
        let removed =
            bare.cost - setting.price(&fewer) - (outcome.trial.cost - setting.price(&outcome.active));
        let limit = outcome.trial.cost + (ALIKE * removed).max(4.0);
        let kind = form.kind;
        for c in 0..setting.candidates.len() {
            let Some(other) = setting.carrier(c).filter(|m| *m > mass) else { continue };
            let mut set = outcome.active.clone();
            set[k] = c;
            let unwanted = setting.banned.contains(&c) || outcome.active.contains(&c);
            if setting.candidates[c].form.kind != kind || unwanted {
                continue;
            }
            let Some(trial) = setting.trial(&set, outcome.corrected) else { continue };
            if trial.cost <= limit && setting.impossible(&set, &trial).is_none() {
                (outcome.active, outcome.trial, mass) = (set, trial, other);
            }
        }
    }
}

/// The effect that removes least from the judging data once everything is estimated exactly, if that is next to
/// nothing.
fn idle(setting: &Setting<'_>, polished: &Polished) -> Option<(usize, bool)> {
    let change = setting.spread.change(&polished.corrections);
    let errors = |effects: &[Effect], corrected: bool| -> Vec<f64> {
        let mut amended = Amended::new(setting.judge, effects);
        if corrected && !change.is_empty() {
            amended.correct(&change);
        }
        let size = |row: usize, x: f64| match setting.judge.rows()[row].channel {
            // While play is crossed the angle is anywhere: squares would be theirs.
            Channel::Transmission => x.abs(),
            _ => x * x,
        };
        let rows = 0..setting.judge.rows().len();
        rows.map(|row| amended.residual(row).iter().map(|x| size(row, *x)).sum()).collect()
    };
    let judged = setting.standing.len()..polished.effects.len();
    let falls = judged.clone().map(|k| {
        let mut fewer = polished.effects.clone();
        fewer.remove(k);
        let fall = |corrected: bool| {
            let (with, without) = (errors(&polished.effects, corrected), errors(&fewer, corrected));
            let relative = without.iter().zip(&with).enumerate().map(|(row, (a, b))| {
                (a - b) / a.max(f64::MIN_POSITIVE) * LEAST / least(setting.judge.rows()[row].channel)
            });
            relative.fold(f64::NEG_INFINITY, f64::max)
        };
        // Also without corrections an effect must explain something.
        (k, fall(false))
    });
    let reachable = |k: usize| {
        let effect = &polished.effects[k];
        let kind = effect.definition();
        effect.parameters.iter().all(|(name, value)| {
            kind.and_then(|kind| kind.parameter(name))
                .is_none_or(|p| matches!(p.role, Role::Setting(_)) || within_reach(p.plausible, *value))
        })
    };
    let several = polished.effects.len() > 1;
    let doubtful = judged.clone().find(|&k| {
        !reachable(k)
            || !saturates(setting, polished, k)
            || (several && is_cancelled(setting, &polished.effects[k]))
    });
    let least = || falls.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, fall)| *fall < 0.5 * LEAST);
    doubtful.map(|k| (k, true)).or_else(|| least().map(|(k, _)| (k, false)))
}

/// Whether an effect makes far more than there is to explain, so that another one takes it back.
fn is_cancelled(setting: &Setting<'_>, effect: &Effect) -> bool {
    let squares = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
    let (mut made, mut wanted) = (0.0, 0.0);
    for (row, response) in setting.train.response(std::slice::from_ref(effect)) {
        made += setting.weights[row] * squares(&response);
        wanted += setting.weights[row] * squares(setting.train.residual(row));
    }
    made > MOST * wanted
}

/// Where a drive saturates, the true torque is the limit: what is left there must be no more than elsewhere. Otherwise
/// the limit only hides that the model is wrong where torques are large. True for all other kinds.
fn saturates(setting: &Setting<'_>, polished: &Polished, k: usize) -> bool {
    let effect = &polished.effects[k];
    if effect.kind != "torque_saturation" {
        return true;
    }
    let experiment = setting.train;
    let amended = Amended::new(experiment, &polished.effects);
    experiment.response(std::slice::from_ref(effect)).iter().all(|(row, response)| {
        let left = amended.residual(*row);
        let mean = |inside: bool| {
            let picked = left.iter().zip(response).filter(|(_, clipped)| (**clipped != 0.0) == inside);
            let (sum, n) = picked.fold((0.0, 0.0_f64), |(sum, n), (x, _)| (sum + x * x, n + 1.0));
            (sum / n.max(1.0), n)
        };
        let ((inside, count), (outside, _)) = (mean(true), mean(false));
        count > 5.0 && inside < 4.0 * outside
    })
}

/// The effects of a search, with the values of its fit.
fn estimates(setting: &Setting<'_>, outcome: &Outcome) -> Vec<Effect> {
    (0..outcome.active.len())
        .map(|k| {
            let coefficients = setting.coefficients(&outcome.active, &outcome.trial, k);
            setting.candidates[outcome.active[k]].form.effect(coefficients)
        })
        .collect()
}

struct Answer<'s> {
    setting: &'s Setting<'s>,
    outcome: &'s Outcome,
    polished: &'s Polished,
}

impl Answer<'_> {
    fn write(&self, train: &dyn Experiment, validation: Option<&dyn Experiment>) -> Diagnosis {
        let judge = validation.unwrap_or(train);
        let counts = |i: usize, n: usize| validation.is_some() || (i * BLOCKS / n.max(1)) % 3 == 1;
        let effects = &self.polished.effects;
        let change = self.setting.spread.change(&self.polished.corrections);
        let standing = self.setting.standing.len();
        let steps = self.sequence(judge, &counts);
        let order: Vec<usize> = {
            let mut order: Vec<usize> = (standing..effects.len()).collect();
            order.sort_by(|a, b| steps[b - standing].0.total_cmp(&steps[a - standing].0));
            order
        };
        let mut final_train = Amended::new(train, effects);
        let mut final_judge = Amended::new(judge, effects);
        if !change.is_empty() {
            final_train.correct(&change);
            final_judge.correct(&change);
        }
        let mut diagnosis = Diagnosis::default();
        (diagnosis.rows, diagnosis.rms) = grouped(judge, &final_judge, &counts);
        diagnosis.rms_training = grouped(train, &final_train, &|_, _| true).1;
        let main = main_channel(&diagnosis);
        if let Some(fall) = diagnosis.rms.get(main) {
            (diagnosis.rms_before, diagnosis.rms_after) = (fall.before, fall.after);
        }
        for &k in &order {
            diagnosis.effects.push(self.found(k, steps[k - standing].0));
        }
        diagnosis.standing = (0..standing).map(|k| self.found(k, 0.0)).collect();
        diagnosis.steps = steps.into_iter().map(|(_, step)| step).collect();
        diagnosis.inertial_corrections = self.corrections(train, &change);
        diagnosis.indistinguishable = self.alternatives(&diagnosis.effects, &order);
        diagnosis.unexplained_parts = unexplained(&final_train, &final_judge, &counts, effects);
        diagnosis.unexplained = !diagnosis.unexplained_parts.is_empty();
        diagnosis.suspects = diagnosis.unexplained_parts.iter().map(|part| part.joint.clone()).collect();
        diagnosis.rejected = self.rejected(&diagnosis);
        diagnosis
    }

    /// Shares of the held-out squared error, and errors, as the effects entered one after the other.
    fn sequence(&self, judge: &dyn Experiment, counts: &dyn Fn(usize, usize) -> bool) -> Vec<(f64, Step)> {
        let weights = &self.setting.weights;
        let main = main_rows(judge);
        let errors = |count: usize| -> (f64, f64) {
            let amended = Amended::new(judge, &self.polished.effects[..count]);
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
        let standing = self.setting.standing.len();
        let prefixes = standing..=self.polished.effects.len();
        let all: Vec<(f64, f64)> = match prefixes.clone().map(|n| self.corrected(n, &main)).collect() {
            Some(all) => all,
            None => prefixes.map(errors).collect(),
        };
        let nominal = all[0].1.powi(2).max(f64::MIN_POSITIVE);
        (0..self.polished.effects.len() - standing)
            .map(|k| {
                let (before, after) = (all[k].1, all[k + 1].1);
                let mut share = (before * before - after * after) / nominal;
                if main.len() < judge.rows().len() && share.abs() < 1e-9 {
                    // An effect that shows in another kind of row only.
                    share = (all[k].0 - all[k + 1].0) / all[0].0.max(f64::MIN_POSITIVE);
                }
                (share, Step { effect: self.polished.effects[standing + k].clone(), before, after })
            })
            .collect()
    }

    /// Held-out error of the first `count` effects with the inertial corrections that fit best beside them: all rows
    /// weighted, and root mean square of the main ones. `None` where nothing was corrected: then nothing but effects
    /// explains.
    fn corrected(&self, count: usize, main: &[usize]) -> Option<(f64, f64)> {
        let active = self.outcome.active.get(..count).filter(|_| self.outcome.corrected)?;
        let errors = self.setting.trial(active, true)?.errors;
        let weighted = errors.iter().zip(&self.setting.weights).map(|(e, w)| e * w).sum();
        let samples: usize = main.iter().map(|&row| self.setting.judge_sums.rows[row].count).sum();
        let plain: f64 = main.iter().map(|&row| errors[row]).sum();
        Some((weighted, (plain / samples.max(1) as f64).sqrt()))
    }

    fn found(&self, k: usize, share: f64) -> Found {
        let effect = self.polished.effects[k].clone();
        let widths = &self.polished.half_width[k];
        let ci95 = widths
            .iter()
            .map(|(name, half)| {
                let value = effect.value(name);
                (name.clone(), [value - half, value + half])
            })
            .collect();
        let doubts = doubts(&effect, widths);
        Found { effect, ci95, share, doubts }
    }

    /// Corrections that matter, by link.
    fn corrections(&self, train: &dyn Experiment, change: &[f64]) -> Vec<Found> {
        if change.is_empty() {
            return Vec::new();
        }
        let mut list: Vec<(f64, Found)> = Vec::new();
        for (body, name) in train.bodies().iter().enumerate() {
            let coordinates = &self.polished.corrections[10 * body..10 * body + 10];
            let sigma = &self.polished.corrections_sigma[10 * body..10 * body + 10];
            let evidence: f64 =
                coordinates.iter().zip(sigma).map(|(x, s)| x * x * (1.0 - s * s).max(0.0)).sum();
            if evidence < 0.5 {
                continue;
            }
            let nominal = &train.inertial_parameters()[10 * body..10 * body + 10];
            list.push((evidence, words::correction(name, nominal, &change[10 * body..10 * body + 10])));
        }
        list.sort_by(|a, b| b.0.total_cmp(&a.0));
        list.into_iter().map(|(_, found)| found).collect()
    }

    /// Candidates that would do as well in the place of an effect that stands, alone or with another kind in the place
    /// of a second one.
    fn alternatives(&self, found: &[Found], order: &[usize]) -> Vec<Vec<Vec<Found>>> {
        let active = &self.outcome.active;
        if active.len() != self.polished.effects.len() {
            return Vec::new();
        }
        let mut groups = Vec::new();
        for (found, &k) in found.iter().zip(order) {
            let (alike, near) = self.alike(active, k);
            let mut group = vec![vec![found.clone()]];
            group.extend(alike.iter().take(4).map(|&c| vec![self.alternative(active, k, c, found.share)]));
            let other_kind = near.iter().find(|&&c| self.form(c).kind != found.effect.kind);
            if let Some(&c) = other_kind {
                group.extend(self.together(k, c, found.share));
            }
            if group.len() > 1 {
                groups.push(group);
            }
        }
        groups
    }

    fn form(&self, c: usize) -> &Form {
        &self.setting.candidates[c].form
    }

    /// Alternatives that differ in two effects: `c` in the place of the `k`-th, and another kind, or another place, in
    /// that of a second one; the best of each kind.
    fn together(&self, k: usize, c: usize, share: f64) -> Vec<Vec<Found>> {
        let (setting, outcome) = (self.setting, self.outcome);
        let mut out = Vec::new();
        for j in (setting.standing.len()..outcome.active.len()).filter(|j| *j != k) {
            let mut bare = outcome.active.clone();
            bare.remove(k.max(j));
            bare.remove(k.min(j));
            let Some(limit) = self.limit(&bare) else { continue };
            let tried = parallel(setting.candidates.len(), |d| {
                let mut set = outcome.active.clone();
                (set[k], set[j]) = (c, d);
                let elsewhere = !setting.meet(d, outcome.active[j]);
                if elsewhere || outcome.active.contains(&d) || d == c || setting.stands(d) {
                    return None;
                }
                let trial = setting.trial(&set, outcome.corrected)?;
                let more = self.excess(&trial, &set);
                let alike =
                    self.as_well(&trial, &set, more, limit) && setting.impossible(&set, &trial).is_none();
                alike.then_some((more, d))
            });
            let mut alike: Vec<(f64, usize)> = tried.into_iter().flatten().collect();
            alike.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut kinds: Vec<&str> = Vec::new();
            for (_, d) in alike {
                if !kinds.contains(&self.form(d).kind) && kinds.len() < 3 {
                    kinds.push(self.form(d).kind);
                    let mut set = outcome.active.clone();
                    (set[k], set[j]) = (c, d);
                    let first = self.alternative(&set, k, c, share);
                    out.push(vec![first, self.alternative(&set, j, d, share)]);
                }
            }
        }
        out
    }

    /// Deviance of a set beyond that of the effects that stand.
    fn excess(&self, trial: &Trial, set: &[usize]) -> f64 {
        let (setting, outcome) = (self.setting, self.outcome);
        let here = outcome.trial.cost - setting.price(&outcome.active);
        trial.cost - setting.price(set) - here
    }

    /// Deviance that the effects missing in `bare` remove.
    fn limit(&self, bare: &[usize]) -> Option<f64> {
        let without = self.setting.trial(bare, self.outcome.corrected)?;
        Some(self.excess(&without, bare))
    }

    /// Whether so much more deviance than that of the effects that stand is nothing, beside what they remove or beside
    /// what blocks of the judging data disagree by.
    fn as_well(&self, trial: &Trial, set: &[usize], more: f64, removed: f64) -> bool {
        let chance = || self.setting.scatter(&self.outcome.trial, &self.outcome.active, trial, set);
        more <= (ALIKE * removed).max(4.0) || (more <= SCATTER * removed && more <= chance())
    }

    /// A candidate in the place of an effect, with the values that fit there.
    fn alternative(&self, set: &[usize], k: usize, c: usize, share: f64) -> Found {
        let mut set = set.to_vec();
        set[k] = c;
        let effect = match self.setting.trial(&set, self.outcome.corrected) {
            Some(trial) => self.form(c).effect(self.setting.coefficients(&set, &trial, k)),
            None => Effect::new(self.form(c).kind, self.form(c).location.clone(), &[]),
        };
        Found { effect, ci95: BTreeMap::new(), share, doubts: Vec::new() }
    }

    /// Candidates that would do as well in the place of the `k`-th effect, and those that would nearly; best first, one
    /// per kind and place.
    fn alike(&self, active: &[usize], k: usize) -> (Vec<usize>, Vec<usize>) {
        let (setting, corrected) = (self.setting, self.outcome.corrected);
        let mut fewer = active.to_vec();
        fewer.remove(k);
        let Some(removed) = self.limit(&fewer) else { return Default::default() };
        let mine = self.form(active[k]);
        let tried = parallel(setting.candidates.len(), |c| {
            let other = self.form(c);
            let same = (other.kind, &other.location) == (mine.kind, &mine.location);
            let elsewhere = !setting.meet(c, active[k]);
            if same
                || elsewhere
                || active.contains(&c)
                || setting.stands(c)
                || generalises(other.kind, mine.kind)
            {
                return None;
            }
            let mut set = active.to_vec();
            set[k] = c;
            let trial = setting.trial(&set, corrected)?;
            let more = self.excess(&trial, &set);
            let near = more <= (SCATTER * removed).max(4.0) && setting.impossible(&set, &trial).is_none();
            near.then(|| (more, c, self.as_well(&trial, &set, more, removed)))
        });
        let mut near: Vec<(f64, usize, bool)> = tried.into_iter().flatten().collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut kept: Vec<(usize, bool)> = Vec::new();
        for (_, c, alike) in near {
            let place = |c: usize| (self.form(c).kind, &self.form(c).location);
            if !kept.iter().any(|&(o, _)| place(o) == place(c)) {
                kept.push((c, alike));
            }
        }
        let alike = kept.iter().filter(|(_, alike)| *alike).map(|(c, _)| *c).collect();
        (alike, kept.into_iter().map(|(c, _)| c).collect())
    }

    /// Why other kinds at the places in question do not stand, one line per kind and place.
    fn rejected(&self, diagnosis: &Diagnosis) -> Vec<Rejected> {
        let places: Vec<&str> = diagnosis
            .effects
            .iter()
            .filter_map(|found| found.effect.location.joint.as_deref())
            .chain(diagnosis.suspects.iter().map(String::as_str))
            .collect();
        let mut list: Vec<Rejected> = Vec::new();
        for (c, candidate) in self.setting.candidates.iter().enumerate() {
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
            let why = self.outcome.reasons.get(&c).cloned().unwrap_or_else(|| "it was not needed".to_owned());
            list.push(Rejected { kind: form.kind.to_owned(), place: form.location.clone(), why });
        }
        list
    }
}

type Falls = BTreeMap<String, Fall>;

/// Root mean squares before and after, by row and by kind of channel.
fn grouped(
    before: &dyn Experiment,
    after: &Amended<'_>,
    counts: &dyn Fn(usize, usize) -> bool,
) -> (Falls, Falls) {
    let squares = |values: &[f64]| {
        let kept = values.iter().enumerate().filter(|(i, _)| counts(*i, values.len()));
        kept.fold((0.0, 0.0_f64), |(sum, n), (_, x)| (sum + x * x, n + 1.0))
    };
    let (mut rows, mut groups) = (Falls::new(), BTreeMap::<Channel, [f64; 4]>::new());
    for (row, what) in before.rows().iter().enumerate() {
        let ((was, n), (is, _)): ((f64, f64), _) =
            (squares(before.residual(row)), squares(after.residual(row)));
        let root = |x: f64| (x / n.max(1.0)).sqrt();
        let fall = Fall { unit: what.unit.to_owned(), before: root(was), after: root(is), noise: what.noise };
        rows.insert(what.name.clone(), fall);
        let sums = [was, is, n, what.noise.powi(2) * n];
        groups.entry(what.channel).or_default().iter_mut().zip(sums).for_each(|(g, s)| *g += s);
    }
    let fall = |(channel, [was, is, n, noise]): (Channel, [f64; 4])| {
        let root = |x: f64| (x / n.max(1.0)).sqrt();
        let unit = channel.unit().to_owned();
        (channel.name().to_owned(), Fall { unit, before: root(was), after: root(is), noise: root(noise) })
    };
    (rows, groups.into_iter().map(fall).collect())
}

/// A kind that contains the other as a special case explains whatever that explains.
fn generalises(kind: &str, special: &str) -> bool {
    matches!(
        (kind, special),
        ("asymmetric_coulomb_friction" | "stribeck_friction", "coulomb_friction")
            | ("payload", "com_offset")
            | ("parallel_spring" | "asymmetric_coulomb_friction", "torque_bias")
    )
}

fn doubts(effect: &Effect, widths: &[(String, f64)]) -> Vec<String> {
    let Some(kind) = effect.definition() else { return Vec::new() };
    let mut doubts = Vec::new();
    for parameter in kind.parameters.iter().filter(|p| p.role == Role::Estimated) {
        let value = effect.value(parameter.name);
        let (low, high) = parameter.plausible;
        if value < low || value > high {
            doubts.push(format!(
                "{} = {value:.4} {} is outside the usual range of {low} to {high} {}",
                parameter.name, parameter.unit, parameter.unit
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

/// The kind of channel that the table is about.
fn main_channel(diagnosis: &Diagnosis) -> &'static str {
    ["post_impact_velocity", "cop", "effort", "base_force", "base_moment", "transmission"]
        .into_iter()
        .find(|name| diagnosis.rms.contains_key(*name))
        .unwrap_or("effort")
}

fn main_rows(experiment: &dyn Experiment) -> Vec<usize> {
    let rows = experiment.rows();
    let order = ["post_impact_velocity", "cop", "effort", "base_force", "base_moment", "transmission"];
    let main = order.into_iter().find(|name| rows.iter().any(|r| r.channel.name() == *name));
    (0..rows.len()).filter(|&r| Some(rows[r].channel.name()) == main).collect()
}

/// Part of a residual's squares that survives averaging over [`SLOW_TIME`]; 0 for tables.
fn slow_share(time: &[f64], residual: &[f64]) -> f64 {
    let n = residual.len();
    let step = if n > 1 { (time[n - 1] - time[0]) / (n - 1) as f64 } else { 0.0 };
    // Tables count postures and impacts: their numbers are no times.
    let half = (0.5 * SLOW_TIME / step.max(1e-9)) as usize;
    if half < 4 || n < 20 * half || step >= 0.5 {
        return 0.0;
    }
    let mut sums = vec![0.0; n + 1];
    for i in 0..n {
        sums[i + 1] = sums[i] + residual[i];
    }
    let averaged: f64 = (half..n - half)
        .map(|i| ((sums[i + half + 1] - sums[i - half]) / (2 * half + 1) as f64).powi(2))
        .sum();
    let all: f64 = residual[half..n - half].iter().map(|x| x * x).sum();
    averaged / all.max(f64::MIN_POSITIVE)
}

/// Rows in which a smooth function of the signals would still lower the held-out error.
fn unexplained(
    train: &Amended<'_>,
    judge: &Amended<'_>,
    counts: &(dyn Fn(usize, usize) -> bool + Sync),
    effects: &[Effect],
) -> Vec<Unexplained> {
    let own_blocks = std::ptr::eq(train.time().as_ptr(), judge.time().as_ptr());
    let parts = parallel(train.rows().len(), |row| {
        let what = &train.rows()[row];
        let (a, b) = (smoother::signals(train, row), smoother::signals(judge, row));
        if a.is_empty() {
            return None;
        }
        let (r, s) = (train.residual(row), judge.residual(row));
        // Where the joint reverses, friction is smeared by the filter: no reason to doubt the effects.
        let smeared = effects.iter().any(|e| e.kind.contains("friction") || e.kind == "coupling");
        let speed = |signals: &smoother::Signals| {
            let v = &signals[1].1;
            0.15 * (v.iter().map(|x| x * x).sum::<f64>() / v.len().max(1) as f64).sqrt()
        };
        let (slow_a, slow_b) = if smeared { (speed(&a), speed(&b)) } else { (0.0, 0.0) };
        let trains = |i: usize| a[1].1[i].abs() >= slow_a && (!own_blocks || !counts(i, r.len()));
        let judges = |i: usize| b[1].1[i].abs() >= slow_b && counts(i, s.len());
        let reach = reach((&a, r, &trains), (&b, s, &judges))?;
        let smooth = 1.0 - reach.after / reach.before.max(f64::MIN_POSITIVE);
        let slow = slow_share(judge.time(), s);
        let share = if smooth > UNEXPLAINED { smooth } else { slow };
        // What is left of an effect that was hundreds of times larger is the inaccuracy of its form.
        let squares = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
        let matters = squares(s) > TRACE * squares(judge.nominal(row));
        let size = squares(s) / (what.noise.powi(2) * s.len() as f64).max(f64::MIN_POSITIVE);
        (matters && ((smooth > UNEXPLAINED && size > 1.0) || (slow > SLOW && size > LOUD.powi(2)))).then(
            || {
                let signals = smoother::correlated(&b, s).into_iter().filter(|(_, c)| c.abs() > 0.15).take(4);
                let signals = signals.map(|(name, c)| format!("{name} ({c:+.2})")).collect();
                Unexplained { joint: what.joint.clone().unwrap_or_else(|| what.name.clone()), share, signals }
            },
        )
    });
    let mut parts: Vec<Unexplained> = parts.into_iter().flatten().collect();
    parts.sort_by(|a, b| b.share.total_cmp(&a.share));
    parts
}
