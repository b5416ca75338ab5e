//! The simpler models of thesis 4.2 on a log: what leaving something out costs.
//!
//! - `point_feet`: the feet's forces act at the middle of the soles, without a moment (on the measured side).
//! - `single_mass`: the force is that of the whole model, the moment that of the force at the centre of mass: no rate
//!   of angular momentum about it.
//! - `decoupled_planes`: forces x, z and moment y come from a motion in the sagittal plane of the mean heading alone,
//!   force y and moment x from one in the frontal plane alone; all other coordinates are frozen at their means, and
//!   the moment z is zero. A joint is sagittal if it moves the centre of mass of the upright robot in x and z but not
//!   in y, frontal if in y and z but not in x; others (yaw) are frozen in both.
//! - `no_impact`: around every touch-down, from when the filter first sees the jump of velocities until it has
//!   forgotten it, accelerations are straight lines between those before and after.
use super::ContactExperiment;
use super::effects::Change;
use super::predict::{BaseWrench, State, orientation};
use crate::robot::BaseKind;
use crate::robot::coordinate;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};

/// A foot touches down when it carries this part of the weight,
const LOADED: f64 = 0.05;
/// having carried less for so long, s.
const UNLOADED: f64 = 0.1;
/// How long an impact lasts, s.
const IMPACT: f64 = 0.03;

/// What moves in a plane.
struct Plane {
    /// By joint.
    moves: Vec<bool>,
    sagittal: bool,
}

/// Means over the log, at which coordinates are frozen.
struct Means {
    joints: Vec<f64>,
    heading: f64,
}

impl ContactExperiment<'_> {
    /// What the motion needs by a simpler model, all samples.
    pub(super) fn simpler(&self, change: &Change) -> Vec<BaseWrench> {
        let mut states: Vec<State> = (0..self.samples()).map(|i| self.logged_state(i)).collect();
        if change.level.no_impact {
            self.smooth_impacts(&mut states);
        }
        let floating = self.robot.layout.base == BaseKind::Floating;
        // In the plane there is but one.
        let planes = (change.level.decoupled_planes && floating).then(|| (self.planes(), self.means()));
        let decoupled = |state: &State| match &planes {
            Some(([sagittal, frontal], means)) => self.decoupled(state, [sagittal, frontal], means, change),
            None => self.needed(state, change),
        };
        let center = change.level.single_mass.then(|| self.calls.find("center_of_mass").ok()).flatten();
        states
            .iter()
            .map(|state| {
                let mut needed = decoupled(state);
                if let Some(function) = center {
                    needed.moment = self.moment_of_force(function, state, &needed, change);
                }
                needed
            })
            .collect()
    }

    /// Moment of the force at the centre of mass, base axes. Payloads and the like move that centre.
    fn moment_of_force(
        &self,
        function: usize,
        state: &State,
        needed: &BaseWrench,
        change: &Change,
    ) -> Vector3<f64> {
        let [mut q, ..] = state.clone();
        change.world.correct(&mut q);
        let mut center = [0.0; 3];
        self.calls.at(function, &q, &mut center);
        let mut center = Vector3::from(center);
        let (mass, more) = (self.parameters.mass(), change.parameters.mass());
        if let Ok(regressor) = self.calls.find("center_of_mass_regressor") {
            let mut columns = vec![0.0; 3 * self.parameters.len()];
            self.calls.at(regressor, &q, &mut columns);
            let added = columns.chunks_exact(3).zip(&change.parameters);
            let added: Vector3<f64> = added.map(|(c, p)| Vector3::from_column_slice(c) * *p).sum();
            center = (center * mass + added) / (mass + more);
        }
        let arm = center - self.base_origin(&q);
        self.base_axes(&q).transpose() * arm.cross(&needed.force)
    }

    fn means(&self) -> Means {
        let first = self.calls.nq - self.robot.layout.joints.len();
        let count = self.samples() as f64;
        let sum = |k: usize| coordinate(&self.recording.trajectory.q, self.calls.nq, k).sum::<f64>();
        // Headings are averaged as directions: they may pass half a turn.
        let forward: Vector3<f64> =
            (0..self.samples()).map(|i| orientation(&self.logged_state(i)[0]) * Vector3::x()).sum();
        Means {
            joints: (first..self.calls.nq).map(|k| sum(k) / count).collect(),
            heading: forward.y.atan2(forward.x),
        }
    }

    /// Joints that move the centre of mass of the upright robot in one plane only.
    fn planes(&self) -> [Plane; 2] {
        let joints = self.robot.layout.joints.len();
        let rest = self.calls.rest(self.robot.layout.base);
        let mut jacobian = vec![0.0; 3 * self.calls.nv];
        match self.calls.find("center_of_mass_jacobian") {
            Ok(function) => self.calls.at(function, &rest, &mut jacobian),
            Err(_) => jacobian.fill(1.0),
        }
        let columns: Vec<&[f64]> = jacobian.chunks_exact(3).skip(self.calls.nv - joints).collect();
        let moves = |quiet: usize, other: usize| -> Vec<bool> {
            columns.iter().map(|c| c[quiet].abs() < 0.05 * c[other].abs()).collect()
        };
        [Plane { moves: moves(1, 0), sagittal: true }, Plane { moves: moves(0, 1), sagittal: false }]
    }

    fn decoupled(&self, state: &State, planes: [&Plane; 2], means: &Means, change: &Change) -> BaseWrench {
        let heading = Rotation3::new(Vector3::z() * means.heading);
        let [sagittal, frontal] = planes.map(|plane| {
            let wrench = self.needed(&in_plane(state, plane, means), change);
            (heading.inverse() * wrench.force, wrench.moment)
        });
        let force = Vector3::new(sagittal.0.x, frontal.0.y, sagittal.0.z);
        BaseWrench { force: heading * force, moment: Vector3::new(frontal.1.x, sagittal.1.y, 0.0) }
    }

    /// Replaces the accelerations around touch-downs.
    fn smooth_impacts(&self, states: &mut [State]) {
        let (r, count) = (&self.recording, states.len());
        let smear = 0.5 / r.cutoff_hz;
        for start in self.touch_downs() {
            let (from, to) = (r.time[start] - smear, r.time[start] + IMPACT + smear);
            let first = r.time.partition_point(|t| *t < from).saturating_sub(1);
            let last = r.time.partition_point(|t| *t <= to).min(count - 1);
            let (before, after) = (states[first][2].clone(), states[last][2].clone());
            let span = r.time[last] - r.time[first];
            for (state, time) in states.iter_mut().zip(&r.time).take(last).skip(first + 1) {
                let part = (time - r.time[first]) / span;
                state[2] = before.iter().zip(&after).map(|(b, a)| b + part * (a - b)).collect();
            }
        }
    }

    /// Samples at which a foot starts to carry weight.
    pub(super) fn touch_downs(&self) -> Vec<usize> {
        let weight = self.parameters.mass() * self.gravity.norm();
        let mut out = Vec::new();
        for record in self.recording.feet.iter().filter(|r| r.is_logged) {
            let mut free_since = None;
            for (i, signals) in record.signals.iter().enumerate() {
                let time = self.recording.time[i];
                if signals[2] < LOADED * weight {
                    free_since.get_or_insert(time);
                } else if let Some(since) = free_since.take()
                    && time - since > UNLOADED
                {
                    out.push(i);
                }
            }
        }
        out.sort_unstable();
        out
    }
}

/// A state with all but the motion in a plane frozen.
fn in_plane(state: &State, plane: &Plane, means: &Means) -> State {
    let [mut q, mut v, mut a] = state.clone();
    let heading = Rotation3::new(Vector3::z() * means.heading);
    let turn = orientation(&q).to_rotation_matrix();
    let linear = |x: &[f64]| Vector3::new(x[0], x[1], x[2]);
    let (omega, speed) = (Vector3::new(v[3], v[4], v[5]), linear(&v));
    // Of the point, not of its components in turning axes.
    let faster = heading.inverse() * (turn * (linear(&a) + omega.cross(&speed)));
    let speed = heading.inverse() * (turn * speed);
    let (roll, pitch, _) = (heading.inverse() * turn).euler_angles();
    let axis = if plane.sagittal { 1 } else { 0 };
    let angle = if plane.sagittal { pitch } else { roll };
    let unit = Vector3::ith(axis, 1.0);
    // In the sagittal plane nothing moves along y, about which it turns; in the frontal one nothing along x.
    let keep = |x: Vector3<f64>| x - unit * x[axis];
    let tilt = Rotation3::new(unit * angle);
    let turned = heading * tilt;
    q[3..7].copy_from_slice(UnitQuaternion::from_rotation_matrix(&turned).coords.as_slice());
    let (rate, growth) = (v[3 + axis], a[3 + axis]);
    let omega = unit * rate;
    let speed = tilt.inverse() * keep(speed);
    let faster = tilt.inverse() * keep(faster) - omega.cross(&speed);
    for k in 0..3 {
        (v[k], v[3 + k]) = (speed[k], omega[k]);
        (a[k], a[3 + k]) = (faster[k], unit[k] * growth);
    }
    for (j, _) in plane.moves.iter().enumerate().filter(|(_, moves)| !**moves) {
        (q[7 + j], v[6 + j], a[6 + j]) = (means.joints[j], 0.0, 0.0);
    }
    [q, v, a]
}
