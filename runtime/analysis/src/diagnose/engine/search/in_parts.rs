//! An error of a link's inertia that is no more than rotors of the joints that carry it.
//!
//! Where the axes of the first two joints of an arm are perpendicular, rotors of both do what one error of the second link's inertia does, diag(a, a, b): six
//! numbers that lower the error at both joints at once enter before one number that lowers it at one.
use super::entry::excluded;
use super::forward::Outcome;
use super::parsimony::{AS_GOOD, CHANCE, rows_alike};
use crate::diagnose::engine::equations::regression::{Regression, ScoredFit};
use crate::parallel::parallel;
use bipedc_effects::effect::kinds;

/// Most rotors in the place of one error.
const PARTS: usize = 3;

/// Puts rotors of joints in the place of an error of a link's inertia, where they have fewer parameters together and explain as much.
pub(crate) fn in_parts(regression: &Regression<'_>, outcome: &mut Outcome) {
    let mut k = regression.standing.len();
    while k < outcome.active.len() {
        match parts(regression, outcome, k) {
            Some((set, scored)) => (outcome.active, outcome.scored) = (set, scored),
            None => k += 1,
        }
    }
}

/// What is active with rotors in the place of the `k`-th effect, and their fit.
fn parts(regression: &Regression<'_>, outcome: &Outcome, k: usize) -> Option<(Vec<usize>, ScoredFit)> {
    let mut set = outcome.active.clone();
    let mine = set.remove(k);
    if regression.candidates[mine].form.kind != &kinds::INERTIA_ERROR {
        return None;
    }
    let bare = regression.scored_fit(&set, outcome.corrected)?;
    let deviance = |set: &[usize], t: &ScoredFit| t.cost - regression.complexity_penalty(set);
    let whole =
        |set: &[usize], t: &ScoredFit| regression.whole_cost(set, t) - regression.complexity_penalty(set);
    let here = deviance(&outcome.active, &outcome.scored);
    let below = whole(&outcome.active, &outcome.scored);
    let removed = deviance(&set, &bare) - here;
    let mut left = regression.candidates[mine].parameters - 1;
    for _ in 0..PARTS {
        let (part, scored) = best_part(regression, (&set, outcome.corrected), mine, left)?;
        set.push(part);
        left -= regression.candidates[part].parameters;
        let more = (deviance(&set, &scored) - here).max(whole(&set, &scored) - below);
        let alike = more <= AS_GOOD * removed && rows_alike(regression, &outcome.scored, &scored);
        if (more <= CHANCE || alike) && regression.impossible(&set, &scored).is_none() {
            return Some((set, scored));
        }
    }
    None
}

/// The rotor that lowers the cost most where an error of an inertia is seen.
fn best_part(
    regression: &Regression<'_>,
    (set, corrected): (&[usize], bool),
    mine: usize,
    most: usize,
) -> Option<(usize, ScoredFit)> {
    let rows = &regression.candidates[mine].rows;
    let tried = parallel(regression.candidates.len(), |c| {
        let candidate = &regression.candidates[c];
        let may = candidate.form.kind == &kinds::ROTOR_INERTIA
            && candidate.parameters <= most
            && candidate.rows.iter().any(|row| rows.contains(row))
            && excluded(regression, set, c).is_none();
        let scored = may.then(|| regression.scored_fit(&[set, &[c]].concat(), corrected)).flatten()?;
        Some((c, scored))
    });
    tried.into_iter().flatten().min_by(|a, b| a.1.cost.total_cmp(&b.1.cost))
}
