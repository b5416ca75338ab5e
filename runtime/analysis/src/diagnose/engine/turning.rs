//! Where joints with dry friction turn about: what friction is there neither its smoothed sign nor a filtered speed tells.
//!
//! Friction jumps where the true speed passes zero; its formula changes its sign over a width of speeds. Between, the formula is too small, and
//! an estimate from all samples makes up for it. Where joints stick long enough such samples are left out anyway; where they only turn
//! about, torques came out up to 0.6 % large, more than twice what noise leaves them uncertain by.
use crate::diagnose::breakdown::velocity_of;
use crate::experiments::{Channel, Experiment};
use bipedc_effects::effect::{Effect, Simulation};

/// So many widths away from rest the sign is within 4 % of one, and what it lacks makes a sixteenth of the error.
const WIDTHS: f64 = 2.0;
/// Least part of the samples that must be left.
const LEFT: f64 = 0.5;
/// The parameter of friction's sign.
const SMOOTHING: &str = "smoothing";

/// Samples of a row at which its joint turns about under dry friction, one flag each; empty where it has none, or moves so
/// slowly that too few others were left.
pub(super) fn turning(experiment: &dyn Experiment, row: usize, effects: &[Effect]) -> Vec<bool> {
    let what = &experiment.rows()[row];
    let joint = what.joint.as_deref().filter(|_| what.channel == Channel::Effort);
    let dry = |effect: &&Effect| {
        matches!(effect.kind.simulation, Simulation::Dry(_)) && effect.location.joint.as_deref() == joint
    };
    let widths = effects.iter().filter(dry).map(|effect| effect.value(SMOOTHING));
    let width = WIDTHS * widths.fold(0.0, f64::max);
    if joint.is_none() || width <= 0.0 {
        return Vec::new();
    }
    let Some(velocity) = velocity_of(experiment, row) else { return Vec::new() };
    let flags: Vec<bool> = velocity.iter().map(|v| v.abs() < width).collect();
    let left = flags.iter().filter(|turns| !**turns).count();
    if (left as f64) < LEFT * flags.len() as f64 { Vec::new() } else { flags }
}
