//! How sharply dry friction changes its sign.
//!
//! The library's sign is a smooth one, over a width of speeds. Where joints start and stop again and again the true one may be sharper, and a
//! Stribeck curve that has faded within that width makes up for it: friction many times as large as at speed, where no sample tells it.
use super::refinement::Refined;
use crate::diagnose::engine::equations::regression::Regression;
use crate::diagnose::engine::judge::significance::{JudgedError, NO_CHANCE, judged_errors};
use crate::diagnose::engine::search::forward::Outcome;
use crate::experiments::corners::{SMOOTHING, WIDTHS};
use bipedc_effects::effect::{Effect, Simulation, kinds};

/// A sharper sign is so much narrower.
const SHARPER: f64 = 0.1;
/// Part by which what is left may be larger without the curve.
pub(crate) const ALIKE: f64 = 0.05;

/// Whether the `k`-th effect is a Stribeck curve that has faded where the sign has hardly changed, and dry friction with a sharper sign leaves as little.
pub(crate) fn is_a_sharp_sign(regression: &Regression<'_>, refined: &Refined, k: usize) -> bool {
    let curve = &refined.effects[k];
    if curve.kind != &kinds::STRIBECK_FRICTION
        || curve.value("stribeck_velocity") > WIDTHS * curve.value(SMOOTHING)
    {
        return false;
    }
    let same = [("torque", curve.value("coulomb")), (SMOOTHING, curve.value(SMOOTHING))];
    let mut dry = Effect::new(&kinds::COULOMB_FRICTION, curve.location.clone(), &same);
    dry.sliding = curve.sliding;
    let (with, without) = (left(regression, refined, &[]), left(regression, refined, &[(k, sharper(&dry))]));
    rows_of(regression, curve).all(|row| !without[row].is_worse_than(&with[row], 1.0 + ALIKE))
}

/// Dry friction in the place of a Stribeck curve that is a sharp sign. Tells whether there was any.
pub(crate) fn put_dry(regression: &Regression<'_>, outcome: &mut Outcome, k: usize) -> bool {
    let here = &regression.candidates[outcome.active[k]].form.location;
    let is_dry = |c: &usize| {
        let form = &regression.candidates[*c].form;
        form.kind == &kinds::COULOMB_FRICTION && form.location == *here
    };
    let fits = |c: usize| {
        let mut active = outcome.active.clone();
        active[k] = c;
        let scored = regression.scored_fit(&active, outcome.corrected)?;
        Some((active, scored))
    };
    let found = (0..regression.candidates.len()).filter(is_dry).find_map(fits);
    let Some((active, scored)) = found else { return false };
    (outcome.active, outcome.scored) = (active, scored);
    true
}

/// Dry friction changes its sign sharply where the data that judge say so.
pub(crate) fn sharpened(regression: &Regression<'_>, mut refined: Refined) -> Refined {
    for k in regression.standing.len()..refined.effects.len() {
        let effect = &refined.effects[k];
        if !matches!(effect.kind.simulation, Simulation::Dry(_)) || effect.kind == &kinds::STRIBECK_FRICTION {
            continue;
        }
        let sharp = sharper(effect);
        let (was, is) = (left(regression, &refined, &[]), left(regression, &refined, &[(k, sharp.clone())]));
        if rows_of(regression, effect).any(|row| was[row].deviance_above(&is[row]) > NO_CHANCE) {
            refined.effects[k] = sharp;
        }
    }
    refined
}

pub(crate) fn sharper(effect: &Effect) -> Effect {
    let mut sharp = effect.clone();
    sharp.parameters.insert(SMOOTHING.to_owned(), SHARPER * effect.value(SMOOTHING));
    sharp
}

/// What effects leave of the data that judge, some of them being others.
fn left(regression: &Regression<'_>, refined: &Refined, others: &[(usize, Effect)]) -> Vec<JudgedError> {
    let mut effects = refined.effects.clone();
    others.iter().for_each(|(k, effect)| effects[*k] = effect.clone());
    judged_errors(regression, &effects, &regression.spread.change(&refined.corrections), None)
}

/// Rows of an effect's joint.
pub(crate) fn rows_of<'r>(
    regression: &'r Regression<'_>,
    effect: &Effect,
) -> impl Iterator<Item = usize> + use<'r> {
    let joint = effect.location.joint.clone();
    let rows = regression.train.rows().iter().enumerate();
    rows.filter(move |(_, row)| row.joint == joint).map(|(row, _)| row)
}
