//! Samples at the corners of laws, where noise of what a law is a function of decides on which side of the corner they seem to be.
//!
//! Dry friction jumps where the true speed passes zero; its formula changes its sign over a width of speeds, and a filtered speed passes zero a
//! little earlier or later. A drive saturates where the true torque meets its limit; of reported torques above the limit those that noise alone
//! put there were smaller. An estimate from all samples makes up for both: dry friction came out up to 0.6 % large, its value at rest
//! 5 %, limits 2 to 4 % small, many times what noise leaves them uncertain by. So estimates leave such samples out, and take the sign beyond as it is.
use crate::diagnose::breakdown::velocity_of;
use crate::experiments::{Channel, Experiment};
use bipedc_effects::effect::{Effect, Simulation};

/// So many widths away from rest the smoothed sign is within 4 % of one.
const WIDTHS: f64 = 2.0;
/// Least part of the samples that must be left.
const LEFT: f64 = 0.5;
/// So many standard deviations of its noise a reported torque is away from a limit.
const DEVIATIONS: f64 = 3.0;
/// Fewest samples beyond a limit that tell where it is.
const BEYOND: usize = 50;
/// The parameter of friction's sign.
const SMOOTHING: &str = "smoothing";
/// Beyond the corner the width of the sign is this part of what is stated.
const SHARP: f64 = 0.02;

/// Samples of a row at the corners of what acts there, one flag each; empty if there are none, or too few others.
pub(super) fn corners(experiment: &dyn Experiment, row: usize, effects: &[Effect]) -> Vec<bool> {
    let mut flags = reversals(experiment, row, effects);
    let limits = limits(experiment, row, effects);
    if flags.is_empty() {
        return limits;
    }
    flags.iter_mut().zip(limits).for_each(|(flag, at_limit)| *flag |= at_limit);
    flags
}

/// The effects with signs as sharp as they are where samples at their corners are left out; `reversed` says of each row
/// whether that is so.
pub(super) fn sharpened(
    experiment: &dyn Experiment,
    effects: &[Effect],
    reversed: impl Fn(usize) -> bool,
) -> Vec<Effect> {
    let mut sharp = effects.to_vec();
    for (row, what) in experiment.rows().iter().enumerate() {
        if what.channel != Channel::Effort || !reversed(row) {
            continue;
        }
        for effect in sharp.iter_mut().filter(|effect| rubs(effect, what.joint.as_deref())) {
            let width = SHARP * effect.value(SMOOTHING);
            effect.parameters.insert(SMOOTHING.to_owned(), width);
        }
    }
    sharp
}

fn rubs(effect: &Effect, joint: Option<&str>) -> bool {
    matches!(effect.kind.simulation, Simulation::Dry(_)) && effect.location.joint.as_deref() == joint
}

/// Samples at which a joint with dry friction turns about; empty where it has none, or moves so slowly that too few others were left.
pub(super) fn reversals(experiment: &dyn Experiment, row: usize, effects: &[Effect]) -> Vec<bool> {
    let what = &experiment.rows()[row];
    let joint = what.joint.as_deref().filter(|_| what.channel == Channel::Effort);
    let widths = effects.iter().filter(|effect| rubs(effect, joint)).map(|effect| effect.value(SMOOTHING));
    let width = WIDTHS * widths.fold(0.0, f64::max);
    if joint.is_none() || width <= 0.0 {
        return Vec::new();
    }
    let Some(velocity) = velocity_of(experiment, row) else { return Vec::new() };
    let slow: Vec<bool> = velocity.iter().map(|v| v.abs() < width).collect();
    // Friction that turns about jumps, and so does the acceleration, which is known as smooth as the filter made it.
    let whole = around(&slow, experiment.smeared());
    let leaves_enough = |flags: &Vec<bool>| {
        let left = flags.iter().filter(|turns| !**turns).count();
        left as f64 >= LEFT * flags.len() as f64
    };
    [whole, slow].into_iter().find(leaves_enough).unwrap_or_default()
}

/// Flags, and those around them as far as `reach` samples.
fn around(flags: &[bool], reach: usize) -> Vec<bool> {
    let mut wide = vec![false; flags.len()];
    for (i, _) in flags.iter().enumerate().filter(|(_, flag)| **flag) {
        wide[i.saturating_sub(reach)..(i + reach + 1).min(flags.len())].fill(true);
    }
    wide
}

/// Samples at which the reported torque is so near a drive's limit that noise decides whether it is beyond; empty where there is no limit,
/// or too few samples are beyond.
fn limits(experiment: &dyn Experiment, row: usize, effects: &[Effect]) -> Vec<bool> {
    let what = &experiment.rows()[row];
    let limit = effects.iter().find_map(|effect| match effect.kind.simulation {
        Simulation::Limit(name) if effect.location.joint == what.joint => Some(effect.value(name)),
        _ => None,
    });
    let Some(limit) = limit.filter(|_| what.channel == Channel::Effort) else { return Vec::new() };
    let Some(reported) = experiment.measured(row) else { return Vec::new() };
    let near = DEVIATIONS * what.noise;
    let beyond = reported.iter().filter(|torque| torque.abs() > limit + near).count();
    if beyond < BEYOND {
        return Vec::new();
    }
    reported.iter().map(|torque| (torque.abs() - limit).abs() < near).collect()
}
