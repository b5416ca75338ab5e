//! Forces and moments on the base: those that the motion needs, and those that the feet report.
use super::ContactExperiment;
use super::effects::Change;
use super::forces::mapped;
use crate::robot::BaseKind;
use crate::robot::feet::Sole;
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// A force (world axes as logged, N) and a moment about the base's origin (base axes, N m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BaseWrench {
    pub force: Vector3<f64>,
    pub moment: Vector3<f64>,
}

/// A state of the robot: q, v, a.
pub(super) type State = [Vec<f64>; 3];

impl ContactExperiment<'_> {
    /// The logged state of a sample.
    pub(super) fn logged_state(&self, i: usize) -> State {
        let state = self.recording.trajectory.part(i..i + 1);
        [state.q.to_vec(), state.v.to_vec(), state.a.to_vec()]
    }

    /// The same with links that a change puts behind their motors.
    pub(super) fn moved_state(&self, i: usize, change: &Change) -> State {
        let mut state = self.logged_state(i);
        let base = self.robot.layout.base;
        for link in &change.behind {
            let [q, v] = [base.nq(), base.nv()].map(|first| first + link.joint);
            for (values, (at, moved)) in state.iter_mut().zip([q, v, v].into_iter().zip(link.behind[i])) {
                values[at] += moved;
            }
        }
        state
    }

    /// Axes of the base in the log's world.
    pub(super) fn base_axes(&self, q: &[f64]) -> Matrix3<f64> {
        match self.robot.layout.base {
            BaseKind::Floating => orientation(q).to_rotation_matrix().into_inner(),
            BaseKind::Planar => Rotation3::new(Vector3::y() * q[2]).into_inner(),
            BaseKind::Fixed | BaseKind::Pivot => Matrix3::identity(),
        }
    }

    /// Origin of the base, m.
    pub(super) fn base_origin(&self, q: &[f64]) -> Vector3<f64> {
        match self.robot.layout.base {
            BaseKind::Floating => Vector3::new(q[0], q[1], q[2]),
            BaseKind::Planar => Vector3::new(q[0], 0.0, q[1]),
            BaseKind::Fixed | BaseKind::Pivot => Vector3::zeros(),
        }
    }

    /// Generalised forces of the base as force and moment; `axes` are those of the base.
    pub(super) fn base_wrench(&self, tau: &[f64], axes: &Matrix3<f64>) -> BaseWrench {
        match self.robot.layout.base {
            BaseKind::Floating => BaseWrench {
                force: axes * Vector3::new(tau[0], tau[1], tau[2]),
                moment: Vector3::new(tau[3], tau[4], tau[5]),
            },
            BaseKind::Planar => {
                BaseWrench { force: Vector3::new(tau[0], 0.0, tau[1]), moment: Vector3::y() * tau[2] }
            }
            BaseKind::Fixed | BaseKind::Pivot => {
                BaseWrench { force: Vector3::zeros(), moment: Vector3::zeros() }
            }
        }
    }

    /// What the motion needs at a state that was logged so.
    pub(super) fn needed(&self, state: &State, change: &Change) -> BaseWrench {
        let axes = self.base_axes(&state[0]);
        let [q, v, a] = self.true_state(state, change);
        let mut tau = vec![0.0; self.calls.nv];
        self.calls.moving(self.inverse_dynamics, &q, &v, &a, &mut tau);
        if change.parameters.iter().any(|p| *p != 0.0) {
            let mut regressor = vec![0.0; self.calls.nv * self.parameters.len()];
            self.calls.moving(self.regressor, &q, &v, &a, &mut regressor);
            let columns = regressor.chunks_exact(self.calls.nv).zip(&change.parameters);
            for (column, parameter) in columns.filter(|(_, p)| **p != 0.0) {
                tau.iter_mut().zip(column).for_each(|(tau, y)| *tau += y * parameter);
            }
        }
        let mut wrench = self.base_wrench(&tau, &axes);
        if self.robot.layout.base == BaseKind::Planar {
            // Computed in the true world; rows are in the logged one.
            wrench.force = change.world.tilt.transpose() * wrench.force;
        }
        wrench
    }

    /// Joints without their encoders' offsets, and the base as it is oriented in truth.
    ///
    /// A floating base's velocities are in its own axes: whatever the world, they stay.
    pub(super) fn true_state(&self, state: &State, change: &Change) -> State {
        let [mut q, mut v, mut a] = state.clone();
        change.world.correct(&mut q);
        let tilt = &change.world.tilt;
        if *tilt == Matrix3::identity() {
            return [q, v, a];
        }
        match self.robot.layout.base {
            BaseKind::Floating => {
                let tilt = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*tilt));
                let turned = tilt * orientation(&q);
                q[3..7].copy_from_slice(turned.coords.as_slice());
            }
            BaseKind::Planar => {
                q[2] += tilt[(0, 2)].atan2(tilt[(2, 2)]);
                for vector in [&mut v, &mut a] {
                    let turned = tilt * Vector3::new(vector[0], 0.0, vector[1]);
                    (vector[0], vector[1]) = (turned.x, turned.z);
                }
            }
            BaseKind::Fixed | BaseKind::Pivot => {}
        }
        [q, v, a]
    }

    /// What the feet report.
    pub(super) fn reported(&self, i: usize, change: &Change) -> BaseWrench {
        let [q, ..] = self.kinematics(i, change);
        let wrench = |f: usize, sole: &Sole| {
            let signals = self.true_signals(f, i, sole, change);
            let (force, moment) = self.recording.feet[f].wrench(sole, &signals);
            if change.level.point_feet {
                // A point carries no moment: the force acts at the middle of the sole.
                return (force, (sole.rotation * self.robot.feet[f].center()).cross(&force));
            }
            (force, moment)
        };
        let mut tau = mapped(&self.robot, &self.calls, &self.feet, &q, &self.recording.logged(), wrench);
        let lost = &self.recording.products[i * self.calls.nv..];
        tau.iter_mut().zip(lost).for_each(|(tau, lost)| *tau -= lost);
        self.base_wrench(&tau, &self.base_axes(&q))
    }

    /// The logged state with joints as they are in truth, in the world as logged.
    pub(super) fn kinematics(&self, i: usize, change: &Change) -> State {
        let [mut q, v, a] = self.moved_state(i, change);
        change.world.correct(&mut q);
        [q, v, a]
    }

    /// A force of 1 N along a sole's normal at a point of its frame, on the base.
    pub(super) fn unit_normal(
        &self,
        i: usize,
        foot: usize,
        at: &Vector3<f64>,
        change: &Change,
    ) -> BaseWrench {
        let [q, ..] = self.kinematics(i, change);
        let wrench = |f: usize, sole: &Sole| {
            let force = if f == foot { sole.rotation.column(2).into_owned() } else { Vector3::zeros() };
            (force, (sole.rotation * at).cross(&force))
        };
        let tau = mapped(&self.robot, &self.calls, &self.feet, &q, &self.recording.logged(), wrench);
        self.base_wrench(&tau, &self.base_axes(&q))
    }

    /// Mean height of the soles, weighted by their normal forces, m.
    pub(super) fn ground_height(&self, i: usize, change: &Change) -> f64 {
        let [q, ..] = self.kinematics(i, change);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (f, record) in self.recording.feet.iter().enumerate().filter(|(_, r)| r.is_logged) {
            let load = record.signals[i][2].max(1e-3);
            sum += load * self.feet[f].sole(&self.calls, &self.robot.feet[f], &q).origin.z;
            weights += load;
        }
        sum / weights
    }
}

/// Orientation of a floating base.
pub(super) fn orientation(q: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5]))
}
