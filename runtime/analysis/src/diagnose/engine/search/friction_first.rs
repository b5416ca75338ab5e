//! Searches that begin with dry friction at every joint, where inertias are free.
use super::entry::excluded;
use super::forward::{Outcome, cheaper, run, run_without};
use crate::diagnose::engine::equations::regression::Regression;
use bipedc_effects::effect::kinds;

/// A run with free inertias, and another one that begins with dry friction at every joint: what one joint's friction makes free inertias do at
/// others costs more on the data that judge than it explains, so that none shows alone where all of them do together.
pub(crate) fn with_friction_first(
    regression: &mut Regression<'_>,
    most: usize,
    entered: &dyn Fn(usize),
) -> Option<Outcome> {
    let one_by_one = run(regression, most, true, entered);
    let rubbing = rubbing(regression);
    if rubbing.len() < 2 || rubbing.len() > most {
        return one_by_one;
    }
    let from_friction = |regression: &mut Regression<'_>| {
        Some(run_without(regression, most, true, (&[], &rubbing), entered)?.0)
    };
    match one_by_one {
        Some(first) => Some(cheaper(regression, first, from_friction)),
        None => from_friction(regression),
    }
}

/// Dry friction at every joint where it is possible and nothing like it stands, as far as it can be fitted together.
fn rubbing(regression: &Regression<'_>) -> Vec<usize> {
    let standing = &regression.standing;
    let of_kind = |c: &usize| {
        regression.candidates[*c].form.kind == &kinds::COULOMB_FRICTION
            && excluded(regression, standing, *c).is_none()
    };
    let location = |c: usize| &regression.candidates[c].form.location;
    let mut all: Vec<usize> = Vec::new();
    for c in (0..regression.candidates.len()).filter(of_kind) {
        if !all.iter().any(|&other| location(other) == location(c)) {
            all.push(c);
        }
    }
    // The one that may not be goes, and the others are fitted anew.
    loop {
        let with = [standing.as_slice(), &all].concat();
        let Some(scored) = regression.scored_fit(&with, true) else { return Vec::new() };
        match regression.impossible(&with, &scored) {
            Some((who, _)) => all.retain(|&c| c != who),
            None => return all,
        }
    }
}
