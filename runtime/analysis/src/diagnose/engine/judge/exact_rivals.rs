//! Alternatives to what acts at a joint, estimated by their laws as they are.
//!
//! A search draws friction with a smooth sign, and what that leaves near reversals may be more than what tells viscous friction from drag. What is said not to be told
//! apart is estimated anew, with all else that acts at the joint, and judged away from jumps.
use super::conclusion::Conclusion;
use super::significance::{NO_CHANCE, judged_errors};
use crate::diagnose::FoundEffect;
use crate::diagnose::engine::equations::regression::is_held_out;
use crate::diagnose::engine::refine::estimates::data;
use crate::diagnose::engine::refine::refinement::refine;
use crate::diagnose::engine::refine::sharp_friction::sharper;
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

/// Friction with a sign as sharp as that of what stands in its place.
fn as_sharp(effect: &Effect, standing: &Effect) -> Effect {
    let is_dry = |effect: &Effect| matches!(effect.kind.simulation, Simulation::Dry(_));
    let narrower = is_dry(effect) && is_dry(standing) && standing.value(SMOOTHING) < effect.value(SMOOTHING);
    if narrower { sharper(effect) } else { effect.clone() }
}
