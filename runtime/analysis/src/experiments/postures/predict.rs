//! Centre of pressure and weight that the model predicts, and what force sensors should have read.
use super::PostureExperiment;
use crate::robot::inertial_parameters::element_of;
use crate::robot::world::{World, is_meant};
use bipedc_effects::effect::{Effect, Law};
use nalgebra::{Matrix3, Vector3};

/// Centre of pressure x, y (m, stance sole frame) and total normal force (N).
pub(super) type Ground = [f64; 3];

/// Effects on force sensors and soles.
#[derive(Debug, Clone, Default)]
pub(super) struct Sensors {
    /// Law, place and value: gain, bias along z (N) or limit (N).
    readings: Vec<(Law, Option<String>, f64)>,
    /// Compliance per corner, m/N.
    compliance: f64,
}

impl Sensors {
    pub fn of(effects: &[Effect]) -> Self {
        let mut sensors = Self::default();
        for effect in effects {
            let law = effect.kind.law;
            let parameter = match law {
                Law::ForceSensorGain => "gain",
                Law::ForceSensorBias => "z",
                Law::ForceSensorSaturation => "limit",
                Law::GroundCompliance => {
                    sensors.compliance += 1.0 / effect.value("stiffness");
                    continue;
                }
                _ => continue,
            };
            sensors.readings.push((law, effect.location.sensor.clone(), effect.value(parameter)));
        }
        sensors
    }
}

impl PostureExperiment<'_> {
    /// What the model predicts of every posture with changed inertial parameters in a changed world.
    pub(super) fn predict(&self, world: &World, change: &[f64], sensors: &Sensors) -> Vec<Ground> {
        (0..self.number.len())
            .map(|i| {
                let (center, down) = self.center_and_down(i, world, sensors, change);
                let mass: f64 = self.parameters.iter().zip(change).step_by(10).map(|(p, c)| p + c).sum();
                let weight = -mass * self.gravity.norm() * down.z;
                [center.x - center.z * down.x / down.z, center.y - center.z * down.y / down.z, weight]
            })
            .collect()
    }

    /// Centre of mass and the direction of gravity (of length 1) in the stance sole's frame.
    fn center_and_down(
        &self,
        posture: usize,
        world: &World,
        sensors: &Sensors,
        change: &[f64],
    ) -> (Vector3<f64>, Vector3<f64>) {
        let q = self.configuration(posture, world);
        let sole = self.feet[self.stance].sole(&self.calls, &self.robot.feet[self.stance], &q);
        let regressor = self.regressor_at(&q);
        let (mut moment, mut mass) = (Vector3::zeros(), 0.0);
        for (k, column) in regressor.chunks_exact(3).enumerate() {
            let parameter = self.parameters[k] + change[k];
            moment += Vector3::from_column_slice(column) * parameter;
            mass += if element_of(k) == 0 { parameter } else { 0.0 };
        }
        let center = sole.rotation.transpose() * (moment / mass - sole.origin);
        (
            center,
            self.sole_in_world(posture, world, sensors, &sole.rotation).transpose()
                * self.gravity.normalize(),
        )
    }

    pub(super) fn configuration(&self, posture: usize, world: &World) -> Vec<f64> {
        let nq = self.calls.nq;
        let mut q = self.q[posture * nq..(posture + 1) * nq].to_vec();
        world.correct(&mut q);
        q
    }

    /// `Σ m c = regressor · parameters`, world axes of the model; 3 × parameters.
    pub(super) fn regressor_at(&self, q: &[f64]) -> Vec<f64> {
        let mut regressor = vec![0.0; 3 * self.parameters.len()];
        self.calls.at(self.regressor, q, &mut regressor);
        regressor
    }

    /// True axes of the stance sole: as the base was logged, else those of the ground.
    pub(super) fn sole_in_world(
        &self,
        posture: usize,
        world: &World,
        sensors: &Sensors,
        logged: &Matrix3<f64>,
    ) -> Matrix3<f64> {
        if self.oriented {
            return world.tilt * logged;
        }
        world.tilt * world.slope * self.sunk(posture, sensors.compliance)
    }

    /// How the stance sole turns because its corners sink in proportion to their forces.
    fn sunk(&self, posture: usize, compliance: f64) -> Matrix3<f64> {
        if compliance == 0.0 || !compliance.is_finite() {
            return Matrix3::identity();
        }
        // Least squares z = a + b x + c y through the sunken corners.
        let foot = &self.robot.feet[self.stance];
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for reading in self.corners.iter().filter(|r| r.place.0 == self.stance) {
            let at = foot.corner(reading.place.1);
            let row = Vector3::new(1.0, at.x, at.y);
            normal += row * row.transpose();
            right -= row * (compliance * reading.force[posture]);
        }
        // Regular in the directions in which the sole has an extent; in the others nothing turns.
        let Ok(inverse) = normal.pseudo_inverse(1e-9) else { return Matrix3::identity() };
        let plane = inverse * right;
        let x = Vector3::new(1.0, 0.0, plane.y).normalize();
        let y = Vector3::new(0.0, 1.0, plane.z);
        let y = (y - x * x.dot(&y)).normalize();
        Matrix3::from_columns(&[x, y, x.cross(&y)])
    }

    /// What has to be added to the measured rows because sensors do not tell the truth.
    pub(super) fn corrections(&self, sensors: &Sensors, predicted: &[Ground]) -> Vec<Ground> {
        if self.corners.is_empty() || sensors.readings.is_empty() {
            return vec![[0.0; 3]; self.number.len()];
        }
        (0..self.number.len())
            .map(|i| {
                let reported: Vec<f64> = self.corners.iter().map(|r| r.force[i]).collect();
                let truth = self.truth(&reported, sensors, predicted[i][2]);
                let places = self.places(i);
                match (pressure(&reported, &places), pressure(&truth, &places)) {
                    (Some(before), Some(after)) => [0, 1, 2].map(|k| after[k] - before[k]),
                    // Without load there is no centre of pressure to correct.
                    _ => [0.0; 3],
                }
            })
            .collect()
    }

    /// True corner forces behind the reported ones; the whole must be `weight`.
    fn truth(&self, reported: &[f64], sensors: &Sensors, weight: f64) -> Vec<f64> {
        let mut truth = reported.to_vec();
        let mut clipped = vec![false; truth.len()];
        for (law, place, value) in &sensors.readings {
            for ((reading, truth), clipped) in self.corners.iter().zip(&mut truth).zip(&mut clipped) {
                let foot = &self.robot.feet[reading.place.0];
                if !is_meant(place.as_deref(), &foot.name, Some(&foot.corners[reading.place.1].name)) {
                    continue;
                }
                match law {
                    Law::ForceSensorGain => *truth /= value,
                    Law::ForceSensorBias => *truth -= value,
                    _ => *clipped |= *truth >= value * (1.0 - super::noise::CLIPPED),
                }
            }
        }
        let missing = weight - truth.iter().sum::<f64>();
        let count = clipped.iter().filter(|c| **c).count();
        if missing > 0.0 && count > 0 {
            let each = missing / count as f64;
            truth.iter_mut().zip(&clipped).filter(|(_, c)| **c).for_each(|(truth, _)| *truth += each);
        }
        truth
    }

    /// Positions of all measured corners in the stance sole's frame, m.
    pub(super) fn places(&self, posture: usize) -> Vec<Vector3<f64>> {
        let nq = self.calls.nq;
        let q = &self.q[posture * nq..(posture + 1) * nq];
        let sole = |foot: usize| self.feet[foot].sole(&self.calls, &self.robot.feet[foot], q);
        let soles: Vec<_> = (0..self.robot.feet.len()).map(sole).collect();
        let stance = soles[self.stance];
        self.corners
            .iter()
            .map(|reading| {
                let (foot, corner) = reading.place;
                let at = soles[foot].origin + soles[foot].rotation * self.robot.feet[foot].corner(corner);
                stance.rotation.transpose() * (at - stance.origin)
            })
            .collect()
    }
}

/// Centre of pressure and total force; `None` without load.
pub(super) fn pressure(forces: &[f64], places: &[Vector3<f64>]) -> Option<Ground> {
    let total: f64 = forces.iter().sum();
    let moment: Vector3<f64> = forces.iter().zip(places).map(|(force, place)| place * *force).sum();
    (total > 1e-6).then(|| [moment.x / total, moment.y / total, total])
}
