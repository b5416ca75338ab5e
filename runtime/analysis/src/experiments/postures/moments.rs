//! The same postures as a regression that is linear in the inertial parameters: moments of the weight about the sole.
use super::PostureExperiment;
use super::predict::Sensors;
use crate::robot::Foot;
use crate::robot::inertial_parameters::element_of;
use crate::robot::world::World;
use nalgebra::{Matrix3, Vector3};

/// Smallest part of the weight that must press along the sole's normal, else the sole stands on its edge.
const UPRIGHT: f64 = 0.1;

/// The ground's moment about the stance sole's origin, in its axes x and y: what the centre of pressure measures and
/// what the weight needs (thesis 5.19 times mass and gravity).
#[derive(Debug, Clone, PartialEq)]
pub struct Moments {
    /// `y_cop N` and `-x_cop N` by posture, N m.
    pub measured: [Vec<f64>; 2],
    /// Derivatives by the inertial parameters, `postures × parameters` (ten per body).
    pub columns: [Vec<f64>; 2],
    /// Force along the sole's normal, N, by posture: weight times cosine of the sole's tilt.
    pub normal: Vec<f64>,
}

/// Where a sole is, in the frame of the stance sole.
#[derive(Debug, Clone, PartialEq)]
pub struct SolePose {
    /// Origin of the sole frame, m.
    pub origin: Vector3<f64>,
    /// Its axes.
    pub rotation: Matrix3<f64>,
    /// Corners, m.
    pub corners: Vec<Vector3<f64>>,
}

impl PostureExperiment<'_> {
    /// Measured moments, and their derivatives by the inertial parameters, for a robot that weighs `mass` (kg).
    ///
    /// With gravity along `d` (length 1) in the sole's axes the centre of pressure is `c - d c_z/d_z`, so `M x_cop` is
    /// linear in mass and first moments of all bodies.
    pub fn moments(&self, mass: f64) -> Moments {
        let present = self.robot.effects;
        let (world, sensors) = (World::of(present, self.robot.layout), Sensors::of(present));
        let change = self.robot.link_inertias.change(present);
        let corrections = self.corrections(&sensors, &self.predict(&world, &change, &sensors));
        let mut out =
            Moments { measured: Default::default(), columns: Default::default(), normal: Vec::new() };
        for (i, correction) in corrections.iter().enumerate() {
            let (along, columns) = self.first_moments(i, &world, &sensors);
            let normal = mass * along;
            let center = |kind: usize| {
                let row = self.kinds.iter().position(|k| *k == kind);
                row.map_or(f64::NAN, |row| self.measured[row][i] + correction[kind])
            };
            out.measured[0].push(center(1) * normal);
            out.measured[1].push(-center(0) * normal);
            for [x, y] in columns {
                out.columns[0].push(y * along);
                out.columns[1].push(-x * along);
            }
            out.normal.push(normal);
        }
        out
    }

    /// Gravity along the sole's normal (m/s²), and how `M x_cop`, `M y_cop` change with each inertial parameter.
    fn first_moments(&self, posture: usize, world: &World, sensors: &Sensors) -> (f64, Vec<[f64; 2]>) {
        let q = self.configuration(posture, world);
        let sole = self.feet[self.stance].sole(&self.calls, &self.robot.feet[self.stance], &q);
        let true_sole = self.sole_in_world(posture, world, sensors, &sole.rotation);
        let down = true_sole.transpose() * self.gravity.normalize();
        let column = |(k, column): (usize, &[f64])| {
            let origin = if element_of(k) == 0 { sole.origin } else { Vector3::zeros() };
            let moved = sole.rotation.transpose() * (Vector3::from_column_slice(column) - origin);
            [moved.x - moved.z * down.x / down.z, moved.y - moved.z * down.y / down.z]
        };
        let columns = self.regressor_at(&q).chunks_exact(3).enumerate().map(column).collect();
        (-self.gravity.norm() * down.z, columns)
    }

    /// Mass that the corner forces of each posture carry, kg; `None` if not all corners are logged.
    pub fn carried(&self) -> Option<Vec<f64>> {
        if self.corners.is_empty() {
            return None;
        }
        let (world, sensors) =
            (World::of(self.robot.effects, self.robot.layout), Sensors::of(self.robot.effects));
        let mass = |i: usize| {
            let (along, _) = self.first_moments(i, &world, &sensors);
            self.corners.iter().map(|reading| reading.force[i]).sum::<f64>() / along
        };
        Some((0..self.number.len()).map(mass).collect())
    }

    /// All soles of a posture, in the order of the feet.
    pub fn soles(&self, posture: usize) -> Vec<SolePose> {
        let nq = self.calls.nq;
        let q = &self.q[posture * nq..(posture + 1) * nq];
        let pose = |foot: usize| self.feet[foot].sole(&self.calls, &self.robot.feet[foot], q);
        let stance = pose(self.stance);
        let of = |(index, foot): (usize, &Foot)| {
            let sole = pose(index);
            let place = |at: Vector3<f64>| stance.rotation.transpose() * (at - stance.origin);
            let corner = |k: usize| place(sole.origin + sole.rotation * foot.corner(k));
            SolePose {
                origin: place(sole.origin),
                rotation: stance.rotation.transpose() * sole.rotation,
                corners: (0..foot.corners.len()).map(corner).collect(),
            }
        };
        self.robot.feet.iter().enumerate().map(of).collect()
    }

    /// Postures in which the stance sole stands on its edge by what the base's orientation says: indices.
    pub fn toppled(&self) -> Vec<usize> {
        let (world, sensors) =
            (World::of(self.robot.effects, self.robot.layout), Sensors::of(self.robot.effects));
        let upright = |i: &usize| self.first_moments(*i, &world, &sensors).0 < UPRIGHT * self.gravity.norm();
        (0..self.number.len()).filter(upright).collect()
    }

    /// Name of the stance foot.
    pub fn stance(&self) -> &str {
        &self.robot.feet[self.stance].name
    }

    /// Feet of the robot.
    pub fn feet(&self) -> &[Foot] {
        self.robot.feet
    }

    /// Positions of all joints, `postures × joints`, rad or m.
    pub fn positions(&self) -> Vec<&[f64]> {
        let (nq, joints) = (self.calls.nq, self.robot.layout.joints.len());
        self.q.chunks_exact(nq).map(|q| &q[nq - joints..]).collect()
    }

    /// Logged centre of pressure, m, by posture; a coordinate that is not logged is no number.
    pub fn centers(&self) -> Vec<[f64; 2]> {
        let row = |kind: usize| self.kinds.iter().position(|k| *k == kind);
        let value = |kind: usize, i: usize| row(kind).map_or(f64::NAN, |row| self.measured[row][i]);
        (0..self.number.len()).map(|i| [value(0, i), value(1, i)]).collect()
    }

    /// Whether the base's orientation was logged, so that the stance sole may be tilted.
    pub fn is_oriented(&self) -> bool {
        self.oriented
    }
}
