//! Payloads that were found before something that acts beside them: their distance took its place.
//!
//! A rotor of 0.03 kg m² at a vertical axis is found as a payload half a metre out, and what that does elsewhere is taken back by another centre of
//! mass of the same link. Each of the two looks well without the other, so that no exchange of one effect leads away from them.
use super::entry::excluded;
use crate::diagnose::engine::equations::fit::{Candidate, TermProducts};
use crate::diagnose::engine::equations::regression::{Regression, ScoredFit};
use crate::experiments::form::{Form, Search};
use crate::parallel::parallel;
use bipedc_effects::effect::Law;

/// Most such exchanges in one search.
const MOST: usize = 4;
/// More deviance than that is no chance.
const CHANCE: f64 = 4.0;

/// What is active once the payload is estimated anew beside the newcomer.
struct Found {
    active: Vec<usize>,
    payload: (usize, Candidate, Vec<TermProducts>),
    scored: ScoredFit,
}

/// Puts what acts at a joint in the place of what takes back a payload's distance, or beside a payload that is further out than links are,
/// the payload estimated anew with each, as long as that costs less or has fewer parameters and tells the rows as well.
pub(crate) fn beside_payloads(
    regression: &mut Regression<'_>,
    (mut active, mut scored): (Vec<usize>, ScoredFit),
    (corrected, most, banned): (bool, usize, &[usize]),
) -> (Vec<usize>, ScoredFit) {
    for _ in 0..MOST {
        let is_free = active.len() < most + regression.standing.len();
        let Some(found) = best(regression, (&active, &scored), (corrected, is_free, banned)) else { break };
        let before: Vec<_> = active.iter().map(|&c| (c, regression.remembered(c))).collect();
        let (payload, candidate, products) = found.payload;
        regression.replace(payload, Some((candidate, products)));
        regression.linearise(&found.active, corrected);
        let fitted = regression.scored_fit(&found.active, corrected).filter(|fitted| {
            is_better(regression, (&active, &scored), (&found.active, fitted))
                && regression.impossible(&found.active, fitted).is_none()
        });
        let Some(fitted) = fitted else {
            before.into_iter().for_each(|(c, form)| regression.recall(c, form));
            // Those that do not stand were taken beside what is refused.
            regression.linearise(&active, corrected);
            break;
        };
        (active, scored) = (found.active, fitted);
    }
    (active, scored)
}

fn parameters(regression: &Regression<'_>, set: &[usize]) -> usize {
    set.iter().map(|&c| regression.candidates[c].parameters).sum()
}

/// Whether one set costs less than another, or has fewer parameters and no more deviance than by chance.
fn is_better(
    regression: &Regression<'_>,
    (active, scored): (&[usize], &ScoredFit),
    (set, fitted): (&[usize], &ScoredFit),
) -> bool {
    let deviance = |set: &[usize], fit: &ScoredFit| fit.cost - regression.complexity_penalty(set);
    let fewer = parameters(regression, set) < parameters(regression, active);
    fitted.cost < scored.cost || (fewer && deviance(set, fitted) <= deviance(active, scored) + CHANCE)
}

/// The best of the sets with another effect beside a payload: with the fewest parameters, and of these the one that costs least.
fn best(
    regression: &Regression<'_>,
    (active, scored): (&[usize], &ScoredFit),
    (corrected, is_free, banned): (bool, bool, &[usize]),
) -> Option<Found> {
    let judged = &active[regression.standing.len()..];
    let is_payload = |c: &usize| regression.candidates[*c].form.kind.law == Law::Payload;
    let payloads = judged.iter().copied().filter(is_payload);
    let bases = payloads.flat_map(|payload| {
        bases(regression, (active, scored), payload).into_iter().map(move |base| (payload, base))
    });
    let tried = bases.flat_map(|(payload, base)| {
        let may = newcomers(regression, payload, &base);
        may.into_iter().map(move |c| (payload, [base.as_slice(), &[c]].concat()))
    });
    let tried = tried.filter(|(_, set)| is_free || set.len() <= active.len());
    let tried = tried.filter(|(_, set)| set.last().is_some_and(|c| !banned.contains(c)));
    let tried: Vec<(usize, Vec<usize>)> = tried.collect();
    let found = parallel(tried.len(), |i| {
        let (payload, set) = &tried[i];
        let near = at_the_centre(regression, (active, scored), *payload);
        let (candidate, products) = regression.linearised(*payload, set, corrected, near)?;
        let scored_anew = regression.scored_fit_with(set, (*payload, &candidate, &products), corrected)?;
        is_better(regression, (active, scored), (set, &scored_anew)).then(|| Found {
            active: set.clone(),
            payload: (*payload, candidate, products),
            scored: scored_anew,
        })
    });
    found.into_iter().flatten().min_by(|a, b| {
        let count = |found: &Found| parameters(regression, &found.active);
        count(a).cmp(&count(b)).then(a.scored.cost.total_cmp(&b.scored.cost))
    })
}

/// A payload's form where it is no further out than the link's frame.
fn at_the_centre(
    regression: &Regression<'_>,
    (active, scored): (&[usize], &ScoredFit),
    payload: usize,
) -> Option<Form> {
    let place = active.iter().position(|c| *c == payload)?;
    let [mass, moments @ ..] = regression.coefficients(active, scored, place) else { return None };
    let coefficients = [&[*mass], &*vec![0.0; moments.len()]].concat();
    regression.candidates[payload].form.linearised(regression.train, &coefficients)
}

/// What stands beside a payload once something else of its link is gone; all that stands, if the payload is further out than links are.
fn bases(
    regression: &Regression<'_>,
    (active, scored): (&[usize], &ScoredFit),
    payload: usize,
) -> Vec<Vec<usize>> {
    let form = |c: usize| &regression.candidates[c].form;
    let beside = |c: &usize| {
        *c != payload
            && !regression.stands(*c)
            && form(*c).location == form(payload).location
            && matches!(form(*c).search, Search::Inertial(_))
    };
    let without = |gone: usize| active.iter().copied().filter(|c| *c != gone).collect();
    let mut bases: Vec<Vec<usize>> = active.iter().copied().filter(beside).map(without).collect();
    let place = active.iter().position(|c| *c == payload).unwrap_or_default();
    let effect = form(payload).effect(regression.coefficients(active, scored, place));
    let reach = regression.candidates[payload].form.reach;
    let is_far = |name: &str| {
        let (low, high) = reach.usual(&effect, name);
        !(low..=high).contains(&effect.value(name))
    };
    if ["x", "y", "z"].into_iter().any(is_far) {
        bases.push(active.to_vec());
    }
    bases
}

/// What may act beside a payload: effects at joints that show in the same rows.
fn newcomers(regression: &Regression<'_>, payload: usize, base: &[usize]) -> Vec<usize> {
    let rows = &regression.candidates[payload].rows;
    let may = |&c: &usize| {
        let candidate = &regression.candidates[c];
        candidate.form.location.joint.is_some()
            && candidate.form.location.other_joint.is_none()
            && candidate.rows.iter().any(|r| rows.contains(r))
            && excluded(regression, base, c).is_none()
    };
    (0..regression.candidates.len()).filter(may).collect()
}
