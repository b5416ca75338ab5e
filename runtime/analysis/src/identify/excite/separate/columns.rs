//! What two effects do to the torques along a motion, as the diagnosis sees it.
use super::Pair;
use crate::experiments::form::effect_columns;
use crate::experiments::{Experiment, MotionExperiment};
use crate::identify::excite::Machine;
use crate::measure::Recording;
use crate::robot::Trajectory;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Effect, Kind, Law, Location, Place, Size};
use nalgebra::DMatrix;

/// An effect of the library at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// With usual values.
    pub usual: Effect,
    kind: &'static Kind,
    /// Value of the parameter that does not enter linearly.
    setting: f64,
}

impl Candidate {
    /// With usual values; a gain is 10 % off.
    ///
    /// # Errors
    /// Kinds that the library does not know or that do not change the torques of a robot whose base hangs; places that
    /// the kind needs and that are missing.
    pub fn new(kind: &str, location: Location) -> Result<Self, Diagnostic> {
        let Some(kind) = bipedc_effects::effect::kind(kind) else {
            return Err(Diagnostic::error(format!("there is no effect `{kind}`")));
        };
        if let Some(reason) = unseen(kind.law, kind.place) {
            let message = format!("no motion of hanging joints shows `{}`: {reason}", kind.name);
            return Err(Diagnostic::error(message).help(kind.experiment));
        }
        let Location { joint, other_joint, link, .. } = &location;
        let complete = match kind.place {
            Place::Joint => joint.is_some(),
            Place::JointPair => joint.is_some() && other_joint.is_some() && joint != other_joint,
            Place::Link => link.is_some(),
            Place::Sensor | Place::Robot => true,
        };
        if !complete {
            let (what, help) = match kind.place {
                Place::JointPair => ("two different joints", "--joint J --other-joint K"),
                Place::Link => ("a link", "--link LINK"),
                _ => ("a joint", "--joint J"),
            };
            return Err(Diagnostic::error(format!("`{}` needs {what}", kind.name))
                .help(format!("say where it is: {help}")));
        }
        let usual: Vec<(&str, f64)> = kind
            .estimated()
            .map(|p| (p.name, if p.size == Size::NothingAt(1.0) { 1.1 } else { p.example() }))
            .collect();
        let usual = Effect::new(kind, location, &usual);
        let setting = kind.search.nonlinear.and_then(|name| usual.parameters.get(name).copied());
        Ok(Self { usual, kind, setting: setting.unwrap_or(0.0) })
    }

    /// Whether it shows only on a base that may be turned: one that is floating in the model and stays at rest.
    pub fn turns_the_world(&self) -> bool {
        self.usual.kind.law == Law::GravityTilt
    }
}

/// Why an effect is not seen in the torques of joints that hang from a fixed base.
fn unseen(law: Law, place: Place) -> Option<&'static str> {
    Some(match law {
        Law::SeriesElasticity | Law::Backlash => "it shows in the motor's angle, not in the torque",
        Law::TrueTorque(_) => "it begins at a limit and enters no torque below it",
        Law::Formula => "a formula of one's own has no columns; its terms may be effects of the library",
        Law::PointFeet | Law::NoImpact | Law::SingleMass | Law::DecoupledPlanes => {
            "it is an assumption about walking"
        }
        Law::GravityTilt => return None,
        _ if matches!(place, Place::Sensor | Place::Robot) => "it shows only in contact with the ground",
        _ => return None,
    })
}

/// Measured torques along motions, and what effects add to them.
pub(super) struct Bench<'r, 'm> {
    pub machine: &'r Machine<'m>,
    pub pair: &'r Pair<'r>,
    /// s; of the motions.
    duration: f64,
}

/// Columns of one motion; rows: measured joint after measured joint, all samples of each.
pub(super) struct Columns {
    /// Of each effect.
    pub effects: [DMatrix<f64>; 2],
    /// What each does with usual values, N m.
    pub usual: DMatrix<f64>,
    /// Of the bodies' inertial parameters, if they are free too.
    pub beside: DMatrix<f64>,
}

impl<'r, 'm> Bench<'r, 'm> {
    pub fn new(machine: &'r Machine<'m>, pair: &'r Pair<'r>, duration: f64) -> Self {
        Self { machine, pair, duration }
    }

    /// Samples on both sides that a sample's torques depend on: a delay looks ahead or back.
    pub fn reach(&self, count: usize) -> usize {
        let effects = self.pair.effects.iter().map(|effect| &effect.usual).chain(self.pair.present);
        let delays = effects.filter(|effect| effect.kind.law == Law::Delay);
        let step = self.duration / (count.max(2) - 1) as f64;
        delays.map(|effect| (effect.value("delay").abs() / step).floor() as usize + 2).max().unwrap_or(0)
    }

    /// # Errors
    /// Those of the model.
    pub fn columns(&self, motion: &Trajectory) -> Result<Columns, Diagnostic> {
        let recording = self.recording(motion)?;
        let pair = self.pair;
        let experiment =
            MotionExperiment::new(pair.model, pair.layout, pair.link_inertias, recording, pair.present)?;
        let (rows, count) = (experiment.rows().len(), motion.len());
        let dense = |columns: Vec<Vec<(usize, Vec<f64>)>>| {
            let mut dense = DMatrix::zeros(rows * count, columns.len());
            for (c, column) in columns.iter().enumerate() {
                for (row, values) in column {
                    dense.column_mut(c).as_mut_slice()[row * count..][..count].copy_from_slice(values);
                }
            }
            dense
        };
        let of = |candidate: &Candidate| {
            let location = &candidate.usual.location;
            let columns = effect_columns(&experiment, candidate.kind, location, candidate.setting);
            dense(columns.unwrap_or_default())
        };
        let usual = pair.effects.each_ref().map(|c| experiment.response(std::slice::from_ref(&c.usual)));
        Ok(Columns {
            effects: pair.effects.each_ref().map(of),
            usual: dense(usual.into()),
            beside: if pair.beside_bodies {
                self.bodies(&experiment, count)
            } else {
                DMatrix::zeros(rows * count, 0)
            },
        })
    }

    fn bodies(&self, experiment: &dyn Experiment, count: usize) -> DMatrix<f64> {
        let rows = experiment.rows().len();
        let mut all = DMatrix::zeros(rows * count, experiment.inertial_count());
        for row in 0..rows {
            let Some(inertial) = experiment.inertial(row) else { continue };
            for (k, &column) in inertial.columns.iter().enumerate() {
                let values = inertial.values.iter().skip(k).step_by(inertial.columns.len());
                values.enumerate().for_each(|(i, y)| all[(row * count + i, column)] = *y);
            }
        }
        all
    }

    /// The motion as a log would have it, without noise.
    fn recording(&self, motion: &Trajectory) -> Result<Recording, Diagnostic> {
        let joints = self.machine.layout.joints.len();
        let tau = self.machine.torques(motion)?;
        let base = self.pair.layout.base;
        let with = |rest: &[f64], values: &[f64]| -> Vec<f64> {
            values.chunks_exact(joints).flat_map(|x| rest.iter().chain(x)).copied().collect()
        };
        let still = vec![0.0; base.nv()];
        let mut trajectory = Trajectory::new(self.pair.layout);
        trajectory.extend([
            &with(base.rest(), &motion.q),
            &with(&still, &motion.v),
            &with(&still, &motion.a),
        ]);
        let step = self.duration / (motion.len().max(2) - 1) as f64;
        let effort = |joint: usize| {
            let measured = self.pair.measured.contains(&joint);
            measured.then(|| motion.of_joint(&tau, joint).collect())
        };
        Ok(Recording {
            time: (0..motion.len()).map(|i| step * i as f64).collect(),
            segments: std::iter::once(0..motion.len()).collect(),
            trajectory,
            effort: (0..joints).map(effort).collect(),
            transmission: vec![None; joints],
            noise: vec![self.pair.noise; joints],
            step,
            ..Recording::default()
        })
    }
}
