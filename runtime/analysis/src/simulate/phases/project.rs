//! States that miss the contacts of a phase by little are moved onto them.
use super::robot::PhasedRobot;
use crate::simulate::mechanics::{Frame, advance};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// What is not worth a change, m and m/s.
const CLOSE: f64 = 1e-9;
/// Heights that are zero after it, m.
const EXACT: f64 = 1e-13;
/// Largest change of a coordinate: more is no inaccuracy but another state. rad or m, and the same per second.
const LARGEST: [f64; 2] = [0.01, 0.1];
/// Newton steps of the heights.
const ROUNDS: usize = 8;

/// How much the beginning of a walk differs from what the scenario says.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Projected {
    /// Largest change of a coordinate, rad or m.
    pub position: f64,
    /// Of a velocity, rad/s or m/s.
    pub velocity: f64,
}

impl PhasedRobot<'_> {
    /// Moves standing points onto the ground, and points in the air out of it, by the least change of all coordinates. Gives the
    /// largest one, rad or m; too large ones are not made.
    pub(super) fn project_position(&self, standing: &[usize], q: &mut [f64]) -> f64 {
        let mut moved = q.to_vec();
        let mut points = standing.to_vec();
        let mut sum = DVector::zeros(self.model.nv());
        for _ in 0..ROUNDS {
            let heights = self.heights(&moved);
            points.extend(self.sunk(&heights, &points));
            let missed = DVector::from_iterator(points.len(), points.iter().map(|&point| heights[point]));
            let accurate = if sum.amax() > 0.0 { EXACT } else { CLOSE };
            if points.is_empty() || missed.amax() <= accurate {
                q.copy_from_slice(&moved);
                return sum.amax();
            }
            let Some(step) = least(self.heights_by_velocity(&moved, &points), -missed) else { return 0.0 };
            sum += &step;
            if sum.iter().any(|x| x.is_nan() || x.abs() > LARGEST[0]) {
                return 0.0;
            }
            advance(self.base, self.model.joints(), (&mut moved, step.as_slice()), 1.0, Frame::Start);
        }
        0.0
    }

    /// The same of velocities: standing points rest, points on the ground that do not stand do not go into it.
    pub(super) fn project_velocity(&self, standing: &[usize], q: &[f64], v: &mut [f64]) -> f64 {
        let heights = self.heights(q);
        let air = (0..heights.len()).filter(|point| self.forbids_scuffing() && !standing.contains(point));
        let on_ground: Vec<usize> = air.filter(|&point| heights[point].abs() <= CLOSE).collect();
        let given = DVector::from_column_slice(v);
        let mut sinking: Vec<usize> = Vec::new();
        loop {
            let mut rows = self.resting(q, standing);
            for height in self.heights_by_velocity(q, &sinking).row_iter() {
                let n = rows.nrows();
                rows = rows.insert_row(n, 0.0);
                rows.row_mut(n).copy_from(&height);
            }
            let missed = &rows * &given;
            let mut change = DVector::zeros(v.len());
            if !missed.is_empty() && missed.amax() > CLOSE {
                let Some(found) = least(rows, -missed) else { return 0.0 };
                change = found;
            }
            if change.iter().any(|x| x.is_nan() || x.abs() > LARGEST[1]) {
                return 0.0;
            }
            let falls = |point: &usize| {
                !sinking.contains(point)
                    && (self.heights_by_velocity(q, &[*point]) * (&given + &change)).amin() < -CLOSE
            };
            let more: Vec<usize> = on_ground.iter().copied().filter(falls).collect();
            if more.is_empty() {
                v.copy_from_slice((given + &change).as_slice());
                return change.amax();
            }
            sinking.extend(more);
        }
    }

    /// Points in the air that are below the ground where they may not be.
    fn sunk(&self, heights: &[f64], known: &[usize]) -> Vec<usize> {
        let below = |point: &usize| heights[*point] < -CLOSE && !known.contains(point);
        if self.forbids_scuffing() { (0..heights.len()).filter(below).collect() } else { Vec::new() }
    }

    /// Whether points in the air may not be below the ground.
    fn forbids_scuffing(&self) -> bool {
        self.assumptions.scuffing.is_finite()
    }

    /// Velocities of standing points by generalised ones.
    fn resting(&self, q: &[f64], standing: &[usize]) -> DMatrix<f64> {
        if standing.is_empty() { DMatrix::zeros(0, self.model.nv()) } else { self.directions(q, standing) }
    }

    /// Their vertical parts.
    fn heights_by_velocity(&self, q: &[f64], points: &[usize]) -> DMatrix<f64> {
        let rows = self.resting(q, points);
        let each = rows.nrows().checked_div(points.len()).unwrap_or(1);
        DMatrix::from_fn(points.len(), rows.ncols(), |point, column| rows[(point * each, column)])
    }
}

/// The smallest vector that rows make these values of.
fn least(rows: DMatrix<f64>, values: DVector<f64>) -> Option<DVector<f64>> {
    let svd = rows.svd(true, true);
    let rank = 1e-9 * svd.singular_values.amax();
    svd.solve(&values, rank).ok()
}
