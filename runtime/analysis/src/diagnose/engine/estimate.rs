//! Estimates of effects that are given, where nothing is searched for.
use super::equations::regression::{Regression, is_held_out};
use super::judge::conclusion::Conclusion;
use super::refine::estimates::{data, spread};
use super::refine::refinement::{Data, refine};
use super::run::{Options, places_of};
use super::search::corrections::settle;
use super::search::forward::Outcome;
use super::words::text;
use crate::diagnose::Diagnosis;
use crate::experiments::Experiment;
use bipedc_effects::effect::Effect;
use std::collections::BTreeMap;

/// What the parameters that stand in given effects are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stated {
    /// They are so, but for those of a user's own formula, where they are where the search starts.
    Held,
    /// Where the search starts, if nothing better is known.
    Start,
}

/// Estimates parameters of given effects; those that are not stated are found.
///
/// As [`super::diagnose`], but nothing else is tried and nothing is dropped.
pub fn estimate(
    train: &dyn Experiment,
    validation: Option<&dyn Experiment>,
    (effects, stated): (&[Effect], Stated),
    options: &Options,
) -> Diagnosis {
    let mut regression = Regression::new(train, validation, &places_of(effects), options, &|_| ());
    regression.linearise(&[], regression.has_corrections());
    let mut starts: Vec<Effect> = effects.iter().map(|effect| start(&regression, effect)).collect();
    let held = if stated == Stated::Held { held_of(effects) } else { Vec::new() };
    for (index, name) in &held {
        starts[*index].parameters.insert(name.clone(), effects[*index].value(name));
    }
    let corrected = regression.has_corrections();
    let Some(scored) = regression.scored_fit(&[], corrected) else { return Diagnosis::default() };
    let outcome = Outcome { active: Vec::new(), scored, corrected, reasons: BTreeMap::new(), rival: None };
    let teaches = |sample: usize, n: usize| !regression.own_blocks || !is_held_out(sample, n);
    let data = Data { held: &held, ..data(&regression, &teaches) };
    let refined = refine(data, starts, &[], spread(&regression, corrected));
    let settled = settle(data, refined, &regression.spread, regression.free);
    let mut diagnosis =
        Conclusion { regression: &regression, outcome: &outcome, settled: &settled }.write(train, validation);
    diagnosis.conclude();
    diagnosis.summary = text::summary(&diagnosis);
    diagnosis
}

/// Parameters that stand in effects and are not a user's own: of which effect, and names.
fn held_of(effects: &[Effect]) -> Vec<(usize, String)> {
    let of_effect = |(index, effect): (usize, &Effect)| {
        let stated = effect.parameters.keys().filter(|name| !effect.own.contains_key(*name));
        stated.map(|name| (index, name.clone())).collect::<Vec<_>>()
    };
    effects.iter().enumerate().flat_map(of_effect).collect()
}

/// Where the final estimate of an effect starts.
fn start(regression: &Regression<'_>, effect: &Effect) -> Effect {
    let stated = |name: &str| effect.parameters.get(name).copied();
    let forms = regression.candidates.iter().enumerate();
    let mine = forms.filter(|(_, c)| c.form.is_of(effect) && c.form.fixed.is_empty());
    let best = mine
        .filter_map(|(index, _)| {
            let scored = regression.scored_fit(&[index], regression.has_corrections())?;
            regression.impossible(&[index], &scored).is_none().then_some((index, scored))
        })
        .min_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    let mut start = match best {
        Some((index, scored)) => {
            regression.candidates[index].form.effect(regression.coefficients(&[index], &scored, 0))
        }
        None => effect.clone(),
    };
    (start.name, start.torque, start.own) = (effect.name.clone(), effect.torque.clone(), effect.own.clone());
    for (name, value) in &effect.parameters {
        start.parameters.entry(name.clone()).or_insert(*value);
    }
    // A kind that no column finds starts from what is stated, or from the middle of what is usual.
    for parameter in effect.kind.estimated() {
        let (low, high) = effect.plausible(parameter.name);
        let middle = 0.1 * (low + high);
        let value = stated(parameter.name).unwrap_or(middle);
        start.parameters.entry(parameter.name.to_owned()).or_insert(value);
    }
    start
}
