//! What effects alone explain, beside effects and inertial corrections, once of these only those are left that count.
//!
//! A search with corrections of all bodies fits better than one without: they take up much that nobody can tell. Of them some
//! links' corrections are stated in the end, and then few effects may explain as much: a payload, say, where a gain of sensors
//! stood because small corrections made up for the rest.
use super::amended::Amended;
use super::fit::Term;
use super::regression::{Regression, is_held_out};
use super::search::Outcome;
use crate::diagnose::{Diagnosis, FoundEffect};
use crate::experiments::Experiment;
use crate::experiments::form::Form;

/// Most numbers of what only the simpler answer states: one effect stands for corrections, many are no simpler cause.
const FEW: usize = 4;
/// Its deviance may be larger by so much, which is chance.
const CHANCE: f64 = 6.0;

/// The answer of a search without corrections.
pub(super) struct Rival {
    outcome: Outcome,
    /// Its candidates as they were.
    forms: Vec<(usize, (Form, Vec<Term>))>,
}

impl Rival {
    /// `None`: it found nothing.
    pub fn of(
        regression: &Regression<'_>,
        outcome: Outcome,
        forms: Vec<(usize, (Form, Vec<Term>))>,
    ) -> Option<Box<Self>> {
        let found = outcome.active.len() > regression.standing.len();
        found.then(|| Box::new(Self { outcome, forms }))
    }

    /// The answer, with its candidates as they were.
    pub fn stand(self, regression: &mut Regression<'_>) -> Outcome {
        self.forms.into_iter().for_each(|(c, form)| regression.recall(c, form));
        self.outcome
    }
}

/// Whether an answer of effects alone is likelier than another one: what only it states is one effect of few numbers, and it tells the
/// rows as well.
pub(super) fn is_likelier(
    regression: &Regression<'_>,
    validation: Option<&dyn Experiment>,
    answer: &Diagnosis,
    other: &Diagnosis,
) -> bool {
    let own = own_numbers(answer, other);
    if own.is_empty() || own.iter().sum::<usize>() > FEW || own.len() > 1 + own_numbers(other, answer).len() {
        return false;
    }
    let [here, there] = [answer, other].map(|diagnosis| deviance(regression, validation, diagnosis));
    here <= there + CHANCE
}

/// How many numbers each effect has that only one answer states.
fn own_numbers(answer: &Diagnosis, other: &Diagnosis) -> Vec<usize> {
    let known = |found: &FoundEffect| {
        let is_it = |o: &FoundEffect| {
            o.effect.kind == found.effect.kind && o.effect.location == found.effect.location
        };
        other.effects.iter().any(is_it)
    };
    let own = answer.effects.iter().filter(|found| !known(found));
    own.map(|found| found.effect.kind.estimated().count()).collect()
}

/// Weighted squares of held-out errors.
fn deviance(regression: &Regression<'_>, validation: Option<&dyn Experiment>, diagnosis: &Diagnosis) -> f64 {
    let judge = validation.unwrap_or(regression.train);
    let all = diagnosis.effects.iter().chain(&diagnosis.standing).chain(&diagnosis.inertial_corrections);
    let amended = Amended::new(judge, &all.map(|found| found.effect.clone()).collect::<Vec<_>>());
    let of_row = |(row, weight): (usize, &f64)| {
        let values = amended.residual(row);
        let judged = (0..values.len()).filter(|i| validation.is_some() || is_held_out(*i, values.len()));
        weight * judged.map(|i| values[i] * values[i]).sum::<f64>()
    };
    regression.weights.iter().enumerate().map(of_row).sum()
}
