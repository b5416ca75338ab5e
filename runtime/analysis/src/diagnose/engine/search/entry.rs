//! Whether a candidate may stand beside others: what it must lower, and what it must not be.
use super::forward::Outcome;
use crate::diagnose::engine::equations::regression::{Regression, ScoredFit};
use crate::diagnose::engine::judge::significance::NO_CHANCE;
use crate::experiments::Channel;
use bipedc_effects::effect::{Acts, Kind, Law, Location};

/// Part of a row's held-out squared error that an effect must remove.
pub(crate) const LEAST: f64 = 0.02;

/// The same of what lies between motor and link, where stops and gears always give way a little, and beside play that torques alone
/// show, where links meet stops in a way that no law of the library tells.
const LEAST_TRANSMISSION: f64 = 0.15;

/// Part of a row's held-out squared error that an effect of a kind must remove beside play at these joints.
pub(crate) fn least(regression: &Regression<'_>, row: usize, kind: &Kind, play: &[&Location]) -> f64 {
    let between = regression.train.rows()[row].channel == Channel::Transmission
        || kind.law.acts() == Acts::Transmission;
    let behind = |location: &&Location| regression.is_behind_play(row, location);
    if between || play.iter().any(behind) { LEAST_TRANSMISSION } else { LEAST }
}

/// Where candidates are play.
pub(crate) fn play<'r>(regression: &'r Regression<'_>, active: &[usize]) -> Vec<&'r Location> {
    let forms = active.iter().map(|&c| &regression.candidates[c].form);
    forms.filter(|form| form.kind.law == Law::Backlash).map(|form| &form.location).collect()
}

/// Part of the squared error that a row had before any effect entered which each effect must remove: less is what the
/// forms of the others leave.
const TRACE: f64 = 1e-3;

/// Part of the noise's squares by which a row must be above it for what clears it to be more than a trace,
const HEARD: f64 = 0.15;
/// and part of that which it must remove.
const CLEARS: f64 = 0.6;

/// Part of what is left above the noise that an effect must remove to be more than what corrections leave.
const SETTLES: f64 = 0.7;

/// Why a candidate does not enter that stands, or whose turn it is not: such reasons hold for a step of a search alone.
const STANDS: &str = "it stands already";

pub(crate) const ANOTHER: &str = "another candidate lowers the held-out error more";

pub(crate) const PASSING: [&str; 2] = [STANDS, ANOTHER];

/// Why a candidate does not stand that makes the equations singular.
pub(crate) const INSEPARABLE: &str = "this data cannot tell it from what stands already";

/// Why a candidate cannot stand beside these, whatever it lowers.
pub(crate) fn excluded(regression: &Regression<'_>, active: &[usize], c: usize) -> Option<String> {
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
pub(crate) fn consider(
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
    let hangs = || {
        !steady(regression, &with, &scored, &plain, active.len()) && !settles(regression, c, base, &scored)
    };
    if !regression.free && hangs() {
        return Err("its size hangs on how masses are corrected".to_owned());
    }
    let play = play(regression, active);
    let alone = largest_fall(regression, (c, &play), rough, &plain);
    let fall = largest_fall(regression, (c, &play), base, &scored).max(alone);
    if fall < LEAST {
        return Err(format!(
            "it lowers no row's held-out squared error by more than {:.1} %",
            100.0 * fall.max(0.0)
        ));
    }
    if alone < LEAST && !regression.free {
        return Err("it explains something only if masses move with it".to_owned());
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
pub(crate) fn shares(regression: &Regression<'_>, a: usize, b: usize) -> bool {
    let (a, b) = (&regression.candidates[a].form, &regression.candidates[b].form);
    a.location == b.location && a.kind.resembles(b.kind)
}

/// Whether the first is play that torques alone show, and the second a delay or a spring where it is felt: when the link meets its
/// stops is known to some milliseconds, and what is left then looks like either.
pub(crate) fn mistimes(regression: &Regression<'_>, play: usize, c: usize) -> bool {
    let [play, other] = [play, c].map(|c| &regression.candidates[c]);
    play.form.kind.law == Law::Backlash
        && matches!(other.form.kind.law, Law::Delay | Law::SeriesElasticity)
        && other.rows.iter().any(|&row| regression.is_behind_play(row, &play.form.location))
}

/// Whether an effect's size is much the same with and without inertial corrections. Effects on links compete with
/// the corrections: theirs need not be.
pub(crate) fn steady(
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

/// Whether an effect removes most of what is left above the noise of a row that inertial corrections and the other effects leave loud: they took up what they
/// could of the effect, so that its size is another one without them.
pub(crate) fn settles(regression: &Regression<'_>, c: usize, before: &ScoredFit, after: &ScoredFit) -> bool {
    let above = |scored: &ScoredFit, row: usize| scored.errors[row] - regression.noise_squares[row];
    let settles = |&row: &usize| {
        regression.is_loud(row, before) && above(after, row) < (1.0 - SETTLES) * above(before, row)
    };
    regression.candidates[c].rows.iter().any(settles)
}

/// The same of the `k`-th effect of what was found, beside all others.
pub(crate) fn is_settling(regression: &Regression<'_>, outcome: &Outcome, k: usize) -> bool {
    if !outcome.corrected {
        return false;
    }
    let mut fewer = outcome.active.clone();
    let c = fewer.remove(k);
    let before = regression.scored_fit(&fewer, true);
    before.is_some_and(|before| settles(regression, c, &before, &outcome.scored))
}

/// Largest relative fall of the held-out error over a candidate's rows, beside play, scaled so that [`LEAST`] is what it takes.
pub(crate) fn largest_fall(
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

/// Whether the fall of error is next to nothing beside the errors that there were without any effect: unless it is most of what is left
/// above the noise, for what forms leave does not go with another effect so closely; or corrections made up for the effect that no description needs.
pub(crate) fn is_trace(
    regression: &Regression<'_>,
    rows: &[usize],
    before: &ScoredFit,
    after: &ScoredFit,
) -> bool {
    let above = |scored: &ScoredFit, row: usize| scored.errors[row] - regression.noise_squares[row];
    let clears = |r: usize| {
        let left = above(before, r);
        left > HEARD * regression.noise_squares[r] && above(after, r) < (1.0 - CLEARS) * left
    };
    let trace = |r: usize| TRACE * regression.reference[r];
    let unburdens = before.fit.prior - after.fit.prior > NO_CHANCE;
    !unburdens && rows.iter().all(|&r| before.errors[r] - after.errors[r] <= trace(r) && !clears(r))
}
