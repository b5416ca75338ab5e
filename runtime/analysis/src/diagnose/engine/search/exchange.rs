//! The best small set at every joint, and exchanges of one effect for another.
use super::entry::{consider, excluded, mistimes, shares};
use crate::diagnose::engine::equations::regression::{Regression, ScoredFit};
use crate::parallel::parallel;

/// Candidates of a joint that are combined.
const POOL: usize = 12;
/// Forms of one kind at a joint that are combined with those of others, where neither shows alone.
const STARTS: usize = 3;
/// Part of a row's held-out squared error that two effects must remove where neither shows alone.
const TOGETHER: f64 = 0.3;

/// The best set of up to three effects at the place of the newcomer, or of what stands there and two more; everything
/// elsewhere kept.
pub(crate) fn best_set(
    regression: &Regression<'_>,
    active: Vec<usize>,
    scored: ScoredFit,
    newcomer: usize,
    corrected: bool,
) -> (Vec<usize>, ScoredFit) {
    let Some(joint) = regression.candidates[newcomer].form.location.joint.clone() else {
        return (active, scored);
    };
    let here = |c: usize| {
        regression.candidates[c].form.location.joint.as_ref() == Some(&joint) && !regression.stands(c)
    };
    let elsewhere: Vec<usize> = active.iter().copied().filter(|&c| !here(c)).collect();
    let pool = pool(regression, &elsewhere, &active, &here, corrected);
    let mut sets: Vec<Vec<usize>> = Vec::new();
    for i in 0..pool.len() {
        sets.push(vec![pool[i]]);
        for j in 0..i {
            sets.push(vec![pool[i], pool[j]]);
            for k in 0..j {
                sets.push(vec![pool[i], pool[j], pool[k]]);
            }
        }
    }
    // And what stands there with two more: some effects show only together.
    let own: Vec<usize> = active.iter().copied().filter(|&c| here(c)).collect();
    for i in 0..pool.len() {
        for j in 0..i {
            if own.len() > 1 && !own.contains(&pool[i]) && !own.contains(&pool[j]) {
                sets.push(own.iter().copied().chain([pool[i], pool[j]]).collect());
            }
        }
    }
    let distinct = |set: &[usize]| {
        let form = |c: usize| &regression.candidates[c].form;
        set.iter().enumerate().all(|(n, &a)| {
            set[..n].iter().all(|&b| {
                !shares(regression, a, b) && !mistimes(regression, a, b) && !mistimes(regression, b, a)
            }) && set[..n]
                .iter()
                .all(|&b| form(a).kind != form(b).kind || form(a).location != form(b).location)
        })
    };
    sets.retain(|set| distinct(set));
    let tried = parallel(sets.len(), |i| {
        let all: Vec<usize> = elsewhere.iter().chain(&sets[i]).copied().collect();
        let t = regression.scored_fit(&all, corrected)?;
        regression.impossible(&all, &t).is_none().then_some((all, t))
    });
    tried
        .into_iter()
        .flatten()
        .fold((active, scored), |best, other| if other.1.cost < best.1.cost { other } else { best })
}

/// The candidates at a place that do best alone, one per kind and place, and those that stand there.
fn pool(
    regression: &Regression<'_>,
    elsewhere: &[usize],
    active: &[usize],
    here: &(dyn Fn(usize) -> bool + Sync),
    corrected: bool,
) -> Vec<usize> {
    let local: Vec<usize> =
        (0..regression.candidates.len()).filter(|&c| here(c) && !regression.banned.contains(&c)).collect();
    let costs = parallel(local.len(), |i| {
        let all: Vec<usize> = elsewhere.iter().copied().chain([local[i]]).collect();
        regression.scored_fit(&all, corrected).map_or(f64::INFINITY, |t| t.cost)
    });
    let mut ranked: Vec<(usize, f64)> = local.into_iter().zip(costs).collect();
    ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut pool: Vec<usize> = active.iter().copied().filter(|&c| here(c)).collect();
    let mut couplings = 0;
    for (c, _) in ranked {
        let form = &regression.candidates[c].form;
        let known = pool.iter().any(|&p| {
            let other = &regression.candidates[p].form;
            other.kind == form.kind && other.location == form.location
        });
        let is_coupling = form.location.other_joint.is_some();
        if known || (is_coupling && couplings >= 2) {
            continue;
        }
        couplings += usize::from(is_coupling);
        pool.push(c);
        if pool.len() >= POOL + 2 {
            break;
        }
    }
    pool
}

/// Two effects in the place of what stands at a joint, if together they explain what neither does alone, as dry friction and a delay
/// that work against each other: the newcomers, all that is active with them, and their fit. Only where more is left than noise.
pub(crate) fn pair(
    regression: &Regression<'_>,
    active: &[usize],
    scored: &ScoredFit,
    corrected: bool,
    banned: &[usize],
) -> Option<(Vec<usize>, Vec<usize>, ScoredFit)> {
    let rough = regression.scored_fit(active, false)?;
    let rows = regression.train.rows();
    let loud = (0..rows.len()).filter(|&r| regression.is_loud(r, scored));
    let pairs: Vec<(usize, Vec<usize>, [usize; 2])> = loud
        .filter_map(|row| rows[row].joint.as_ref().map(|joint| (row, joint)))
        .flat_map(|(row, joint)| {
            let here = |c: usize| regression.candidates[c].form.location.joint.as_ref() == Some(joint);
            let kept = |c: &usize| regression.stands(*c) || !here(*c);
            let elsewhere: Vec<usize> = active.iter().copied().filter(kept).collect();
            let free = |c: usize| !banned.contains(&c) && excluded(regression, &elsewhere, c).is_none();
            let local = forms_of(regression, joint, (&elsewhere, corrected), &free);
            let all = (0..local.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
            all.map(|(i, j)| (row, elsewhere.clone(), [local[i], local[j]])).collect::<Vec<_>>()
        })
        .collect();
    let tried = parallel(pairs.len(), |i| {
        let (row, elsewhere, [a, b]) = &pairs[i];
        let (row, a, b) = (*row, *a, *b);
        let kind = |c: usize| regression.candidates[c].form.kind;
        let looks_like = shares(regression, a, b) || mistimes(regression, a, b) || mistimes(regression, b, a);
        if kind(a) == kind(b) || looks_like {
            return None;
        }
        let all = [elsewhere.as_slice(), &[a, b]].concat();
        let removes = |before: &ScoredFit, after: &ScoredFit| {
            before.errors[row] - after.errors[row] > TOGETHER * before.errors[row]
        };
        if !regression.free && !removes(&rough, &regression.scored_fit(&all, false)?) {
            return None;
        }
        let fitted = regression.scored_fit(&all, corrected)?;
        let stands = fitted.cost < scored.cost
            && removes(scored, &fitted)
            && regression.impossible(&all, &fitted).is_none();
        stands.then(|| (vec![a, b], all, fitted))
    });
    tried.into_iter().flatten().min_by(|a, b| a.2.cost.total_cmp(&b.2.cost))
}

/// Forms of effects at a joint, the best few of each kind.
fn forms_of(
    regression: &Regression<'_>,
    joint: &str,
    (active, corrected): (&[usize], bool),
    free: &dyn Fn(usize) -> bool,
) -> Vec<usize> {
    let location = |c: usize| &regression.candidates[c].form.location;
    let here = |c: &usize| location(*c).joint.as_deref() == Some(joint) && location(*c).other_joint.is_none();
    let local: Vec<usize> = (0..regression.candidates.len()).filter(here).filter(|&c| free(c)).collect();
    let costs = parallel(local.len(), |i| {
        let with = [active, &[local[i]]].concat();
        regression.scored_fit(&with, corrected).map_or(f64::INFINITY, |t| t.cost)
    });
    let mut ranked: Vec<(usize, f64)> = local.into_iter().zip(costs).collect();
    ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut kept: Vec<usize> = Vec::new();
    for (c, _) in ranked {
        let kind = |c: usize| regression.candidates[c].form.kind;
        if kept.iter().filter(|&&o| kind(o) == kind(c)).count() < STARTS {
            kept.push(c);
        }
    }
    kept
}

/// Exchanges effects one at a time for others that do better, until none does.
pub(crate) fn exchange(
    regression: &Regression<'_>,
    mut active: Vec<usize>,
    mut scored: ScoredFit,
    corrected: bool,
) -> (Vec<usize>, ScoredFit) {
    for _ in 0..3 {
        let before = scored.cost;
        for k in regression.standing.len()..active.len() {
            let mut fewer = active.clone();
            let gone = fewer.remove(k);
            let (Some(base), Some(rough)) =
                (regression.scored_fit(&fewer, corrected), regression.scored_fit(&fewer, false))
            else {
                continue;
            };
            let rows = &regression.candidates[gone].rows;
            let tried = parallel(regression.candidates.len(), |c| {
                if !regression.candidates[c].rows.iter().any(|r| rows.contains(r)) {
                    return None;
                }
                let t = consider(regression, &fewer, &base, &rough, corrected, c).ok()?;
                let mut other = fewer.clone();
                other.push(c);
                Some((other, t))
            });
            for (other, t) in tried.into_iter().flatten() {
                if t.cost < scored.cost && !tells_less(regression, (&active, &scored), gone, (&other, &t)) {
                    (active, scored) = (other, t);
                }
            }
        }
        if scored.cost >= before - 1e-9 {
            break;
        }
    }
    (active, scored)
}

/// Whether an effect on a link in the place of another one costs less only because what it leaves more is below the noise.
fn tells_less(
    regression: &Regression<'_>,
    (active, scored): (&[usize], &ScoredFit),
    gone: usize,
    (other, fitted): (&[usize], &ScoredFit),
) -> bool {
    let both = other.last().is_some_and(|&c| regression.is_of_link(c)) && regression.is_of_link(gone);
    both && regression.whole_cost(other, fitted) > regression.whole_cost(active, scored)
}
