//! Joint torques of a robot on its feet, beside the rows of its base.
//!
//! A joint's row is the logged effort minus `(D q̈ + H − Jᵀ w)`: inverse dynamics under the forces that the feet report.
//! Effort, motion and forces passed the same zero-phase filter, and all rows pass it once more. A joint whose torque
//! depends on a moment about the vertical that no foot logs has no row.
use super::effects::Change;
use super::foot::SIGNALS;
use super::forces::mapped;
use super::rows::NOISE_SAMPLES;
use super::{ContactExperiment, ContactRecording};
use crate::experiments::{Experiment, Inertial, MotionExperiment, Row};
use crate::log::Log;
use crate::measure::{Missing, Options, Recording};
use crate::robot::InertialParameters;
use crate::robot::LinkInertias;
use crate::robot::Robot;
use crate::robot::feet::Sole;
use bipedc_effects::diagnostic::Diagnostics;
use bipedc_effects::effect::{Effect, Kind, Law, Location};
use nalgebra::Vector3;
use std::sync::OnceLock;

/// A joint that feels more than this part of a moment about the vertical at a foot has no row unless it is logged.
const FELT: f64 = 0.3;

/// A log of a free robot with foot forces and joint efforts: base rows first, then joints.
pub struct WalkingExperiment<'a> {
    base: ContactExperiment<'a>,
    joints: MotionExperiment<'a>,
    rows: Vec<Row>,
    /// Of the joints' rows, at the samples that count.
    residual: Vec<Vec<f64>>,
    inertial: OnceLock<Vec<Option<Inertial>>>,
    /// Joints without a row, and why.
    pub missing: Vec<Missing>,
}

impl<'a> WalkingExperiment<'a> {
    /// Reads a log as [`ContactExperiment::read`]; joints without an effort have no row.
    ///
    /// # Errors
    /// As [`ContactExperiment::read`].
    pub fn read(robot: Robot<'a>, log: &Log, options: &Options) -> Result<Self, Diagnostics> {
        Self::new(ContactExperiment::read(robot, log, options)?)
            .map_err(|e| Diagnostics(vec![e.in_file(log.path())]))
    }

    /// From the rows of the base.
    ///
    /// # Errors
    /// A model that lacks functions or is another robot's.
    pub fn new(base: ContactExperiment<'a>) -> Result<Self, bipedc_effects::diagnostic::Diagnostic> {
        let robot = base.robot;
        let nominal = base.change(&[]);
        let mut motion = base.recording.motion();
        let missing = base.without_vertical_moment(&mut motion);
        let ground = base.ground_forces(&nominal);
        // The effects on masses are in the joints' rows as in those of the base.
        let joints = MotionExperiment::on_ground(
            robot.model,
            robot.layout,
            robot.link_inertias,
            motion,
            robot.effects,
            ground,
        )?;
        let residual: Vec<Vec<f64>> =
            (0..joints.rows().len()).map(|row| base.recording.smooth(joints.residual(row))).collect();
        let noise = base.joint_noise(&nominal);
        let mut rows = base.rows().to_vec();
        rows.extend(joints.rows().iter().cloned());
        for row in &mut rows {
            let joint = row.joint.as_ref();
            let index = joint.and_then(|name| robot.layout.joints.iter().position(|j| j.name == *name));
            if let Some(index) = index {
                row.noise = noise[index].max(1e-9);
            }
        }
        Ok(Self { base, joints, rows, residual, inertial: OnceLock::new(), missing })
    }

    /// The rows of the base.
    pub fn base(&self) -> &ContactExperiment<'a> {
        &self.base
    }

    fn first(&self) -> usize {
        self.base.rows.len()
    }

    /// Derivatives of the joints' rows through the filter, like the rows themselves.
    fn joint_inertial(&self) -> Vec<Option<Inertial>> {
        let smooth = |inertial: &Inertial| {
            let width = inertial.columns.len();
            let column =
                |k: usize| inertial.values.iter().skip(k).step_by(width).copied().collect::<Vec<f64>>();
            let columns: Vec<Vec<f64>> = (0..width).map(|k| self.base.recording.smooth(&column(k))).collect();
            let samples = 0..self.base.time.len();
            let values = samples.flat_map(|i| columns.iter().map(move |c| c[i])).collect();
            Inertial { columns: inertial.columns.clone(), values }
        };
        (0..self.residual.len()).map(|row| self.joints.inertial(row).map(smooth)).collect()
    }

    fn joint_response(&self, effects: &[Effect]) -> Vec<(usize, Vec<f64>)> {
        let all = self.base.robot.with(effects);
        let at_feet = |effect: &Effect| {
            matches!(effect.kind.law, Law::EncoderOffset | Law::ForceSensorBias | Law::ForceSensorGain)
        };
        let changes = effects.iter().any(at_feet);
        let ground = changes.then(|| self.base.ground_forces(&self.base.change(effects)));
        let rows = if changes { (0..self.residual.len()).collect() } else { self.joints.touched(effects) };
        let changed = self.joints.residuals(&all, &rows, ground.as_deref());
        let response = |(row, residual): (usize, Vec<f64>)| {
            let mut values = self.base.recording.smooth(&residual);
            values.iter_mut().zip(&self.residual[row]).for_each(|(x, nominal)| *x = nominal - *x);
            (self.first() + row, values)
        };
        changed.into_iter().map(response).collect()
    }
}

impl ContactRecording {
    /// All samples as a log of efforts, which passed the filter here.
    fn motion(&self) -> Recording {
        Recording {
            time: self.time.clone(),
            segments: self.segments.clone(),
            trajectory: self.trajectory.clone(),
            effort: self.effort.clone(),
            transmission: vec![None; self.effort.len()],
            step: self.step,
            cutoff_hz: self.cutoff_hz,
            noise: self.effort_noise.clone(),
            ..Recording::default()
        }
    }
}

impl ContactExperiment<'_> {
    /// Generalised forces of the ground, `Jᵀ w`, of all samples under a change; `samples × nv`.
    fn ground_forces(&self, change: &Change) -> Vec<f64> {
        let logged = self.recording.logged();
        let at = |i: usize| {
            let [q, ..] = self.kinematics(i, change);
            let wrench = |f: usize, sole: &Sole| {
                self.recording.feet[f].wrench(sole, &self.true_signals(f, i, sole, change))
            };
            mapped(&self.robot, &self.calls, &self.feet, &q, &logged, wrench)
        };
        (0..self.samples()).flat_map(at).collect()
    }

    /// Samples at which noise and dependences are looked at.
    fn probes(&self) -> impl Iterator<Item = usize> + use<> {
        (0..self.samples()).step_by((self.samples() / NOISE_SAMPLES).max(1))
    }

    /// Takes away the efforts of joints that feel a moment that was not logged.
    fn without_vertical_moment(&self, motion: &mut Recording) -> Vec<Missing> {
        let mut missing = Vec::new();
        let nominal = self.change(&[]);
        let first = self.robot.layout.base.nv();
        for (f, record) in self.recording.feet.iter().enumerate() {
            let known = record.columns.has_torque(self.robot.planar()) || self.robot.planar();
            if !record.is_logged || known {
                continue;
            }
            let mut felt = vec![0.0_f64; self.calls.nv];
            for i in self.probes() {
                let [q, ..] = self.kinematics(i, &nominal);
                let unit = |foot: usize, _: &Sole| {
                    (Vector3::zeros(), if foot == f { Vector3::z() } else { Vector3::zeros() })
                };
                let tau = mapped(&self.robot, &self.calls, &self.feet, &q, &self.recording.logged(), unit);
                felt.iter_mut().zip(tau).for_each(|(felt, tau)| *felt = felt.max(tau.abs()));
            }
            for (j, joint) in self.robot.layout.joints.iter().enumerate() {
                if felt[first + j] > FELT && motion.effort[j].take().is_some() {
                    let foot = &self.robot.feet[f].name;
                    let reason = format!(
                        "its effort depends on the moment about the vertical at `{foot}`, which is not logged"
                    );
                    missing.push(Missing { name: joint.name.clone(), reason });
                }
            }
        }
        missing
    }

    /// Noise of the joints' rows: of efforts, of forces through the legs, of accelerations through the mass matrix.
    fn joint_noise(&self, change: &Change) -> Vec<f64> {
        let (first, r) = (self.robot.layout.base.nv(), &self.recording);
        let [still, moving] = r.noise_gain();
        let mut sums = vec![0.0; self.robot.layout.joints.len()];
        let mut add = |tau: &[f64], sigma: f64| {
            sums.iter_mut().zip(&tau[first..]).for_each(|(sum, tau)| *sum += (tau * sigma).powi(2));
        };
        let mut count = 0.0;
        for i in self.probes() {
            count += 1.0;
            let [q, ..] = self.kinematics(i, change);
            for (foot, record) in r.feet.iter().enumerate().filter(|(_, record)| record.is_logged) {
                for k in (0..12).filter(|k| record.noise[*k] > 0.0) {
                    let mut unit = [0.0; SIGNALS];
                    unit[k] = 1.0;
                    let one = |f: usize, sole: &Sole| {
                        if f == foot {
                            record.wrench(sole, &unit)
                        } else {
                            (Vector3::zeros(), Vector3::zeros())
                        }
                    };
                    let tau = mapped(&self.robot, &self.calls, &self.feet, &q, &r.logged(), one);
                    add(&tau, record.noise[k] * still.sqrt());
                }
            }
            let [q, v, a] = self.true_state(&self.logged_state(i), change);
            let mut needed = vec![0.0; self.calls.nv];
            self.calls.moving(self.inverse_dynamics, &q, &v, &a, &mut needed);
            let axes = self.base_axes(&q);
            for (k, sigma) in r.position_noise.iter().enumerate().filter(|(_, sigma)| **sigma > 0.0) {
                let mut faster = a.clone();
                if first == 6 && k < 3 {
                    // Logged in world axes, wanted in those of the base.
                    faster.iter_mut().zip(axes.row(k).iter()).for_each(|(a, part)| *a += part);
                } else {
                    faster[k] += 1.0;
                }
                let mut more = vec![0.0; self.calls.nv];
                self.calls.moving(self.inverse_dynamics, &q, &v, &faster, &mut more);
                more.iter_mut().zip(&needed).for_each(|(more, needed)| *more -= needed);
                add(&more, sigma * moving.sqrt());
            }
        }
        let own = r.effort_noise.iter().map(|noise| noise * noise * still);
        sums.iter().zip(own).map(|(sum, own)| (sum / count + own).sqrt()).collect()
    }
}

impl Experiment for WalkingExperiment<'_> {
    fn rows(&self) -> &[Row] {
        &self.rows
    }
    fn time(&self) -> &[f64] {
        self.base.time()
    }
    fn residual(&self, row: usize) -> &[f64] {
        match row.checked_sub(self.first()) {
            Some(joint) => &self.residual[joint],
            None => self.base.residual(row),
        }
    }
    fn measured(&self, row: usize) -> Option<Vec<f64>> {
        match row.checked_sub(self.first()) {
            Some(joint) => self.joints.measured(joint).map(|values| self.base.recording.smooth(&values)),
            None => self.base.measured(row),
        }
    }
    fn response(&self, effects: &[Effect]) -> Vec<(usize, Vec<f64>)> {
        let mut out = self.base.response(effects);
        out.extend(self.joint_response(effects).into_iter().filter(|(_, v)| v.iter().any(|x| *x != 0.0)));
        out
    }
    fn candidates(&self) -> Vec<(&'static Kind, Location)> {
        let mut out = self.base.candidates();
        for candidate in self.joints.candidates() {
            if !out.contains(&candidate) {
                out.push(candidate);
            }
        }
        out
    }
    fn guess(&self, kind: &'static Kind, place: &Location) -> Option<Effect> {
        self.base.guess(kind, place)
    }
    fn inertial_count(&self) -> usize {
        self.base.inertial_count()
    }
    fn inertial_parameters(&self) -> &InertialParameters {
        self.base.inertial_parameters()
    }
    fn inertial(&self, row: usize) -> Option<&Inertial> {
        match row.checked_sub(self.first()) {
            Some(joint) => self.inertial.get_or_init(|| self.joint_inertial())[joint].as_ref(),
            None => self.base.inertial(row),
        }
    }
    fn signals(&self, row: usize) -> Vec<(String, Vec<f64>)> {
        let Some(joint) = row.checked_sub(self.first()) else { return self.base.signals(row) };
        let signals = self.joints.signals(joint).into_iter();
        signals.map(|(name, values)| (name, self.base.recording.pick(&values))).collect()
    }
    fn phases(&self) -> Vec<(String, Vec<bool>)> {
        self.base.phases()
    }
    fn seeds(&self, kind: &'static Kind, location: &Location) -> Option<Vec<f64>> {
        self.joints.seeds(kind, location)
    }
    fn link_inertias(&self) -> Option<&LinkInertias> {
        self.base.link_inertias()
    }
}
