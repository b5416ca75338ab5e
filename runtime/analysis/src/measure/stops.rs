//! When joints lie at their stops: the stop carries a torque there that no drive feels, so that the effort is a bound and tells nothing.
use crate::log::Block;
use crate::measure::columns::Plan;
use crate::robot::JointLayout;

/// A joint lies at its stop within this part of the way between its stops.
const NEAR: f64 = 2e-3;
/// A joint that lies there for more of the log than this was put there: its stop may carry nothing.
const MOST: f64 = 0.9;
/// Filters smear the torque that a stop takes over this part of a period of their cut-off, on either side.
const SMEARED: f64 = 0.5;

/// Times at which joints lay at their stops.
#[derive(Debug, Clone, Default)]
pub struct Stops {
    joints: Vec<Option<OfJoint>>,
    /// Of all samples, s.
    seen: f64,
}

/// The two stops of a joint: lower, upper.
#[derive(Debug, Clone)]
struct OfJoint {
    position: Option<usize>,
    limits: [f64; 2],
    near: f64,
    /// First and last time, s.
    at: [Vec<[f64; 2]>; 2],
    /// The joint was seen beyond it, so that it is no stop.
    beyond: [bool; 2],
}

impl Stops {
    pub(crate) fn new(layout: &JointLayout, plan: &Plan) -> Self {
        let joints = layout.joints.iter().zip(&plan.joints).map(|(joint, columns)| {
            let limits = joint.limits.filter(|[low, high]| low < high)?;
            let near = NEAR * (limits[1] - limits[0]);
            // What the motor's encoder tells is not where the joint is.
            let position = columns.position.filter(|_| !columns.by_motor);
            Some(OfJoint { position, limits, near, at: [Vec::new(), Vec::new()], beyond: [false; 2] })
        });
        Self { joints: joints.collect(), seen: 0.0 }
    }

    /// Looks at the samples of a block that count.
    pub(crate) fn look(&mut self, block: &Block<'_>, step: f64) {
        let core = block.core.clone();
        self.seen += step * core.len() as f64;
        for joint in self.joints.iter_mut().flatten() {
            let Some(position) = joint.position else { continue };
            let samples = block.time[core.clone()].iter().zip(&block.columns[position][core.clone()]);
            samples.for_each(|(time, angle)| joint.add(*time, *angle, step));
        }
    }

    /// First and last times at which a joint lay at a stop, s.
    fn times(&self, joint: usize) -> Vec<[f64; 2]> {
        let Some(Some(of)) = self.joints.get(joint) else { return Vec::new() };
        let sides = (0..2).filter(|side| !of.beyond[*side] && of.duration(*side) < MOST * self.seen);
        sides.flat_map(|side| of.at[side].iter().copied()).collect()
    }

    /// Whether a joint lies at a stop at these times (s), or so near them that a filter of this cut-off (Hz) smears it there; empty:
    /// never.
    pub(crate) fn flags(&self, joint: usize, times: &[f64], cutoff_hz: f64) -> Vec<bool> {
        let reach = SMEARED / cutoff_hz;
        let mut flags = vec![false; times.len()];
        for [first, last] in self.times(joint) {
            let from = times.partition_point(|time| *time < first - reach);
            let to = times.partition_point(|time| *time <= last + reach);
            flags[from..to.max(from)].fill(true);
        }
        if flags.contains(&true) { flags } else { Vec::new() }
    }

    /// The same of any joint that strikes or leaves a stop; empty: none does, or so often that nothing would be left.
    pub(crate) fn strikes(&self, times: &[f64], cutoff_hz: f64) -> Vec<bool> {
        let reach = SMEARED / cutoff_hz;
        let mut flags = vec![false; times.len()];
        for event in (0..self.joints.len()).flat_map(|joint| self.times(joint)).flatten() {
            let from = times.partition_point(|time| *time < event - reach);
            let to = times.partition_point(|time| *time <= event + reach);
            flags[from..to.max(from)].fill(true);
        }
        let struck = flags.iter().filter(|flag| **flag).count();
        if struck > 0 && (struck as f64) < MOST * flags.len() as f64 { flags } else { Vec::new() }
    }

    /// One sentence on all joints that lay at a stop; `None`: none did.
    pub(crate) fn words(&self, layout: &JointLayout) -> Option<String> {
        let of_joint = |(index, joint): (usize, &crate::robot::Joint)| {
            let spent: f64 = self.times(index).iter().map(|[first, last]| last - first).sum();
            (spent > 0.0).then(|| format!("`{}` {spent:.3} s", joint.name))
        };
        let joints: Vec<String> = layout.joints.iter().enumerate().filter_map(of_joint).collect();
        (!joints.is_empty()).then(|| {
            format!(
                "joints lie at their stops (position limits of the URDF: {}), which carry a torque that no drive feels: what is left there is taken for it",
                joints.join(", ")
            )
        })
    }
}

impl OfJoint {
    fn add(&mut self, time: f64, angle: f64, step: f64) {
        let way = [angle - self.limits[0], self.limits[1] - angle];
        for ((way, beyond), at) in way.into_iter().zip(&mut self.beyond).zip(&mut self.at) {
            *beyond |= way < -self.near;
            if way > self.near {
                continue;
            }
            match at.last_mut() {
                Some([_, last]) if time - *last < 1.5 * step => *last = time + step,
                _ => at.push([time, time + step]),
            }
        }
    }

    /// s
    fn duration(&self, side: usize) -> f64 {
        self.at[side].iter().map(|[first, last]| last - first).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn looked(limits: [f64; 2], angle: impl Fn(f64) -> f64) -> Stops {
        let near = NEAR * (limits[1] - limits[0]);
        let mut joint =
            OfJoint { position: None, limits, near, at: [Vec::new(), Vec::new()], beyond: [false; 2] };
        (0..4000).map(|i| 1e-3 * f64::from(i)).for_each(|time| joint.add(time, angle(time), 1e-3));
        Stops { joints: vec![Some(joint)], seen: 4.0 }
    }

    #[test]
    fn a_joint_that_is_held_by_its_stop_is_seen_there() {
        let swing = |time: f64| (std::f64::consts::TAU * time).sin();
        let times: Vec<f64> = (0..400).map(|i| 0.01 * f64::from(i)).collect();
        let flags = looked([-2.0, 0.5], |time| swing(time).min(0.5)).flags(0, &times, 25.0);
        for (time, at_stop) in times.iter().zip(flags) {
            let near = [-0.021, 0.021].map(|reach| swing(time + reach) > 0.5).contains(&true);
            let far = [-0.019, 0.0, 0.019].map(|reach| swing(time + reach) > 0.49).contains(&true);
            assert!(if at_stop { far } else { !near || swing(*time) < 0.5 && !far }, "{time} {at_stop}");
        }
        // It passes the limit, or never comes there: it is no stop.
        assert!(looked([-2.0, 0.5], swing).flags(0, &times, 25.0).is_empty());
        assert!(looked([-2.0, 1.1], swing).flags(0, &times, 25.0).is_empty());
        // It was put there.
        assert!(looked([-2.0, 0.5], |_| 0.5).flags(0, &times, 25.0).is_empty());
    }
}
