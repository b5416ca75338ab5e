//! Which candidates stand: forward search, pruning, and the best small set at every joint.
use super::companions::beside_payloads;
use super::corrected::{is_corrected_as_likely, is_corrected_likelier};
use super::entry::{
    ANOTHER, INSEPARABLE, LEAST, consider, is_settling, is_trace, largest_fall, play, steady,
};
use super::exchange::{best_set, exchange, pair};
use super::friction_first::with_friction_first;
use super::rival::Rival;
use crate::diagnose::engine::equations::fit::Term;
use crate::diagnose::engine::equations::regression::{Regression, ScoredFit};
use crate::diagnose::engine::refine::behind_motors::is_behind_motor;
use crate::experiments::form::Form;
use crate::parallel::parallel;
use bipedc_effects::effect::Law;
use std::collections::BTreeMap;

/// Most effects that are looked for.
const MOST: usize = 24;
/// Most entries, those included that did not last, for each effect that is looked for.
const ROUNDS: usize = 2;
/// Part of what an effect explains that another one explains nearly as well.
const NEARLY: f64 = 0.8;

/// Costs of effects on links that differ by no more than that are about the same.
const ABOUT_AS_MUCH: f64 = 8.0;

/// A candidate's form and terms, as they were.
type Remembered = (Form, Vec<Term>);

/// What the search found.
pub(crate) struct Outcome {
    pub active: Vec<usize>,
    pub scored: ScoredFit,
    pub corrected: bool,
    /// Why candidates did not stand, by index: the last reason.
    pub reasons: BTreeMap<usize, String>,
    /// What effects alone explain, where corrections explain more; what corrections explain, where effects are as likely.
    pub rival: Option<Box<Rival>>,
}

/// Runs the search with and without inertial corrections, and takes what costs less: a single cause is preferred to
/// corrections of many links, and these to many causes. `entered` is told how many effects stand.
pub(crate) fn search(
    regression: &mut Regression<'_>,
    most: usize,
    entered: &dyn Fn(usize),
) -> Option<Outcome> {
    if regression.free {
        return with_friction_first(regression, most, entered);
    }
    let plain = run(regression, most, false, entered)?;
    if !regression.has_corrections() {
        return Some(plain);
    }
    let forms: Vec<_> = plain.active.iter().map(|&c| (c, regression.remembered(c))).collect();
    let corrected = run_steady(regression, most, entered)?;
    let corrected = beside_corrections(regression, (&plain, &forms), corrected);
    if is_corrected_likelier(regression, &plain, &corrected) {
        let found = plain.active.len() > regression.standing.len();
        let rival = found.then(|| Rival::of(plain, forms));
        return Some(Outcome { rival, ..corrected });
    }
    let rival = is_corrected_as_likely(regression, &plain, &corrected).then(|| {
        let forms = corrected.active.iter().map(|&c| (c, regression.remembered(c))).collect();
        Rival::of(corrected, forms)
    });
    // The nonlinear candidates as they were when the simpler answer was found.
    forms.into_iter().for_each(|(c, form)| regression.recall(c, form));
    Some(Outcome { rival, ..plain })
}

/// A search's answer with corrections, or these beside all that a search without them found at joints, whichever costs less: corrections of masses take up a rotor's
/// inertia that stands beside an error of the same masses, until of both nothing is seen but corrections far larger than descriptions are off.
fn beside_corrections(
    regression: &mut Regression<'_>,
    (plain, forms): (&Outcome, &[(usize, Remembered)]),
    corrected: Outcome,
) -> Outcome {
    let judged = &plain.active[regression.standing.len()..];
    let of_joints: Vec<usize> = judged.iter().copied().filter(|&c| !regression.is_of_link(c)).collect();
    if of_joints.is_empty() || of_joints.len() == judged.len() {
        return corrected;
    }
    let own: Vec<_> = corrected.active.iter().map(|&c| (c, regression.remembered(c))).collect();
    let as_found = forms.iter().filter(|(c, _)| of_joints.contains(c)).cloned();
    as_found.for_each(|(c, form)| regression.recall(c, form));
    let active = [regression.standing.as_slice(), &of_joints].concat();
    let scored = regression.scored_fit(&active, true).filter(|scored| {
        scored.cost < corrected.scored.cost && regression.impossible(&active, scored).is_none()
    });
    let Some(scored) = scored else {
        own.into_iter().for_each(|(c, form)| regression.recall(c, form));
        return corrected;
    };
    Outcome { active, scored, ..corrected }
}

/// A run with inertial corrections, without effects whose size hangs on these corrections.
fn run_steady(regression: &mut Regression<'_>, most: usize, entered: &dyn Fn(usize)) -> Option<Outcome> {
    let banned = regression.banned.clone();
    let mut outcome = run(regression, most, true, entered)?;
    for _ in 0..2 {
        let judged = regression.standing.len()..outcome.active.len();
        // What more would change is not known.
        if judged.len() >= most {
            break;
        }
        let Some(plain) = regression.scored_fit(&outcome.active, false) else { break };
        let unsteady = judged.rev().find(|&k| {
            !steady(regression, &outcome.active, &outcome.scored, &plain, k)
                && !is_settling(regression, &outcome, k)
        });
        let Some(k) = unsteady else { break };
        regression.ban(outcome.active[k]);
        outcome = run(regression, most, true, entered)?;
    }
    regression.banned = banned;
    Some(outcome)
}

/// Runs the search, and once more without a link's effect that was taken first where one at a joint whose motor alone is measured explains
/// nearly as much: the spring behind a motor shows only once what else the motor carries stands, and a payload makes up for both
/// better than either does alone.
pub(crate) fn run(
    regression: &mut Regression<'_>,
    most: usize,
    corrected: bool,
    entered: &dyn Fn(usize),
) -> Option<Outcome> {
    let (first, doubtful) = run_without(regression, most, corrected, (&[], &[]), entered)?;
    let first = single(regression, (most, corrected), first, entered);
    if doubtful.is_empty() {
        return Some(first);
    }
    let without = |regression: &mut Regression<'_>| {
        Some(run_without(regression, most, corrected, (&doubtful, &[]), entered)?.0)
    };
    Some(cheaper(regression, first, without))
}

/// What was found, or what a search without the couplings that were found does: what two causes do each in part, friction of a joint and an encoder's offset at the next
/// one, a coupling does in one step, and stands in the way of both.
fn single(
    regression: &mut Regression<'_>,
    (most, corrected): (usize, bool),
    found: Outcome,
    entered: &dyn Fn(usize),
) -> Outcome {
    let is_coupling = |c: &usize| regression.candidates[*c].form.location.other_joint.is_some();
    let judged = &found.active[regression.standing.len()..];
    let couplings: Vec<usize> = judged.iter().copied().filter(is_coupling).collect();
    if couplings.is_empty() {
        return found;
    }
    let banned = regression.banned.clone();
    let without = |regression: &mut Regression<'_>| {
        couplings.into_iter().for_each(|c| regression.ban(c));
        Some(run_without(regression, most, corrected, (&[], &[]), entered)?.0)
    };
    let found = cheaper(regression, found, without);
    regression.banned = banned;
    found
}

/// What was found or what another search finds, whichever costs less; candidates have the terms that they had in it.
pub(crate) fn cheaper<'r>(
    regression: &mut Regression<'r>,
    first: Outcome,
    search: impl FnOnce(&mut Regression<'r>) -> Option<Outcome>,
) -> Outcome {
    let forms: Vec<_> = first.active.iter().map(|&c| (c, regression.remembered(c))).collect();
    match search(regression) {
        Some(other) if other.scored.cost < first.scored.cost => other,
        _ => {
            forms.into_iter().for_each(|(c, form)| regression.recall(c, form));
            first
        }
    }
}

/// The search without some candidates, from a set of others on, and which of those that entered are to be left out when it is run once more.
pub(crate) fn run_without(
    regression: &mut Regression<'_>,
    most: usize,
    corrected: bool,
    (barred, start): (&[usize], &[usize]),
    entered: &dyn Fn(usize),
) -> Option<(Outcome, Vec<usize>)> {
    regression.linearise(&[], corrected);
    let mut active: Vec<usize> = regression.standing.clone();
    let standing = active.len();
    let mut scored = regression.scored_fit(&active, corrected)?;
    // Corrections that make up for one row's large error make others' large.
    let plain = regression.scored_fit(&active, false)?;
    regression.reference = scored.errors.iter().zip(&plain.errors).map(|(a, b)| a.min(*b)).collect();
    if !start.is_empty() {
        active.extend_from_slice(start);
        scored = regression.scored_fit(&active, corrected)?;
        (active, scored) = prune(regression, active, scored, corrected);
    }
    let mut reasons = BTreeMap::new();
    let mut banned: Vec<usize> = barred.to_vec();
    let mut doubtful = Vec::new();
    // What enters may drive out what entered before, and the other way round: there is an end to it.
    let most = most.min(MOST);
    for _ in 0..ROUNDS * most {
        if active.len() - standing >= most {
            break;
        }
        let before = (active.clone(), scored.clone());
        let tried = tried(regression, &active, &scored, (corrected, &banned), &mut reasons);
        let found = cheapest(regression, &active, &tried);
        if let Some(&(link, ref better)) = found.filter(|_| barred.is_empty() && doubtful.is_empty()) {
            doubtful = doubts(regression, &tried, (link, scored.cost - better.cost), scored.cost);
        }
        let with = |c: usize| [active.as_slice(), &[c]].concat();
        let alone = found.map(|(candidate, better)| (vec![*candidate], with(*candidate), better.clone()));
        let found = alone.or_else(|| pair(regression, &active, &scored, corrected, &banned));
        let Some((newcomers, set, better)) = found else { break };
        (active, scored) = (set, better);
        // What lies behind a motor carries what else was found there: its form is another one once that stands.
        if is_at_hidden_joint(regression, newcomers[0]) {
            regression.linearise(&active, corrected);
            scored = regression.scored_fit(&active, corrected).unwrap_or(scored);
        }
        (active, scored) = best_set(regression, active, scored, newcomers[0], corrected);
        (active, scored) = prune(regression, active, scored, corrected);
        regression.linearise(&active, corrected);
        let why;
        (scored, why) = exactly(regression, &active, scored, corrected);
        if let Some(why) = why {
            newcomers.iter().for_each(|&c| drop(reasons.insert(c, why.clone())));
            banned.extend(newcomers);
            (active, scored) = before;
            regression.linearise(&active, corrected);
        } else if active == before.0 {
            // They would enter and be driven out for ever.
            banned.extend(newcomers);
        }
        entered(active.len() - standing);
    }
    (active, scored) = exchange(regression, active, scored, corrected);
    (active, scored) = prune(regression, active, scored, corrected);
    (active, scored) = relinearised(regression, active, scored, corrected);
    (active, scored) = beside_payloads(regression, (active, scored), (corrected, most, &banned));
    Some((Outcome { active, scored, corrected, reasons, rival: None }, doubtful))
}

/// The fit of effects with their nonlinear parts in, and why one is not possible: what is impossible then, or cannot be told from the
/// others, was never possible.
fn exactly(
    regression: &Regression<'_>,
    active: &[usize],
    rough: ScoredFit,
    corrected: bool,
) -> (ScoredFit, Option<String>) {
    match regression.scored_fit(active, corrected) {
        Some(exact) => {
            let why = regression.impossible(active, &exact).map(|(_, why)| why);
            (exact, why)
        }
        None => (rough, Some(INSEPARABLE.to_owned())),
    }
}

/// Drops effects that only made up for directions of a payload that were taken at another estimate.
fn relinearised(
    regression: &mut Regression<'_>,
    mut active: Vec<usize>,
    mut scored: ScoredFit,
    corrected: bool,
) -> (Vec<usize>, ScoredFit) {
    let mut k = regression.standing.len();
    while active.len() > 1 && k < active.len() {
        let mut fewer = active.clone();
        let gone = fewer.remove(k);
        if fewer.iter().all(|&c| regression.candidates[c].form.kind.law != Law::Payload) {
            k += 1;
            continue;
        }
        regression.linearise(&fewer, corrected);
        let without =
            regression.scored_fit(&fewer, corrected).filter(|t| regression.impossible(&fewer, t).is_none());
        let rows = &regression.candidates[gone].rows;
        match without.filter(|t| t.cost <= scored.cost || is_trace(regression, rows, t, &scored)) {
            Some(better) => (active, scored) = (fewer, better),
            None => {
                regression.linearise(&active, corrected);
                k += 1;
            }
        }
    }
    (active, scored)
}

/// Candidates that may enter, with the fit that each leads to.
fn tried(
    regression: &Regression<'_>,
    active: &[usize],
    base: &ScoredFit,
    (corrected, banned): (bool, &[usize]),
    reasons: &mut BTreeMap<usize, String>,
) -> Vec<(usize, ScoredFit)> {
    let Some(rough) = regression.scored_fit(active, false) else { return Vec::new() };
    let tried =
        parallel(regression.candidates.len(), |c| consider(regression, active, base, &rough, corrected, c));
    let mut may_enter = Vec::new();
    for (c, result) in tried.into_iter().enumerate().filter(|(c, _)| !banned.contains(c)) {
        match result {
            Err(reason) => {
                reasons.insert(c, reason);
            }
            Ok(scored) => {
                reasons.insert(c, ANOTHER.to_owned());
                may_enter.push((c, scored));
            }
        }
    }
    may_enter
}

/// The candidate whose entry lowers the cost most, the first of equal ones. Of effects on links that cost about as much, as they do where all lower the
/// error below the noise, the one that lowers it most: a payload that is seen at some joints is no displaced centre of mass at one.
fn cheapest<'t>(
    regression: &Regression<'_>,
    active: &[usize],
    tried: &'t [(usize, ScoredFit)],
) -> Option<&'t (usize, ScoredFit)> {
    let first = tried.iter().min_by(|a, b| a.1.cost.total_cmp(&b.1.cost))?;
    if !regression.is_of_link(first.0) {
        return Some(first);
    }
    let near = |(c, scored): &&(usize, ScoredFit)| {
        regression.is_of_link(*c) && scored.cost <= first.1.cost + ABOUT_AS_MUCH
    };
    let whole = |(c, scored): &(usize, ScoredFit)| regression.whole_cost(&[active, &[*c]].concat(), scored);
    tried.iter().filter(near).min_by(|a, b| whole(a).total_cmp(&whole(b)))
}

/// An effect on a link that lowers the cost by `fall`, in all its forms, if one at a joint whose motor alone is measured lowers it
/// nearly as much.
fn doubts(
    regression: &Regression<'_>,
    tried: &[(usize, ScoredFit)],
    (link, fall): (usize, f64),
    cost: f64,
) -> Vec<usize> {
    let place = |c: usize| &regression.candidates[c].form.location;
    let rivals = tried.iter().filter(|(_, scored)| cost - scored.cost > NEARLY * fall);
    if place(link).link.is_none() || !rivals.map(|(c, _)| *c).any(|c| is_at_hidden_joint(regression, c)) {
        return Vec::new();
    }
    let kind = |c: usize| regression.candidates[c].form.kind;
    let forms = 0..regression.candidates.len();
    forms.filter(|&c| kind(c) == kind(link) && place(c) == place(link)).collect()
}

/// Whether a candidate is at a joint of which the motor's angle alone was measured, and something may lie behind it.
fn is_at_hidden_joint(regression: &Regression<'_>, c: usize) -> bool {
    let joint = |c: usize| &regression.candidates[c].form.location.joint;
    let here = |o: &usize| joint(*o) == joint(c);
    joint(c).is_some()
        && (0..regression.candidates.len()).filter(here).any(|o| is_behind_motor(regression, o))
}

/// Drops effects that no longer pay.
fn prune(
    regression: &Regression<'_>,
    mut active: Vec<usize>,
    mut scored: ScoredFit,
    corrected: bool,
) -> (Vec<usize>, ScoredFit) {
    loop {
        let without = (regression.standing.len()..active.len()).filter_map(|k| {
            let mut fewer = active.clone();
            let gone = fewer.remove(k);
            let t = regression.scored_fit(&fewer, corrected)?;
            let rows = &regression.candidates[gone].rows;
            let rough = regression.scored_fit(&fewer, false)?;
            let full = regression.scored_fit(&active, false)?;
            let play = play(regression, &fewer);
            let fall = |before: &ScoredFit, after: &ScoredFit| {
                largest_fall(regression, (gone, &play), before, after)
            };
            let fall = fall(&t, &scored).max(fall(&rough, &full));
            let idle = t.cost <= scored.cost || fall < 0.5 * LEAST || is_trace(regression, rows, &t, &scored);
            (idle && regression.impossible(&fewer, &t).is_none()).then_some((fewer, t))
        });
        match without.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost)) {
            Some((fewer, t)) => (active, scored) = (fewer, t),
            None => return (active, scored),
        }
    }
}
