//! What the ground does to single contact points, from what it does to the robot.
use crate::diagnostic::Diagnostic;
use crate::model::{Argument, Model, State};
use nalgebra::{DMatrix, DVector};

/// Singular values below this part of the largest belong to forces that the motion does not tell.
const RANK: f64 = 1e-9;

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
    /// of a flat foot, the one with the least sum of squares.
    pub fn spread(
        &self,
        model: &dyn Model<f64>,
        q: &[f64],
        standing: &[usize],
        sum: &[f64],
    ) -> Vec<[f64; 3]> {
        let mut forces = vec![[0.0; 3]; self.points];
        if standing.is_empty() || !sum.iter().all(|x| x.is_finite()) {
            return forces;
        }
        let size = 1 + self.tangents(model);
        let svd = self.directions(model, q, standing).svd(true, true);
        let least = RANK * svd.singular_values.amax();
        let Ok(found) = svd.solve(&DVector::from_column_slice(sum), least) else { return forces };
        for (k, &point) in standing.iter().enumerate() {
            let own = &found.as_slice()[k * size..(k + 1) * size];
            forces[point] = [own[1], if size == 3 { own[2] } else { 0.0 }, own[0]];
        }
        forces
    }
}
