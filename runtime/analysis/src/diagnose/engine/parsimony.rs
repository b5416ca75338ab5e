//! Parsimony: of explanations that are as good, the simplest.
use super::parallel::parallel;
use super::regression::{Regression, ScoredFit};
use super::search::{Outcome, consider};

/// Alternatives whose held-out error differs by less than this part of what the effect removes are named together.
pub(super) const ALIKE: f64 = 0.01;
/// They are as well if blocks of the judging data disagree about which is better, up to this part.
pub(super) const SCATTER: f64 = 0.05;
/// The same for an effect with fewer parameters to stand in another one's place.
const AS_GOOD: f64 = 0.001;

/// Of explanations that are as good, the one with fewer effects, and on the likelier link.
pub(super) fn simplify(regression: &Regression<'_>, outcome: &mut Outcome) {
    with_fewer_parameters(regression, outcome);
    merge(regression, outcome);
    likeliest_links(regression, outcome);
}

/// Of effects in whose place another one with fewer parameters does as well, that one.
fn with_fewer_parameters(regression: &Regression<'_>, outcome: &mut Outcome) {
    for k in regression.standing.len()..outcome.active.len() {
        replace(regression, outcome, k, &|_, more, removed| more <= (AS_GOOD * removed).max(4.0));
    }
}

/// Puts an effect with fewer parameters at the same place in that of the `k`-th, if blocks of the judging data disagree about which
/// is better: for effects of which the data do not tell all parameters. Tells whether there was one.
pub(super) fn put_simpler(regression: &Regression<'_>, outcome: &mut Outcome, k: usize) -> bool {
    let here = regression.candidates[outcome.active[k]].form.location.clone();
    let (scored, active) = (outcome.scored.clone(), outcome.active.clone());
    replace(regression, outcome, k, &|(c, set, other), more, removed| {
        let chance = || regression.scatter(&scored, &active, other, set);
        regression.candidates[*c].form.location == here
            && (more <= (ALIKE * removed).max(4.0) || (more <= SCATTER * removed && more <= chance()))
    })
}

/// A candidate, all that is active with it, and their fit.
type Replacement = (usize, Vec<usize>, ScoredFit);

/// Puts the candidate with the fewest parameters in the place of the `k`-th effect that is `as_good`, told how much more deviance there is
/// with it and how much the effect removes. Tells whether there was one.
fn replace(
    regression: &Regression<'_>,
    outcome: &mut Outcome,
    k: usize,
    as_good: &(dyn Fn(&Replacement, f64, f64) -> bool + Sync),
) -> bool {
    let deviance = |t: &ScoredFit, set: &[usize]| t.cost - regression.complexity_penalty(set);
    let count = |c: usize| regression.candidates[c].parameters;
    let mut fewer = outcome.active.clone();
    let mine = fewer.remove(k);
    let (Some(bare), Some(rough)) =
        (regression.scored_fit(&fewer, outcome.corrected), regression.scored_fit(&fewer, false))
    else {
        return false;
    };
    let here = deviance(&outcome.scored, &outcome.active);
    let removed = deviance(&bare, &fewer) - here;
    let tried = parallel(regression.candidates.len(), |c| {
        if count(c) >= count(mine)
            || consider(regression, &fewer, &bare, &rough, outcome.corrected, c).is_err()
        {
            return None;
        }
        let mut set = outcome.active.clone();
        set[k] = c;
        let scored = regression.scored_fit(&set, outcome.corrected)?;
        let more = deviance(&scored, &set) - here;
        let replacement = (c, set, scored);
        as_good(&replacement, more, removed).then_some(replacement)
    });
    let least =
        |a: &Replacement, b: &Replacement| count(a.0).cmp(&count(b.0)).then(a.2.cost.total_cmp(&b.2.cost));
    let Some((_, set, scored)) = tried.into_iter().flatten().min_by(least) else { return false };
    (outcome.active, outcome.scored) = (set, scored);
    true
}

/// One effect for two at its place that are nearly it together: friction that differs by direction is, but for the moment
/// of reversal, friction and a bias.
fn merge(regression: &Regression<'_>, outcome: &mut Outcome) {
    let form = |c: usize| &regression.candidates[c].form;
    let first = regression.standing.len();
    let judged: Vec<usize> = outcome.active[first..].to_vec();
    let here = |a: usize, b: usize| form(a).location == form(b).location;
    let pairs = judged.iter().flat_map(|&a| judged.iter().map(move |&b| (a, b)));
    for (first, second) in pairs.filter(|&(a, b)| a != b && here(a, b)) {
        let mut all = 0..regression.candidates.len();
        let is_both =
            |&c: &usize| here(c, first) && form(c).kind.is_sum_of(form(first).kind, form(second).kind);
        let Some(both) = all.find(is_both) else { continue };
        let bare: Vec<usize> =
            outcome.active.iter().copied().filter(|&c| c != first && c != second).collect();
        let set: Vec<usize> = bare.iter().copied().chain([both]).collect();
        let (Some(without), Some(scored)) =
            (regression.scored_fit(&bare, outcome.corrected), regression.scored_fit(&set, outcome.corrected))
        else {
            continue;
        };
        let deviance = |t: &ScoredFit, set: &[usize]| t.cost - regression.complexity_penalty(set);
        let (apart, merged) = (deviance(&outcome.scored, &outcome.active), deviance(&scored, &set));
        let removed = deviance(&without, &bare) - apart;
        if merged <= apart + (ALIKE * removed).max(4.0) && regression.impossible(&set, &scored).is_none() {
            (outcome.active, outcome.scored) = (set, scored);
        }
    }
}

/// Of links on which an effect explains as much, the heaviest is the likeliest to carry it; the others are named as
/// alternatives.
fn likeliest_links(regression: &Regression<'_>, outcome: &mut Outcome) {
    for k in regression.standing.len()..outcome.active.len() {
        let form = &regression.candidates[outcome.active[k]].form;
        let Some(mut mass) = regression.carrier(outcome.active[k]) else { continue };
        let mut fewer = outcome.active.clone();
        fewer.remove(k);
        let Some(bare) = regression.scored_fit(&fewer, outcome.corrected) else { continue };
        let removed = bare.cost
            - regression.complexity_penalty(&fewer)
            - (outcome.scored.cost - regression.complexity_penalty(&outcome.active));
        let limit = outcome.scored.cost + (ALIKE * removed).max(4.0);
        let kind = form.kind;
        for c in 0..regression.candidates.len() {
            let Some(other) = regression.carrier(c).filter(|m| *m > mass) else { continue };
            let mut set = outcome.active.clone();
            set[k] = c;
            let unwanted = regression.banned.contains(&c) || outcome.active.contains(&c);
            if regression.candidates[c].form.kind != kind || unwanted {
                continue;
            }
            let Some(scored) = regression.scored_fit(&set, outcome.corrected) else { continue };
            if scored.cost <= limit && regression.impossible(&set, &scored).is_none() {
                (outcome.active, outcome.scored, mass) = (set, scored, other);
            }
        }
    }
}
