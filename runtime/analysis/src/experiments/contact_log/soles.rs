//! How deep the corners of loaded soles lie, as base and joints tell: rows on which the ground's compliance shows.
//!
//! One row per corner of a foot whose forces are logged: its height (m, the log's world axes) less the mean of the same
//! stance, since nobody logs where the ground is. Predicted: level. With `ground_compliance` a corner sinks by
//! δ = f/k - d ḟ/k² (the slow part of f = k δ + d δ̇); the corner forces f are those of a plate on equal springs with
//! the foot's force and centre of pressure. While a foot swings, and near touchdown, lift-off and tipping, the row is zero.
use super::ContactExperiment;
use super::effects::Change;
use super::foot::SIGNALS;
use super::rows::NOISE_SAMPLES;
use crate::experiments::{Channel, Row};
use crate::robot::Foot;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// A foot stands from this part of the weight on ...
const STANDS: f64 = 0.2;
/// ... as long as its centre of pressure keeps this part of the sole's length and width away from the edges: about them it tips.
const INSIDE: f64 = 0.04;
/// Left out at either end of a stance, in periods of the cut-off.
const MARGIN: f64 = 1.5;
/// Shortest stance, in samples.
const SHORTEST: usize = 8;
/// Of joint angles, for slopes, rad.
const STEP: f64 = 1e-6;
/// Smallest noise that is believed, m: no robot's lengths are known better.
const SMALLEST: f64 = 2e-4;

/// Spring (N/m) and damper (N s/m) below each corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Soil {
    pub stiffness: f64,
    pub damping: f64,
}

/// Which corner of which foot.
#[derive(Debug, Clone, Copy)]
pub(super) struct SoleCorner {
    foot: usize,
    corner: usize,
}

impl ContactExperiment<'_> {
    /// Finds the corners that have rows, and lists these rows.
    pub(super) fn add_soles(&mut self) {
        let planar = self.robot.planar();
        let feet = self.robot.feet.iter().zip(&self.recording.feet).enumerate();
        let feet = feet.filter(|(_, (foot, record))| record.is_logged && foot.is_flat(planar) && !planar);
        let corners = feet
            .flat_map(|(foot, (of, _))| (0..of.corners.len()).map(move |corner| SoleCorner { foot, corner }));
        self.soles = corners.collect();
        self.stances = (0..self.robot.feet.len()).map(|foot| self.stances_of(foot)).collect();
        let stances = &self.stances;
        self.soles.retain(|sole| !stances[sole.foot].is_empty());
        let nominal = self.change(&[]);
        for residual in self.sole_residuals(&nominal) {
            let SoleCorner { foot: at, corner } = self.soles[self.rows.len() - self.kinds.len()];
            let foot = &self.robot.feet[at];
            self.rows.push(Row {
                name: format!("{}/{}/height", foot.name, foot.corners[corner].name),
                channel: Channel::Sole,
                unit: "m",
                joint: None,
                noise: self.height_noise(SoleCorner { foot: at, corner }, &nominal).max(SMALLEST),
            });
            self.residual.push(residual);
        }
    }

    /// Samples during which a foot stands, without the ends.
    fn stances_of(&self, foot: usize) -> Vec<Range<usize>> {
        let record = &self.recording.feet[foot];
        if !record.is_logged {
            return Vec::new();
        }
        let weight = self.parameters.mass() * self.gravity.norm();
        let plate = Plate::new(&self.robot.feet[foot]);
        let margin = (MARGIN / self.recording.cutoff_hz / self.recording.step).ceil() as usize;
        let mut out = Vec::new();
        for segment in &self.recording.segments {
            let mut first = None;
            for i in segment.start..=segment.end {
                let signals = record.signals.get(i).filter(|_| i < segment.end);
                let stands = signals
                    .is_some_and(|signals| signals[2] > STANDS * weight && plate.is_flat_under(signals));
                match (stands, first) {
                    (true, None) => first = Some(i),
                    (false, Some(start)) => {
                        let inside = start + margin..i.saturating_sub(margin);
                        if inside.len() >= SHORTEST {
                            out.push(inside);
                        }
                        first = None;
                    }
                    _ => {}
                }
            }
        }
        out
    }

    /// Measured minus predicted heights, one row per corner, at the samples that count.
    pub(super) fn sole_residuals(&self, change: &Change) -> Vec<Vec<f64>> {
        let mut rows = Vec::with_capacity(self.soles.len());
        for foot in 0..self.robot.feet.len() {
            let mine = self.soles.iter().filter(|sole| sole.foot == foot).count();
            if mine == 0 {
                continue;
            }
            let mut sinks = vec![vec![0.0; self.samples()]; mine];
            for stance in &self.stances[foot] {
                let heights = self.heights(foot, stance.clone(), change);
                let depths = self.depths(foot, stance.clone(), change);
                for corner in 0..mine {
                    let errors: Vec<f64> = heights
                        .iter()
                        .zip(&depths)
                        .map(|(height, depth)| height[corner] + depth[corner])
                        .collect();
                    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
                    let values = errors.iter().map(|error| error - mean);
                    sinks[corner][stance.clone()]
                        .iter_mut()
                        .zip(values)
                        .for_each(|(row, value)| *row = value);
                }
            }
            rows.extend(sinks.iter().map(|row| self.recording.pick(row)));
        }
        rows
    }

    /// Heights of a foot's corners during a stance, m.
    fn heights(&self, foot: usize, stance: Range<usize>, change: &Change) -> Vec<Vec<f64>> {
        let of = &self.robot.feet[foot];
        let height = |i: usize| {
            let [q, ..] = self.kinematics(i, change);
            let sole = self.feet[foot].sole(&self.calls, of, &q);
            (0..of.corners.len()).map(|c| sole.origin.z + (sole.rotation * of.corner(c)).z).collect()
        };
        stance.map(height).collect()
    }

    /// What the noise of base and joints makes of a corner's height, m.
    fn height_noise(&self, at: SoleCorner, change: &Change) -> f64 {
        let of = &self.robot.feet[at.foot];
        let place = |q: &[f64]| {
            let sole = self.feet[at.foot].sole(&self.calls, of, q);
            sole.origin + sole.rotation * of.corner(at.corner)
        };
        let gain = self.recording.value_gain();
        let noise = &self.recording.position_noise;
        let stride = (self.samples() / NOISE_SAMPLES).max(1);
        let variance = |i: usize| -> f64 {
            let [mut q, ..] = self.kinematics(i, change);
            let here = place(&q);
            let arm = self.base_axes(&q).transpose() * (here - self.base_origin(&q));
            // The base's height, and its turns about its own axes.
            let up = self.base_axes(&q).transpose() * Vector3::z();
            let mut sum = noise[2].powi(2);
            for k in 0..3 {
                let mut axis = Vector3::zeros();
                axis[k] = 1.0;
                sum += (axis.cross(&arm).dot(&up) * noise[3 + k]).powi(2);
            }
            for (joint, sigma) in noise[6..].iter().enumerate() {
                q[7 + joint] += STEP;
                sum += ((place(&q).z - here.z) / STEP * sigma).powi(2);
                q[7 + joint] -= STEP;
            }
            sum * gain
        };
        let at: Vec<usize> = (0..self.samples()).step_by(stride).collect();
        (at.iter().map(|i| variance(*i)).sum::<f64>() / at.len().max(1) as f64).sqrt()
    }

    /// How deep the corners sink, m.
    fn depths(&self, foot: usize, stance: Range<usize>, change: &Change) -> Vec<Vec<f64>> {
        let count = self.robot.feet[foot].corners.len();
        let Some(soil) = change.soil else { return vec![vec![0.0; count]; stance.len()] };
        let plate = Plate::new(&self.robot.feet[foot]);
        let force = |i: usize| plate.forces(&self.recording.feet[foot].signals[i]);
        let (first, last) = (stance.start, stance.end - 1);
        let depth = |i: usize| {
            let (before, after) = (i.saturating_sub(1).max(first), (i + 1).min(last));
            let (now, earlier, later) = (force(i), force(before), force(after));
            let time = (after - before) as f64 * self.recording.step;
            let rate = |c: usize| (later[c] - earlier[c]) / time;
            (0..count)
                .map(|c| now[c] / soil.stiffness - soil.damping * rate(c) / soil.stiffness.powi(2))
                .collect()
        };
        stance.map(depth).collect()
    }
}

/// A rigid sole on equal springs.
struct Plate {
    corners: Vec<Vector3<f64>>,
    inverse: Matrix3<f64>,
}

impl Plate {
    fn new(foot: &Foot) -> Self {
        // Places as 1, x, y.
        let corners: Vec<Vector3<f64>> = (0..foot.corners.len())
            .map(|c| {
                let at = foot.corner(c);
                Vector3::new(1.0, at.x, at.y)
            })
            .collect();
        let sum: Matrix3<f64> = corners.iter().map(|c| c * c.transpose()).sum();
        Self { corners, inverse: sum.try_inverse().unwrap_or_else(Matrix3::zeros) }
    }

    /// Normal forces of the corners, N.
    fn forces(&self, signals: &[f64; SIGNALS]) -> Vec<f64> {
        let plane = self.inverse * moments(signals);
        self.corners.iter().map(|c| c.dot(&plane)).collect()
    }

    /// Whether the force acts so far from the edges that the sole does not tip.
    fn is_flat_under(&self, signals: &[f64; SIGNALS]) -> bool {
        let moments = moments(signals);
        (1..3).all(|axis| {
            let ends = self.corners.iter().map(|corner| corner[axis]);
            let (low, high) =
                (ends.clone().fold(f64::INFINITY, f64::min), ends.fold(f64::NEG_INFINITY, f64::max));
            let (center, margin) = (moments[axis] / moments.x, INSIDE * (high - low));
            center > low + margin && center < high - margin
        })
    }
}

/// A foot's normal force and its first moments: from the centre of pressure, or from the torque where that is logged.
fn moments(signals: &[f64; SIGNALS]) -> Vector3<f64> {
    Vector3::new(signals[2], signals[5] - signals[10], signals[8] + signals[9])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::ContactPoint;

    #[test]
    fn a_plate_carries_force_and_moments() {
        let point = |x: f64, y: f64| ContactPoint { name: String::new(), position: [x, y, -0.05] };
        let corners = vec![point(0.13, 0.04), point(0.13, -0.05), point(-0.07, 0.04), point(-0.06, -0.05)];
        let foot = Foot { name: "foot".into(), frame: "foot".into(), side: None, corners };
        let mut signals = [0.0; SIGNALS];
        (signals[2], signals[5], signals[8]) = (100.0, 3.0, -1.2);
        let forces = Plate::new(&foot).forces(&signals);
        let sum = |weight: &dyn Fn(usize) -> f64| (0..4).map(|c| weight(c) * forces[c]).sum::<f64>();
        assert!((sum(&|_| 1.0) - 100.0).abs() < 1e-10);
        assert!((sum(&|c| foot.corner(c).x) - 3.0).abs() < 1e-12);
        assert!((sum(&|c| foot.corner(c).y) + 1.2).abs() < 1e-12);
        // The same force and its torque about the sole's origin: M_x = y f, M_y = -x f.
        let mut torques = [0.0; SIGNALS];
        (torques[2], torques[9], torques[10]) = (100.0, -1.2, -3.0);
        assert!(Plate::new(&foot).forces(&torques).iter().zip(&forces).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
