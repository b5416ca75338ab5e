//! When joints lie at their stops: the stop carries a torque there that no drive feels, so that the effort is a bound and tells nothing.
use crate::log::Block;
use crate::measure::columns::Plan;
use crate::measure::noise::of_encoders;
use crate::parallel::parallel;
use crate::robot::JointLayout;

/// A joint lies at its stop within this part of the way between its stops.
const NEAR: f64 = 2e-3;
/// A joint that is there for more of the log than this is looked at more closely: it lies at its stop where it is no farther from the outermost
/// place that it takes than the noise of its position tells. One that is there, too, was put there: its stop may carry nothing.
const MOST: f64 = 0.9;
/// Noise of a position stays within so many standard deviations, as good as ever.
const WITHIN: f64 = 4.5;
/// Stops yield by this part of the way between them, however little noise there is.
const YIELDS: f64 = 1e-4;
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
    /// What the noise of the position does, either way.
    reach: f64,
    at: [Vec<Stay>; 2],
    /// The joint was seen beyond it, so that it is no stop.
    beyond: [bool; 2],
}

/// A joint near its stop, at one place as far as its noise tells.
#[derive(Debug, Clone)]
struct Stay {
    /// First and last time, s.
    times: [f64; 2],
    /// Least and largest way to the stop.
    ways: [f64; 2],
}

impl Stops {
    pub(crate) fn new(layout: &JointLayout, plan: &Plan) -> Self {
        let joints = layout.joints.iter().zip(&plan.joints).map(|(joint, columns)| {
            let limits = joint.limits.filter(|[low, high]| low < high)?;
            // What the motor's encoder tells is not where the joint is.
            let position = columns.position.filter(|_| !columns.by_motor);
            Some(OfJoint { position, ..OfJoint::between(limits) })
        });
        Self { joints: joints.collect(), seen: 0.0 }
    }

    /// Looks at the samples of a block that count.
    pub(crate) fn look(&mut self, block: &Block<'_>, step: f64) {
        let core = block.core.clone();
        self.seen += step * core.len() as f64;
        let near = parallel(self.joints.len(), |joint| {
            let joint = self.joints[joint].as_ref()?;
            let angles = &block.columns[joint.position?];
            angles.iter().any(|angle| joint.is_near(*angle)).then(|| of_encoders(angles, 1))
        });
        for (joint, noise) in self.joints.iter_mut().zip(near) {
            let Some((joint, position)) = joint.as_mut().and_then(|joint| joint.position.map(|p| (joint, p)))
            else {
                continue;
            };
            if let Some(noise) = noise {
                joint.hear(noise);
            }
            let samples = block.time[core.clone()].iter().zip(&block.columns[position][core.clone()]);
            samples.for_each(|(time, angle)| joint.add(*time, *angle, step));
        }
    }

    /// First and last times at which a joint lay at a stop, s.
    fn times(&self, joint: usize) -> Vec<[f64; 2]> {
        let Some(Some(of)) = self.joints.get(joint) else { return Vec::new() };
        (0..2).filter(|side| !of.beyond[*side]).flat_map(|side| of.times(side, MOST * self.seen)).collect()
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

    /// The stop at which a joint lay all along, if it did: -1 for the lower one, which pushes upwards, 1 for the upper one.
    pub(crate) fn always(&self, joint: usize) -> Option<f64> {
        let of = self.joints.get(joint)?.as_ref()?;
        let lies =
            |side: &usize| !of.beyond[*side] && of.closest(*side) >= MOST * self.seen && self.seen > 0.0;
        (0..2).find(lies).map(|side| if side == 0 { -1.0 } else { 1.0 })
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
    fn between(limits: [f64; 2]) -> Self {
        let way = limits[1] - limits[0];
        let at = [Vec::new(), Vec::new()];
        Self { position: None, limits, near: NEAR * way, reach: YIELDS * way, at, beyond: [false; 2] }
    }

    /// Ways to both stops.
    fn ways(&self, angle: f64) -> [f64; 2] {
        [angle - self.limits[0], self.limits[1] - angle]
    }

    fn is_near(&self, angle: f64) -> bool {
        self.ways(angle).iter().any(|way| *way <= self.near)
    }

    /// Of the loudest block the noise counts.
    fn hear(&mut self, noise: f64) {
        self.reach = self.reach.max(WITHIN * noise);
    }

    fn add(&mut self, time: f64, angle: f64, step: f64) {
        let ways = self.ways(angle);
        for ((way, beyond), at) in ways.into_iter().zip(&mut self.beyond).zip(&mut self.at) {
            *beyond |= way < -self.near;
            if way > self.near {
                continue;
            }
            let until = time + step;
            match at.last_mut().filter(|stay| time - stay.times[1] < 1.5 * step) {
                Some(stay) => {
                    let from = stay.times[1];
                    if !stay.goes_on(until, way, self.reach) {
                        // Somewhere else, without a gap between.
                        at.push(Stay { times: [from, until], ways: [way; 2] });
                    }
                }
                None => at.push(Stay { times: [time, until], ways: [way; 2] }),
            }
        }
    }

    /// First and last times at which it lay at one of its stops, for no more than `most` of all; s.
    fn times(&self, side: usize, most: f64) -> Vec<[f64; 2]> {
        let near = joined(self.at[side].iter());
        let found = if duration(&near) < most { near } else { self.at_outermost(side) };
        if duration(&found) < most { found } else { Vec::new() }
    }

    /// First and last times at the outermost place that it takes.
    fn at_outermost(&self, side: usize) -> Vec<[f64; 2]> {
        let at = &self.at[side];
        let outermost = at.iter().map(|stay| stay.ways[0]).fold(f64::INFINITY, f64::min);
        let closely = |stay: &&Stay| 0.5 * (stay.ways[0] + stay.ways[1]) - outermost <= 2.0 * self.reach;
        joined(at.iter().filter(closely))
    }

    /// How long it was there, s.
    fn closest(&self, side: usize) -> f64 {
        duration(&self.at_outermost(side))
    }
}

impl Stay {
    /// Whether it is the same place still.
    fn goes_on(&mut self, until: f64, way: f64, reach: f64) -> bool {
        let ways = [self.ways[0].min(way), self.ways[1].max(way)];
        let same = ways[1] - ways[0] <= 2.0 * reach;
        if same {
            *self = Self { times: [self.times[0], until], ways };
        }
        same
    }
}

/// First and last times of stays, those as one that follow each other.
fn joined<'s>(stays: impl Iterator<Item = &'s Stay>) -> Vec<[f64; 2]> {
    let mut joined: Vec<[f64; 2]> = Vec::new();
    for Stay { times: [first, last], .. } in stays {
        match joined.last_mut() {
            Some([_, until]) if first <= until => *until = *last,
            _ => joined.push([*first, *last]),
        }
    }
    joined
}

/// s
fn duration(times: &[[f64; 2]]) -> f64 {
    times.iter().map(|[first, last]| last - first).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn looked(limits: [f64; 2], angle: impl Fn(f64) -> f64) -> Stops {
        let mut joint = OfJoint::between(limits);
        let times: Vec<f64> = (0..4000).map(|i| 1e-3 * f64::from(i)).collect();
        joint.hear(of_encoders(&times.iter().map(|time| angle(*time)).collect::<Vec<_>>(), 1));
        times.iter().for_each(|time| joint.add(*time, angle(*time), 1e-3));
        Stops { joints: vec![Some(joint)], seen: 4.0 }
    }

    /// Of 4 s 3.8 s are spent near the stop, 2 s of them at it: so a knee does that hardly leaves it.
    #[test]
    fn a_joint_that_is_always_near_its_stop_lies_at_it_where_its_noise_says_so() {
        let noise = |time: f64| 1e-4 * (1.7e5 * time).sin();
        let knee = |time: f64| match time.rem_euclid(2.0) {
            phase if phase < 1.0 => 0.0,
            phase if phase < 1.9 => 2e-3 * (std::f64::consts::PI * (phase - 1.0) / 0.9).sin(),
            phase => 0.1 * (std::f64::consts::PI * (phase - 1.9) / 0.1).sin(),
        };
        let times: Vec<f64> = (0..4000).map(|i| 1e-3 * f64::from(i)).collect();
        let found = looked([0.0, 2.1], |time| knee(time) + noise(time));
        let spent = duration(&found.times(0));
        assert!((2.0..2.6).contains(&spent), "{spent}");
        for (time, at_stop) in times.iter().zip(found.flags(0, &times, 250.0)) {
            let phase = time.rem_euclid(2.0);
            assert!(at_stop || phase > 0.999, "{time}");
            assert!(!at_stop || !(1.15..1.75).contains(&phase), "{time}");
        }
        // Held at it all the time.
        let held = looked([0.0, 2.1], noise);
        assert!(held.times(0).is_empty() && held.always(0) == Some(-1.0));
        assert!(looked([-2.1, 0.0], noise).always(0) == Some(1.0) && found.always(0).is_none());
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
