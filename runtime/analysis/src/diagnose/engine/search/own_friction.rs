//! What a joint does itself, taken for a coupling with another one that moves much as it does, or that moves seldom while it does.
//!
//! In a squat ankles turn back half a knee's motion. A coupling whose friction follows the difference of both speeds then has a sharper sign than the knee's own
//! smooth one, and lowers the error by that alone.
use super::forward::Outcome;
use crate::diagnose::engine::equations::regression::Regression;
use crate::diagnose::engine::judge::significance::{judged_errors, says_no_more};
use crate::diagnose::engine::refine::estimates::{data, spread};
use crate::diagnose::engine::refine::refinement::{Refined, refine};
use crate::diagnose::engine::refine::sharp_friction::{ALIKE, rows_of, sharper};
use crate::experiments::corners::SMOOTHING;
use crate::experiments::jumps::Jumps;
use bipedc_effects::effect::{Effect, Kind, Location, kinds};

/// Two joints move much as one does if one tells the other's angle but for this part of its variance.
const ALIKE_IN_MOTION: f64 = 0.5;

/// Puts what a joint does itself in the place of its coupling (the `k`-th effect), or dry friction in that of a kind with more numbers that says no more, if all rows are told as well.
/// Tells whether it did.
pub(crate) fn put_own(
    regression: &Regression<'_>,
    outcome: &mut Outcome,
    (refined, k): (&Refined, usize),
    teaches: &(dyn Fn(usize, usize) -> bool + Sync),
) -> bool {
    let Some(own) = (match says_no_more(refined, k) {
        true => Some(vec![dry(&refined.effects[k])]),
        false => of_coupling(regression, &refined.effects[k]),
    }) else {
        return false;
    };
    let mut active = outcome.active.clone();
    active.remove(k);
    let mut effects = refined.effects.clone();
    effects.remove(k);
    for effect in own {
        let stands = |other: &Effect| other.kind == effect.kind && other.location == effect.location;
        if effects.iter().any(stands) {
            continue;
        }
        let is_it = |c: &usize| {
            let form = &regression.candidates[*c].form;
            form.is_of(&effect) && form.fixed.is_empty() && !regression.banned.contains(c)
        };
        let Some(c) = (0..regression.candidates.len()).find(is_it) else { return false };
        active.push(c);
        effects.push(effect);
    }
    let Some(scored) = regression.scored_fit(&active, outcome.corrected) else { return false };
    let other = refine(data(regression, teaches), effects, &[], spread(regression, outcome.corrected));
    // When a joint turns back the filter tells roughly.
    let jumps = Jumps::of(regression.judge, &[refined.effects.as_slice(), &other.effects].concat());
    let [with, without] = [refined, &other].map(|fit| {
        judged_errors(regression, &fit.effects, &regression.spread.change(&fit.corrections), Some(&jumps))
    });
    if !rows_of(regression, &refined.effects[k])
        .all(|row| !without[row].is_worse_than(&with[row], 1.0 + ALIKE))
    {
        return false;
    }
    (outcome.active, outcome.scored) = (active, scored);
    true
}

/// Dry friction of one size in the place of one whose sizes in both directions, or at rest and at speed, are the same.
fn dry(effect: &Effect) -> Effect {
    let torque = match effect.kind == &kinds::STRIBECK_FRICTION {
        true => effect.value("coulomb"),
        false => 0.5 * (effect.value("positive") + effect.value("negative")),
    };
    let same = [("torque", torque), (SMOOTHING, effect.value(SMOOTHING))];
    let mut dry = Effect::new(&kinds::COULOMB_FRICTION, effect.location.clone(), &same);
    dry.sliding = effect.sliding;
    dry
}

/// What a joint does itself in the place of its coupling.
fn of_coupling(regression: &Regression<'_>, coupling: &Effect) -> Option<Vec<Effect>> {
    // The sign of a difference of speeds is that of the joint's own wherever the other one is slower or rests.
    let turns = coupling.kind == &kinds::COUPLING
        && coupling.value("coulomb") != 0.0
        && coupling.value("differential") != 0.0;
    let times = proportion(regression, coupling).or_else(|| turns.then_some(0.0));
    own(coupling, times?)
}

/// How many times as far as its own joint the other joint of a coupling moves, if both move much alike.
fn proportion(regression: &Regression<'_>, coupling: &Effect) -> Option<f64> {
    let Location { joint: Some(own), other_joint: Some(other), .. } = &coupling.location else { return None };
    if coupling.kind != &kinds::COUPLING {
        return None;
    }
    let place = |name: &String| regression.train.joints().iter().position(|joint| joint == name);
    let motion = regression.train.motion();
    let from_mean = |joint: usize| {
        let angles = motion.positions.get(joint)?;
        let mean = angles.iter().sum::<f64>() / angles.len().max(1) as f64;
        Some(angles.iter().map(|angle| angle - mean).collect::<Vec<f64>>())
    };
    let (own, other) = (from_mean(place(own)?)?, from_mean(place(other)?)?);
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let times = product(&own, &other) / product(&own, &own);
    let rest: Vec<f64> = own.iter().zip(&other).map(|(own, other)| other - times * own).collect();
    (product(&rest, &rest) < ALIKE_IN_MOTION * product(&other, &other)).then_some(times)
}

/// What the joint does itself where the other one moves so many times as far, as far as that is possible: whether it tells as much is judged.
fn own(coupling: &Effect, times: f64) -> Option<Vec<Effect>> {
    let parts: [(&Kind, &str, f64); 3] = [
        (
            &kinds::COULOMB_FRICTION,
            "torque",
            coupling.value("coulomb") * (times + coupling.value("differential")).signum(),
        ),
        (&kinds::VISCOUS_FRICTION, "damping", times * coupling.value("damping")),
        (&kinds::ROTOR_INERTIA, "inertia", times * coupling.value("inertia")),
    ];
    let place = Location { joint: coupling.location.joint.clone(), ..Location::default() };
    let parts: Vec<_> = parts.into_iter().filter(|(.., value)| *value > 0.0).collect();
    (!parts.is_empty()).then(|| {
        let effect = |(kind, name, value)| {
            let mut effect = Effect::new(kind, place.clone(), &[(name, value)]);
            effect.sliding = coupling.sliding;
            if kind == &kinds::COULOMB_FRICTION { sharper(&effect) } else { effect }
        };
        parts.into_iter().map(effect).collect()
    })
}
