//! Springs and play behind motors' encoders: which effects are left once the motion of their links is computed exactly.
//!
//! Where the motor's angle alone is measured, a spring moves the whole chain behind it. The search draws a straight line from the
//! stiffness at which it looked, and whatever that leaves other effects make up for: in one log 80 N m/rad at a knee and an offset for
//! a hip whose spring has 103 N m/rad instead of the 128 at which it was sought. Estimated all at once they keep each other
//! where they are. So the effects that were found stand in line once more, each estimated exactly beside those before it.
use super::amended::Amended;
use super::estimates::{data, estimates, spread};
use super::refinement::refine;
use crate::diagnose::engine::equations::regression::Regression;
use crate::diagnose::engine::judge::significance::without_sticking;
use crate::diagnose::engine::search::entry::{mistimes, shares};
use crate::diagnose::engine::search::forward::Outcome;
use crate::experiments::corners::landings_in_legs;
use crate::experiments::{Channel, Experiment};
use bipedc_effects::effect::{Acts, Effect};

/// Beside play in a leg on the ground errors beyond so many times the noise count by their size, and not by its square: beside a stop that was
/// met otherwise, a link is half a gap or more away from where it is taken to be.
const FORGIVEN: f64 = 3.0;

/// Effects that stand in line: those that a search found, and more that lie behind the motors of their joints.
struct Line<'r, 'a> {
    regression: &'r Regression<'a>,
    corrected: bool,
    teaches: &'r (dyn Fn(usize, usize) -> bool + Sync),
    /// Candidates, those that stand from the start first, and where the estimate of each begins.
    all: Vec<usize>,
    starts: Vec<Effect>,
    /// Samples where links meet their stops: how, no law tells, so that nothing is to stand for that.
    jumps: Vec<bool>,
}

/// Leaves those effects in `outcome` that lower the exact held-out error by more than they cost, beginning with what lies behind a
/// motor. Others are as they were. Where something is left at a joint whose motor alone is measured, springs and play that the search
/// did not find there stand in line too: what they carry is another thing once a motor's inertia or friction is known.
pub(crate) fn stand_in_line(
    regression: &Regression<'_>,
    outcome: &mut Outcome,
    teaches: &(dyn Fn(usize, usize) -> bool + Sync),
) {
    let standing = regression.standing.len();
    let found = outcome.active.len();
    let more = not_found(regression, outcome);
    let all: Vec<usize> = outcome.active.iter().copied().chain(more.iter().map(|(c, _)| *c)).collect();
    let hidden: Vec<usize> = (standing..all.len()).filter(|&k| is_behind_motor(regression, all[k])).collect();
    if hidden.is_empty() || all.len() < standing + 2 {
        return;
    }
    let mut starts = estimates(regression, outcome);
    starts.extend(more.into_iter().map(|(_, start)| start));
    let jumps = landings_in_legs(regression.judge, &starts);
    let line = Line { regression, corrected: outcome.corrected, teaches, all, starts, jumps };
    let lines = hidden.into_iter().map(|first| line.behind(first));
    let Some((kept, least)) = lines.min_by(|a, b| a.1.total_cmp(&b.1)) else { return };
    let before: Vec<usize> = (0..found).collect();
    if kept == before {
        return;
    }
    // As good as all of them, or the line was the wrong one.
    let is_confused = before.iter().any(|&a| before.iter().any(|&b| line.confused(a, b)));
    if !is_confused && least >= line.cost(&before) {
        return;
    }
    let active: Vec<usize> = kept.iter().map(|&k| line.all[k]).collect();
    if let Some(scored) = regression.scored_fit(&active, outcome.corrected) {
        (outcome.active, outcome.scored) = (active, scored);
    }
}

impl Line<'_, '_> {
    /// Exact held-out error of some of the effects, and what they cost.
    fn cost(&self, kept: &[usize]) -> f64 {
        let effects = kept.iter().map(|&k| self.starts[k].clone()).collect();
        let active: Vec<usize> = kept.iter().map(|&k| self.all[k]).collect();
        exact_deviance(self.regression, self.corrected, effects, (self.teaches, &self.jumps))
            + self.regression.complexity_penalty(&active)
    }

    fn confused(&self, a: usize, b: usize) -> bool {
        mistimes(self.regression, self.all[a], self.all[b])
    }

    /// Whether two have the same place and kind, or are taken for each other.
    fn excludes(&self, a: usize, b: usize) -> bool {
        self.confused(a, b) || self.confused(b, a) || shares(self.regression, self.all[a], self.all[b])
    }

    /// Those that stand with this one, in order, and their cost.
    fn behind(&self, first: usize) -> (Vec<usize>, f64) {
        let standing = self.regression.standing.len();
        let mut kept: Vec<usize> = (0..standing).chain([first]).collect();
        let mut least = self.cost(&kept);
        loop {
            let may_stand = |k: &usize| !kept.contains(k) && !kept.iter().any(|&o| self.excludes(o, *k));
            let tried = (standing..self.all.len()).filter(may_stand).map(|k| {
                let with = [kept.as_slice(), &[k]].concat();
                let cost = self.cost(&with);
                (with, cost)
            });
            let Some((with, lower)) =
                tried.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, lower)| *lower < least)
            else {
                break;
            };
            (kept, least) = (with, lower);
        }
        kept.sort_unstable();
        (kept, least)
    }
}

/// Springs and play at joints whose motors alone are measured and at which a search found something else alone, where more is left than
/// noise; with estimates to begin with.
fn not_found(regression: &Regression<'_>, outcome: &Outcome) -> Vec<(usize, Effect)> {
    let form = |c: usize| &regression.candidates[c].form;
    let found = &outcome.active[regression.standing.len()..];
    let is_at = |c: usize| found.iter().any(|&f| form(f).location == form(c).location);
    let is_told = |c: usize| {
        found.iter().any(|&f| form(f).location == form(c).location && is_behind_motor(regression, f))
    };
    let is_loud =
        |c: usize| regression.candidates[c].rows.iter().any(|&row| regression.is_loud(row, &outcome.scored));
    let open = (0..regression.candidates.len()).filter(|&c| is_behind_motor(regression, c));
    let open = open.filter(|&c| is_at(c) && !is_told(c) && is_loud(c) && !regression.banned.contains(&c));
    let mut best: Vec<(usize, Effect, f64)> = Vec::new();
    for c in open {
        let with = [outcome.active.as_slice(), &[c]].concat();
        let Some(scored) = regression.scored_fit(&with, outcome.corrected) else { continue };
        let coefficients = regression.coefficients(&with, &scored, outcome.active.len());
        if form(c).impossible(coefficients).is_some() {
            continue;
        }
        let start = form(c).effect(coefficients);
        let known = best
            .iter_mut()
            .find(|(b, ..)| form(*b).kind == form(c).kind && form(*b).location == form(c).location);
        match known {
            Some(known) if known.2 > scored.cost => *known = (c, start, scored.cost),
            Some(_) => (),
            None => best.push((c, start, scored.cost)),
        }
    }
    best.into_iter().map(|(c, start, _)| (c, start)).collect()
}

/// The square of an error, which grows with its size beyond a limit, as Huber's.
fn forgiving_square(error: f64, limit: f64) -> f64 {
    let size = error.abs();
    if size > limit { limit * (2.0 * size - limit) } else { size * size }
}

/// Whether a candidate lies between a motor and a link of which nobody measured the angle: its torque shows it.
pub(crate) fn is_behind_motor(regression: &Regression<'_>, c: usize) -> bool {
    let candidate = &regression.candidates[c];
    candidate.form.kind.law.acts() == Acts::Transmission
        && candidate.rows.iter().all(|&row| regression.train.rows()[row].channel != Channel::Transmission)
}

/// Weighted held-out squares of effects that are estimated exactly, with the prior of what is corrected beside them; samples where links meet
/// their stops (`jumps`) do not count.
pub(crate) fn exact_deviance(
    regression: &Regression<'_>,
    corrected: bool,
    effects: Vec<Effect>,
    (teaches, jumps): (&(dyn Fn(usize, usize) -> bool + Sync), &[bool]),
) -> f64 {
    let refined = refine(data(regression, teaches), effects, &[], spread(regression, corrected));
    let mut amended = Amended::new(regression.judge, &refined.effects);
    let change = regression.spread.change(&refined.corrections);
    if !change.is_empty() {
        amended.correct(&change);
    }
    let squares = |row: usize| -> f64 {
        let away = |i: usize| !jumps.get(i).is_some_and(|jumps| *jumps);
        let told = without_sticking(regression.judge, row, amended.residual(row), away);
        let limit =
            if jumps.is_empty() { f64::INFINITY } else { FORGIVEN * regression.judge.rows()[row].noise };
        told.map(|x| forgiving_square(x, limit)).sum::<f64>() * regression.weights[row]
    };
    let prior: f64 = refined.corrections.iter().map(|x| x * x).sum();
    (0..regression.judge.rows().len()).map(squares).sum::<f64>() + prior
}
