//! Short moments at which something shakes the robot far harder than all the rest of the log: a blow, a servo at a singular posture, a
//! cable that snaps.
//!
//! A filter sees less of such a motion than the sensors do, so that no model can tell the efforts there, and least squares would give
//! them all the weight. The motion alone decides, before any filter: what efforts an effect leaves says nothing about it.
use crate::log::Block;
use crate::measure::columns::{JointColumns, Plan};
use crate::robot::JointLayout;

/// At a jolt a joint accelerates so many times harder than ever else.
const TIMES: f64 = 4.0;
/// And at least so hard, rad/s² or m/s²: encoders of joints at rest flicker.
const LEAST: f64 = 20.0;
/// Most jolts of a joint: what happens more often belongs to the motion.
const MOST: usize = 3;
/// Largest part of the log near jolts, for the same reason.
const LARGEST_PART: f64 = 0.05;
/// A jolt is felt so long before it, where a filter smears it, and after it, while drives answer; s.
const FELT: [f64; 2] = [0.1, 0.3];
/// Accelerations are second differences over so long on either side, s: shorter ones are the encoders' steps.
const SPAN: f64 = 0.02;
/// Of so long the hardest acceleration is kept, s.
const PIECE: f64 = 0.05;

/// How hard joints accelerate, piece after piece of a log.
#[derive(Debug, Clone, Default)]
pub struct Jolts {
    joints: Vec<Option<OfJoint>>,
}

/// Of a joint whose effort is measured.
#[derive(Debug, Clone)]
struct OfJoint {
    position: usize,
    /// First time (s) and hardest acceleration (rad/s² or m/s²) of each piece.
    pieces: Vec<[f64; 2]>,
}

/// What was found of a joint.
struct Found {
    /// First time of each piece with a jolt, s.
    at: Vec<f64>,
    /// The hardest acceleration by that of the rest of the log.
    times: f64,
}

impl Jolts {
    pub(crate) fn new(plan: &Plan) -> Self {
        let of = |columns: &JointColumns| {
            columns.effort.and(columns.position).map(|position| OfJoint { position, pieces: Vec::new() })
        };
        Self { joints: plan.joints.iter().map(of).collect() }
    }

    /// Looks at the samples of a block that count.
    pub(crate) fn look(&mut self, block: &Block<'_>, step: f64) {
        let half = (SPAN / step).round().max(1.0) as usize;
        for joint in self.joints.iter_mut().flatten() {
            let angles = &block.columns[joint.position];
            for i in block.core.clone().filter(|&i| i >= half && i + half < angles.len()) {
                let change = angles[i + half] - 2.0 * angles[i] + angles[i - half];
                joint.add(block.time[i], change.abs() / (half as f64 * step).powi(2));
            }
        }
    }

    fn found(&self) -> impl Iterator<Item = (usize, Found)> + '_ {
        let of = self.joints.iter().enumerate();
        of.filter_map(|(index, joint)| Some((index, joint.as_ref()?.found()?)))
    }

    /// Samples at these times (s) that feel a jolt of any joint behind a filter of this cut-off (Hz), one flag each; empty: none.
    pub(crate) fn flags(&self, times: &[f64], cutoff_hz: f64) -> Vec<bool> {
        let mut flags = vec![false; times.len()];
        let [before, after] = FELT.map(|felt| felt.max(1.0 / cutoff_hz));
        for first in self.found().flat_map(|(_, found)| found.at) {
            let from = times.partition_point(|time| *time < first - before);
            let to = times.partition_point(|time| *time <= first + PIECE + after);
            flags[from..to.max(from)].fill(true);
        }
        if flags.contains(&true) { flags } else { Vec::new() }
    }

    /// A sentence on each joint that was shaken, and what is done about it.
    pub(crate) fn words(&self, layout: &JointLayout) -> Vec<String> {
        let of_joint = |(index, found): (usize, Found)| {
            let when: Vec<String> = found.at.iter().map(|time| format!("{time:.2}")).collect();
            format!(
                "`{}` is shaken near {} s, {:.0} times as hard as ever else (or its encoder jumps), which no filter shows as it was: the efforts of all joints are left out there",
                layout.joints[index].name,
                when.join(", "),
                found.times
            )
        };
        self.found().map(of_joint).collect()
    }
}

impl OfJoint {
    fn add(&mut self, time: f64, acceleration: f64) {
        if !acceleration.is_finite() {
            return;
        }
        match self.pieces.last_mut() {
            Some([first, hardest]) if time - *first < PIECE => *hardest = hardest.max(acceleration),
            _ => self.pieces.push([time, acceleration]),
        }
    }

    /// `None`: the joint has no jolt.
    fn found(&self) -> Option<Found> {
        let mut near = vec![false; self.pieces.len()];
        let mut at = Vec::new();
        let mut found = None;
        let first = self.hardest(&near)?.1;
        for _ in 0..MOST {
            let (peak, size) = self.hardest(&near)?;
            let time = self.pieces[peak][0];
            let felt = time - FELT[0]..=time + PIECE + FELT[1];
            let pieces = self.pieces.iter().zip(&mut near);
            pieces.for_each(|([first, _], near)| *near |= felt.contains(first));
            at.push(time);
            let part = near.iter().filter(|near| **near).count() as f64 / near.len() as f64;
            if part > LARGEST_PART {
                break;
            }
            let rest = self.hardest(&near)?.1;
            if size > (TIMES * rest).max(LEAST) {
                found = Some(Found { at: at.clone(), times: first / rest });
            }
        }
        found
    }

    /// Piece with the hardest acceleration of those that are not near a jolt, and how hard it is.
    fn hardest(&self, near: &[bool]) -> Option<(usize, f64)> {
        let others = self.pieces.iter().zip(near).enumerate().filter(|(_, (_, near))| !**near);
        others.map(|(i, ([_, hardest], _))| (i, *hardest)).max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten seconds of a swing that accelerates by 5 rad/s², with what is added to it.
    fn shaken(added: impl Fn(f64) -> f64) -> Option<Found> {
        let mut joint = OfJoint { position: 0, pieces: Vec::new() };
        for time in (0..2500).map(|i| f64::from(i) / 250.0) {
            joint.add(time, (5.0 * (3.0 * time).sin() + added(time)).abs());
        }
        joint.found()
    }

    fn pulse(t: f64, middle: f64, size: f64) -> f64 {
        size * (-((t - middle) / 0.02).powi(2)).exp()
    }

    #[test]
    fn a_blow_is_found_with_the_time_around_it() {
        let found = shaken(|t| pulse(t, 4.02, 100.0)).unwrap();
        assert!(found.at.len() == 1 && (3.96..4.03).contains(&found.at[0]), "{:?}", found.at);
        assert!(found.times > 15.0, "{}", found.times);
        let joint = OfJoint { position: 0, pieces: vec![[0.0, 1.0]; 100] };
        let mut jolts = Jolts { joints: vec![None, Some(joint)] };
        let times: Vec<f64> = (0..1000).map(|i| f64::from(i) / 100.0).collect();
        assert!(jolts.flags(&times, 10.0).is_empty());
        let pieces = (0..200).map(|i| [0.05 * f64::from(i), if i == 80 { 90.0 } else { 1.0 }]).collect();
        jolts.joints[0] = Some(OfJoint { position: 0, pieces });
        assert_eq!(jolts.flags(&times, 10.0).iter().filter(|flag| **flag).count(), 46);
        assert_eq!(jolts.flags(&times, 4.0).iter().filter(|flag| **flag).count(), 61);
    }

    #[test]
    fn what_happens_often_belongs_to_the_motion() {
        assert!(shaken(|t| (0..5).map(|k| pulse(t, 1.0 + 2.0 * f64::from(k), 100.0)).sum()).is_none());
        assert!(shaken(|t| pulse(t, 4.0, 14.0)).is_none());
        assert!(shaken(|_| 0.0).is_none());
    }

    #[test]
    fn a_robot_that_rests_but_for_one_motion_is_not_shaken() {
        let mut joint = OfJoint { position: 0, pieces: Vec::new() };
        for time in (0..2500).map(|i| f64::from(i) / 250.0) {
            let moves = if (4.0..5.0).contains(&time) { 50.0 * (12.56 * time).sin() } else { 0.0 };
            joint.add(time, f64::abs(moves));
        }
        assert!(joint.found().is_none());
    }
}
