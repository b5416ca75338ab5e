//! Friction of a joint that shows only beside other friction of it.
//!
//! Dry and viscous friction come together. What the smaller one does may lie below all that a single sample's noise hides, and below what the form of a
//! large effect may leave; the larger one is then some per cent too large. Estimated together, away from reversals, thousands of samples tell both.
use super::entry::excluded;
use super::forward::Outcome;
use crate::diagnose::engine::equations::regression::Regression;
use crate::diagnose::engine::judge::significance::judged_errors;
use crate::diagnose::engine::refine::amended::Amended;
use crate::diagnose::engine::refine::estimates::{data, estimates, spread};
use crate::diagnose::engine::refine::refinement::{Refined, refine};
use crate::experiments::Experiment;
use crate::experiments::jumps::Jumps;
use bipedc_effects::effect::{Effect, Kind, Law, kinds};
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
pub(crate) fn beside_friction(
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
        let here = |c: &usize| regression.candidates[*c].form.location == *location && !declined.contains(c);
        let joined: Vec<(f64, &Kind, Outcome)> = (0..regression.candidates.len())
            .filter(here)
            .filter_map(|c| {
                let (fall, with) = joined(regression, outcome, c)?;
                Some((fall, regression.candidates[c].form.kind, with))
            })
            .collect();
        // A torque that comes late looks like damping, of either sign.
        let is_late = |(_, kind, _): &&(f64, &Kind, Outcome)| kind.law == Law::Delay;
        let late = joined.iter().filter(is_late).map(|(fall, ..)| *fall).fold(0.0, f64::max);
        let is_weak = |(fall, kind, _): &(f64, &Kind, Outcome)| WEAK.contains(kind) && *fall > late;
        let found = joined.into_iter().filter(is_weak).find_map(|(.., with)| {
            let start = estimates(regression, &with);
            let both = refine(data(regression, teaches), start, &[], spread(regression, with.corrected));
            is_sure(regression, (&refined, &both), k).then_some((with, both))
        });
        if let Some((with, both)) = found {
            (outcome.active, outcome.scored) = (with.active, with.scored);
            refined = both;
        }
    }
    refined
}

/// All that stands with another candidate, and by how much deviance that lowers what the data that judge show of a row, if they may confirm it.
fn joined(regression: &Regression<'_>, outcome: &Outcome, c: usize) -> Option<(f64, Outcome)> {
    if excluded(regression, &outcome.active, c).is_some() {
        return None;
    }
    let active = [outcome.active.as_slice(), &[c]].concat();
    let scored = regression.scored_fit(&active, outcome.corrected)?;
    let fall = |&row: &usize| (outcome.scored.errors[row] - scored.errors[row]) * regression.weights[row];
    let fall = regression.candidates[c].rows.iter().map(fall).fold(f64::NEG_INFINITY, f64::max);
    if fall < CONFIRMED || regression.impossible(&active, &scored).is_some() {
        return None;
    }
    let outcome =
        Outcome { active, scored, corrected: outcome.corrected, reasons: BTreeMap::new(), rival: None };
    Some((fall, outcome))
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
