//! Alternatives to what acts at a joint, estimated by their laws as they are.
//!
//! A search draws friction with a smooth sign, and what that leaves near reversals may be more than what tells viscous friction from drag. What is said not to be told
//! apart is estimated anew, with all else that acts at the joint, and judged away from jumps.
use super::alternatives::SINGLES;
use super::conclusion::Conclusion;
use super::significance::{JudgedError, NO_CHANCE, judged_errors, without_sticking};
use crate::diagnose::FoundEffect;
use crate::diagnose::engine::equations::regression::is_held_out;
use crate::diagnose::engine::refine::amended::Amended;
use crate::diagnose::engine::refine::estimates::data;
use crate::diagnose::engine::refine::refinement::refine;
use crate::diagnose::engine::refine::sharp_friction::sharper;
use crate::experiments::Experiment;
use crate::experiments::corners::SMOOTHING;
use crate::experiments::jumps::Jumps;
use bipedc_effects::effect::{Effect, Simulation};

/// Squares that are so many times as large, and by more than chance, are seen.
const SEEN: f64 = 1.1;

impl Conclusion<'_> {
    /// Whether the data that judge tell others in the place of some effects, of which the first acts at one joint, from these.
    pub(crate) fn is_told_exactly(&self, gone: &[usize], others: &[FoundEffect]) -> bool {
        let (regression, refined) = (self.regression, &self.settled.refined);
        let mine = &refined.effects[gone[0]];
        let place = &mine.location;
        if regression.is_table || place.joint.is_none() || !self.settled.corrections.is_empty() {
            return false;
        }
        let at_joint = |effect: &Effect| effect.location.joint == place.joint;
        let rest =
            (0..refined.effects.len()).filter(|k| !gone.contains(k)).map(|k| refined.effects[k].clone());
        let (own, fixed): (Vec<Effect>, Vec<Effect>) = rest.partition(at_joint);
        let others = others.iter().map(|found| as_sharp(&found.effect, mine));
        let start = own.into_iter().chain(others).collect();
        let teaches = |sample: usize, n: usize| !regression.own_blocks || !is_held_out(sample, n);
        let found = refine(data(regression, &teaches), start, &fixed, None).effects;
        let set = [found, fixed].concat();
        let jumps = Jumps::of(regression.judge, &[refined.effects.as_slice(), &set].concat());
        let jumps = jumps.leave_enough().then_some(&jumps);
        let left = |effects: &[Effect]| judged_errors(regression, effects, &[], jumps);
        let (here, there) = (left(&refined.effects), left(&set));
        there
            .iter()
            .zip(&here)
            .any(|(there, here)| there.is_larger_than(here, SEEN) && there.deviance_above(here) > NO_CHANCE)
    }
}

/// What is left of a row is more than its noise from so much of the noise's squares on.
const MORE: f64 = 1.08;
/// Squares that are so many times as large are worse.
const WORSE: f64 = 1.03;

impl Conclusion<'_> {
    /// An effect in whose place one that a search could not tell from it leaves clearly less of the data that judge when both are estimated exactly, and the
    /// candidate of that one. Only where the effect leaves more than noise.
    pub(crate) fn surpassed(&self) -> Option<(usize, usize)> {
        let (regression, active, refined) = (self.regression, &self.outcome.active, &self.settled.refined);
        let is_plain = self.settled.corrections.is_empty() && active.len() == refined.effects.len();
        if regression.is_table || regression.free || !is_plain {
            return None;
        }
        let left = Amended::new(regression.judge, &refined.effects);
        let is_more = |row: usize| {
            let values = left.residual(row);
            let all = without_sticking(regression.judge, row, values, |_| true);
            let (sum, n) = all.fold((0.0, 0.0_f64), |(sum, n), x| (sum + x * x, n + 1.0));
            sum > MORE * n * regression.resolutions[row].powi(2)
        };
        let loud: Vec<usize> = (0..regression.judge.rows().len()).filter(|&row| is_more(row)).collect();
        let shows = |k: &usize| regression.candidates[active[*k]].rows.iter().any(|row| loud.contains(row));
        (regression.standing.len()..active.len()).filter(shows).find_map(|k| {
            let (alike, _) = self.alike(active, k);
            alike.into_iter().take(SINGLES).find(|&c| self.is_better(k, c)).map(|c| (k, c))
        })
    }

    /// Whether a candidate in the place of the `k`-th effect leaves clearly less of a row and not more of any, all estimated exactly.
    fn is_better(&self, k: usize, c: usize) -> bool {
        let (regression, outcome) = (self.regression, self.outcome);
        let mut set = outcome.active.clone();
        set[k] = c;
        let Some(scored) = regression.scored_fit(&set, outcome.corrected) else { return false };
        let mut start = self.settled.refined.effects.clone();
        start[k] = regression.candidates[c].form.effect(regression.coefficients(&set, &scored, k));
        let teaches = |sample: usize, n: usize| !regression.own_blocks || !is_held_out(sample, n);
        let found = refine(data(regression, &teaches), start, &[], None).effects;
        let jumps = Jumps::of(regression.judge, &[self.settled.refined.effects.as_slice(), &found].concat());
        let jumps = jumps.leave_enough().then_some(&jumps);
        let left = |effects: &[Effect]| judged_errors(regression, effects, &[], jumps);
        let (here, there) = (left(&self.settled.refined.effects), left(&found));
        let mut rows = here.iter().zip(&there);
        let less = |(here, there): (&JudgedError, &JudgedError)| {
            here.is_larger_than(there, SEEN) && here.deviance_above(there) > NO_CHANCE
        };
        rows.clone().all(|(here, there)| !there.is_larger_than(here, WORSE)) && rows.any(less)
    }
}

/// Friction with a sign as sharp as that of what stands in its place.
fn as_sharp(effect: &Effect, standing: &Effect) -> Effect {
    let is_dry = |effect: &Effect| matches!(effect.kind.simulation, Simulation::Dry(_));
    let narrower = is_dry(effect) && is_dry(standing) && standing.value(SMOOTHING) < effect.value(SMOOTHING);
    if narrower { sharper(effect) } else { effect.clone() }
}
