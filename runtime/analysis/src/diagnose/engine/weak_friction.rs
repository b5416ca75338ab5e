//! Friction of a joint that shows only beside other friction of it.
//!
//! Dry and viscous friction come together. What the smaller one does may lie below all that a single sample's noise hides, and below what the form of a
//! large effect may leave; the larger one is then some per cent too large. Estimated together, away from reversals, thousands of samples tell both.
use super::amended::Amended;
use super::entry::excluded;
use super::estimates::{data, estimates, spread};
use super::refinement::{Refined, refine};
use super::regression::Regression;
use super::search::Outcome;
use super::significance::judged_errors;
use crate::experiments::Experiment;
use crate::experiments::jumps::Jumps;
use bipedc_effects::effect::{Effect, Kind, kinds};
use std::collections::BTreeMap;

/// What it may stand beside,
const FRICTION: [&Kind; 4] = [
    &kinds::COULOMB_FRICTION,
    &kinds::ASYMMETRIC_COULOMB_FRICTION,
    &kinds::STRIBECK_FRICTION,
    &kinds::VISCOUS_FRICTION,
];
/// and what it may be: laws with one parameter.
const WEAK: [&Kind; 2] = [&kinds::COULOMB_FRICTION, &kinds::VISCOUS_FRICTION];
/// It is no chance where it is so many times as large as the half width of its 95 % interval: six standard deviations.
const SURE: f64 = 3.0;
/// The data that judge must confirm it by so much deviance, two standard deviations.
const CONFIRMED: f64 = 4.0;
/// Part of the other friction's torque below which it may be that one's inaccuracy.
const INACCURATE: f64 = 0.015;

/// Adds friction beside friction that was found, estimated anew with all that stands; `declined`: candidates that are not tried.
pub(super) fn beside_friction(
    regression: &Regression<'_>,
    outcome: &mut Outcome,
    mut refined: Refined,
    (teaches, declined): (&(dyn Fn(usize, usize) -> bool + Sync), &[usize]),
) -> Refined {
    for k in regression.standing.len()..outcome.active.len() {
        if !FRICTION.contains(&refined.effects[k].kind) {
            continue;
        }
        let location = &refined.effects[k].location;
        let may = |&c: &usize| {
            let form = &regression.candidates[c].form;
            WEAK.contains(&form.kind) && form.location == *location && !declined.contains(&c)
        };
        let tried: Vec<usize> = (0..regression.candidates.len()).filter(may).collect();
        let found = tried.into_iter().find_map(|c| {
            let with = joined(regression, outcome, c)?;
            let data = data(regression, teaches);
            let both = refine(data, estimates(regression, &with), &[], spread(regression, with.corrected));
            is_sure(regression, (&refined, &both), k).then_some((with, both))
        });
        if let Some((with, both)) = found {
            (outcome.active, outcome.scored) = (with.active, with.scored);
            refined = both;
        }
    }
    refined
}

/// All that stands with another candidate, if the data that judge may confirm it.
fn joined(regression: &Regression<'_>, outcome: &Outcome, c: usize) -> Option<Outcome> {
    if excluded(regression, &outcome.active, c).is_some() {
        return None;
    }
    let active = [outcome.active.as_slice(), &[c]].concat();
    let scored = regression.scored_fit(&active, outcome.corrected)?;
    let fall = |&row: &usize| (outcome.scored.errors[row] - scored.errors[row]) * regression.weights[row];
    let confirmed = regression.candidates[c].rows.iter().any(|row| fall(row) > CONFIRMED);
    let possible = || regression.impossible(&active, &scored).is_none();
    (confirmed && possible()).then(|| Outcome {
        active,
        scored,
        corrected: outcome.corrected,
        reasons: BTreeMap::new(),
        rival: None,
    })
}

/// Whether the last of both estimates' effects is there beyond doubt, beside the `k`-th: by its interval, by what it lowers of the data that judge away from jumps, and by
/// its size.
fn is_sure(regression: &Regression<'_>, (alone, both): (&Refined, &Refined), k: usize) -> bool {
    let (Some(new), Some(halves)) = (both.effects.last(), both.half_width.last()) else { return false };
    let told = halves.iter().all(|(name, half)| half.is_finite() && new.value(name) > SURE * half);
    if !told || halves.is_empty() {
        return false;
    }
    let jumps = Jumps::of(regression.judge, &both.effects);
    let left = |refined: &Refined| {
        let change = regression.spread.change(&refined.corrections);
        judged_errors(regression, &refined.effects, &change, Some(&jumps))
    };
    let (was, is) = (left(alone), left(both));
    let row = regression.train.rows().iter().position(|row| row.joint == new.location.joint);
    let Some(row) = row.filter(|row| was[*row].deviance_above(&is[*row]) > CONFIRMED) else { return false };
    let size = |effect: &Effect| {
        let with = Amended::new(regression.judge, std::slice::from_ref(effect));
        let torque =
            with.residual(row).iter().zip(regression.judge.residual(row)).map(|(a, b)| (a - b).powi(2));
        torque.sum::<f64>().sqrt()
    };
    size(new) > INACCURATE * size(&both.effects[k])
}
