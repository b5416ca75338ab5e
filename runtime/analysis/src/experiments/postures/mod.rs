//! Static postures: the centre of pressure against the ground projection of the centre of mass (thesis 5.4.1).
//!
//! Rows: `cop/x`, `cop/y` in the sole frame of the stance foot, and `base/force/z` (the sum of all corner forces
//! against the robot's weight) where every corner of every foot is logged. Without `base/…` columns the stance sole is
//! horizontal and the base follows from the joints. Signs: [`crate::diagnose`].
//!
//! What happens to a reading of a corner's force sensor is undone in the measurement: the change of the centre of
//! pressure that the corrected forces cause is added to the logged one. A saturated corner carries what is missing of
//! the robot's weight (several of them: equal parts).
//!
//! `ground_compliance`: corners sink by force / stiffness; the stance sole tilts by the plane that fits best. Damping
//! plays no part at rest.
mod load;
mod moments;
mod noise;
mod predict;

use crate::experiments::experiment::sought_at;
use crate::experiments::{Experiment, Inertial, Row};
use crate::robot::InertialParameters;
use crate::robot::LinkInertias;
use crate::robot::Robot;
use crate::robot::calls::ModelCalls;
use crate::robot::feet::FootCalls;
use crate::robot::inertial_parameters::body_of;
use crate::robot::world::World;
use bipedc_effects::effect::{Effect, Evidence, Kind, Law, Location, Place};
pub(crate) use load::normalise;
pub use moments::{Moments, SolePose};
use nalgebra::Vector3;
pub(crate) use noise::is_clipped;
use predict::Sensors;

/// A measured corner.
#[derive(Debug, Clone)]
struct Reading {
    /// Indices of foot and corner.
    place: (usize, usize),
    /// One value per posture, N.
    force: Vec<f64>,
}

/// Postures against a model; built by [`PostureExperiment::read`].
pub struct PostureExperiment<'a> {
    robot: Robot<'a>,
    calls: ModelCalls<'a>,
    feet: Vec<FootCalls>,
    stance: usize,
    regressor: usize,
    gravity: Vector3<f64>,
    number: Vec<f64>,
    /// Logged configurations, `postures × nq`.
    q: Vec<f64>,
    /// Whether the base's orientation was logged.
    oriented: bool,
    /// All corners of all feet, or none.
    corners: Vec<Reading>,
    parameters: InertialParameters,
    rows: Vec<Row>,
    measured: Vec<Vec<f64>>,
    /// Which of x, y, weight each row is.
    kinds: Vec<usize>,
    residual: Vec<Vec<f64>>,
    inertial: Vec<Inertial>,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
}

impl PostureExperiment<'_> {
    /// Residual of all rows under effects.
    fn residual_under(&self, effects: &[Effect]) -> Vec<Vec<f64>> {
        let effects = self.robot.with(effects);
        let world = World::of(&effects, self.robot.layout);
        let sensors = Sensors::of(&effects);
        let change = self.robot.link_inertias.change(&effects);
        let predicted = self.predict(&world, &change, &sensors);
        let corrections = self.corrections(&sensors, &predicted);
        let rows = self.kinds.iter().zip(&self.measured);
        rows.map(|(&kind, measured)| {
            let all = measured.iter().zip(predicted.iter().zip(&corrections));
            all.map(|(measured, (predicted, correction))| measured + correction[kind] - predicted[kind])
                .collect()
        })
        .collect()
    }

    fn shows(&self, body: usize) -> bool {
        self.inertial.iter().any(|i| i.columns.iter().any(|c| body_of(*c) == body))
    }

    /// A corner's sensor as `foot/corner`.
    fn sensor(&self, reading: &Reading) -> String {
        let foot = &self.robot.feet[reading.place.0];
        format!("{}/{}", foot.name, foot.corners[reading.place.1].name)
    }

    /// Whether these postures can show an effect on the robot as a whole.
    fn can_show(&self, law: Law) -> bool {
        match law {
            Law::GroundSlope => !self.oriented,
            Law::GroundCompliance => {
                let flat = self.robot.feet[self.stance].is_flat(self.robot.planar());
                !self.corners.is_empty() && !self.oriented && flat
            }
            _ => true,
        }
    }
}

impl Experiment for PostureExperiment<'_> {
    fn rows(&self) -> &[Row] {
        &self.rows
    }
    fn time(&self) -> &[f64] {
        &self.number
    }
    fn residual(&self, row: usize) -> &[f64] {
        &self.residual[row]
    }
    fn response(&self, effects: &[Effect]) -> Vec<(usize, Vec<f64>)> {
        let changed = self.residual_under(effects);
        let rows = self.residual.iter().zip(changed).enumerate();
        rows.map(|(row, (nominal, changed))| {
            (row, nominal.iter().zip(changed).map(|(nominal, changed)| nominal - changed).collect::<Vec<_>>())
        })
        .filter(|(_, values)| values.iter().any(|v| *v != 0.0))
        .collect()
    }
    fn candidates(&self) -> Vec<(&'static Kind, Location)> {
        let links = self.robot.link_places(|body| self.shows(body));
        let sensors = |kind: &Kind| {
            let shows = |reading: &&Reading| {
                kind.law != Law::ForceSensorSaturation || noise::is_clipped(&reading.force).is_some()
            };
            let shown = self.corners.iter().filter(shows);
            shown.map(|reading| Location::sensor(self.sensor(reading))).collect::<Vec<_>>()
        };
        sought_at(Evidence::Postures, |kind| match kind.place {
            Place::Link => links.clone(),
            Place::Joint => self.robot.joint_places().collect(),
            Place::Robot if !self.can_show(kind.law) => Vec::new(),
            Place::Robot => vec![Location::default()],
            Place::Sensor if kind.law == Law::ForceSensorGain && !self.corners.is_empty() => {
                std::iter::once(Location::default()).chain(sensors(kind)).collect()
            }
            Place::Sensor => sensors(kind),
            Place::JointPair => Vec::new(),
        })
    }
    fn guess(&self, kind: &'static Kind, place: &Location) -> Option<Effect> {
        let meant = |r: &&Reading| place.sensor.as_deref().is_none_or(|name| name == self.sensor(r));
        let limits = self.corners.iter().filter(meant).filter_map(|r| noise::is_clipped(&r.force));
        let limit = limits.fold(f64::NEG_INFINITY, f64::max);
        let known = kind.law == Law::ForceSensorSaturation && limit.is_finite();
        known.then(|| Effect::new(kind, place.clone(), &[("limit", limit)]))
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
    fn link_inertias(&self) -> Option<&LinkInertias> {
        Some(self.robot.link_inertias)
    }
    fn signals(&self, _row: usize) -> Vec<(String, Vec<f64>)> {
        self.robot.joint_signals("position", &self.q, self.calls.nq)
    }
}
