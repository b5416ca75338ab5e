//! Explanations that the data cannot tell from the one that stands.
use super::conclusion::Conclusion;
use super::significance::{JudgedError, judged_errors};
use crate::diagnose::FoundEffect;
use crate::diagnose::engine::equations::regression::{ScoredFit, is_held_out};
use crate::diagnose::engine::refine::behind_motors::{exact_deviance, is_behind_motor};
use crate::diagnose::engine::search::forward::Outcome;
use crate::diagnose::engine::search::parsimony::{ALIKE, SCATTER, rows_within};
use crate::experiments::corners::landings_in_legs;
use crate::experiments::form::Form;
use crate::parallel::parallel;
use bipedc_effects::effect::{Effect, Kind};
use std::collections::BTreeMap;

/// Most single effects that are named in the place of one: who reads ten reads none.
pub(crate) const SINGLES: usize = 4;
/// No row's squared error may be larger than this part of it in the place of an effect that removed a hundred times as much: one sees that.
const WORSE: f64 = 0.1;
/// The same where more than noise is left anyway, or where blocks of the judging data disagree.
const MUCH_WORSE: f64 = 0.25;
/// Most pairs.
const PAIRS: usize = 3;

/// A set with a candidate in the place of its `k`-th.
fn replaced(set: &[usize], k: usize, c: usize) -> Vec<usize> {
    let mut set = set.to_vec();
    set[k] = c;
    set
}

impl Conclusion<'_> {
    /// Candidates that would do as well in the place of an effect that stands, alone or with another kind in the place
    /// of a second one.
    pub(crate) fn alternatives(&self, found: &[FoundEffect], order: &[usize]) -> Vec<Vec<Vec<FoundEffect>>> {
        if self.outcome.active.len() != self.settled.refined.effects.len() {
            return Vec::new();
        }
        match self.as_stated() {
            Some(plain) => Conclusion { outcome: &plain, ..*self }.alternatives_to(found, order),
            None => self.alternatives_to(found, order),
        }
    }

    /// What was found without inertial corrections, where these were looked at and none is stated: corrections of all bodies could make up
    /// for what an alternative lacks, and nobody would be told of them.
    fn as_stated(&self) -> Option<Outcome> {
        let outcome = self.outcome;
        if !outcome.corrected || self.regression.free || !self.settled.corrections.is_empty() {
            return None;
        }
        let scored = self.regression.scored_fit(&outcome.active, false)?;
        let (active, reasons) = (outcome.active.clone(), BTreeMap::new());
        Some(Outcome { active, scored, corrected: false, reasons, rival: None })
    }

    fn alternatives_to(&self, found: &[FoundEffect], order: &[usize]) -> Vec<Vec<Vec<FoundEffect>>> {
        let active = &self.outcome.active;
        let is_hidden = active.iter().any(|&c| is_behind_motor(self.regression, c));
        let (regression, refined) = (self.regression, &self.settled.refined);
        let here = judged_errors(regression, &refined.effects, &self.change(&refined.corrections), None);
        let mut groups = Vec::new();
        for (found, &k) in found.iter().zip(order) {
            let (alike, near) = self.alike(active, k);
            let mut group = vec![vec![found.clone()]];
            let stands_in = |c: &&usize| is_hidden || !self.is_told_apart(&replaced(active, k, **c), &here);
            let singles = alike.iter().filter(stands_in);
            let singles = singles.map(|&c| vec![self.alternative(active, k, c, found.share)]);
            group.extend(singles.filter(|one| is_hidden || !self.is_told_exactly(&[k], one)).take(SINGLES));
            group.extend(self.as_sum(k, found.share));
            let other_kind = near.iter().find(|&&c| self.form(c).kind != found.effect.kind);
            match other_kind {
                // The search draws a straight line from one stiffness: others that do as well beside that need not beside the law itself.
                _ if is_hidden => self.keep_exact(k, &mut group),
                Some(&c) => group.extend(self.together((k, c), found.share, &here)),
                None => {}
            }
            if group.len() > 1 {
                groups.push(group);
            }
        }
        groups
    }

    /// Leaves, of single effects in the place of the `k`-th, the first of `group`, those that do as well when all are estimated exactly.
    fn keep_exact(&self, k: usize, group: &mut Vec<Vec<FoundEffect>>) {
        let regression = self.regression;
        let standing = &self.settled.refined.effects;
        let jumps = landings_in_legs(regression.judge, standing);
        let teaches = |sample: usize, n: usize| !regression.own_blocks || !is_held_out(sample, n);
        let deviance =
            |effects| exact_deviance(regression, self.outcome.corrected, effects, (&teaches, &jumps));
        let mut without = standing.clone();
        without.remove(k);
        let here = deviance(standing.clone());
        let removed = deviance(without.clone()) - here;
        let as_well = |other: &Vec<FoundEffect>| {
            let others = other.iter().map(|found| found.effect.clone());
            let set: Vec<Effect> = without.iter().cloned().chain(others).collect();
            deviance(set) - here <= (ALIKE * removed).max(4.0)
        };
        let others = group.split_off(1);
        group.extend(others.into_iter().filter(as_well));
    }

    fn form(&self, c: usize) -> &Form {
        &self.regression.candidates[c].form
    }

    /// Alternatives that differ in two effects: `c` in the place of the `k`-th, and another kind, or another place, in that of a second one
    /// with which the `k`-th shares a row; the best of each kind, and of these the best few.
    fn together(&self, (k, c): (usize, usize), share: f64, here: &[JudgedError]) -> Vec<Vec<FoundEffect>> {
        let (regression, outcome) = (self.regression, self.outcome);
        let mut out = Vec::new();
        let met = |j: &usize| *j != k && regression.meet(outcome.active[*j], outcome.active[k]);
        for j in (regression.standing.len()..outcome.active.len()).filter(met) {
            let mut bare = outcome.active.clone();
            bare.remove(k.max(j));
            bare.remove(k.min(j));
            let Some(limit) = self.limit(&bare) else { continue };
            let tried = parallel(regression.candidates.len(), |d| {
                let mut set = outcome.active.clone();
                (set[k], set[j]) = (c, d);
                let elsewhere = !regression.meet(d, outcome.active[j]);
                if elsewhere || outcome.active.contains(&d) || d == c || regression.stands(d) {
                    return None;
                }
                let scored = regression.scored_fit(&set, outcome.corrected)?;
                let more = self.excess(&scored, &set);
                let alike = self.as_well(&scored, &set, more, limit)
                    && regression.impossible(&set, &scored).is_none();
                alike.then_some((more, d))
            });
            let mut alike: Vec<(f64, usize)> = tried.into_iter().flatten().collect();
            alike.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut kinds: Vec<&Kind> = Vec::new();
            for (more, d) in alike {
                let set = replaced(&replaced(&outcome.active, k, c), j, d);
                if kinds.contains(&self.form(d).kind) || kinds.len() == 3 || self.is_told_apart(&set, here) {
                    continue;
                }
                let pair = vec![self.alternative(&set, k, c, share), self.alternative(&set, j, d, share)];
                if !self.is_told_exactly(&[k, j], &pair) {
                    kinds.push(self.form(d).kind);
                    out.push((more, pair));
                }
            }
        }
        out.sort_by(|a, b| a.0.total_cmp(&b.0));
        out.into_iter().take(PAIRS).map(|(_, pair)| pair).collect()
    }

    /// What corrections of a fit change, where the answer states any.
    fn change(&self, corrections: &[f64]) -> Vec<f64> {
        match self.outcome.corrected && !corrections.is_empty() {
            true => self.regression.spread.change(corrections),
            false => Vec::new(),
        }
    }

    /// Whether one sees that a set explains less than what stands, which leaves `here`: by its laws as they are, where the search smoothed
    /// their jumps.
    fn is_told_apart(&self, set: &[usize], here: &[JudgedError]) -> bool {
        let (regression, corrected) = (self.regression, self.outcome.corrected);
        let Some(scored) = regression.scored_fit(set, corrected).filter(|_| !regression.is_table) else {
            return false;
        };
        let effect = |(j, &c): (usize, &usize)| self.form(c).effect(regression.coefficients(set, &scored, j));
        let others: Vec<Effect> = set.iter().enumerate().map(effect).collect();
        let there = judged_errors(regression, &others, &self.change(&scored.fit.corrections), None);
        there.iter().zip(here).any(|(there, here)| there.is_worse_than(here, 1.0 + MUCH_WORSE))
    }

    /// Two effects that are the `k`-th by algebra while its joint moves: friction that differs by direction is friction and a bias.
    fn as_sum(&self, k: usize, share: f64) -> Option<Vec<FoundEffect>> {
        let (regression, active) = (self.regression, &self.outcome.active);
        let mine = self.form(active[k]);
        let here = |c: &usize| self.form(*c).location == mine.location && !active.contains(c);
        let places: Vec<usize> = (0..regression.candidates.len()).filter(here).collect();
        let is_sum = |&(a, b): &(usize, usize)| mine.kind.is_sum_of(self.form(a).kind, self.form(b).kind);
        let pairs = places.iter().flat_map(|&a| places.iter().map(move |&b| (a, b)));
        let (a, b) = pairs.filter(|(a, b)| a < b).find(is_sum)?;
        let mut bare = active.clone();
        bare.remove(k);
        let set = [replaced(active, k, a), vec![b]].concat();
        let scored = regression.scored_fit(&set, self.outcome.corrected)?;
        let as_well = self.excess(&scored, &set) <= (ALIKE * self.limit(&bare)?).max(4.0);
        let last = set.len() - 1;
        (as_well && regression.impossible(&set, &scored).is_none())
            .then(|| vec![self.alternative(&set, k, a, share), self.alternative(&set, last, b, share)])
    }

    /// Deviance of a set beyond that of the effects that stand.
    fn excess(&self, scored: &ScoredFit, set: &[usize]) -> f64 {
        let (regression, outcome) = (self.regression, self.outcome);
        let here = outcome.scored.cost - regression.complexity_penalty(&outcome.active);
        scored.cost - regression.complexity_penalty(set) - here
    }

    /// Deviance that the effects missing in `bare` remove.
    fn limit(&self, bare: &[usize]) -> Option<f64> {
        let without = self.regression.scored_fit(bare, self.outcome.corrected)?;
        Some(self.excess(&without, bare))
    }

    /// Whether so much more deviance than that of the effects that stand is nothing, beside what they remove or beside
    /// what blocks of the judging data disagree by.
    fn as_well(&self, scored: &ScoredFit, set: &[usize], more: f64, removed: f64) -> bool {
        let (regression, here) = (self.regression, &self.outcome.scored);
        let chance = || regression.scatter(here, &self.outcome.active, scored, set);
        let growth = |row: usize| if regression.is_loud(row, here) { MUCH_WORSE } else { WORSE };
        more <= 4.0
            || (more <= ALIKE * removed && rows_within(regression, here, scored, &growth))
            || (more <= SCATTER * removed
                && rows_within(regression, here, scored, &|_| MUCH_WORSE)
                && more <= chance())
    }

    /// A candidate in the place of an effect, with the values that fit there.
    fn alternative(&self, set: &[usize], k: usize, c: usize, share: f64) -> FoundEffect {
        let mut set = set.to_vec();
        set[k] = c;
        let effect = match self.regression.scored_fit(&set, self.outcome.corrected) {
            Some(scored) => self.form(c).effect(self.regression.coefficients(&set, &scored, k)),
            None => Effect::new(self.form(c).kind, self.form(c).location.clone(), &[]),
        };
        FoundEffect { effect, ci95: BTreeMap::new(), share, doubts: Vec::new() }
    }

    /// Candidates that would do as well in the place of the `k`-th effect, and those that would nearly; best first, one
    /// per kind and place.
    pub(crate) fn alike(&self, active: &[usize], k: usize) -> (Vec<usize>, Vec<usize>) {
        let (regression, corrected) = (self.regression, self.outcome.corrected);
        let mut fewer = active.to_vec();
        fewer.remove(k);
        let Some(removed) = self.limit(&fewer) else { return Default::default() };
        let mine = self.form(active[k]);
        let tried = parallel(regression.candidates.len(), |c| {
            let other = self.form(c);
            let same = (other.kind, &other.location) == (mine.kind, &mine.location);
            let elsewhere = !regression.meet(c, active[k]);
            if same
                || elsewhere
                || active.contains(&c)
                || regression.stands(c)
                || other.kind.contains(mine.kind)
            {
                return None;
            }
            let mut set = active.to_vec();
            set[k] = c;
            let scored = regression.scored_fit(&set, corrected)?;
            let more = self.excess(&scored, &set);
            let near = more <= (SCATTER * removed).max(4.0) && regression.impossible(&set, &scored).is_none();
            near.then(|| (more, c, self.as_well(&scored, &set, more, removed)))
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
}
