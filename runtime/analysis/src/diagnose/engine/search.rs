//! Which candidates stand: forward search, pruning, and the best small set at every joint.
use super::behind_motors::is_behind_motor;
use super::corrected::{is_corrected_as_likely, is_corrected_likelier};
use super::exchange::{best_set, exchange, pair};
use super::friction_first::with_friction_first;
use super::regression::{Regression, ScoredFit};
use super::rival::Rival;
use crate::experiments::Channel;
use crate::parallel::parallel;
use bipedc_effects::effect::{Acts, Kind, Law, Location};
use std::collections::BTreeMap;

/// Part of a row's held-out squared error that an effect must remove.
pub(super) const LEAST: f64 = 0.02;
/// The same of what lies between motor and link, where stops and gears always give way a little, and beside play that torques alone
/// show, where links meet stops in a way that no law of the library tells.
const LEAST_TRANSMISSION: f64 = 0.15;

/// Part of a row's held-out squared error that an effect of a kind must remove beside play at these joints.
pub(super) fn least(regression: &Regression<'_>, row: usize, kind: &Kind, play: &[&Location]) -> f64 {
    let between = regression.train.rows()[row].channel == Channel::Transmission
        || kind.law.acts() == Acts::Transmission;
    let behind = |location: &&Location| regression.is_behind_play(row, location);
    if between || play.iter().any(behind) { LEAST_TRANSMISSION } else { LEAST }
}

/// Where candidates are play.
fn play<'r>(regression: &'r Regression<'_>, active: &[usize]) -> Vec<&'r Location> {
    let forms = active.iter().map(|&c| &regression.candidates[c].form);
    forms.filter(|form| form.kind.law == Law::Backlash).map(|form| &form.location).collect()
}

/// Part of the squared error that a row had before any effect entered which each effect must remove: less is what the
/// forms of the others leave.
const TRACE: f64 = 1e-3;
/// Most effects that are looked for.
const MOST: usize = 24;
/// Most entries, those included that did not last, for each effect that is looked for.
const ROUNDS: usize = 2;
/// Part of what an effect explains that another one explains nearly as well.
const NEARLY: f64 = 0.8;
/// Why a candidate does not enter that stands, or whose turn it is not: such reasons hold for a step of a search alone.
const STANDS: &str = "it stands already";
const ANOTHER: &str = "another candidate lowers the held-out error more";
pub(super) const PASSING: [&str; 2] = [STANDS, ANOTHER];
/// Why a candidate does not stand that makes the equations singular.
const INSEPARABLE: &str = "this data cannot tell it from what stands already";

/// What the search found.
pub(super) struct Outcome {
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
pub(super) fn search(
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

/// A run with inertial corrections, without effects whose size hangs on these corrections.
fn run_steady(regression: &mut Regression<'_>, most: usize, entered: &dyn Fn(usize)) -> Option<Outcome> {
    let banned = regression.banned.clone();
    let mut outcome = run(regression, most, true, entered)?;
    for _ in 0..2 {
        let Some(plain) = regression.scored_fit(&outcome.active, false) else { break };
        let judged = regression.standing.len()..outcome.active.len();
        let unsteady =
            judged.rev().find(|&k| !steady(regression, &outcome.active, &outcome.scored, &plain, k));
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
pub(super) fn run(
    regression: &mut Regression<'_>,
    most: usize,
    corrected: bool,
    entered: &dyn Fn(usize),
) -> Option<Outcome> {
    let (first, doubtful) = run_without(regression, most, corrected, (&[], &[]), entered)?;
    if doubtful.is_empty() {
        return Some(first);
    }
    let without = |regression: &mut Regression<'_>| {
        Some(run_without(regression, most, corrected, (&doubtful, &[]), entered)?.0)
    };
    Some(cheaper(regression, first, without))
}

/// What was found or what another search finds, whichever costs less; candidates have the terms that they had in it.
pub(super) fn cheaper<'r>(
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
pub(super) fn run_without(
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
    regression.reference.clone_from(&scored.errors);
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
        let found = cheapest(&tried);
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

/// The candidate whose entry lowers the cost most, the first of equal ones.
fn cheapest(tried: &[(usize, ScoredFit)]) -> Option<&(usize, ScoredFit)> {
    tried.iter().min_by(|a, b| a.1.cost.total_cmp(&b.1.cost))
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

/// Why a candidate cannot stand beside these, whatever it lowers.
pub(super) fn excluded(regression: &Regression<'_>, active: &[usize], c: usize) -> Option<String> {
    let candidate = &regression.candidates[c];
    let same = |a: &usize| {
        let other = &regression.candidates[*a].form;
        other.kind == candidate.form.kind && other.location == candidate.form.location
    };
    if regression.banned.contains(&c) {
        return Some("its exact estimate is impossible".to_owned());
    }
    if active.iter().any(same) {
        return Some(STANDS.to_owned());
    }
    if active.iter().any(|&a| mistimes(regression, a, c)) {
        return Some(
            "beside play that torques alone show, stops that are met early or late look like it".to_owned(),
        );
    }
    let other = *active.iter().find(|&&a| shares(regression, a, c))?;
    Some(format!("{} stands there and has the same part", regression.candidates[other].form.kind))
}

/// Whether a candidate may enter: the reason if not.
pub(super) fn consider(
    regression: &Regression<'_>,
    active: &[usize],
    base: &ScoredFit,
    rough: &ScoredFit,
    corrected: bool,
    c: usize,
) -> Result<ScoredFit, String> {
    let candidate = &regression.candidates[c];
    if let Some(reason) = excluded(regression, active, c) {
        return Err(reason);
    }
    let mut with = active.to_vec();
    with.push(c);
    let inseparable = || INSEPARABLE.to_owned();
    let scored = regression.scored_fit(&with, corrected).ok_or_else(inseparable)?;
    let plain = regression.scored_fit(&with, false).ok_or_else(inseparable)?;
    if let Some((who, why)) = regression.impossible(&with, &scored) {
        let of = if who == c { String::new() } else { "with it another effect is impossible: ".to_owned() };
        return Err(format!("{of}{why}"));
    }
    if !regression.free && !steady(regression, &with, &scored, &plain, active.len()) {
        return Err("its size hangs on how masses are corrected".to_owned());
    }
    let play = play(regression, active);
    let alone = largest_fall(regression, (c, &play), rough, &plain);
    if alone < LEAST && !regression.free {
        return Err("it explains something only if masses move with it".to_owned());
    }
    let fall = largest_fall(regression, (c, &play), base, &scored).max(alone);
    if fall < LEAST {
        return Err(format!(
            "it lowers no row's held-out squared error by more than {:.1} %",
            100.0 * fall.max(0.0)
        ));
    }
    if is_trace(regression, &candidate.rows, base, &scored) {
        return Err(
            "it would remove a trace of what the other effects removed: their own inaccuracy".to_owned()
        );
    }
    if scored.cost >= base.cost {
        let (penalty, worth) = (
            regression.complexity_penalty(&[c]),
            base.cost - scored.cost + regression.complexity_penalty(&[c]),
        );
        return Err(format!(
            "the evidence for it, {worth:.0}, does not pay for its parameters, {penalty:.0}"
        ));
    }
    Ok(scored)
}

/// Whether two effects at one place differ only in what neither is about: the moment of reversal, a constant.
pub(super) fn shares(regression: &Regression<'_>, a: usize, b: usize) -> bool {
    let (a, b) = (&regression.candidates[a].form, &regression.candidates[b].form);
    a.location == b.location && a.kind.resembles(b.kind)
}

/// Whether the first is play that torques alone show, and the second a delay or a spring where it is felt: when the link meets its
/// stops is known to some milliseconds, and what is left then looks like either.
pub(super) fn mistimes(regression: &Regression<'_>, play: usize, c: usize) -> bool {
    let [play, other] = [play, c].map(|c| &regression.candidates[c]);
    play.form.kind.law == Law::Backlash
        && matches!(other.form.kind.law, Law::Delay | Law::SeriesElasticity)
        && other.rows.iter().any(|&row| regression.is_behind_play(row, &play.form.location))
}

/// Whether an effect's size is much the same with and without inertial corrections. Effects on links compete with
/// the corrections: theirs need not be.
fn steady(
    regression: &Regression<'_>,
    with: &[usize],
    corrected: &ScoredFit,
    plain: &ScoredFit,
    k: usize,
) -> bool {
    if regression.candidates[with[k]].form.location.link.is_some() {
        return true;
    }
    let (a, b) = (regression.coefficients(with, corrected, k), regression.coefficients(with, plain, k));
    let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
    let size = norm(&mut a.iter().copied()).max(norm(&mut b.iter().copied()));
    norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) <= 0.5 * size
}

/// Largest relative fall of the held-out error over a candidate's rows, beside play, scaled so that [`LEAST`] is what it takes.
fn largest_fall(
    regression: &Regression<'_>,
    (c, play): (usize, &[&Location]),
    before: &ScoredFit,
    after: &ScoredFit,
) -> f64 {
    let candidate = &regression.candidates[c];
    let fall = |&r: &usize| {
        let relative = (before.errors[r] - after.errors[r]) / before.errors[r].max(f64::MIN_POSITIVE);
        relative * LEAST / least(regression, r, candidate.form.kind, play)
    };
    candidate.rows.iter().map(fall).fold(f64::NEG_INFINITY, f64::max)
}

/// Whether the fall of error is next to nothing beside the errors that there were without any effect.
fn is_trace(regression: &Regression<'_>, rows: &[usize], before: &ScoredFit, after: &ScoredFit) -> bool {
    let trace = |r: usize| TRACE * regression.reference[r];
    rows.iter().all(|&r| before.errors[r] - after.errors[r] <= trace(r))
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
