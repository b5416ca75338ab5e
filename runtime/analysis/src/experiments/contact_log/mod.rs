//! Logs of a robot that is free in space, with forces at its feet: what no joint has to be measured for.
//!
//! Rows: `base/force/x`, `/y`, `/z` (N, the log's world axes) and `base/moment/x`, `/y`, `/z` (N m, about the origin of
//! the root, in its axes); planar: x, z and y. Measured: the feet's wrenches mapped to the base, `Jᵀ w`; predicted: the
//! unactuated rows of inverse dynamics. Both from signals that passed the same zero-phase filter; the rows pass it once
//! more, both sides alike, because accelerations are noisiest just below the cut-off. The moment about
//! the vertical is left out if the feet log no torque, because nothing is known of it. Where only normal forces of
//! corners are logged, the rows are `base/force/z` and `cop/x`, `cop/y`: the centre of pressure of all feet (m, world
//! axes, in the height of the loaded soles) against the zero moment point.
//!
//! A log without any `base/…` column is one of a robot that stands on the foot that carries its base (root link: that
//! foot, or a point of its sole), as in thesis 5.4.2; see `standing`.
//!
//! At an impact velocities jump: nothing is filtered across one, and what lies within two periods of the cut-off beside it
//! (one where steps are short) does not count; see `strikes`, `stretches`.
//!
//! While the feet carry less than a twentieth of the weight there is no centre of pressure: its rows are zero.
//!
//! Foot forces are in world axes at the centre of pressure in the sole frame, or, where the mapping file says
//! `frame = "sole"`, force and torque at and in the sole frame. Signs: [`crate::diagnose`].
//!
//! - A force sensor's bias changes the force; a logged centre of pressure is a measurement of its own and stays, a
//!   logged torque too. A gain scales force and torque.
//! - A saturated sensor has a part missing that is not known: at samples near which it stays at its limit, the force
//!   along the sole's normal (not negative) that fits the base best is added at the sensor. A limit below a reading
//!   contradicts the log and explains nothing.
//! - `foot_slip`, `spin_friction` and `impact_restitution` change what the ground does to the feet; that is measured
//!   here, so they change none of these rows. `ground_compliance` shows in how deep the soles lie: `soles`.
//! - `ground_slope` changes none of these rows where the base's orientation is logged; [`ContactExperiment::quantities`]
//!   tells how far the soles are from level.
//! - The assumptions of thesis 4.2 are levels of the model: their response is what leaving something out costs. They
//!   are no candidates. See `simpler`.
//!
//! Noise of a row is that of forces and positions (from third differences of the raw columns, taken as white), through
//! the filter (for positions twice differentiated) and through the model's mass matrix.
mod columns;
mod effects;
mod falls;
mod foot;
mod forces;
mod one_sided;
mod passing;
mod phases;
mod predict;
mod products;
mod quantities;
mod read;
mod rows;
mod simpler;
mod soles;
mod standing;
mod stretches;
mod strikes;
mod through_legs;
mod unlogged;
mod walking;

pub use crate::measure::CUTOFF_HZ;
pub use forces::ContactRecording;
pub use quantities::Quantity;
pub use walking::WalkingExperiment;

use crate::experiments::experiment::sought_at;
use crate::experiments::memo::Memo;
use crate::experiments::motion::Hidden;
use crate::experiments::{Channel, Experiment, Inertial, Row, data_checks};
use crate::measure::JointPositions;
use crate::robot::InertialParameters;
use crate::robot::LinkInertias;
use crate::robot::Robot;
use crate::robot::calls::ModelCalls;
use crate::robot::feet::FootCalls;
use crate::robot::inertial_parameters::body_of;
use crate::robot::world::World;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Acts, Effect, Evidence, Kind, Law, Location, Place};
use effects::{Change, spares_contact};
use nalgebra::Vector3;
use rows::Component;
use std::sync::Arc;

/// A log of a free robot against a model; built by [`ContactExperiment::read`].
pub struct ContactExperiment<'a> {
    robot: Robot<'a>,
    calls: ModelCalls<'a>,
    feet: Vec<FootCalls>,
    inverse_dynamics: usize,
    regressor: usize,
    recording: ContactRecording,
    /// In world axes, m/s².
    gravity: Vector3<f64>,
    parameters: InertialParameters,
    rows: Vec<Row>,
    kinds: Vec<Component>,
    time: Vec<f64>,
    residual: Vec<Vec<f64>>,
    inertial: Vec<Inertial>,
    /// Corners with a row of their own, after the rows of `kinds`.
    soles: Vec<soles::SoleCorner>,
    /// When each foot stands.
    stances: Vec<Vec<std::ops::Range<usize>>>,
    /// All rows under the effects that were asked for last.
    under: Memo<Vec<Vec<f64>>>,
}

impl<'a> ContactExperiment<'a> {
    /// What it was made from.
    pub fn recording(&self) -> &ContactRecording {
        &self.recording
    }

    fn change(&self, effects: &[Effect]) -> Change {
        Change::of(&self.robot.with(effects), &self.robot)
    }

    fn shows(&self, body: usize) -> bool {
        self.inertial.iter().any(|i| i.columns.iter().any(|c| body_of(*c) == body))
    }

    /// What effects explain, with links behind their motors.
    fn response_with(&self, effects: &[Effect], behind: Vec<Hidden>) -> Vec<(usize, Vec<f64>)> {
        let as_motors = behind.is_empty();
        if as_motors && effects.iter().all(spares_contact) {
            return Vec::new();
        }
        let inertial_only = effects.iter().all(|e| e.kind.law.acts() == Acts::Body);
        let linear = self.kinds.iter().all(|kind| !matches!(kind, Component::Pressure(_)));
        // A simpler model of the description may not be linear in what is added.
        if inertial_only && linear && !self.change(&[]).level.is_simpler() {
            return self.linear_response(&self.robot.link_inertias.change(effects));
        }
        let changed = || {
            let change = self.change(effects).with_links(behind);
            // What acts at the soles only leaves the wrenches alone, and the other way round.
            let of_ground = as_motors && effects.iter().all(|e| e.kind.law == Law::GroundCompliance);
            let mut changed = match of_ground {
                true => self.residual[..self.kinds.len()].to_vec(),
                false => self.residual_under(&change),
            };
            changed.extend(self.sole_residuals(&change));
            changed
        };
        // Where links move behind their motors, what acts on torques moves them.
        let changed = match as_motors {
            true => self.under.of(effects, |effect| !spares_contact(effect), changed),
            false => Arc::new(changed()),
        };
        let rows = self.residual.iter().zip(changed.iter()).enumerate();
        rows.map(|(row, (nominal, changed))| {
            (row, nominal.iter().zip(changed).map(|(nominal, changed)| nominal - changed).collect::<Vec<_>>())
        })
        .filter(|(_, values)| values.iter().any(|v| *v != 0.0))
        .collect()
    }

    /// What inertial effects alone explain: exact, since these rows are linear in inertial parameters.
    fn linear_response(&self, change: &[f64]) -> Vec<(usize, Vec<f64>)> {
        let rows = self.inertial.iter().enumerate();
        rows.map(|(row, inertial)| {
            let factors: Vec<f64> = inertial.columns.iter().map(|c| change[*c]).collect();
            let sum = |values: &[f64]| values.iter().zip(&factors).map(|(v, f)| v * f).sum();
            (row, inertial.values.chunks_exact(factors.len().max(1)).map(sum).collect::<Vec<f64>>())
        })
        .filter(|(_, values)| values.iter().any(|v| *v != 0.0))
        .collect()
    }
}

impl Experiment for ContactExperiment<'_> {
    fn rows(&self) -> &[Row] {
        &self.rows
    }
    fn time(&self) -> &[f64] {
        &self.time
    }
    fn residual(&self, row: usize) -> &[f64] {
        &self.residual[row]
    }
    fn measured(&self, row: usize) -> Option<Vec<f64>> {
        // A sole's height is predicted to be level.
        Some(if row < self.kinds.len() { self.reported_row(row) } else { self.residual[row].clone() })
    }
    fn phases(&self) -> Vec<(String, Vec<bool>)> {
        self.support()
    }
    fn beside_impacts(&self) -> f64 {
        self.recording.beside_impacts()
    }
    fn response(&self, effects: &[Effect]) -> Vec<(usize, Vec<f64>)> {
        self.response_with(effects, Vec::new())
    }
    fn candidates(&self) -> Vec<(&'static Kind, Location)> {
        let links = self.robot.link_places(|body| self.shows(body));
        let sensors = |kind: &Kind| {
            let shows = |(foot, sensor): (usize, usize)| {
                kind.law != Law::ForceSensorSaturation || self.clipped(foot, sensor).is_some()
            };
            let shown = self.sensors().into_iter().filter(move |(foot, sensor, _)| shows((*foot, *sensor)));
            shown.map(|(_, _, name)| Location::sensor(name)).collect::<Vec<_>>()
        };
        sought_at(Evidence::Contact, |kind| match kind.place {
            Place::Link => links.clone(),
            Place::Joint => self.robot.joint_places().collect(),
            Place::Robot if kind.law == Law::GroundCompliance && self.soles.is_empty() => Vec::new(),
            Place::Robot => vec![Location::default()],
            Place::Sensor if kind.law == Law::ForceSensorSaturation => sensors(kind),
            Place::Sensor => std::iter::once(Location::default()).chain(sensors(kind)).collect(),
            Place::JointPair => Vec::new(),
        })
    }
    fn guess(&self, kind: &'static Kind, place: &Location) -> Option<Effect> {
        if kind.law != Law::ForceSensorSaturation {
            return None;
        }
        let meant = |name: &str| place.sensor.as_deref().is_none_or(|sensor| sensor == name);
        let sensors = self.sensors().into_iter().filter(|(_, _, name)| meant(name));
        let limits = sensors.filter_map(|(foot, sensor, _)| self.clipped(foot, sensor));
        let limit = limits.fold(f64::NEG_INFINITY, f64::max);
        limit.is_finite().then(|| Effect::new(kind, place.clone(), &[("limit", limit)]))
    }
    fn noise_in_signals(&self, row: usize) -> f64 {
        // The feet's forces are signals.
        let row = &self.rows[row];
        if matches!(row.channel, Channel::BaseForce | Channel::BaseMoment) { row.noise } else { 0.0 }
    }
    fn inertial_count(&self) -> usize {
        self.parameters.len()
    }
    fn inertial_parameters(&self) -> &InertialParameters {
        &self.parameters
    }
    fn inertial(&self, row: usize) -> Option<&Inertial> {
        self.inertial.get(row)
    }
    fn signals(&self, _row: usize) -> Vec<(String, Vec<f64>)> {
        let (nq, nv) = (self.calls.nq, self.calls.nv);
        let mut list = self.robot.joint_signals("position", &self.recording.trajectory.q, nq);
        list.extend(self.robot.joint_signals("velocity", &self.recording.trajectory.v, nv));
        for (foot, record) in self.robot.feet.iter().zip(&self.recording.feet).filter(|(_, r)| r.is_logged) {
            list.push((format!("{}/force/z", foot.name), record.signals.iter().map(|s| s[2]).collect()));
        }
        list.push(("time".to_owned(), self.recording.time.clone()));
        list.into_iter().map(|(name, values)| (name, self.recording.pick(&values))).collect()
    }
    fn motion(&self) -> JointPositions {
        let positions = self.robot.joint_signals("position", &self.recording.trajectory.q, self.calls.nq);
        let positions = positions.into_iter().map(|(_, values)| self.recording.pick(&values)).collect();
        JointPositions { time: self.recording.pick(&self.recording.time), positions }
    }
    fn check(&self) -> Vec<Diagnostic> {
        self.duration().and_then(data_checks::short).into_iter().collect()
    }
    fn duration(&self) -> Option<f64> {
        Some(self.recording.duration())
    }
    fn link_inertias(&self) -> Option<&LinkInertias> {
        Some(self.robot.link_inertias)
    }
}
