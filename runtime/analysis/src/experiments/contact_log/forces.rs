//! Forces on the feet at the samples of a log, filtered, and what they do to the robot's coordinates.
use super::foot::FootRecord;
use super::passing::Passing;
use crate::log::Block;
use crate::measure::acceleration_noise::AccelerationNoise;
use crate::measure::filtered::noise_gains;
use crate::measure::stops::Stops;
use crate::measure::trajectory::{Even, States, Unusable};
use crate::robot::Robot;
use crate::robot::Trajectory;
use crate::robot::calls::ModelCalls;
use crate::robot::feet::{FootCalls, Sole};
use crate::signal::Butterworth;
use bipedc_effects::diagnostic::Diagnostic;
use nalgebra::Vector3;
use std::ops::Range;

/// Stretches of fewer samples are left out: a spline needs so many.
pub(super) const SHORTEST: usize = 16;

/// Motion and foot forces of a log; states as the model has them.
#[derive(Debug, Clone, Default)]
pub struct ContactRecording {
    /// Times of the samples, s.
    pub time: Vec<f64>,
    /// Stretches without gaps, as ranges of samples.
    pub segments: Vec<Range<usize>>,
    /// Whether a segment begins and ends at an impact; one per segment.
    pub(super) at_impacts: Vec<[bool; 2]>,
    /// Samples that count: within the times asked for, not near the ends of a stretch.
    pub kept: Vec<usize>,
    pub(super) trajectory: Trajectory,
    pub(super) feet: Vec<FootRecord>,
    /// What filtering one by one has lost of inverse dynamics less `Jᵀ w`, `samples × nv`: see [`super::products`].
    pub(super) products: Vec<f64>,
    /// Logged efforts by joint, through the filter; N m.
    pub(super) effort: Vec<Option<Vec<f64>>>,
    /// Logged motor angle (divided by the gear ratio) minus joint angle, by joint, not filtered; rad.
    pub(super) transmission: Vec<Option<Vec<f64>>>,
    /// Motions of motors beside those of their joints, through the filter: rad, rad/s, rad/s².
    pub(super) motors: Vec<Option<Vec<[f64; 3]>>>,
    /// Joints whose motor's angle stands for theirs.
    pub(super) motor_side: Vec<bool>,
    /// Noise of efforts as logged.
    pub(super) effort_noise: Vec<f64>,
    /// Noise of each coordinate as logged (floating base: linear in world axes, then angles).
    pub(super) position_noise: Vec<f64>,
    /// Parts of a white noise's variance that remain in a value and in a second derivative, after one and after two passes of
    /// the filter.
    pub(super) noise_gains: [[f64; 2]; 2],
    /// The same of a first derivative after one pass.
    pub(super) velocity_gain: f64,
    /// Noise of the joints' accelerations, after one and after two passes of the filter.
    pub(super) joint_noise: [Vec<f64>; 2],
    /// When joints lay at their stops.
    pub(super) stops: Stops,
    /// Whether rows pass the filter once more, which they do unless this is changed: measured and predicted alike,
    /// because accelerations are noisiest just below the cut-off.
    pub filter_rows: bool,
    /// The foot that carries the base and stands still, where the log has no motion of the base.
    pub(super) standing: Option<usize>,
    /// Sampling step, s.
    pub step: f64,
    /// Cut-off of the filter, Hz.
    pub cutoff_hz: f64,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
    /// What is odd about the log.
    pub warnings: Vec<Diagnostic>,
}

impl ContactRecording {
    /// Adds what lies between two impacts or ends of the block; `impacts`: whether one is at its begin, at its end.
    pub(super) fn add_stretch(
        &mut self,
        passing: &Passing<'_, '_>,
        block: &Block<'_>,
        impacts: [bool; 2],
    ) -> Result<(), Unusable> {
        let range = block.core.clone();
        let even = Even::new(&passing.columns.plan, block, passing.step);
        let states = even.states(
            &passing.columns.plan,
            passing.robot.layout,
            passing.filter,
            block.time,
            range.clone(),
        )?;
        let States { q, v, a, count } = &states;
        let (nq, nv) = (q.len() / count, v.len() / count);
        let first = self.time.len();
        let here = block.time[range.start];
        let step = passing.step;
        let continues = !impacts[0]
            && self.time.last().is_some_and(|last| here - last < (passing.stride as f64 + 0.5) * step);
        // The stride goes on where the last block left off.
        let skipped = self
            .time
            .last()
            .filter(|_| continues)
            .map_or(0, |last| passing.stride.saturating_sub(((here - last) / step).round() as usize));
        let kept: Vec<usize> = (skipped..*count).step_by(passing.stride).collect();
        match (self.segments.last_mut(), self.at_impacts.last_mut()) {
            (Some(last), Some(ends)) if continues => {
                last.end = first + kept.len();
                ends[1] = impacts[1];
            }
            _ => {
                self.segments.push(first..first + kept.len());
                self.at_impacts.push(impacts);
            }
        }
        for &i in &kept {
            self.time.push(block.time[range.start + i]);
            let of = |width: usize| i * width..(i + 1) * width;
            self.trajectory.extend([&q[of(nq)], &v[of(nv)], &a[of(nv)]]);
        }
        let at: Vec<usize> = kept.iter().map(|i| range.start + i).collect();
        for (foot, record) in passing.robot.feet.iter().zip(&mut self.feet).filter(|(_, r)| r.is_logged) {
            record.add(passing, block, foot, &at)?;
        }
        for (joint, values) in passing.columns.plan.joints.iter().zip(&mut self.effort) {
            if let (Some(column), Some(values)) = (joint.effort, values) {
                values.extend(passing.smooth(block, &block.columns[column], &at)?);
            }
        }
        self.add_motors(passing, (&even, block), &at)?;
        self.add_products(passing, (&even, block), &at)
    }

    /// Angles of motors beside those of their joints.
    fn add_motors(
        &mut self,
        passing: &Passing<'_, '_>,
        (even, block): (&Even, &Block<'_>),
        at: &[usize],
    ) -> Result<(), Unusable> {
        for (joint, columns) in passing.columns.plan.joints.iter().enumerate() {
            let (Some(motor), Some(position)) = (columns.motor_position, columns.position) else { continue };
            let [motor, position] = [motor, position].map(|column| &block.columns[column]);
            if let Some(values) = &mut self.transmission[joint] {
                values.extend(at.iter().map(|i| motor[*i] - position[*i]));
            }
            if let Some(values) = &mut self.motors[joint] {
                let all = even.motion_of(motor, passing.filter, block.time, 0..block.time.len())?;
                values.extend(at.iter().map(|i| all[*i]));
            }
        }
        Ok(())
    }

    /// Values at the samples that count.
    pub(super) fn pick<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.kept.iter().map(|i| values[*i]).collect()
    }

    /// A signal of all samples through the filter once more, at the samples that count.
    pub(super) fn smooth(&self, values: &[f64]) -> Vec<f64> {
        let filter = Butterworth::new(self.cutoff_hz, 1.0 / self.step).ok().filter(|_| self.filter_rows);
        let Some(filter) = filter else { return self.pick(values) };
        let parts = self.segments.iter().flat_map(|s| filter.zero_phase(&values[s.clone()]));
        self.pick(&parts.collect::<Vec<f64>>())
    }

    /// Noise after the filter.
    pub(super) fn finish(&mut self, passing: &Passing<'_, '_>, raw: &[f64], joints: &AccelerationNoise) {
        self.noise_gains = [1, 2].map(|passes| {
            let [value, _, second] = noise_gains(passing.filter, passing.step, passes);
            [value, second]
        });
        self.velocity_gain = noise_gains(passing.filter, passing.step, 1)[1];
        self.joint_noise = [1, 2].map(|passes| joints.levels(passing.filter, passing.step, passes));
        let plan = &passing.columns.plan;
        let noise = |column: Option<usize>| column.and_then(|c| raw.get(c)).copied().unwrap_or(0.0);
        let mut all: Vec<f64> = vec![0.0; if self.standing.is_some() { 6 } else { 0 }];
        if let Some(base) = &plan.base {
            let each: Vec<f64> = base.0.iter().map(|c| noise(Some(*c))).collect();
            all.extend(&each[..3.min(each.len())]);
            if let Some(quaternion) = each.get(3..7) {
                // ω̇ = 2 vec(q* q̈): its length is one, so that the noise of its four elements is that of three axes.
                let mean = (quaternion.iter().map(|n| n * n).sum::<f64>() / 3.0).sqrt();
                all.extend([2.0 * mean; 3]);
            }
        }
        all.extend(plan.joints.iter().map(|joint| noise(joint.position)));
        self.position_noise = all;
        self.effort_noise = plan.joints.iter().map(|joint| noise(joint.effort)).collect();
    }

    /// Part of a white noise's variance that remains in values of the rows.
    pub(super) fn noise_gain(&self) -> f64 {
        self.noise_gains[usize::from(self.filter_rows)][0]
    }

    /// One standard deviation of each coordinate's acceleration in the rows (floating base: linear in world axes, then angles);
    /// m/s², rad/s².
    pub(super) fn acceleration_noise(&self) -> Vec<f64> {
        let rows = usize::from(self.filter_rows);
        let (gain, joints) = (self.noise_gains[rows][1].sqrt(), &self.joint_noise[rows]);
        let base = &self.position_noise[..self.position_noise.len() - joints.len()];
        base.iter().map(|sigma| sigma * gain).chain(joints.iter().copied()).collect()
    }

    /// Part of a white noise's variance that remains in values that passed the filter once.
    pub(super) fn value_gain(&self) -> f64 {
        self.noise_gains[0][0]
    }

    /// Generalised forces of the ground on the robot, `Jᵀ w`, for configurations at these times; `times × nv`, as the
    /// model has them. Inverse dynamics minus this is the effort under the feet's forces.
    ///
    /// `time` may be any times of samples of this recording; the nearest one counts.
    ///
    /// # Errors
    /// The model has no `position_of_…`, `rotation_of_…` or `jacobian_of_…` of the feet's links.
    pub fn generalised_forces(
        &self,
        robot: &Robot<'_>,
        time: &[f64],
        q: &[f64],
    ) -> Result<Vec<f64>, Diagnostic> {
        let calls = ModelCalls::new(robot.model);
        let feet =
            robot.feet.iter().map(|foot| FootCalls::new(&calls, foot)).collect::<Result<Vec<_>, _>>()?;
        let mut out = Vec::with_capacity(time.len() * calls.nv);
        for (t, q) in time.iter().zip(q.chunks_exact(calls.nq)) {
            let sample = self.nearest(*t);
            let wrenches =
                |foot: usize, sole: &Sole| self.feet[foot].wrench(sole, &self.feet[foot].signals[sample]);
            out.extend(mapped(robot, &calls, &feet, q, &self.logged(), wrenches));
        }
        Ok(out)
    }

    /// Mean square of each joint's speed beyond its noise, and of that noise, rad²/s² or m²/s², at the samples that count.
    pub fn motion(&self) -> Vec<[f64; 2]> {
        let joints = self.effort.len();
        let noise = &self.position_noise[self.position_noise.len() - joints..];
        let of_joint = |joint: usize, noise: f64| {
            let speeds: Vec<f64> = self.trajectory.velocities(joint).collect();
            let square =
                self.kept.iter().map(|i| speeds[*i].powi(2)).sum::<f64>() / self.kept.len().max(1) as f64;
            let noise = noise.powi(2) * self.velocity_gain;
            [(square - noise).max(0.0), noise]
        };
        noise.iter().enumerate().map(|(joint, noise)| of_joint(joint, *noise)).collect()
    }

    /// Whether the effort of any joint is logged.
    pub fn has_efforts(&self) -> bool {
        self.effort.iter().any(Option::is_some)
    }

    /// Which feet have forces.
    pub(super) fn logged(&self) -> Vec<bool> {
        self.feet.iter().map(|foot| foot.is_logged).collect()
    }

    fn nearest(&self, time: f64) -> usize {
        let after = self.time.partition_point(|t| *t < time).min(self.time.len() - 1);
        let before = after.saturating_sub(1);
        if (self.time[before] - time).abs() < (self.time[after] - time).abs() { before } else { after }
    }
}

/// `Jᵀ w` over all feet with forces, nv values; `wrench` gives force and moment about the sole's origin in world axes.
pub(super) fn mapped(
    robot: &Robot<'_>,
    calls: &ModelCalls<'_>,
    feet: &[FootCalls],
    q: &[f64],
    logged: &[bool],
    wrench: impl Fn(usize, &Sole) -> (Vector3<f64>, Vector3<f64>),
) -> Vec<f64> {
    let mut out = vec![0.0; calls.nv];
    let mut jacobian = Vec::new();
    for (f, foot) in robot.feet.iter().enumerate().filter(|(f, _)| logged[*f]) {
        let sole = feet[f].sole(calls, foot, q);
        let (force, moment) = wrench(f, &sole);
        // The jacobian is of the link's origin.
        let moment = moment + sole.below.cross(&force);
        feet[f].jacobian(calls, q, &mut jacobian);
        for (out, column) in out.iter_mut().zip(jacobian.chunks_exact(6)) {
            *out += force.x * column[0] + force.y * column[1] + force.z * column[2];
            *out += moment.x * column[3] + moment.y * column[4] + moment.z * column[5];
        }
    }
    out
}
