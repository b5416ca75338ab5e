//! Parsimony: of explanations that are as good, the simplest.
use super::entry::{consider, excluded};
use super::forward::Outcome;
use super::in_parts::in_parts;
use crate::diagnose::engine::equations::regression::{Regression, ScoredFit};
use crate::parallel::parallel;
use bipedc_effects::effect::{Kind, kinds};

/// Alternatives whose held-out error differs by less than this part of what the effect removes are named together.
pub(crate) const ALIKE: f64 = 0.01;
/// They are as well if blocks of the judging data disagree about which is better, up to this part.
pub(crate) const SCATTER: f64 = 0.05;
/// The same for an effect with fewer parameters to stand in another one's place.
pub(crate) const AS_GOOD: f64 = 0.001;
/// No more deviance than that is chance.
pub(crate) const CHANCE: f64 = 4.0;
/// No row's held-out squared error may grow by more than this part of it then: of an effect that removed a thousand times what noise leaves, a
/// hundredth is more than noise.
const GROWTH: f64 = 0.03;

/// Whether no row is told worse, to speak of, by one explanation than by another. Tables of some ten postures or impacts scatter more.
pub(crate) fn rows_alike(regression: &Regression<'_>, better: &ScoredFit, other: &ScoredFit) -> bool {
    rows_within(regression, better, other, &|_| GROWTH)
}

/// Whether no row's squared error is more than this part of it larger.
pub(crate) fn rows_within(
    regression: &Regression<'_>,
    better: &ScoredFit,
    other: &ScoredFit,
    growth: &dyn Fn(usize) -> f64,
) -> bool {
    let alike = |(row, (better, other)): (usize, (&f64, &f64))| *other <= (1.0 + growth(row)) * better;
    regression.is_table || better.errors.iter().zip(&other.errors).enumerate().all(alike)
}

/// Of explanations that are as good, the one with fewer effects, and on the likelier link.
pub(crate) fn simplify(regression: &Regression<'_>, outcome: &mut Outcome) {
    with_fewer_parameters(regression, outcome);
    commonest(regression, outcome);
    in_parts(regression, outcome);
    merge(regression, outcome);
    likeliest_links(regression, outcome);
}

/// Of effects in whose place another one with fewer parameters does as well, that one.
fn with_fewer_parameters(regression: &Regression<'_>, outcome: &mut Outcome) {
    for k in regression.standing.len()..outcome.active.len() {
        let here = outcome.scored.clone();
        let mine = outcome.active[k];
        replace(regression, outcome, k, &|(c, _, other), more, removed| {
            // What bodies do is known as it is: of them no part of what they remove is a form's inaccuracy.
            let exact = regression.is_of_link(mine) && regression.is_of_link(*c);
            more <= CHANCE || (!exact && more <= AS_GOOD * removed && rows_alike(regression, &here, other))
        });
    }
}

/// Kinds of friction with one parameter, and what is far commoner and the same where the load or the speed hardly changes.
const COMMONER: [(&Kind, &Kind); 2] = [
    (&kinds::LOAD_DEPENDENT_FRICTION, &kinds::COULOMB_FRICTION),
    (&kinds::QUADRATIC_DRAG, &kinds::VISCOUS_FRICTION),
];

/// Of kinds of friction that the data cannot tell apart, the commoner one.
fn commonest(regression: &Regression<'_>, outcome: &mut Outcome) {
    let form = |c: usize| &regression.candidates[c].form;
    for k in regression.standing.len()..outcome.active.len() {
        let mine = form(outcome.active[k]);
        let Some((_, commoner)) = COMMONER.into_iter().find(|(rarer, _)| mine.kind == *rarer) else {
            continue;
        };
        let mut fewer = outcome.active.clone();
        fewer.remove(k);
        let Some(bare) = regression.scored_fit(&fewer, outcome.corrected) else { continue };
        // As many parameters, so that costs compare as deviances do.
        let removed = bare.cost + regression.complexity_penalty(&[outcome.active[k]]) - outcome.scored.cost;
        let fitted = |c: usize| {
            let mut set = outcome.active.clone();
            set[k] = c;
            let scored = regression.scored_fit(&set, outcome.corrected)?;
            let more = scored.cost - outcome.scored.cost;
            let stands = more <= (ALIKE * removed).max(CHANCE)
                && rows_alike(regression, &outcome.scored, &scored)
                && regression.impossible(&set, &scored).is_none();
            stands.then_some((set, scored))
        };
        let may = |c: &usize| {
            form(*c).kind == commoner
                && form(*c).location == mine.location
                && excluded(regression, &fewer, *c).is_none()
        };
        let found = (0..regression.candidates.len()).filter(may).filter_map(fitted);
        if let Some((set, scored)) = found.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost)) {
            (outcome.active, outcome.scored) = (set, scored);
        }
    }
}

/// Puts an effect with fewer parameters at the same place in that of the `k`-th, if blocks of the judging data disagree about which
/// is better: for effects of which the data do not tell all parameters. One that `says_no_more` by its own interval stands back also
/// where the search, whose laws are smoothed, finds it a little better. Tells whether there was one.
pub(crate) fn put_simpler(
    regression: &Regression<'_>,
    outcome: &mut Outcome,
    k: usize,
    says_no_more: bool,
) -> bool {
    let here = regression.candidates[outcome.active[k]].form.location.clone();
    let (scored, active) = (outcome.scored.clone(), outcome.active.clone());
    replace(regression, outcome, k, &|(c, set, other), more, removed| {
        let chance = || regression.scatter(&scored, &active, other, set);
        regression.candidates[*c].form.location == here
            && (more <= CHANCE
                || (more <= ALIKE * removed && rows_alike(regression, &scored, other))
                || (more <= SCATTER * removed && (says_no_more || more <= chance())))
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
    let whole =
        |t: &ScoredFit, set: &[usize]| regression.whole_cost(set, t) - regression.complexity_penalty(set);
    let tried = parallel(regression.candidates.len(), |c| {
        if count(c) >= count(mine)
            || consider(regression, &fewer, &bare, &rough, outcome.corrected, c).is_err()
        {
            return None;
        }
        let mut set = outcome.active.clone();
        set[k] = c;
        let scored = regression.scored_fit(&set, outcome.corrected)?;
        let mut more = deviance(&scored, &set) - here;
        if regression.is_of_link(mine) && regression.is_of_link(c) {
            // Below the noise too: a payload is seen at more joints than a centre of mass that lies elsewhere.
            more = more.max(whole(&scored, &set) - whole(&outcome.scored, &outcome.active));
        }
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
/// of reversal, friction and a bias. And one that explains more than two others, whose entry it came too late for.
fn merge(regression: &Regression<'_>, outcome: &mut Outcome) {
    let form = |c: usize| &regression.candidates[c].form;
    let judged: Vec<usize> = outcome.active[regression.standing.len()..].to_vec();
    let pairs = judged.iter().enumerate().flat_map(|(k, &a)| judged[..k].iter().map(move |&b| [a, b]));
    for [first, second] in pairs.filter(|&[a, b]| form(a).location == form(b).location) {
        if let Some((set, scored)) = merged(regression, outcome, [first, second]) {
            (outcome.active, outcome.scored) = (set, scored);
        }
    }
}

/// The best candidate in the place of two, what is active with it, and their fit.
fn merged(
    regression: &Regression<'_>,
    outcome: &Outcome,
    pair: [usize; 2],
) -> Option<(Vec<usize>, ScoredFit)> {
    let candidate = |c: usize| &regression.candidates[c];
    let bare: Vec<usize> = outcome.active.iter().copied().filter(|c| !pair.contains(c)).collect();
    if bare.len() + 2 != outcome.active.len() {
        return None;
    }
    let deviance = |t: &ScoredFit, set: &[usize]| t.cost - regression.complexity_penalty(set);
    let without = regression.scored_fit(&bare, outcome.corrected)?;
    let apart = deviance(&outcome.scored, &outcome.active);
    let removed = deviance(&without, &bare) - apart;
    let tried = parallel(regression.candidates.len(), |c| {
        let [form, first, second] = [c, pair[0], pair[1]].map(|c| &candidate(c).form);
        let fits = form.location == first.location
            && candidate(c).parameters <= candidate(pair[0]).parameters + candidate(pair[1]).parameters
            && excluded(regression, &bare, c).is_none();
        if !fits || pair.contains(&c) {
            return None;
        }
        let set = [bare.as_slice(), &[c]].concat();
        let scored = regression.scored_fit(&set, outcome.corrected)?;
        let more = deviance(&scored, &set) - apart;
        let as_well = form.kind.is_sum_of(first.kind, second.kind) && more <= (ALIKE * removed).max(CHANCE);
        let stands =
            (as_well || scored.cost < outcome.scored.cost) && regression.impossible(&set, &scored).is_none();
        stands.then_some((set, scored))
    });
    tried.into_iter().flatten().min_by(|a, b| a.1.cost.total_cmp(&b.1.cost))
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
        let (here, active) = (outcome.scored.clone(), outcome.active.clone());
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
            let whole = |active: &[usize], t: &ScoredFit| regression.whole_cost(active, t);
            let more = (scored.cost - here.cost).max(whole(&set, &scored) - whole(&outcome.active, &here));
            let chance = || regression.scatter(&here, &active, &scored, &set);
            let as_well = more <= CHANCE
                || (more <= ALIKE * removed && rows_alike(regression, &here, &scored))
                || (more <= SCATTER * removed && more <= chance());
            if as_well && regression.impossible(&set, &scored).is_none() {
                (outcome.active, outcome.scored, mass) = (set, scored, other);
            }
        }
    }
}
