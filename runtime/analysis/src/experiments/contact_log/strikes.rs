//! Impacts in a log: where all velocities jump between two samples, and forces change.
//!
//! A filter that runs across a jump mixes the motions before and after it: accelerations of tens of rad/s² that nobody
//! had, and torques of joints off by as much as they need. Soft landings, whose forces grow over several samples, are no jumps.
use super::foot::FootRecord;
use super::passing::Passing;
use crate::log::Block;
use std::ops::Range;

/// Second differences so many times as large as nine tenths of all, and `ALONE` times as large as those beside them, are jumps of the
/// velocity: of noise one in 10⁵ is, of motions and soft landings none.
const LARGE: f64 = 3.0;
const ALONE: f64 = 4.0;
/// And jump by this part of usual speeds (nine tenths of all are slower).
const FAST: f64 = 0.25;
/// Those beside them: from so many samples away to so many.
const BESIDE: [usize; 2] = [3, 8];
/// Part of the coordinates whose velocities must jump, and at least two: an encoder that slips is no impact.
const COORDINATES: f64 = 0.25;
/// The normal force of a foot changes by this part of the weight.
const CHANGE: f64 = 0.05;
/// Jumps so many samples apart are one impact.
const ONE: usize = 3;
/// Coordinates that move less do not, m or rad.
const STILL: f64 = 1e-6;

/// The last sample before each impact of a block, and the first one after it.
pub(super) fn impacts(passing: &Passing<'_, '_>, block: &Block<'_>, feet: &[FootRecord]) -> Vec<[usize; 2]> {
    let plan = &passing.columns.plan;
    let base = plan.base.iter().flat_map(|base| base.0.iter().copied().take(3));
    let coordinates: Vec<usize> = plan.joints.iter().filter_map(|joint| joint.position).chain(base).collect();
    let least = (COORDINATES * coordinates.len() as f64).ceil().max(2.0) as usize;
    let mut count = vec![0; block.time.len()];
    for column in coordinates {
        for sample in jumps(&block.columns[column]) {
            count[sample] += 1;
        }
    }
    // Whether a jump between two samples shows at the first or at the second one depends on the coordinate.
    let near = |i: usize| count[i.saturating_sub(1)..(i + 2).min(count.len())].iter().sum::<usize>();
    let candidates: Vec<usize> = (0..count.len()).filter(|&i| count[i] > 0 && near(i) >= least).collect();
    if candidates.is_empty() {
        return Vec::new();
    }
    let forces: Vec<Vec<f64>> = feet
        .iter()
        .zip(passing.robot.feet)
        .filter(|(record, _)| record.is_logged)
        .map(|(record, foot)| {
            let [_, _, normal, ..] = record.raw(block, foot);
            normal
        })
        .collect();
    let changes = |i: &usize| {
        let around = i.saturating_sub(ONE)..(i + ONE + 1).min(count.len());
        let steps = |force: &Vec<f64>| {
            let largest = force[around.clone()].windows(2).map(|pair| (pair[1] - pair[0]).abs());
            largest.fold(0.0, f64::max)
        };
        forces.iter().any(|force| steps(force) > CHANGE * passing.weight)
    };
    grouped(candidates.into_iter().filter(changes))
}

/// Samples at which the velocity jumps.
fn jumps(positions: &[f64]) -> Vec<usize> {
    let (least, most) =
        positions.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    if positions.len() < 2 * BESIDE[1] || most - least <= STILL {
        return Vec::new();
    }
    let first = positions.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    let seconds: Vec<f64> = positions.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs()).collect();
    let least = (LARGE * usual(seconds.clone())).max(FAST * usual(first));
    let largest = |range: Range<usize>| seconds[range].iter().copied().fold(0.0, f64::max);
    let [near, far] = BESIDE;
    let alone = |&i: &usize| {
        let before = i.saturating_sub(far)..i.saturating_sub(near - 1);
        let after = (i + near).min(seconds.len())..(i + far + 1).min(seconds.len());
        seconds[i] > ALONE * largest(before).max(largest(after))
    };
    (0..seconds.len()).filter(|i| seconds[*i] > least).filter(alone).map(|i| i + 1).collect()
}

/// Nine tenths are not larger.
fn usual(mut sizes: Vec<f64>) -> f64 {
    let place = sizes.len() * 9 / 10;
    *sizes.select_nth_unstable_by(place, f64::total_cmp).1
}

/// Neighbours as one impact.
fn grouped(samples: impl Iterator<Item = usize>) -> Vec<[usize; 2]> {
    let mut groups: Vec<[usize; 2]> = Vec::new();
    for sample in samples {
        match groups.last_mut() {
            Some([_, last]) if sample - *last <= ONE => *last = sample,
            _ => groups.push([sample, sample]),
        }
    }
    groups
}

/// Stretches between impacts, and whether an impact is at begin and end. Samples at which velocities jump belong to neither
/// side: one of them may hold the force of the impact.
pub(super) fn between(impacts: &[[usize; 2]], count: usize) -> Vec<(Range<usize>, [bool; 2])> {
    let begins = std::iter::once((0, false)).chain(impacts.iter().map(|[_, last]| (last + 1, true)));
    let ends = impacts.iter().map(|[first, _]| (*first, true)).chain([(count, false)]);
    begins
        .zip(ends)
        .map(|((begin, struck), (end, strikes))| (begin..end.max(begin), [struck, strikes]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Swings whose velocity jumps at 1.003 s, and noise.
    fn swing(jump: f64, noise: f64) -> Vec<f64> {
        let at = |i: u32| {
            let t = 0.005 * f64::from(i);
            0.4 * (5.0 * t).sin() + jump * (t - 1.003).max(0.0) + noise * (f64::from(i) * 77.7).sin()
        };
        (0..600).map(at).collect()
    }

    #[test]
    fn a_jump_of_the_velocity_is_seen_where_it_is() {
        for noise in [0.0, 1e-4] {
            let found = jumps(&swing(3.0, noise));
            assert!(!found.is_empty() && found.iter().all(|i| [200, 201].contains(i)), "{found:?}");
        }
        assert!(jumps(&swing(0.0, 1e-4)).is_empty());
        assert!(jumps(&swing(0.0, 0.0)).is_empty());
        assert!(jumps(&[0.5; 40]).is_empty());
    }

    #[test]
    fn stretches_leave_out_what_is_between() {
        assert_eq!(grouped([10, 11, 40].into_iter()), [[10, 11], [40, 40]]);
        let found = between(&[[10, 11], [40, 40]], 60);
        let wanted = [(0..10, [false, true]), (12..40, [true, true]), (41..60, [true, false])];
        assert_eq!(found, wanted);
    }
}
