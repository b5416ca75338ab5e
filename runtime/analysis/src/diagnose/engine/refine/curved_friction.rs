//! Stribeck curves that have faded before a joint is as fast as it usually is.
//!
//! Estimates leave samples near reversals out, where filters smear what jumps. A curve that is over within a fraction of the usual speed is seen there
//! and nowhere else, so that dry friction stands for it. Where a joint moves smoothly its filtered speed is its speed, and those samples tell as well as
//! others: a curve that clears what dry friction leaves of them in the data that judge takes its place.
use super::estimates::{data, spread};
use super::refinement::{Data, Refined, refine};
use super::sharp_friction::{rows_of, sharper};
use crate::diagnose::engine::equations::regression::Regression;
use crate::diagnose::engine::judge::significance::{JudgedError, NO_CHANCE, judged_errors, without_sticking};
use crate::diagnose::engine::search::forward::Outcome;
use crate::experiments::corners::SMOOTHING;
use crate::experiments::jumps::Jumps;
use crate::experiments::signals::velocity_of;
use bipedc_effects::effect::{Effect, kinds};

/// Speeds at which a curve may have faded, as quantiles of the joint's own.
const STARTS: [f64; 4] = [0.02, 0.05, 0.1, 0.25];
/// Squares that dry friction leaves are so many times those of a curve that takes its place, where that leaves more than noise.
const CLEARS: f64 = 3.0;
/// Friction at rest is so many times that at speed, and their difference so many of its half widths.
const LARGER: f64 = 1.1;
const SURE: f64 = 2.0;

/// Curves, or dry friction with a sharper sign, in the place of dry friction that leaves more than noise near reversals.
pub(crate) fn curved(
    regression: &Regression<'_>,
    outcome: &mut Outcome,
    mut refined: Refined,
    teaches: &(dyn Fn(usize, usize) -> bool + Sync),
) -> Refined {
    for k in regression.standing.len()..outcome.active.len() {
        let dry = &kinds::COULOMB_FRICTION;
        if refined.effects[k].kind != dry {
            continue;
        }
        let Some((curve, halves)) = curve_of(regression, outcome, (&refined, k), teaches) else { continue };
        if curve.kind == dry || stands(regression, outcome, k) {
            refined.effects[k] = curve;
            refined.half_width[k] = halves;
        }
    }
    refined
}

type HalfWidths = Vec<(String, f64)>;

/// What clears what the `k`-th effect leaves of its joint's row, if there is such a thing: dry friction with a sharper sign, or a curve.
fn curve_of(
    regression: &Regression<'_>,
    outcome: &Outcome,
    (refined, k): (&Refined, usize),
    teaches: &(dyn Fn(usize, usize) -> bool + Sync),
) -> Option<(Effect, HalfWidths)> {
    let dry = &refined.effects[k];
    let row = rows_of(regression, dry).next()?;
    let change = regression.spread.change(&refined.corrections);
    // How a joint begins to move out of a rest, where friction is anything between its bounds, filters tell roughly.
    let departures = Jumps::at_departures(regression.judge);
    let left = |effects: &[Effect]| judged_errors(regression, effects, &change, Some(&departures));
    let try_again = |start: Effect| estimated(regression, outcome, (refined, k), start, teaches);
    // A sign that is sharper than the library's leaves no room for a curve.
    let (sharp, was) = {
        let mut stands = (None, left(&refined.effects));
        let as_found = (sharper(dry), refined.half_width[k].clone());
        for sharp in [Some(as_found), try_again(sharper(dry))].into_iter().flatten() {
            let is = left(&with(refined, k, sharp.0.clone()));
            if stands.1[row].deviance_above(&is[row]) > NO_CHANCE {
                stands = (Some(sharp), is);
            }
        }
        stands
    };
    if was[row].is_noise() {
        return sharp;
    }
    let Some(speeds) = speeds(regression, row) else { return sharp };
    let starts = STARTS.iter().flat_map(|part| {
        let at = speeds[((speeds.len() - 1) as f64 * part) as usize];
        let curve = curve_at(dry, at);
        // How sharply the sign changes nobody knows either.
        [sharper(&curve), curve]
    });
    let found = starts.filter_map(|start| {
        let (curve, halves) = try_again(start)?;
        let is = left(&with(refined, k, curve.clone()));
        (is_told(&curve, &halves) && clears(&was, &is, row)).then_some((is, curve, halves))
    });
    let best = found.min_by(|a, b| a.0[row].deviance_above(&b.0[row]).total_cmp(&0.0));
    best.map(|(_, curve, halves)| (curve, halves)).or(sharp)
}

/// The effects with another one in the place of the `k`-th.
fn with(refined: &Refined, k: usize, other: Effect) -> Vec<Effect> {
    let mut effects = refined.effects.clone();
    effects[k] = other;
    effects
}

/// How fast the joint of a row is where it moves, ascending.
fn speeds(regression: &Regression<'_>, row: usize) -> Option<Vec<f64>> {
    let velocity = velocity_of(regression.train, row)?;
    let told = without_sticking(regression.train, row, &velocity, |_| true);
    let mut speeds: Vec<f64> = told.map(f64::abs).filter(|speed| *speed > 0.0).collect();
    speeds.sort_unstable_by(f64::total_cmp);
    (!speeds.is_empty()).then_some(speeds)
}

/// A curve that has faded at a speed, in the place of dry friction.
fn curve_at(dry: &Effect, speed: f64) -> Effect {
    let torque = dry.value("torque");
    let start = [
        ("coulomb", torque),
        ("static", 1.5 * torque),
        ("stribeck_velocity", speed),
        (SMOOTHING, dry.value(SMOOTHING)),
    ];
    let mut curve = Effect::new(&kinds::STRIBECK_FRICTION, dry.location.clone(), &start);
    curve.sliding = dry.sliding;
    curve
}

/// A curve in the place of the `k`-th effect, from all samples at which its joint moves; everything else stays as it is.
fn estimated(
    regression: &Regression<'_>,
    outcome: &Outcome,
    (refined, k): (&Refined, usize),
    curve: Effect,
    teaches: &(dyn Fn(usize, usize) -> bool + Sync),
) -> Option<(Effect, HalfWidths)> {
    let mut others = refined.effects.clone();
    others.remove(k);
    let data = Data { at_corners: true, ..data(regression, teaches) };
    let mut found = refine(data, vec![curve], &others, spread(regression, outcome.corrected));
    Some((found.effects.pop()?, found.half_width.pop()?))
}

/// Whether a curve is one beyond doubt.
fn is_told(curve: &Effect, halves: &HalfWidths) -> bool {
    let [coulomb, at_rest] = ["coulomb", "static"].map(|name| curve.value(name));
    let half = |wanted: &str| halves.iter().find(|(name, _)| name == wanted).map_or(f64::INFINITY, |h| h.1);
    let known = halves.iter().all(|(_, half)| half.is_finite());
    known
        && coulomb > 0.0
        && at_rest > LARGER * coulomb
        && at_rest - coulomb > SURE * half("coulomb").hypot(half("static"))
        && curve.value("stribeck_velocity") > SURE * half("stribeck_velocity")
}

/// Whether a curve clears what dry friction leaves of a row, and nothing is left of others for it.
fn clears(was: &[JudgedError], is: &[JudgedError], row: usize) -> bool {
    let falls = was[row].deviance_above(&is[row]) > NO_CHANCE
        && (is[row].is_noise() || was[row].is_worse_than(&is[row], CLEARS));
    falls && was.iter().zip(is).all(|(was, is)| !is.is_worse_than(was, 1.0 + 1e-3))
}

/// Lets a curve stand for the `k`-th effect of what a search found; tells whether there is one.
fn stands(regression: &Regression<'_>, outcome: &mut Outcome, k: usize) -> bool {
    let here = &regression.candidates[outcome.active[k]].form.location;
    let is_curve = |c: &usize| {
        let form = &regression.candidates[*c].form;
        form.kind == &kinds::STRIBECK_FRICTION && form.location == *here
    };
    let fits = |c: usize| {
        let mut active = outcome.active.clone();
        active[k] = c;
        let scored = regression.scored_fit(&active, outcome.corrected)?;
        Some((active, scored))
    };
    let found = (0..regression.candidates.len()).filter(is_curve).filter_map(fits);
    let best = found.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    let Some((active, scored)) = best else { return false };
    (outcome.active, outcome.scored) = (active, scored);
    true
}
