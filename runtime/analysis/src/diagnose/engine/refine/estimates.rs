//! From what a search found to exact estimates: where these start, and from what they are made.
use super::refinement::Data;
use crate::diagnose::engine::equations::block_equations::Spread;
use crate::diagnose::engine::equations::regression::{Regression, is_held_out};
use crate::diagnose::engine::search::forward::Outcome;
use bipedc_effects::effect::Effect;

/// What the estimates of a regression are made from.
pub(crate) fn data<'r>(
    regression: &'r Regression<'_>,
    teaches: &'r (dyn Fn(usize, usize) -> bool + Sync),
) -> Data<'r> {
    let judges = if regression.own_blocks { is_held_out } else { |_, _| true };
    Data {
        experiment: regression.train,
        weights: &regression.weights,
        teaches,
        judge: regression.judge,
        judges,
        held: &[],
        at_corners: false,
    }
}

/// How far inertial parameters may move, if they may.
pub(crate) fn spread<'r>(regression: &'r Regression<'_>, corrected: bool) -> Option<&'r Spread> {
    corrected.then_some(&regression.spread)
}

/// The effects of a search, with the values of its fit; those of the description as they are described, so that estimates of what is true
/// stay there.
pub(crate) fn from_description(regression: &Regression<'_>, outcome: &Outcome) -> Vec<Effect> {
    let mut effects = estimates(regression, outcome);
    for (effect, was) in effects.iter_mut().zip(&regression.described) {
        if let Some(was) = was {
            effect.clone_from(was);
        }
    }
    effects
}

/// The effects of a search, with the values of its fit.
pub(crate) fn estimates(regression: &Regression<'_>, outcome: &Outcome) -> Vec<Effect> {
    (0..outcome.active.len())
        .map(|k| {
            let coefficients = regression.coefficients(&outcome.active, &outcome.scored, k);
            regression.candidates[outcome.active[k]].form.effect(coefficients)
        })
        .collect()
}
