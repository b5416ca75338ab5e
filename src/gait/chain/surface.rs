//! The constraint surface of a phase with feet that stand: q = T(φ) where the ground holds what it held when the phase began (6.30).
use super::Refused;
use crate::gait::PhasedBench;
use crate::gait::checked::{configurations, dependent_in_all, says_nothing_new};
use bipedc_analysis::gait::Reason;
use bipedc_compiler::compile::ProgramModel;
use bipedc_compiler::derive::dependence::dependent_row;
use bipedc_compiler::description::gait::GaitOutput;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::{Argument, Model, State};
use nalgebra::{DMatrix, DVector};

/// Iterations after which there is no solution nearby.
const ITERATIONS: usize = 40;
/// Residuals (m, rad) of a solution.
const SOLVED: f64 = 1e-12;

/// A point of the surface.
pub struct SurfacePoint {
    /// T
    pub q: Vec<f64>,
    /// T′, per unit of φ.
    pub slope: Vec<f64>,
}

/// Functions of a phase that fix q.
pub(super) struct Surface {
    constraints: usize,
    jacobian: usize,
    slope: usize,
    curvature: usize,
    /// Contact points that are held, along x and z.
    held: Vec<(usize, Axis)>,
    positions: usize,
    heights: usize,
    along: usize,
    normals: usize,
    name: String,
    outputs: Vec<GaitOutput>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Axis {
    X,
    Z,
}

impl Surface {
    /// Of a phase of the gait; `standing` are the contact points that stand.
    pub fn new(
        model: &ProgramModel,
        bench: &PhasedBench,
        index: usize,
        standing: &[usize],
    ) -> Result<Self, Diagnostic> {
        let phase = &bench.gait.phases[index].name;
        let need = |family: &str, of: Option<&str>| {
            let functions = &bench.compiled.model.functions;
            let found = functions.iter().position(|f| f.family == family && f.subject.as_deref() == of);
            found.ok_or_else(|| Diagnostic::error(format!("the gait has no function `{family}`")))
        };
        let own = |family: &str| need(family, Some(phase));
        let points = &model.compiled().tree.points;
        let foot = |point: usize| points.get(point).map_or("", |p| p.name.split('/').next().unwrap_or(""));
        let mut held: Vec<(usize, Axis)> = Vec::new();
        for &point in standing {
            let others = standing.iter().filter(|&&other| foot(other) == foot(point));
            match others.take_while(|&&other| other != point).count() {
                0 => held.extend([(point, Axis::X), (point, Axis::Z)]),
                // A second point of a foot keeps it from turning, more say nothing new.
                1 => held.push((point, Axis::Z)),
                _ => {}
            }
        }
        Ok(Self {
            constraints: own("virtual_constraints")?,
            jacobian: own("virtual_constraints_jacobian")?,
            slope: own("virtual_constraints_slope")?,
            curvature: own("virtual_constraints_curvature")?,
            held,
            positions: need("contact_positions", None)?,
            heights: need("contact_distances", None)?,
            along: need("contact_tangential_directions", None)?,
            normals: need("contact_normal_directions", None)?,
            name: phase.clone(),
            outputs: bench.gait.phases[index].outputs.clone(),
        })
    }

    /// That contacts, outputs and φ fix the joints, if not in every posture.
    ///
    /// # Errors
    /// The output that says what contacts, φ and the outputs before it say.
    pub fn checked(&self, model: &ProgramModel) -> Result<(), Diagnostic> {
        let arguments = vec![0.0; Model::<f64>::argument_length(model, Argument::Parameters)];
        let matrix = |q: Vec<f64>| self.in_turn(&self.matrix(model, (&q, &arguments)));
        let found = dependent_in_all(configurations(Model::<f64>::nq(model)).map(matrix));
        found.and_then(|row| self.output(row)).map_or(Ok(()), |output| Err(self.nothing_new(output)))
    }

    /// Rows of the matrix: what is held, φ, then the outputs.
    fn in_turn(&self, matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
        let (held, last) = (self.held.len(), matrix.nrows() - 1);
        let rows = (0..held).chain([last]).chain(held..last);
        rows.map(|row| matrix.row(row).iter().copied().collect()).collect()
    }

    /// The output of such a row.
    fn output(&self, row: usize) -> Option<&GaitOutput> {
        self.outputs.get(row.checked_sub(self.held.len() + 1)?)
    }

    fn nothing_new(&self, output: &GaitOutput) -> Diagnostic {
        says_nothing_new(
            output,
            &format!("contacts and φ of phase `{}` and the outputs before it", self.name),
        )
    }

    /// Coordinates that the ground holds at q, m.
    pub fn held(&self, model: &ProgramModel, q: &[f64]) -> Vec<f64> {
        let state = State::new().with(Argument::Q, q);
        let (x, z) = (call(model, self.positions, &state), call(model, self.heights, &state));
        let of = |&(point, axis): &(usize, Axis)| if axis == Axis::X { x[point] } else { z[point] };
        self.held.iter().map(of).collect()
    }

    /// The same heights, but on the ground.
    pub fn put_on_the_ground(&self, held: &mut [f64]) {
        for ((_, axis), held) in self.held.iter().zip(held) {
            *held = if *axis == Axis::Z { 0.0 } else { *held };
        }
    }

    /// T and T′ for these arguments of the gait, with feet where they are held, looked for from `near`.
    pub fn at(
        &self,
        model: &ProgramModel,
        (arguments, held): (&[f64], &[f64]),
        near: &[f64],
    ) -> Result<SurfacePoint, Refused> {
        let residual = |q: &[f64]| {
            let state = State::new().with(Argument::Q, q).with(Argument::Parameters, arguments);
            let mut found: Vec<f64> =
                self.held(model, q).iter().zip(held).map(|(now, held)| now - held).collect();
            found.extend(call(model, self.constraints, &state));
            let size = found.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            (if found.iter().any(|x| x.is_nan()) { f64::INFINITY } else { size }, found)
        };
        let mut q = near.to_vec();
        let (mut size, mut values) = residual(&q);
        for _ in 0..ITERATIONS {
            let step = self.solve(model, (&q, arguments), &values)?;
            let mut scale = 1.0;
            let (next, found) = loop {
                let next: Vec<f64> = q.iter().zip(&step).map(|(q, d)| q - scale * d).collect();
                let found = residual(&next);
                if found.0 < size || scale < 1e-3 {
                    break (next, found);
                }
                scale *= 0.5;
            };
            if found.0 >= size {
                break;
            }
            (q, (size, values)) = (next, found);
        }
        if size > SOLVED {
            let message = format!("phase `{}` has no posture at φ = {:.6}", self.name, arguments[0]);
            let why = Diagnostic::error(message).help("outputs and contacts contradict each other there");
            return Err(Refused { reason: Reason::NoPosture, why });
        }
        let state = State::new().with(Argument::Q, &q).with(Argument::Parameters, arguments);
        let mut right = vec![0.0; self.held.len()];
        right.extend(call(model, self.slope, &state).iter().map(|slope| -slope));
        let slope = self.solve(model, (&q, arguments), &right)?;
        Ok(SurfacePoint { q, slope })
    }

    /// φ̈ of an acceleration.
    pub fn phase_acceleration(&self, model: &ProgramModel, (q, v): (&[f64], &[f64]), a: &[f64]) -> f64 {
        let arguments = vec![0.0; Model::<f64>::argument_length(model, Argument::Parameters)];
        let state = State::new().with(Argument::Q, q).with(Argument::V, v);
        let state = state.with(Argument::Parameters, &arguments);
        let columns = call(model, self.jacobian, &state);
        let rows = columns.len() / q.len();
        let curvature = call(model, self.curvature, &state).last().copied().unwrap_or(f64::NAN);
        columns.chunks_exact(rows).zip(a).map(|(column, a)| column[rows - 1] * a).sum::<f64>() + curvature
    }

    /// J x = b for the Jacobian of all constraints.
    fn solve(
        &self,
        model: &ProgramModel,
        (q, arguments): (&[f64], &[f64]),
        right: &[f64],
    ) -> Result<Vec<f64>, Refused> {
        let matrix = self.matrix(model, (q, arguments));
        let solved = matrix.clone().full_piv_lu().solve(&DVector::from_column_slice(right));
        let found = solved.filter(|x| x.iter().all(|x| x.is_finite()));
        let singular = || {
            let output = dependent_row(&self.in_turn(&matrix)).and_then(|row| self.output(row));
            let unknown = || {
                let message =
                    format!("contacts, outputs and φ of phase `{}` do not fix the joints", self.name);
                Diagnostic::error(message)
            };
            let why = output.map_or_else(unknown, |output| self.nothing_new(output));
            Refused { reason: Reason::NoPosture, why }
        };
        found.map(|x| x.as_slice().to_vec()).ok_or_else(singular)
    }

    /// The Jacobian of all constraints: what is held, then outputs and φ.
    fn matrix(&self, model: &ProgramModel, (q, arguments): (&[f64], &[f64])) -> DMatrix<f64> {
        let n = q.len();
        let state = State::new().with(Argument::Q, q).with(Argument::Parameters, arguments);
        let (along, normals) = (call(model, self.along, &state), call(model, self.normals, &state));
        let columns = call(model, self.jacobian, &state);
        let own = columns.len() / n;
        let entry = |row: usize, column: usize| match self.held.get(row) {
            Some(&(point, Axis::X)) => along[point * n + column],
            Some(&(point, Axis::Z)) => normals[point * n + column],
            None => columns[column * own + row - self.held.len()],
        };
        DMatrix::from_fn(n, n, entry)
    }
}

fn call(model: &ProgramModel, function: usize, state: &State<'_, f64>) -> Vec<f64> {
    let size = Model::<f64>::signature(model, function).map_or(0, |s| s.rows * s.columns);
    let mut out = vec![0.0; size];
    // Lengths come from the model itself; a refusal would be a fault of ours, seen in the numbers.
    if model.evaluate(function, state, &mut out).is_err() {
        out.fill(f64::NAN);
    }
    out
}
