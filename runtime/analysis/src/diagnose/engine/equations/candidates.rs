//! Which effects a search tries, in which forms.
use super::block_equations::Spread;
use super::fit::Candidate;
use crate::experiments::Experiment;
use crate::experiments::form::{Column, Form, Search};
use crate::parallel::parallel;
use bipedc_effects::effect::{Kind, Law, Location};

/// All forms of all kinds and places, those that are named as alternatives only last.
pub(crate) fn all_forms(experiment: &dyn Experiment, places: &[(&'static Kind, Location)]) -> Vec<Form> {
    let searched = parallel(places.len(), |i| forms_of(experiment, places[i].0, &places[i].1));
    let payloads = places.iter().filter(|(kind, _)| kind.law == Law::Payload);
    searched
        .into_iter()
        .flatten()
        .chain(payloads.filter_map(|(_, at)| Form::mass_only(experiment, at)))
        .collect()
}

/// Forms with their columns, numbered in order; those that show nowhere are left out.
pub(crate) fn candidates_of(
    experiment: &dyn Experiment,
    forms: Vec<Form>,
    columns: &[Vec<Column>],
    spread: &Spread,
) -> Vec<Candidate> {
    let mut next = 0;
    let mut candidates = Vec::with_capacity(forms.len());
    for (form, columns) in forms.into_iter().zip(columns) {
        let ids: Vec<usize> = (next..next + columns.len()).collect();
        next += columns.len();
        let rows = touched(&form, columns, experiment);
        let idle = columns.iter().filter(|column| column.is_empty()).count();
        if !rows.is_empty() {
            candidates.push(Candidate::new(form, &ids, rows, spread, idle));
        }
    }
    candidates
}

fn forms_of(experiment: &dyn Experiment, kind: &'static Kind, location: &Location) -> Vec<Form> {
    let guess = experiment.guess(kind, location).zip(kind.search.nonlinear);
    let guess = guess.and_then(|(effect, name)| effect.parameters.get(name).copied());
    match experiment.seeds(kind, location).or(guess.map(|value| vec![value])) {
        Some(seeds) => {
            seeds.into_iter().filter_map(|seed| Form::new(experiment, kind, location, seed)).collect()
        }
        None => Form::all(experiment, kind, location),
    }
}

/// Rows that a form can change.
fn touched(form: &Form, columns: &[Column], experiment: &dyn Experiment) -> Vec<usize> {
    let mut rows: Vec<usize> = match &form.search {
        Search::Probes(_) => columns.iter().flatten().map(|(row, _)| *row).collect(),
        Search::Inertial(directions) => (0..experiment.rows().len())
            .filter(|&row| {
                experiment.inertial(row).is_some_and(|inertial| {
                    inertial.columns.iter().any(|&c| directions.iter().any(|d| d[c] != 0.0))
                })
            })
            .collect(),
    };
    rows.sort_unstable();
    rows.dedup();
    rows
}
