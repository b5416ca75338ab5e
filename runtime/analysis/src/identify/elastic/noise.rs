//! How far rows scatter: what they are weighted by.
use super::solve::{Point, Solver};
use crate::identify::triangle::Triangle;
use nalgebra::DVector;

/// Standard deviations of residuals.
pub struct Noise {
    /// By elastic drive, N m at the motor.
    pub motors: Vec<f64>,
    /// By channel, N m or N.
    pub joints: Vec<f64>,
}

impl Noise {
    pub fn ones(solver: &Solver<'_, '_>) -> Self {
        // Before residuals are known, a motor's torque counts as much as the torque behind its gear.
        let gear = |t: &usize| 1.0 / solver.drives[*t].drive.turns().abs().max(f64::MIN_POSITIVE);
        Self {
            motors: solver.folded.elastic.iter().map(gear).collect(),
            joints: vec![1.0; solver.design.channels.len()],
        }
    }
}

impl Solver<'_, '_> {
    /// Standard deviation of every row's residual.
    pub fn residuals(&self, point: &Point) -> Noise {
        let copies = usize::from(self.folded.instruments);
        let deviation = |triangle: &Triangle, own: &DVector<f64>, unknowns: usize| {
            let freedom = triangle.rows().saturating_sub(unknowns).max(1) as f64;
            (triangle.squares(own) / freedom).sqrt()
        };
        let summed = |parts: &mut dyn Iterator<Item = &Triangle>| {
            parts.fold(None, |sum: Option<Triangle>, part| match sum {
                Some(mut sum) => {
                    sum.add(part);
                    Some(sum)
                }
                None => Some(part.clone()),
            })
        };
        let motor = |k: usize| {
            let triangle = summed(&mut self.folded.motors.iter().map(|cell| &cell[k]))
                .unwrap_or_else(|| Triangle::new(0));
            let count = self.folded.laws.count();
            let own = DVector::from_iterator(
                (1 + copies) * count,
                std::iter::repeat_n(0.0, copies * count).chain(point.motors[k].iter().copied()),
            );
            deviation(&triangle, &own, count)
        };
        let stiffness = self.stiffness(&point.motors);
        let joint = |c: usize| {
            let triangle = summed(&mut self.folded.joints.iter().map(|cell| &cell[c]))
                .unwrap_or_else(|| Triangle::new(0));
            let places = &self.design.channels[c].places;
            let zeros = std::iter::repeat_n(0.0, copies * places.len());
            let values: Vec<f64> = zeros
                .chain(places.iter().map(|&p| point.theta[p]))
                .chain(self.folded.springs[c].map(|k| stiffness[k]))
                .collect();
            deviation(&triangle, &DVector::from_vec(values), places.len())
        };
        let floor = |list: Vec<f64>| -> Vec<f64> {
            let least = 1e-12 * list.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE.sqrt());
            list.into_iter().map(|x| x.max(least)).collect()
        };
        Noise {
            motors: floor((0..self.folded.elastic.len()).map(motor).collect()),
            joints: floor((0..self.design.channels.len()).map(joint).collect()),
        }
    }
}
