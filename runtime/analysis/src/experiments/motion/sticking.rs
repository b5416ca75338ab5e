//! Where joints stick: there dry friction is anything between its bounds, whatever the sign of the noise of a speed.
//!
//! Such samples bound a torque and tell none. They are left out where a joint has dry friction (what it needs jumps with
//! its direction), even if it rests most of the time, as joints do that move one after the other; a joint without dry friction that
//! holds its load tells that load.
use crate::measure::directions::resting;
use bipedc_effects::effect::{Effect, Simulation};
use nalgebra::{DMatrix, DVector};

/// A filter smears the kink of a velocity that stops over this part of a period of its cut-off: as far around a rest a joint that seems to move may rest, with friction that is anything.
const SMEARED: f64 = 0.35;
/// Least part of the samples that must be left where joints take turns ...
const MOVING: f64 = 0.01;
/// ... and where there is one joint only: if that rests most of the time, its log is about holding loads.
const MOVING_ALONE: f64 = 0.5;
/// A jump of the torque with the direction of so many standard deviations of its noise is dry friction.
const JUMP: f64 = 1.0;
/// Fewest samples that tell a jump.
const FEWEST: usize = 100;

/// What is known of one joint, sample after sample.
pub(super) struct Joint<'a> {
    pub residual: &'a [f64],
    /// What its smooth effects are functions of: angle, velocity, acceleration, load.
    pub signals: &'a [Vec<f64>],
    /// Slower than this it may as well stand still, rad/s or m/s.
    pub still: f64,
    /// Standard deviation of the effort's noise, N m or N.
    pub noise: f64,
    /// Samples in a period of the cut-off.
    pub period: f64,
    /// The robot has no other joint.
    pub alone: bool,
}

/// Samples at which the joint sticks, one flag each; empty if it does not.
pub(super) fn sticking(joint: &Joint<'_>, present: &[&Effect]) -> Vec<bool> {
    let flags = resting(&joint.signals[1], joint.still, joint.period, SMEARED);
    let moving = flags.iter().filter(|rests| !**rests).count();
    let least = if joint.alone { MOVING_ALONE } else { MOVING };
    if moving == flags.len() || moving < FEWEST || (moving as f64) < least * flags.len() as f64 {
        return Vec::new();
    }
    let is_dry = present.iter().any(|effect| matches!(effect.kind.simulation, Simulation::Dry(_)));
    if is_dry || jump(joint, &flags) > JUMP * joint.noise { flags } else { Vec::new() }
}

/// By how much the torque jumps with the direction beside linear functions of the signals, half of it; 0 if unknown.
fn jump(joint: &Joint<'_>, resting: &[bool]) -> f64 {
    let moving: Vec<usize> = (0..resting.len()).filter(|&i| !resting[i]).collect();
    let columns = DMatrix::from_fn(moving.len(), joint.signals.len() + 2, |i, column| match column {
        0 => joint.signals[1][moving[i]].signum(),
        1 => 1.0,
        _ => joint.signals[column - 2][moving[i]],
    });
    let lengths = DVector::from_fn(columns.ncols(), |c, _| columns.column(c).norm().max(f64::MIN_POSITIVE));
    let scaled = DMatrix::from_fn(columns.nrows(), columns.ncols(), |r, c| columns[(r, c)] / lengths[c]);
    let measured = DVector::from_fn(moving.len(), |i, _| joint.residual[moving[i]]);
    // Signals that are the same, such as an angle and the load that it makes, share what they explain.
    let gram = scaled.tr_mul(&scaled) + DMatrix::identity(columns.ncols(), columns.ncols()) * 1e-9;
    let solution = gram.cholesky().map(|gram| gram.solve(&scaled.tr_mul(&measured)));
    solution.map_or(0.0, |solution| solution[0] / lengths[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joint_with(friction: f64, noise: f64) -> Vec<bool> {
        // Back and forth, and 0.2 s of rest at either end.
        let count = 2000;
        let speed = |i: usize| match i % 250 {
            0..50 => 0.0,
            k => {
                (std::f64::consts::PI * (k - 50) as f64 / 200.0).sin()
                    * if (i / 250).is_multiple_of(2) { 1.0 } else { -1.0 }
            }
        };
        let velocity: Vec<f64> = (0..count).map(speed).collect();
        let angle: Vec<f64> = velocity
            .iter()
            .scan(0.0, |angle, v| {
                *angle += 0.004 * v;
                Some(*angle)
            })
            .collect();
        let white = |i: usize| noise * (i as f64 * 12.9898).sin() * 2.0_f64.sqrt();
        let residual: Vec<f64> = (0..count)
            .map(|i| {
                0.3 * velocity[i]
                    + white(i)
                    + if velocity[i] == 0.0 { 0.0 } else { friction * velocity[i].signum() }
            })
            .collect();
        let signals = [angle.clone(), velocity, vec![0.0; count], angle.iter().map(|q| q.sin()).collect()];
        let (still, period, alone) = (0.02, 16.0, false);
        sticking(&Joint { residual: &residual, signals: &signals, still, noise, period, alone }, &[])
    }

    #[test]
    fn joints_with_dry_friction_stick_and_others_rest() {
        let sticks = joint_with(1.0, 0.05);
        assert!((0..2000).filter(|i| i % 250 < 50).all(|i| sticks[i]));
        let left = sticks.iter().filter(|sticks| !**sticks).count();
        assert!(left > 1450, "{left}");
        assert!(joint_with(0.0, 0.05).is_empty(), "without friction a resting joint tells its load");
        assert!(joint_with(0.01, 0.05).is_empty(), "friction far below the noise does no harm");
    }

    /// Moves for 100 samples of so many, as a joint does whose neighbours take their turns.
    fn joint_that_waits(every: usize, alone: bool) -> Vec<bool> {
        let speed = |i: usize| match i % every {
            0..100 => (std::f64::consts::TAU * (i % every) as f64 / 100.0).sin(),
            _ => 0.0,
        };
        let velocity: Vec<f64> = (0..8000).map(speed).collect();
        let residual: Vec<f64> = (0..8000)
            .map(|i| {
                0.05 * (i as f64 * 12.9898).sin()
                    + if velocity[i] == 0.0 { 0.3 } else { velocity[i].signum() }
            })
            .collect();
        let zeros = vec![0.0; 8000];
        let signals = [zeros.clone(), velocity, zeros.clone(), zeros];
        let (still, noise, period) = (0.02, 0.05, 16.0);
        sticking(&Joint { residual: &residual, signals: &signals, still, noise, period, alone }, &[])
    }

    #[test]
    fn joints_that_take_turns_stick_most_of_the_time_and_a_joint_alone_holds_its_load() {
        let left = |every: usize| joint_that_waits(every, false).iter().filter(|sticks| !**sticks).count();
        assert!((600..=800).contains(&left(1000)), "{}", left(1000));
        // One of thirty joints, as it moves in one log and rests in most of it.
        assert!((150..=200).contains(&left(4000)), "{}", left(4000));
        assert!(joint_that_waits(1000, true).is_empty());
    }
}
