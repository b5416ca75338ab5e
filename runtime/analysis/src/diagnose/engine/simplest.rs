//! Of explanations that are as good, the simplest.
use super::parallel::parallel;
use super::search::{Outcome, consider};
use super::setting::{Setting, Trial};

/// Alternatives whose held-out error differs by less than this part of what the effect removes are named together.
pub(super) const ALIKE: f64 = 0.01;
/// The same for an effect with fewer parameters to stand in another one's place.
const AS_GOOD: f64 = 0.001;

/// Of explanations that are as good, the one with fewer effects, and on the likelier link.
pub(super) fn simplest(setting: &Setting<'_>, outcome: &mut Outcome) {
    with_fewer_parameters(setting, outcome);
    merge(setting, outcome);
    likeliest_links(setting, outcome);
}

/// Of effects in whose place another one with fewer parameters does as well, that one.
fn with_fewer_parameters(setting: &Setting<'_>, outcome: &mut Outcome) {
    let deviance = |t: &Trial, set: &[usize]| t.cost - setting.price(set);
    let count = |c: usize| setting.candidates[c].parameters;
    for k in setting.standing.len()..outcome.active.len() {
        let mut fewer = outcome.active.clone();
        fewer.remove(k);
        let (Some(bare), Some(rough)) =
            (setting.trial(&fewer, outcome.corrected), setting.trial(&fewer, false))
        else {
            continue;
        };
        let here = deviance(&outcome.trial, &outcome.active);
        let limit = here + (AS_GOOD * (deviance(&bare, &fewer) - here)).max(4.0);
        let mine = outcome.active[k];
        let tried = parallel(setting.candidates.len(), |c| {
            if count(c) >= count(mine)
                || consider(setting, &fewer, &bare, &rough, outcome.corrected, c).is_err()
            {
                return None;
            }
            let mut set = outcome.active.clone();
            set[k] = c;
            let trial = setting.trial(&set, outcome.corrected)?;
            (deviance(&trial, &set) <= limit).then_some((c, set, trial))
        });
        let least = |a: &(usize, Vec<usize>, Trial), b: &(usize, Vec<usize>, Trial)| {
            count(a.0).cmp(&count(b.0)).then(a.2.cost.total_cmp(&b.2.cost))
        };
        if let Some((_, set, trial)) = tried.into_iter().flatten().min_by(least) {
            (outcome.active, outcome.trial) = (set, trial);
        }
    }
}

/// One effect for two at its place that are nearly it together: friction that differs by direction is, but for the moment
/// of reversal, friction and a bias.
fn merge(setting: &Setting<'_>, outcome: &mut Outcome) {
    let form = |c: usize| &setting.candidates[c].form;
    let first = setting.standing.len();
    let judged: Vec<usize> = outcome.active[first..].to_vec();
    let here = |a: usize, b: usize| form(a).location == form(b).location;
    let pairs = judged.iter().flat_map(|&a| judged.iter().map(move |&b| (a, b)));
    for (first, second) in pairs.filter(|&(a, b)| a != b && here(a, b)) {
        let mut all = 0..setting.candidates.len();
        let is_both =
            |&c: &usize| here(c, first) && form(c).kind.is_sum_of(form(first).kind, form(second).kind);
        let Some(both) = all.find(is_both) else { continue };
        let bare: Vec<usize> =
            outcome.active.iter().copied().filter(|&c| c != first && c != second).collect();
        let set: Vec<usize> = bare.iter().copied().chain([both]).collect();
        let (Some(without), Some(trial)) =
            (setting.trial(&bare, outcome.corrected), setting.trial(&set, outcome.corrected))
        else {
            continue;
        };
        let deviance = |t: &Trial, set: &[usize]| t.cost - setting.price(set);
        let (apart, merged) = (deviance(&outcome.trial, &outcome.active), deviance(&trial, &set));
        let removed = deviance(&without, &bare) - apart;
        if merged <= apart + (ALIKE * removed).max(4.0) && setting.impossible(&set, &trial).is_none() {
            (outcome.active, outcome.trial) = (set, trial);
        }
    }
}

/// Of links on which an effect explains as much, the heaviest is the likeliest to carry it; the others are named as
/// alternatives.
fn likeliest_links(setting: &Setting<'_>, outcome: &mut Outcome) {
    for k in setting.standing.len()..outcome.active.len() {
        let form = &setting.candidates[outcome.active[k]].form;
        let Some(mut mass) = setting.carrier(outcome.active[k]) else { continue };
        let mut fewer = outcome.active.clone();
        fewer.remove(k);
        let Some(bare) = setting.trial(&fewer, outcome.corrected) else { continue };
        let removed =
            bare.cost - setting.price(&fewer) - (outcome.trial.cost - setting.price(&outcome.active));
        let limit = outcome.trial.cost + (ALIKE * removed).max(4.0);
        let kind = form.kind;
        for c in 0..setting.candidates.len() {
            let Some(other) = setting.carrier(c).filter(|m| *m > mass) else { continue };
            let mut set = outcome.active.clone();
            set[k] = c;
            let unwanted = setting.banned.contains(&c) || outcome.active.contains(&c);
            if setting.candidates[c].form.kind != kind || unwanted {
                continue;
            }
            let Some(trial) = setting.trial(&set, outcome.corrected) else { continue };
            if trial.cost <= limit && setting.impossible(&set, &trial).is_none() {
                (outcome.active, outcome.trial, mass) = (set, trial, other);
            }
        }
    }
}
