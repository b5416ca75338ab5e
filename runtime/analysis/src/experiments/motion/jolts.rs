//! Short moments at which something shakes the robot far harder than all the rest of the log: a blow, a servo at a singular posture, a
//! cable that snaps.
//!
//! The filter sees less of such a motion than the sensors do, so that no model can tell the efforts there, and least squares would give
//! them all the weight. The motion alone decides: what efforts an effect leaves says nothing about it.

/// At a jolt a joint accelerates so many times harder than ever else.
const TIMES: f64 = 4.0;
/// Most jolts of a joint: what happens more often belongs to the motion.
const MOST: usize = 3;
/// Largest part of the samples near jolts, for the same reason.
const LARGEST_PART: f64 = 0.05;
/// Periods of the filter's cut-off before and after a jolt at which it is felt: the filter smears it, and drives answer it for a while.
const FELT: [f64; 2] = [1.0, 3.0];

/// Jolts of one joint.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Jolts {
    /// Index of the joint.
    pub joint: usize,
    /// First and last sample of each stretch that feels one.
    pub stretches: Vec<[usize; 2]>,
    /// Its hardest acceleration by that of the rest of the log.
    pub times: f64,
}

impl Jolts {
    /// Looks at a joint's accelerations at times that grow (s); `None`: it has none.
    pub fn of(joint: usize, accelerations: &[f64], time: &[f64], cutoff_hz: f64) -> Option<Self> {
        let [before, after] = FELT.map(|periods| periods / cutoff_hz);
        let mut near = vec![false; accelerations.len()];
        let hardest = |near: &[bool]| {
            let others = accelerations.iter().zip(near).enumerate().filter(|(_, (_, near))| !**near);
            others.map(|(i, (a, _))| (i, a.abs())).max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let mut found = None;
        let first = hardest(&near)?.1;
        for _ in 0..MOST {
            let (peak, size) = hardest(&near)?;
            let from = time.partition_point(|t| *t < time[peak] - before);
            let to = time.partition_point(|t| *t <= time[peak] + after);
            near[from..to].fill(true);
            let part = near.iter().filter(|near| **near).count() as f64 / near.len() as f64;
            if part > LARGEST_PART {
                break;
            }
            let rest = hardest(&near)?.1;
            if size > TIMES * rest {
                found = Some(Self { joint, stretches: stretches(&near), times: first / rest });
            }
        }
        found
    }

    /// One sentence on when, and what is done about it.
    pub fn words(&self, name: &str, time: &[f64]) -> String {
        let when =
            self.stretches.iter().map(|[first, last]| format!("{:.3} to {:.3} s", time[*first], time[*last]));
        format!(
            "`{name}` is shaken from {}, {:.0} times as hard as ever else and faster than the filter sees: the efforts of all joints are left out there",
            when.collect::<Vec<_>>().join(" and "),
            self.times
        )
    }
}

/// Samples at which any joint feels a jolt, one flag each; empty: none.
pub(super) fn flags(jolts: &[Jolts], samples: usize) -> Vec<bool> {
    let mut flags = vec![false; if jolts.is_empty() { 0 } else { samples }];
    let stretches = jolts.iter().flat_map(|jolts| &jolts.stretches);
    stretches.for_each(|[first, last]| flags[*first..=*last].fill(true));
    flags
}

/// First and last index of each run of set flags.
fn stretches(flags: &[bool]) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for index in (0..flags.len()).filter(|index| flags[*index]) {
        match runs.last_mut() {
            Some([_, last]) if *last + 1 == index => *last = index,
            _ => runs.push([index, index]),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUTOFF: f64 = 10.0;

    /// Ten seconds at 250 Hz of a swing, with what is added to its accelerations.
    fn shaken(added: impl Fn(f64) -> f64) -> Option<Jolts> {
        let time: Vec<f64> = (0..2500).map(|i| f64::from(i) / 250.0).collect();
        let accelerations: Vec<f64> = time.iter().map(|t| 5.0 * (3.0 * t).sin() + added(*t)).collect();
        Jolts::of(0, &accelerations, &time, CUTOFF)
    }

    fn pulse(t: f64, middle: f64, size: f64) -> f64 {
        size * (-((t - middle) / 0.02).powi(2)).exp()
    }

    #[test]
    fn a_blow_is_found_with_the_time_around_it() {
        let jolts = shaken(|t| pulse(t, 4.0, 100.0)).unwrap();
        assert_eq!(jolts.stretches, [[975, 1075]]);
        assert!(jolts.times > 15.0, "{jolts:?}");
        assert!(jolts.words("knee", &[0.0; 2500]).contains("`knee` is shaken from 0.000 to 0.000 s"));
        assert_eq!(flags(&[jolts], 2500).iter().filter(|flag| **flag).count(), 101);
    }

    #[test]
    fn what_happens_often_belongs_to_the_motion() {
        assert_eq!(shaken(|t| (0..5).map(|k| pulse(t, 1.0 + 2.0 * f64::from(k), 100.0)).sum()), None);
        assert_eq!(shaken(|t| pulse(t, 4.0, 14.0)), None);
        assert_eq!(shaken(|_| 0.0), None);
    }

    #[test]
    fn a_robot_that_rests_but_for_one_motion_is_not_shaken() {
        let time: Vec<f64> = (0..2500).map(|i| f64::from(i) / 250.0).collect();
        let moves = |t: f64| if (4.0..5.0).contains(&t) { 5.0 * (12.56 * t).sin() } else { 0.0 };
        let accelerations: Vec<f64> = time.iter().map(|t| moves(*t)).collect();
        assert_eq!(Jolts::of(0, &accelerations, &time, CUTOFF), None);
    }
}
