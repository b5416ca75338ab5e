//! What effects alone explain, beside effects and inertial corrections, once of these only those are left that count.
//!
//! A search with corrections of all bodies fits better than one without: they take up much that nobody can tell. Of them some
//! links' corrections are stated in the end, and then few effects may explain as much: a payload, say, where a gain of sensors
//! stood because small corrections made up for the rest.
use super::forward::Outcome;
use super::parsimony::ALIKE;
use crate::diagnose::engine::equations::fit::Term;
use crate::diagnose::engine::equations::regression::{Regression, is_held_out};
use crate::diagnose::engine::refine::amended::Amended;
use crate::diagnose::{Diagnosis, FoundEffect};
use crate::experiments::Experiment;
use crate::experiments::form::Form;
use crate::robot::link_inertias::CadError;
use bipedc_effects::effect::{Effect, kinds};

/// Most numbers of what only the simpler answer states: one effect stands for corrections, many are no simpler cause.
const FEW: usize = 4;
/// Its deviance may be larger by so much, which is chance.
const CHANCE: f64 = 6.0;
/// A mass is usually off by no more than so many of its standard deviations.
const USUALLY: f64 = 2.0;

/// The answer of the search that was not taken.
pub(crate) struct Rival {
    outcome: Outcome,
    /// Its candidates as they were.
    forms: Vec<(usize, (Form, Vec<Term>))>,
}

impl Rival {
    /// What was found, and its candidates as they were then.
    pub fn of(outcome: Outcome, forms: Vec<(usize, (Form, Vec<Term>))>) -> Box<Self> {
        Box::new(Self { outcome, forms })
    }

    /// The answer, with its candidates as they were.
    pub fn stand(self, regression: &mut Regression<'_>) -> Outcome {
        self.forms.into_iter().for_each(|(c, form)| regression.recall(c, form));
        self.outcome
    }
}

/// Whether an answer of effects alone is likelier than another one: what only it states is one effect of few numbers, and it tells the
/// rows as well.
pub(crate) fn is_likelier(
    regression: &Regression<'_>,
    validation: Option<&dyn Experiment>,
    answer: &Diagnosis,
    other: &Diagnosis,
) -> bool {
    if !answer.inertial_corrections.is_empty() {
        return false;
    }
    let own = own_numbers(answer, other);
    if own.is_empty() || own.iter().sum::<usize>() > FEW || own.len() > 1 + own_numbers(other, answer).len() {
        return false;
    }
    let [here, there] = [answer, other].map(|diagnosis| left(regression, validation, stated(diagnosis)));
    let heavier = is_heavier(regression, answer, other);
    here - there <= if heavier { alike(regression, validation, (answer, other), here) } else { CHANCE }
}

/// Whether a payload stands for the correction of its own link alone, of which it is a special case, and is heavier than a description is
/// usually off.
fn is_heavier(regression: &Regression<'_>, answer: &Diagnosis, other: &Diagnosis) -> bool {
    let (own, theirs) = (own(answer, other), own(other, answer));
    let [found] = own[..] else { return false };
    let link =
        found.effect.location.link.as_deref().and_then(|name| regression.train.link_inertias()?.link(name));
    let usual = link.map_or(f64::INFINITY, |link| USUALLY * CadError::default().mass * link.mass);
    let same = |other: &&FoundEffect| corrects(other) && other.effect.location == found.effect.location;
    found.effect.kind == &kinds::PAYLOAD
        && !theirs.is_empty()
        && theirs.iter().all(same)
        && found.effect.value("mass") > usual
}

/// What only the answer states and what only another one states in its place, effects of the one and inertial corrections of
/// the other, where both tell the rows as well: the held-out deviance is the same but for chance, or a hundredth of what they remove.
pub(crate) fn indistinguishable(
    regression: &Regression<'_>,
    validation: Option<&dyn Experiment>,
    answer: &Diagnosis,
    other: &Diagnosis,
) -> Option<Vec<Vec<FoundEffect>>> {
    let (here, there) = (own(answer, other), own(other, answer));
    let is_corrected = |side: &[&FoundEffect]| side.iter().any(|found| corrects(found));
    if here.is_empty() || there.is_empty() || is_corrected(&here) == is_corrected(&there) {
        return None;
    }
    let of = |answer: &Diagnosis| left(regression, validation, stated(answer));
    let error = of(answer);
    let is_alike = (of(other) - error).abs() <= alike(regression, validation, (answer, other), error);
    let owned = |side: Vec<&FoundEffect>| side.into_iter().cloned().collect();
    is_alike.then(|| vec![owned(here), owned(there)])
}

/// By how much the deviance of an answer, given too, may differ from that of another one as good: by chance, or by a hundredth of what it removes
/// with what only it states.
fn alike(
    regression: &Regression<'_>,
    validation: Option<&dyn Experiment>,
    (answer, other): (&Diagnosis, &Diagnosis),
    error: f64,
) -> f64 {
    let here = own(answer, other);
    let without = stated(answer).filter(|found| !here.contains(found));
    let removed = left(regression, validation, without) - error;
    (ALIKE * removed).max(CHANCE)
}

/// The deviance with some of what answers state.
fn left<'d>(
    regression: &Regression<'_>,
    validation: Option<&dyn Experiment>,
    found: impl Iterator<Item = &'d FoundEffect>,
) -> f64 {
    let effects: Vec<Effect> = found.map(|found| found.effect.clone()).collect();
    deviance(regression, validation, &effects)
}

fn corrects(found: &FoundEffect) -> bool {
    found.effect.kind == &kinds::INERTIAL_CORRECTION
}

/// All that an answer states.
fn stated(answer: &Diagnosis) -> impl Iterator<Item = &FoundEffect> {
    answer.effects.iter().chain(&answer.standing).chain(&answer.inertial_corrections)
}

/// What only one answer states.
fn own<'d>(answer: &'d Diagnosis, other: &Diagnosis) -> Vec<&'d FoundEffect> {
    let is_it = |a: &FoundEffect, b: &FoundEffect| {
        a.effect.kind == b.effect.kind && a.effect.location == b.effect.location
    };
    stated(answer).filter(|found| !stated(other).any(|o| is_it(found, o))).collect()
}

/// How many numbers each effect has that only one answer states.
fn own_numbers(answer: &Diagnosis, other: &Diagnosis) -> Vec<usize> {
    let effects = own(answer, other).into_iter().filter(|found| !corrects(found));
    effects.map(|found| found.effect.kind.estimated().count()).collect()
}

/// Weighted squares of held-out errors.
fn deviance(regression: &Regression<'_>, validation: Option<&dyn Experiment>, effects: &[Effect]) -> f64 {
    let judge = validation.unwrap_or(regression.train);
    let amended = Amended::new(judge, effects);
    let of_row = |(row, weight): (usize, &f64)| {
        let values = amended.residual(row);
        let judged = (0..values.len()).filter(|i| validation.is_some() || is_held_out(*i, values.len()));
        weight * judged.map(|i| values[i] * values[i]).sum::<f64>()
    };
    regression.weights.iter().enumerate().map(of_row).sum()
}
