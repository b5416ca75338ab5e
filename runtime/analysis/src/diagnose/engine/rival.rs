//! What effects alone explain, beside effects and inertial corrections, once of these only those are left that count.
//!
//! A search with corrections of all bodies fits better than one without: they take up much that nobody can tell. Of them some
//! links' corrections are stated in the end, and then few effects may explain as much: a payload, say, where a gain of sensors
//! stood because small corrections made up for the rest.
use super::amended::Amended;
use super::fit::Term;
use super::regression::{Regression, is_held_out};
use super::search::Outcome;
use crate::diagnose::Diagnosis;
use crate::experiments::Experiment;
use crate::experiments::form::Form;

/// What one of the ten numbers of a correction costs, as one of an effect does.
const NUMBER: f64 = 4.0;
/// A row's held-out error may be larger by this part for an explanation with fewer numbers.
const ALIKE: f64 = 0.015;

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
    pub fn stand(self: Box<Self>, regression: &mut Regression<'_>) -> Outcome {
        self.forms.into_iter().for_each(|(c, form)| regression.recall(c, form));
        self.outcome
    }
}

/// Whether an answer is likelier than another one: it tells the rows better for what it costs, or as well with fewer numbers.
pub(super) fn is_likelier(
    regression: &Regression<'_>,
    validation: Option<&dyn Experiment>,
    answer: &Diagnosis,
    other: &Diagnosis,
) -> bool {
    if answer.effects.is_empty() {
        return false;
    }
    let [mine, its] = [answer, other].map(|diagnosis| numbers(diagnosis) as f64 * NUMBER);
    let [here, there] = [answer, other].map(|diagnosis| deviance(regression, validation, diagnosis));
    let alike = answer.rows.iter().all(|(row, fall)| {
        other.rows.get(row).is_some_and(|other| fall.after <= (1.0 + ALIKE) * other.after)
    });
    here + mine <= there + its || (mine <= its && alike)
}

/// How many numbers an answer states.
fn numbers(diagnosis: &Diagnosis) -> usize {
    let effects = diagnosis.effects.iter().map(|found| found.effect.kind.estimated().count());
    effects.sum::<usize>() + 10 * diagnosis.inertial_corrections.len()
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
