//! What the ground does to single contact points, from what it does to the robot.
use crate::simulate::{Block, Cone, Law, Problem, Solver, Tolerance};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::model::{Argument, Model, State};
use nalgebra::{DMatrix, DVector};

/// Singular values below this part of the largest belong to forces that the motion does not tell.
const RANK: f64 = 1e-9;

/// A coefficient of friction that nothing exceeds.
const UNLIMITED: f64 = 1e4;

/// What generalised forces may differ by, as a part of the largest.
const SAME: f64 = 1e-7;

/// Functions that spread generalised forces over the standing points.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointForces {
    inverse: usize,
    normal: usize,
    tangential: usize,
    points: usize,
}

/// Functions of the model that it needs.
pub(crate) const FUNCTIONS: [&str; 3] =
    ["inverse_dynamics", "contact_normal_directions", "contact_tangential_directions"];

impl PointForces {
    pub fn new(model: &dyn Model<f64>) -> Result<Self, Diagnostic> {
        let find = |name: &str| {
            model.function(name).ok_or_else(|| {
                Diagnostic::error(format!("the model has no function `{name}`"))
                    .help("add it to what is generated from the description")
            })
        };
        let [inverse, normal, tangential] = FUNCTIONS;
        let (inverse, normal, tangential) = (find(inverse)?, find(normal)?, find(tangential)?);
        let points = model.signature(normal).map_or(0, |s| s.columns);
        Ok(Self { inverse, normal, tangential, points })
    }

    fn call(model: &dyn Model<f64>, function: usize, state: &State<'_, f64>) -> Vec<f64> {
        let mut out = vec![0.0; model.signature(function).map_or(0, |s| s.rows * s.columns)];
        if model.evaluate(function, state, &mut out).is_err() {
            out.fill(f64::NAN);
        }
        out
    }

    /// `D a + H − τ = W λ`, N and N m.
    pub fn generalised(&self, model: &dyn Model<f64>, [q, v, a, tau]: [&[f64]; 4]) -> Vec<f64> {
        let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::A, a);
        let needed = Self::call(model, self.inverse, &state);
        needed.iter().zip(tau).map(|(needed, tau)| needed - tau).collect()
    }

    /// `D Δv`, N s and N m s.
    pub fn impulse(&self, model: &dyn Model<f64>, q: &[f64], jump: &[f64]) -> Vec<f64> {
        let still = vec![0.0; jump.len()];
        let rest = self.generalised(model, [q, &still, &still, &still]);
        let moved = self.generalised(model, [q, &still, jump, &still]);
        moved.iter().zip(rest).map(|(moved, rest)| moved - rest).collect()
    }

    /// Directions of the points: `nv` rows, per point the normal and the tangential ones (x, or x and y).
    pub fn directions(&self, model: &dyn Model<f64>, q: &[f64], points: &[usize]) -> DMatrix<f64> {
        let state = State::new().with(Argument::Q, q);
        let normal = Self::call(model, self.normal, &state);
        let tangential = Self::call(model, self.tangential, &state);
        let (nv, tangents) = (model.nv(), self.tangents(model));
        let size = 1 + tangents;
        DMatrix::from_fn(nv, points.len() * size, |row, column| {
            let (point, axis) = (points[column / size], column % size);
            if axis == 0 {
                normal[point * nv + row]
            } else {
                tangential[(point * tangents + axis - 1) * nv + row]
            }
        })
    }

    fn tangents(&self, model: &dyn Model<f64>) -> usize {
        let columns = model.signature(self.tangential).map_or(0, |s| s.columns);
        columns.checked_div(self.points).unwrap_or(0)
    }

    /// Forces on the standing points (world axes) whose generalised force is `sum`. Where several sets do, as on four corners
    /// of a flat foot, the one with the least sum of squares of those that pull nowhere and stay within friction; if there is
    /// none, which the verdict will say, of all.
    pub fn spread(
        &self,
        model: &dyn Model<f64>,
        q: &[f64],
        (standing, friction): (&[usize], f64),
        sum: &[f64],
    ) -> Vec<[f64; 3]> {
        let mut forces = vec![[0.0; 3]; self.points];
        if standing.is_empty() || !sum.iter().all(|x| x.is_finite()) {
            return forces;
        }
        let tangents = self.tangents(model);
        let size = 1 + tangents;
        let (rows, sum) = (self.directions(model, q, standing), DVector::from_column_slice(sum));
        let svd = rows.clone().svd(true, true);
        let least = RANK * svd.singular_values.amax();
        let Ok(mut found) = svd.solve(&sum, least) else { return forces };
        if !admissible(&found, tangents, friction)
            && let Some(better) = within_friction(&rows, &sum, tangents, friction)
        {
            found = better;
        }
        for (k, &point) in standing.iter().enumerate() {
            let own = &found.as_slice()[k * size..(k + 1) * size];
            forces[point] = [own[1], if size == 3 { own[2] } else { 0.0 }, own[0]];
        }
        forces
    }
}

/// Whether all points push, and none more along the ground than friction holds.
fn admissible(forces: &DVector<f64>, tangents: usize, friction: f64) -> bool {
    forces.as_slice().chunks_exact(1 + tangents).all(|own| {
        let along = own[1..].iter().map(|x| x * x).sum::<f64>().sqrt();
        // Infinite friction times nothing holds too.
        own[0] >= 0.0 && (along <= friction * own[0] || along == 0.0)
    })
}

/// The forces that share the load within the laws of contact: a contact problem in which everything sticks.
fn within_friction(
    rows: &DMatrix<f64>,
    sum: &DVector<f64>,
    tangents: usize,
    friction: f64,
) -> Option<DVector<f64>> {
    let size = 1 + tangents;
    let (square, right) = (rows.transpose() * rows, rows.transpose() * sum);
    let mut problem = Problem::default();
    problem.clear(rows.ncols());
    problem.set_delassus(|i, j| square[(i, j)]);
    problem.free.iter_mut().zip(right.iter()).for_each(|(free, right)| *free = -right);
    let friction = friction.min(UNLIMITED);
    let law = Law::Contact { friction, tangents, cone: Cone::Round };
    problem.blocks.extend((0..rows.ncols() / size).map(|k| Block { first: k * size, law }));
    let solved =
        Solver::default().solve(&mut problem, &Tolerance { relative: 1e-10, ..Tolerance::default() });
    let found = DVector::from_column_slice(&problem.impulse);
    (solved.converged && (rows * &found - sum).amax() <= SAME * sum.amax()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wrench of four corners of a sole, 0.3 m by 0.2 m, about its middle: force, then moment.
    fn sole() -> DMatrix<f64> {
        let corners = [[-0.15, -0.1], [0.15, -0.1], [-0.15, 0.1], [0.15, 0.1]];
        DMatrix::from_fn(6, 12, |row, column| {
            let [x, y] = corners[column / 3];
            // z, x, y as the directions have them.
            let force = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]][column % 3];
            let moment = [y * force[2], -x * force[2], x * force[1] - y * force[0]];
            if row < 3 { force[row] } else { moment[row - 3] }
        })
    }

    #[test]
    fn no_corner_pulls_or_exceeds_friction() {
        let rows = sole();
        // 10 N at six tenths of the way to a corner: least squares alone would pull the opposite one with 0.5 N.
        let sum = DVector::from_vec(vec![1.0, 0.0, 10.0, 0.6, -0.9, -0.06]);
        let free = rows.clone().svd(true, true).solve(&sum, 1e-9).unwrap();
        assert!(free[0] < -0.4 && !admissible(&free, 2, 0.6));
        let found = within_friction(&rows, &sum, 2, 0.6).unwrap();
        let normal: Vec<f64> = found.iter().step_by(3).copied().collect();
        for (found, expected) in normal.iter().zip([0.0, 2.0, 2.0, 6.0]) {
            assert!((found - expected).abs() < 1e-5, "{normal:?}");
        }
        assert!(admissible(&found, 2, 0.6 + 1e-9), "{found}");
        // What slips cannot be held, and is left to the verdict.
        let sum = DVector::from_vec(vec![8.0, 0.0, 10.0, 0.0, 0.0, 0.0]);
        assert!(within_friction(&rows, &sum, 2, 0.6).is_none());
    }
}
