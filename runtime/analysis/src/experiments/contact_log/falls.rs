//! Robots that fall: then links touch the ground at which no force is measured.
use super::ContactRecording;
use super::predict::orientation;
use crate::robot::{BaseKind, Robot};
use nalgebra::Vector3;

/// The base lies when it is tilted by more than this against how it began, rad.
const LIES: f64 = std::f64::consts::FRAC_PI_3;
/// What touches the ground does so some time before, s.
const BEFORE: f64 = 0.3;

impl ContactRecording {
    /// Leaves out what comes after the base has tipped over; tells when that begins, s.
    pub(super) fn keep_upright(&mut self, robot: &Robot<'_>) -> Option<f64> {
        let fallen = (0..self.time.len()).find(|i| self.tilt(robot.layout.base, *i) > LIES)?;
        let end = self.time[fallen] - BEFORE;
        let kept: Vec<usize> = self.kept.iter().copied().filter(|i| self.time[*i] < end).collect();
        if kept.len() < self.kept.len() {
            self.assumptions.push(format!(
                "the robot falls: from {end:.2} s on nothing is looked at, because links without sensors may touch the ground"
            ));
        }
        self.kept = kept;
        Some(end)
    }

    /// Of the base against the first sample, rad.
    fn tilt(&self, base: BaseKind, sample: usize) -> f64 {
        let [first, now] = [0, sample].map(|i| self.trajectory.part(i..i + 1).q);
        match base {
            BaseKind::Floating => {
                let up = orientation(first).inverse() * Vector3::z();
                (orientation(now) * up).angle(&Vector3::z())
            }
            BaseKind::Planar => (now[2] - first[2]).abs(),
            BaseKind::Fixed | BaseKind::Pivot => 0.0,
        }
    }
}
