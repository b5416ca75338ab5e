//! Which candidates stand: forward search, pruning, and the best small set at every joint.
use super::parallel::parallel;
use super::refine::{exchange, refine};
use super::setting::{Setting, Trial};
use crate::experiments::Channel;
use bipedc_effects::effect::Law;
use std::collections::BTreeMap;

/// Part of a row's held-out squared error that an effect must remove.
pub(super) const LEAST: f64 = 0.02;
/// The same between motor and link: stops and gears always give way a little.
const LEAST_TRANSMISSION: f64 = 0.15;

/// Part of a row's held-out squared error that an effect must remove.
pub(super) fn least(channel: Channel) -> f64 {
    if channel == Channel::Transmission { LEAST_TRANSMISSION } else { LEAST }
}
/// Part of the squared error that a row had before any effect entered which each effect must remove: less is what the
/// forms of the others leave.
const TRACE: f64 = 1e-3;
/// Most effects that are looked for.
const MOST: usize = 12;
/// Most entries, those included that did not last.
const ROUNDS: usize = 24;
/// What the search found.
pub(super) struct Outcome {
    pub active: Vec<usize>,
    pub trial: Trial,
    pub corrected: bool,
    /// Why candidates did not stand, by index: the last reason.
    pub reasons: BTreeMap<usize, String>,
}

/// Runs the search with and without inertial corrections, and takes what costs less: a single cause is preferred to
/// corrections of many links, and these to many causes. `entered` is told how many effects stand.
pub(super) fn search(setting: &mut Setting<'_>, most: usize, entered: &dyn Fn(usize)) -> Option<Outcome> {
    if setting.free {
        return run(setting, most, true, entered);
    }
    let plain = run(setting, most, false, entered)?;
    if !setting.has_corrections() {
        return Some(plain);
    }
    let forms: Vec<_> = plain.active.iter().map(|&c| (c, setting.remembered(c))).collect();
    let corrected = run_steady(setting, most, entered)?;
    let earned = corrections_earn(setting, &corrected.active, &corrected.trial);
    if earned && corrected.trial.cost < plain.trial.cost {
        return Some(corrected);
    }
    // The nonlinear candidates as they were when the simpler answer was found.
    forms.into_iter().for_each(|(c, form)| setting.recall(c, form));
    Some(plain)
}

/// A run with inertial corrections, without effects whose size hangs on these corrections.
fn run_steady(setting: &mut Setting<'_>, most: usize, entered: &dyn Fn(usize)) -> Option<Outcome> {
    let banned = setting.banned.clone();
    let mut outcome = run(setting, most, true, entered)?;
    for _ in 0..2 {
        let Some(plain) = setting.trial(&outcome.active, false) else { break };
        let judged = setting.standing.len()..outcome.active.len();
        let unsteady = judged.rev().find(|&k| !steady(setting, &outcome.active, &outcome.trial, &plain, k));
        let Some(k) = unsteady else { break };
        setting.ban(outcome.active[k]);
        outcome = run(setting, most, true, entered)?;
    }
    setting.banned = banned;
    Some(outcome)
}

fn run(setting: &mut Setting<'_>, most: usize, corrected: bool, entered: &dyn Fn(usize)) -> Option<Outcome> {
    setting.linearise(&[], corrected);
    let mut active: Vec<usize> = setting.standing.clone();
    let standing = active.len();
    let mut trial = setting.trial(&active, corrected)?;
    setting.reference.clone_from(&trial.errors);
    let mut reasons = BTreeMap::new();
    let mut banned: Vec<usize> = Vec::new();
    // What enters may drive out what entered before, and the other way round: there is an end to it.
    for _ in 0..ROUNDS {
        if active.len() - standing >= most.min(MOST) {
            break;
        }
        let before = (active.clone(), trial.clone());
        let found = best(setting, &active, &trial, corrected, &banned, &mut reasons);
        let Some((candidate, better)) = found else { break };
        active.push(candidate);
        trial = better;
        (active, trial) = refine(setting, active, trial, candidate, corrected);
        active = prune(setting, active, trial, corrected).0;
        setting.linearise(&active, corrected);
        trial = setting.trial(&active, corrected)?;
        // What is impossible once its nonlinear part is in was never possible.
        if let Some((_, why)) = setting.impossible(&active, &trial) {
            reasons.insert(candidate, why);
            banned.push(candidate);
            (active, trial) = before;
            setting.linearise(&active, corrected);
        }
        entered(active.len() - standing);
    }
    (active, trial) = exchange(setting, active, trial, corrected);
    (active, trial) = prune(setting, active, trial, corrected);
    (active, trial) = relinearised(setting, active, trial, corrected);
    Some(Outcome { active, trial, corrected, reasons })
}

/// Drops effects that only made up for directions of a payload that were taken at another estimate.
fn relinearised(
    setting: &mut Setting<'_>,
    mut active: Vec<usize>,
    mut trial: Trial,
    corrected: bool,
) -> (Vec<usize>, Trial) {
    let mut k = setting.standing.len();
    while active.len() > 1 && k < active.len() {
        let mut fewer = active.clone();
        let gone = fewer.remove(k);
        if fewer.iter().all(|&c| setting.candidates[c].form.kind.law != Law::Payload) {
            k += 1;
            continue;
        }
        setting.linearise(&fewer, corrected);
        let without = setting.trial(&fewer, corrected).filter(|t| setting.impossible(&fewer, t).is_none());
        let rows = &setting.candidates[gone].rows;
        match without.filter(|t| t.cost <= trial.cost || is_trace(setting, rows, t, &trial)) {
            Some(better) => (active, trial) = (fewer, better),
            None => {
                setting.linearise(&active, corrected);
                k += 1;
            }
        }
    }
    (active, trial)
}

/// The candidate whose entry lowers the cost most, if any may enter.
fn best(
    setting: &Setting<'_>,
    active: &[usize],
    base: &Trial,
    corrected: bool,
    banned: &[usize],
    reasons: &mut BTreeMap<usize, String>,
) -> Option<(usize, Trial)> {
    let rough = setting.trial(active, false)?;
    let tried = parallel(setting.candidates.len(), |c| consider(setting, active, base, &rough, corrected, c));
    let mut best: Option<(usize, Trial)> = None;
    for (c, result) in tried.into_iter().enumerate().filter(|(c, _)| !banned.contains(c)) {
        match result {
            Err(reason) => {
                reasons.insert(c, reason);
            }
            Ok(trial) => {
                reasons.insert(c, "another candidate lowers the held-out error more".to_owned());
                if best.as_ref().is_none_or(|(_, b)| trial.cost < b.cost) {
                    best = Some((c, trial));
                }
            }
        }
    }
    best
}

/// Whether a candidate may enter: the reason if not.
pub(super) fn consider(
    setting: &Setting<'_>,
    active: &[usize],
    base: &Trial,
    rough: &Trial,
    corrected: bool,
    c: usize,
) -> Result<Trial, String> {
    let candidate = &setting.candidates[c];
    let same = |a: &usize| {
        let other = &setting.candidates[*a].form;
        other.kind == candidate.form.kind && other.location == candidate.form.location
    };
    if setting.banned.contains(&c) {
        return Err("its exact estimate is impossible".to_owned());
    }
    if active.iter().any(same) {
        return Err("it stands already".to_owned());
    }
    if let Some(&other) = active.iter().find(|&&a| shares(setting, a, c)) {
        return Err(format!("{} stands there and has the same part", setting.candidates[other].form.kind));
    }
    let mut with = active.to_vec();
    with.push(c);
    let inseparable = || "this data cannot tell it from what stands already".to_owned();
    let trial = setting.trial(&with, corrected).ok_or_else(inseparable)?;
    let plain = setting.trial(&with, false).ok_or_else(inseparable)?;
    if let Some((who, why)) = setting.impossible(&with, &trial) {
        let of = if who == c { String::new() } else { "with it another effect is impossible: ".to_owned() };
        return Err(format!("{of}{why}"));
    }
    if !setting.free && !steady(setting, &with, &trial, &plain, active.len()) {
        return Err("its size hangs on how masses are corrected".to_owned());
    }
    let alone = largest_fall(setting, &candidate.rows, rough, &plain);
    if alone < LEAST && !setting.free {
        return Err("it explains something only if masses move with it".to_owned());
    }
    let fall = largest_fall(setting, &candidate.rows, base, &trial).max(alone);
    if fall < LEAST {
        return Err(format!(
            "it lowers no row's held-out squared error by more than {:.1} %",
            100.0 * fall.max(0.0)
        ));
    }
    if is_trace(setting, &candidate.rows, base, &trial) {
        return Err(
            "it would remove a trace of what the other effects removed: their own inaccuracy".to_owned()
        );
    }
    if trial.cost >= base.cost {
        let (price, worth) = (setting.price(&[c]), base.cost - trial.cost + setting.price(&[c]));
        return Err(format!("the evidence for it, {worth:.0}, does not pay for its parameters, {price:.0}"));
    }
    Ok(trial)
}

/// Whether two effects at one place differ only in what neither is about: the moment of reversal, a constant.
pub(super) fn shares(setting: &Setting<'_>, a: usize, b: usize) -> bool {
    let (a, b) = (&setting.candidates[a].form, &setting.candidates[b].form);
    a.location == b.location && a.kind.resembles(b.kind)
}

/// Whether an effect's size is much the same with and without inertial corrections. Effects on links compete with
/// the corrections: theirs need not be.
fn steady(setting: &Setting<'_>, with: &[usize], corrected: &Trial, plain: &Trial, k: usize) -> bool {
    if setting.candidates[with[k]].form.location.link.is_some() {
        return true;
    }
    let (a, b) = (setting.coefficients(with, corrected, k), setting.coefficients(with, plain, k));
    let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
    let size = norm(&mut a.iter().copied()).max(norm(&mut b.iter().copied()));
    norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) <= 0.5 * size
}

/// Largest relative fall of the held-out error over some rows, scaled so that [`LEAST`] is what it takes.
fn largest_fall(setting: &Setting<'_>, rows: &[usize], before: &Trial, after: &Trial) -> f64 {
    let fall = |&r: &usize| {
        let relative = (before.errors[r] - after.errors[r]) / before.errors[r].max(f64::MIN_POSITIVE);
        relative * LEAST / least(setting.train.rows()[r].channel)
    };
    rows.iter().map(fall).fold(f64::NEG_INFINITY, f64::max)
}

/// Whether the fall of error is next to nothing beside the errors that there were without any effect.
fn is_trace(setting: &Setting<'_>, rows: &[usize], before: &Trial, after: &Trial) -> bool {
    let trace = |r: usize| TRACE * setting.reference[r];
    rows.iter().all(|&r| before.errors[r] - after.errors[r] <= trace(r))
}

/// Drops effects that no longer pay.
fn prune(
    setting: &Setting<'_>,
    mut active: Vec<usize>,
    mut trial: Trial,
    corrected: bool,
) -> (Vec<usize>, Trial) {
    loop {
        let without = (setting.standing.len()..active.len()).filter_map(|k| {
            let mut fewer = active.clone();
            let gone = fewer.remove(k);
            let t = setting.trial(&fewer, corrected)?;
            let rows = &setting.candidates[gone].rows;
            let rough = setting.trial(&fewer, false)?;
            let full = setting.trial(&active, false)?;
            let fall =
                largest_fall(setting, rows, &t, &trial).max(largest_fall(setting, rows, &rough, &full));
            let idle = t.cost <= trial.cost || fall < 0.5 * LEAST || is_trace(setting, rows, &t, &trial);
            (idle && setting.impossible(&fewer, &t).is_none()).then_some((fewer, t))
        });
        match without.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost)) {
            Some((fewer, t)) => (active, trial) = (fewer, t),
            None => return (active, trial),
        }
    }
}

/// Whether inertial corrections lower the held-out error by more than chance.
fn corrections_earn(setting: &Setting<'_>, active: &[usize], corrected: &Trial) -> bool {
    let Some(plain) = setting.trial(active, false) else { return true };
    let (with, without) = (setting.block_errors(corrected, active), setting.block_errors(&plain, active));
    (0..corrected.errors.len()).any(|row| {
        let falls: Vec<f64> = without.iter().zip(&with).map(|(a, b)| a[row] - b[row]).collect();
        let mean = falls.iter().sum::<f64>() / falls.len() as f64;
        let variance =
            falls.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / (falls.len() - 1).max(1) as f64;
        let total = mean * falls.len() as f64;
        total > LEAST * plain.errors[row] && mean > 2.5 * (variance / falls.len() as f64).sqrt()
    })
}
