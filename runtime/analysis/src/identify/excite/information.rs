//! How much a motion tells: the regression that it would make, and how that changes with the motion.
use super::machine::Machine;
use super::spectrum::{self, Criterion, Scaling};
use crate::robot::Trajectory;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Columns of this part of their length are sums of others.
const DEPENDENT: f64 = 1e-9;
/// Step of central differences of the regressor, rad and rad/s, rad/s².
const STEP: f64 = 1e-5;

/// What a motion is worth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MotionQuality {
    /// Condition number of the regressor with columns of length 1.
    pub condition_number: f64,
    /// Condition number of the regressor in SI units (thesis 5.9, 5.16).
    pub unscaled_condition_number: f64,
    /// `ln det WᵀW` over the samples at which motions are judged, SI units.
    pub log_determinant: f64,
}

/// The regression of the moving joints' rows on what these rows tell.
pub struct Regression<'r, 'm> {
    machine: &'r Machine<'m>,
    /// Where the columns of each row begin in a batch's values.
    starts: Vec<usize>,
    /// Columns of the base regressor that are no sums of others while only the moving joints move.
    columns: Vec<usize>,
}

impl<'r, 'm> Regression<'r, 'm> {
    /// Finds the columns; `random` gives numbers between -1 and 1.
    pub fn new(machine: &'r Machine<'m>, random: &mut dyn FnMut() -> f64) -> Self {
        let pattern = machine.regressor.pattern();
        let starts = pattern
            .iter()
            .scan(0, |sum, row| {
                *sum += row.len();
                Some(*sum - row.len())
            })
            .collect();
        let mut columns: Vec<usize> = machine.moving.iter().flat_map(|&row| pattern[row].clone()).collect();
        columns.sort_unstable();
        columns.dedup();
        let mut regression = Self { machine, starts, columns };
        regression.group(random);
        regression
    }

    /// Drops columns that are sums of those before them at random states.
    fn group(&mut self, random: &mut dyn FnMut() -> f64) {
        let (machine, joints) = (self.machine, self.machine.layout.joints.len());
        let count = 4 * self.columns.len().max(8);
        let mut states = machine.resting(count);
        for i in 0..count {
            for &joint in machine.moving {
                let at = i * joints + joint;
                (states.q[at], states.v[at], states.a[at]) = (1.5 * random(), 2.0 * random(), 5.0 * random());
            }
        }
        let rows = self.rows(&states);
        let mut kept: Vec<DVector<f64>> = Vec::new();
        let mut place = 0;
        self.columns.retain(|_| {
            let column = rows.column(place).into_owned();
            place += 1;
            let mut rest = column.clone();
            // Twice is enough (Parlett).
            for _ in 0..2 {
                for direction in &kept {
                    rest.axpy(-direction.dot(&rest), direction, 1.0);
                }
            }
            let independent = rest.norm() > DEPENDENT * column.norm();
            if independent {
                kept.push(rest.normalize());
            }
            independent
        });
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.columns.len()
    }

    /// The regressor of the moving joints' torques; rows: joint after joint, all states of each.
    pub fn rows(&self, motion: &Trajectory) -> DMatrix<f64> {
        let (pattern, count) = (self.machine.regressor.pattern(), motion.len());
        let mut entries = vec![0.0; pattern.iter().map(Vec::len).sum::<usize>() * count];
        self.machine.regressor.evaluate(&motion.batch(), &mut entries);
        let mut rows = DMatrix::zeros(self.machine.moving.len() * count, self.columns.len());
        for (k, &row) in self.machine.moving.iter().enumerate() {
            for (place, column) in pattern[row].iter().enumerate() {
                let Ok(to) = self.columns.binary_search(column) else { continue };
                let from = (self.starts[row] + place) * count;
                rows.column_mut(to).as_mut_slice()[k * count..][..count]
                    .copy_from_slice(&entries[from..from + count]);
            }
        }
        rows
    }

    /// What a motion is worth; infinite condition numbers if it does not tell everything.
    pub fn quality(&self, motion: &Trajectory) -> MotionQuality {
        let rows = self.rows(motion);
        let (condition_number, log_determinant) = spectrum::quality(&rows, Scaling::Unit);
        let (unscaled_condition_number, _) = spectrum::quality(&rows, Scaling::Own);
        MotionQuality { condition_number, unscaled_condition_number, log_determinant }
    }

    /// The smooth cost of a motion and its derivatives by positions, velocities and accelerations, laid out like them;
    /// `None` where it is infinite.
    ///
    /// The regressor's own derivatives are central differences (exact for velocities and accelerations, up to rounding:
    /// it is of second degree in them).
    pub fn cost(
        &self,
        motion: &Trajectory,
        criterion: Criterion,
        scaling: Scaling,
    ) -> Option<(f64, Trajectory)> {
        let (cost, slopes) = spectrum::slopes(&self.rows(motion), criterion, scaling)?;
        let joints = self.machine.layout.joints.len();
        let mut gradient = motion.zeros();
        for &joint in self.machine.moving {
            for order in 0..3 {
                let [up, down] = [STEP, -STEP].map(|step| self.rows(&shifted(motion, order, joint, step)));
                let change = (up - down) / (2.0 * STEP);
                let product = change.component_mul(&slopes);
                // Rows: joint after joint, all states of each.
                for (r, row) in product.row_iter().enumerate() {
                    gradient.order_mut(order)[(r % motion.len()) * joints + joint] += row.sum();
                }
            }
        }
        Some((cost, gradient))
    }
}

/// The motion with one joint's position (0), velocity (1) or acceleration (2) changed.
pub fn shifted(motion: &Trajectory, order: usize, joint: usize, step: f64) -> Trajectory {
    let mut other = motion.clone();
    other.joint_mut(order, joint).for_each(|x| *x += step);
    other
}
