//! The answer of a diagnosis: what was found, what each effect explains, what is left, why others do not stand.
use super::errors::errors;
use super::significance::{NO_CHANCE, limits_all, uncertain, without_sticking};
use super::unexplained::{unexplained, untaught};
use crate::diagnose::engine::equations::regression::{Regression, is_held_out};
use crate::diagnose::engine::refine::amended::Amended;
use crate::diagnose::engine::search::corrections::Settled;
use crate::diagnose::engine::search::entry::{PASSING, consider};
use crate::diagnose::engine::search::forward::Outcome;
use crate::diagnose::engine::search::late::late;
use crate::diagnose::{Diagnosis, FoundEffect, Rejected, Scope, Step};
use crate::experiments::Experiment;
use crate::experiments::form::Reach;
use crate::number::counting;
use bipedc_effects::effect::{Effect, kinds};
use std::collections::BTreeMap;

/// Effects with a smaller share of the main rows' error are there for other rows.
const ELSEWHERE: f64 = 0.01;

/// Part of a row's error by which inertial corrections alone have to lower it where the description leaves noise.
const SHOWS: f64 = 0.01;

/// More of the weighted squared error than that is no chance.
const CHANCE: f64 = 4.0;

/// Why a candidate does not stand that the search would let in: it went when everything was estimated exactly.
const NO_MORE: &str = "with the other effects estimated exactly it may as well be nothing, or the held-out error does not fall with it";

/// A search that is over, with its final estimate.
pub(crate) struct Conclusion<'s> {
    pub regression: &'s Regression<'s>,
    pub outcome: &'s Outcome,
    pub settled: &'s Settled,
}

impl Conclusion<'_> {
    /// An effect that the final estimate, with what was corrected, tells nothing of: all that it might be includes that it is nothing,
    /// or the held-out error does not fall with it, neither beside what entered before it nor, where corrections make up for what these leave, beside all.
    pub(crate) fn idle(&self, diagnosis: &Diagnosis) -> Option<usize> {
        let judged = self.regression.standing.len()..self.outcome.active.len();
        let share = |k: usize| {
            let effect = &self.settled.refined.effects[k];
            let same = |found: &&FoundEffect| {
                found.effect.kind == effect.kind && found.effect.location == effect.location
            };
            diagnosis.effects.iter().find(same).map_or(f64::INFINITY, |found| found.share)
        };
        let several = judged.len() > 1;
        // Beside corrections, where these are: alone it may remove what they would.
        let falls = |k: usize| {
            let main = main_rows(self.regression.judge);
            let elsewhere = main.len() < self.regression.judge.rows().len();
            match (self.corrected(k, &main), self.corrected(k + 1, &main)) {
                (Some(before), Some(after)) => before.1 > after.1 || elsewhere && before.0 > after.0,
                _ => share(k) > 0.0,
            }
        };
        let chance = if self.settled.corrections.is_empty() { NO_CHANCE } else { CHANCE };
        let says_nothing = |k: usize| several && !falls(k) && self.removed(k) <= chance;
        let refined = &self.settled.refined;
        judged.rev().find(|&k| uncertain(refined, k) || limits_all(refined, k) || says_nothing(k))
    }

    /// What an effect removes of the weighted squared error beside all others, which are fitted anew without it. Its share is that beside those which entered before it:
    /// what they leave of a large error may hide it, as a payload that entered later does. Where nothing was corrected, of rows that are above their noise without it.
    fn removed(&self, k: usize) -> f64 {
        let (regression, corrected) = (self.regression, !self.settled.corrections.is_empty());
        let mut fewer = self.outcome.active.clone();
        fewer.remove(k);
        let [without, with] =
            [&fewer, &self.outcome.active].map(|active| regression.scored_fit(active, corrected));
        let (Some(without), Some(with)) = (without, with) else { return 0.0 };
        let counts = |row: &usize| corrected || regression.is_loud(*row, &without);
        let falls = |row: usize| (without.errors[row] - with.errors[row]) * regression.weights[row];
        (0..regression.weights.len()).filter(counts).map(falls).sum()
    }

    pub(crate) fn write(&self, train: &dyn Experiment, validation: Option<&dyn Experiment>) -> Diagnosis {
        let judge = validation.unwrap_or(train);
        let counts = |sample: usize, n: usize| validation.is_some() || is_held_out(sample, n);
        let effects = &self.settled.refined.effects;
        let shows = self.corrections_show(train, validation);
        let all = if shows { self.settled.all() } else { Vec::new() };
        let standing = self.regression.standing.len();
        let steps = self.sequence(judge, &counts);
        let order: Vec<usize> = {
            let mut order: Vec<usize> = (standing..effects.len()).collect();
            order.sort_by(|a, b| steps[b - standing].0.total_cmp(&steps[a - standing].0));
            order
        };
        let mut diagnosis = Diagnosis { scope: Scope::of(train, judge), ..Diagnosis::default() };
        diagnosis.take(errors(train, validation, [&[], &all]));
        for &k in &order {
            diagnosis.effects.push(self.found(k, steps[k - standing].0.max(0.0)));
        }
        diagnosis.standing = (0..standing).map(|k| self.found(k, 0.0)).collect();
        diagnosis.steps = steps.into_iter().map(|(_, step)| step).collect();
        if shows {
            diagnosis.inertial_corrections.clone_from(&self.settled.corrections);
        }
        if self.settled.impossible {
            diagnosis.warnings.push(
                "inertial corrections were left out: no physically possible ones near the estimate were found"
                    .to_owned(),
            );
        }
        diagnosis.indistinguishable = self.alternatives(&diagnosis.effects, &order);
        diagnosis.bolted = bolted(train, &diagnosis.indistinguishable);
        let (final_train, final_judge) = (Amended::new(train, &all), Amended::new(judge, &all));
        if validation.is_some() {
            diagnosis.warnings.extend(untaught(&final_train, &final_judge, &self.regression.resolutions));
        }
        diagnosis.unexplained_parts =
            unexplained(&final_train, &final_judge, &counts, (effects, &self.regression.resolutions));
        diagnosis.unexplained = !diagnosis.unexplained_parts.is_empty();
        diagnosis.suspects = diagnosis.unexplained_parts.iter().map(|part| part.joint.clone()).collect();
        diagnosis.late = late(&final_judge);
        let all = diagnosis.effects.iter().chain(&diagnosis.inertial_corrections);
        diagnosis.acts_on = all.map(|found| acts_on(train, &found.effect)).collect();
        diagnosis.rejected = self.rejected(&diagnosis);
        diagnosis
    }

    /// Whether inertial corrections are worth telling: beside effects, where the description leaves more than noise, or where some row's held-out error falls by
    /// them. Else what they fit is the encoders' noise in accelerations, of which long logs have enough to tell them from nothing.
    fn corrections_show(&self, train: &dyn Experiment, validation: Option<&dyn Experiment>) -> bool {
        let asked = self.regression.free || !self.settled.refined.effects.is_empty();
        if asked || self.settled.corrections.is_empty() {
            return true;
        }
        let all = self.settled.all();
        let falls = errors(train, validation, [&[], &all]).rows;
        let described = errors(train, validation, [&[], &[]]).rows;
        described.values().any(|fall| fall.above_noise().is_some())
            || falls.values().any(|fall| fall.after < (1.0 - SHOWS) * fall.before)
    }

    /// Shares of the held-out squared error where joints do not stick, and errors of all samples, as the effects entered one after the other: what friction does at
    /// rest, by the noise of a speed, says nothing for or against it.
    fn sequence(&self, judge: &dyn Experiment, counts: &dyn Fn(usize, usize) -> bool) -> Vec<(f64, Step)> {
        let weights = &self.regression.weights;
        let main = main_rows(judge);
        let rms = |(sum, n): (f64, usize)| (sum / n.max(1) as f64).sqrt();
        let add = |(sum, n): (f64, usize), x: f64| (sum + x * x, n + 1);
        let errors = |count: usize| -> ((f64, f64), f64) {
            let amended = Amended::new(judge, &self.settled.refined.effects[..count]);
            let (mut weighted, mut free, mut all) = (0.0, (0.0, 0), (0.0, 0));
            for (row, weight) in weights.iter().enumerate() {
                let values = amended.residual(row);
                let told = without_sticking(judge, row, values, |i| counts(i, values.len()));
                let of_row = told.fold((0.0, 0), add);
                weighted += weight * of_row.0;
                if main.contains(&row) {
                    free = (free.0 + of_row.0, free.1 + of_row.1);
                    let kept = (0..values.len()).filter(|&i| counts(i, values.len())).map(|i| values[i]);
                    all = kept.fold(all, add);
                }
            }
            ((weighted, rms(free)), rms(all))
        };
        let standing = self.regression.standing.len();
        let prefixes = standing..=self.settled.refined.effects.len();
        let (alone, whole): (Vec<(f64, f64)>, Vec<f64>) = prefixes.clone().map(errors).unzip();
        let beside: Option<Vec<(f64, f64)>> = prefixes.map(|n| self.corrected(n, &main)).collect();
        // Corrections of all links mimic a mass that one of them carries: what it removes shows where nothing is corrected. Inertias that are
        // free are none of the description's, and nothing shows without them.
        let removed = |all: &[(f64, f64)]| {
            let [first, last] = [all.first(), all.last()].map(|ends| ends.map_or(0.0, |ends| ends.1.powi(2)));
            1.0 - last / first.max(f64::MIN_POSITIVE)
        };
        let tells =
            |beside: &Vec<(f64, f64)>| self.regression.free || removed(beside) + ELSEWHERE > removed(&alone);
        let beside = beside.filter(tells);
        let whole: Vec<f64> = beside.as_ref().map_or(whole, |all| all.iter().map(|ends| ends.1).collect());
        let all = beside.unwrap_or(alone.clone());
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
        let step = |k: usize| Step { effect: effect(k), before: whole[k], after: whole[k + 1] };
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
        let doubts = doubts(&effect, widths, Reach::of(self.regression.train, &effect.location));
        let mut found = FoundEffect { effect, ci95, share, doubts };
        for name in self.open_signs(&found.effect) {
            if let Some([low, high]) = found.ci95.get_mut(name) {
                let most = low.abs().max(high.abs());
                (*low, *high) = (-most, most);
            }
            found.doubts.push(format!("this data does not tell the sign of {name}: its cosine alone acts"));
        }
        found
    }

    /// Angles of a tilted gravity whose other sign would do the same: of a robot whose joints all turn about one axis.
    fn open_signs(&self, effect: &Effect) -> Vec<&'static str> {
        /// Of the squares of the noise.
        const NOTHING: f64 = 0.01;
        if effect.kind != &kinds::GRAVITY_TILT {
            return Vec::new();
        }
        let train = self.regression.train;
        let made = |effect: &Effect| train.response(std::slice::from_ref(effect));
        let own = made(effect);
        let is_open = |name: &&str| {
            let mut other = effect.clone();
            other.parameters.insert((*name).to_owned(), -effect.value(name));
            own.iter().zip(made(&other)).all(|((row, own), (_, other))| {
                let squares: f64 = own.iter().zip(&other).map(|(a, b)| (a - b).powi(2)).sum();
                squares <= NOTHING * train.rows()[*row].noise.powi(2) * own.len() as f64
            })
        };
        let is_turned = |name: &&str| effect.value(name) != 0.0;
        ["roll", "pitch"].into_iter().filter(is_turned).filter(is_open).collect()
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
            let lasting = |why: &&String| !PASSING.contains(&why.as_str());
            let before = || self.outcome.reasons.get(&c).filter(lasting).cloned();
            now.err().or_else(|| before().or_else(|| Some(NO_MORE.to_owned())))
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

/// Links among these that are of one body, by body.
fn bolted(train: &dyn Experiment, groups: &[Vec<Vec<FoundEffect>>]) -> Vec<Vec<String>> {
    let mut bodies: BTreeMap<usize, Vec<String>> = BTreeMap::new();
    for link in groups.iter().flatten().flatten().filter_map(|found| found.effect.location.link.as_ref()) {
        let Some(known) = train.link_inertias().and_then(|links| links.link(link)) else { continue };
        let of_body = bodies.entry(known.body).or_default();
        if !of_body.contains(link) {
            of_body.push(link.clone());
        }
    }
    bodies.into_values().filter(|links| links.len() > 1).collect()
}

/// Joints (or rows) in which an effect makes more than the measurement's noise, and its own joint.
fn acts_on(train: &dyn Experiment, effect: &Effect) -> Vec<String> {
    let rows = train.rows();
    let is_heard = |(row, made): &(usize, Vec<f64>)| {
        let squares: f64 = made.iter().map(|x| x * x).sum();
        squares > rows[*row].noise.powi(2) * made.len() as f64
    };
    let name = |row: usize| rows[row].joint.clone().unwrap_or_else(|| rows[row].name.clone());
    let made = train.response(std::slice::from_ref(effect));
    let own = effect.location.joint.clone();
    made.iter().filter(|made| is_heard(made)).map(|(row, _)| name(*row)).chain(own).collect()
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

fn doubts(effect: &Effect, widths: &[(String, f64)], reach: Reach) -> Vec<String> {
    let mut doubts = Vec::new();
    for parameter in effect.kind.estimated() {
        let value = effect.value(parameter.name);
        let (low, high) = reach.usual(effect, parameter.name);
        if value < low || value > high {
            let (name, unit) = (parameter.name, effect.unit(parameter.name));
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            doubts.push(format!(
                "{name} = {value:.4}{unit} is outside the usual range of {} to {}{unit}",
                short(low),
                short(high)
            ));
        }
    }
    let told = |name: &str| widths.iter().find(|(of, _)| of == name).is_none_or(|(_, half)| half.is_finite());
    let untold: Vec<&str> = effect.kind.estimated().map(|p| p.name).filter(|name| !told(name)).collect();
    if !untold.is_empty() {
        doubts.push(format!("this data does not determine {}", untold.join(", ")));
    }
    doubts
}

/// Two digits that count, without zeros at the end.
fn short(x: f64) -> f64 {
    counting(x, 2).parse().unwrap_or(x)
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
