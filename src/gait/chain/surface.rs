//! The constraint surface of a phase with feet that stand: q = T(φ) where the ground holds what it held when the phase began (6.30).
use super::Refused;
use super::equations::Factors;
use crate::gait::PhasedBench;
use crate::gait::checked::{configurations, dependent_in_all, says_nothing_new};
use bipedc_analysis::gait::Reason;
use bipedc_compiler::compile::ProgramModel;
use bipedc_compiler::derive::dependence::dependent_row;
use bipedc_compiler::description::gait::{FilePlace, GaitOutput};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::{Argument, Model, State};
use nalgebra::DMatrix;
use std::cell::RefCell;

/// Iterations after which there is no solution nearby.
const ITERATIONS: usize = 40;
/// Residuals (m, rad) of a solution.
const SOLVED: f64 = 1e-12;
/// Those from which one more step, on the equations at hand, leaves nothing but rounding.
const SETTLED: f64 = 1e-13;

/// By which part of the configurations of no special kind joints are off a posture where φ's sign is looked at.
const BENT: f64 = 0.3;
/// φ that falls by less, m or rad per rad, does not tell forward from back.
const FALLS: f64 = 1e-6;

/// A point of the surface.
#[derive(Debug, Clone)]
pub struct SurfacePoint {
    /// T
    pub q: Vec<f64>,
    /// T′, per unit of φ.
    pub slope: Vec<f64>,
    /// ∂φ/∂q
    pub along_phase: Vec<f64>,
}

/// Memory of a search.
#[derive(Debug, Default)]
struct Work {
    /// Places along x and heights of all contact points, m.
    places: [Vec<f64>; 2],
    /// Their slopes, and those of outputs and φ.
    slopes: [Vec<f64>; 3],
    constraints: Vec<f64>,
    /// Arguments of the gait where they do not count.
    zeros: Vec<f64>,
    /// Of all constraints, row after row.
    matrix: Vec<f64>,
    factors: Factors,
    /// What constraints leave at q, and at the next one.
    values: [Vec<f64>; 2],
    step: Vec<f64>,
    next: Vec<f64>,
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
    /// Unit of φ, and where the file says φ.
    unit: String,
    variable_at: FilePlace,
    work: RefCell<Work>,
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
            unit: bench.gait.phases[index].unit.clone(),
            variable_at: bench.gait.phases[index].variable_at,
            work: RefCell::default(),
        })
    }

    /// That φ grows as the robot goes forward, and that contacts, outputs and φ fix the joints, if not in every posture.
    ///
    /// # Errors
    /// φ falls near `posture`; the output that says what contacts, φ and the outputs before it say.
    pub fn checked(&self, model: &ProgramModel, posture: &[f64]) -> Result<(), Diagnostic> {
        if let Some(slope) = self.falling(model, posture) {
            let FilePlace { line, column } = self.variable_at;
            let message = format!(
                "the phase variable of phase `{}` decreases as the robot goes forward: by {:.6} {} per rad that the whole robot turns about the foot that stands",
                self.name, -slope, self.unit
            );
            let help = "write it with the other sign, `end`, `over`, `at` and `phase` in formulas too: φ grows along the phase";
            return Err(Diagnostic::error(message).at(line, column).help(help));
        }
        let arguments = vec![0.0; Model::<f64>::argument_length(model, Argument::Parameters)];
        let matrix = |q: Vec<f64>| self.in_turn(&self.matrix(model, (&q, &arguments)));
        let found = dependent_in_all(configurations(Model::<f64>::nq(model)).map(matrix));
        match found {
            Some(row) if row == self.held.len() => Err(self.stays()),
            Some(row) => self.output(row).map_or(Ok(()), |output| Err(self.nothing_new(output))),
            None => Ok(()),
        }
    }

    /// That φ is what the contacts fix already, or a constant.
    fn stays(&self) -> Diagnostic {
        let FilePlace { line, column } = self.variable_at;
        let message = format!("the phase variable of phase `{}` does not grow: nothing moves it", self.name);
        let help = "choose one that grows along the phase, such as the angle of the leg that stands or the place of the hip";
        Diagnostic::error(message).at(line, column).help(help)
    }

    /// By how much φ changes where the whole robot turns forward about what stands, per rad, if it falls in all postures near one.
    fn falling(&self, model: &ProgramModel, posture: &[f64]) -> Option<f64> {
        let &(about, _) = self.held.first()?;
        let arguments = vec![0.0; Model::<f64>::argument_length(model, Argument::Parameters)];
        let slope = |near: Vec<f64>| {
            let joint = |(k, (q, off)): (usize, (&f64, f64))| if k < 3 { 0.0 } else { q + BENT * off };
            let q: Vec<f64> = posture.iter().zip(near).enumerate().map(joint).collect();
            let state = State::new().with(Argument::Q, &q).with(Argument::Parameters, &arguments);
            let (x, z) =
                (call(model, self.positions, &state)[about], call(model, self.heights, &state)[about]);
            let columns = call(model, self.jacobian, &state);
            let own = columns.len() / q.len();
            let phase = |column: usize| columns[(column + 1) * own - 1];
            // The base is at the origin.
            -z * phase(0) + x * phase(1) + phase(2)
        };
        let all: Vec<f64> = configurations(posture.len()).map(slope).collect();
        all.iter().all(|slope| *slope < -FALLS).then(|| all[0])
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
        let work = &mut *self.work.borrow_mut();
        let mut q = near.to_vec();
        let size = self.solved(model, (arguments, held), &mut q, work)?;
        if size > SOLVED {
            let message = format!("phase `{}` has no posture at φ = {:.6}", self.name, arguments[0]);
            let why = Diagnostic::error(message).help("outputs and contacts contradict each other there");
            return Err(Refused { reason: Reason::NoPosture, why });
        }
        let state = State::new().with(Argument::Q, &q).with(Argument::Parameters, arguments);
        call_into(model, self.slope, &state, &mut work.constraints);
        let mut slope = vec![0.0; self.held.len()];
        slope.extend(work.constraints.iter().map(|slope| -slope));
        work.factors.solve(&mut slope);
        if !slope.iter().all(|x| x.is_finite()) {
            return Err(self.singular(&work.matrix));
        }
        let last = work.matrix.len() - q.len();
        Ok(SurfacePoint { q, slope, along_phase: work.matrix[last..].to_vec() })
    }

    /// Newton's method on all constraints; the largest of what they leave. The factors are those at q, but for a last step of next to nothing.
    fn solved(
        &self,
        model: &ProgramModel,
        (arguments, held): (&[f64], &[f64]),
        q: &mut [f64],
        work: &mut Work,
    ) -> Result<f64, Refused> {
        let mut size = self.residual(model, (q, arguments, held), work, 0);
        for iteration in 0.. {
            self.factored(model, (q, arguments), work)?;
            let Work { values, step, factors, .. } = &mut *work;
            step.clone_from(&values[0]);
            factors.solve(step);
            if !step.iter().all(|x| x.is_finite()) {
                return Err(self.singular(&work.matrix));
            }
            if size <= SETTLED {
                q.iter_mut().zip(&work.step).for_each(|(q, step)| *q -= step);
                break;
            }
            let mut scale = 1.0;
            let found = loop {
                let Work { next, step, .. } = &mut *work;
                next.clear();
                next.extend(q.iter().zip(step.iter()).map(|(q, step)| q - scale * step));
                let next = std::mem::take(&mut work.next);
                let found = self.residual(model, (&next, arguments, held), work, 1);
                work.next = next;
                // Rounding is not made less by shorter steps.
                if found < size || scale < 1e-3 || size <= SOLVED {
                    break found;
                }
                scale *= 0.5;
            };
            if found >= size || iteration == ITERATIONS {
                break;
            }
            q.copy_from_slice(&work.next);
            work.values.swap(0, 1);
            size = found;
        }
        Ok(size)
    }

    /// What the constraints leave at q, into one of the values; the largest, infinity where there is no number.
    fn residual(
        &self,
        model: &ProgramModel,
        (q, arguments, held): (&[f64], &[f64], &[f64]),
        work: &mut Work,
        into: usize,
    ) -> f64 {
        let state = State::new().with(Argument::Q, q).with(Argument::Parameters, arguments);
        let Work { places: [x, z], constraints, values, .. } = work;
        call_into(model, self.positions, &state, x);
        call_into(model, self.heights, &state, z);
        call_into(model, self.constraints, &state, constraints);
        let now = |&(point, axis): &(usize, Axis)| if axis == Axis::X { x[point] } else { z[point] };
        let left = self.held.iter().zip(held).map(|(which, held)| now(which) - held);
        values[into].clear();
        values[into].extend(left.chain(constraints.iter().copied()));
        if values[into].iter().any(|x| x.is_nan()) {
            return f64::INFINITY;
        }
        values[into].iter().fold(0.0, |m: f64, x| m.max(x.abs()))
    }

    /// φ̈ of an acceleration at a point of the surface.
    pub fn phase_acceleration(
        &self,
        model: &ProgramModel,
        (point, v): (&SurfacePoint, &[f64]),
        a: &[f64],
    ) -> f64 {
        let Work { constraints, zeros, .. } = &mut *self.work.borrow_mut();
        zeros.resize(Model::<f64>::argument_length(model, Argument::Parameters), 0.0);
        let state = State::new().with(Argument::Q, &point.q).with(Argument::V, v);
        call_into(model, self.curvature, &state.with(Argument::Parameters, zeros), constraints);
        let curvature = constraints.last().copied().unwrap_or(f64::NAN);
        point.along_phase.iter().zip(a).map(|(slope, a)| slope * a).sum::<f64>() + curvature
    }

    /// Why the equations have no solution.
    fn singular(&self, matrix: &[f64]) -> Refused {
        let size = matrix.len().isqrt();
        let matrix = DMatrix::from_row_slice(size, size, matrix);
        let output = dependent_row(&self.in_turn(&matrix)).and_then(|row| self.output(row));
        let unknown = || {
            let message = format!("contacts, outputs and φ of phase `{}` do not fix the joints", self.name);
            Diagnostic::error(message)
        };
        let why = output.map_or_else(unknown, |output| self.nothing_new(output));
        Refused { reason: Reason::NoPosture, why }
    }

    /// The Jacobian of all constraints and its factors.
    fn factored(
        &self,
        model: &ProgramModel,
        (q, arguments): (&[f64], &[f64]),
        work: &mut Work,
    ) -> Result<(), Refused> {
        self.write_matrix(model, (q, arguments), work);
        let Work { matrix, factors, .. } = work;
        if factors.of(matrix, q.len()) { Ok(()) } else { Err(self.singular(matrix)) }
    }

    /// The Jacobian of all constraints: what is held, then outputs and φ.
    fn write_matrix(&self, model: &ProgramModel, (q, arguments): (&[f64], &[f64]), work: &mut Work) {
        let n = q.len();
        let state = State::new().with(Argument::Q, q).with(Argument::Parameters, arguments);
        let Work { slopes: [along, normals, columns], matrix, .. } = work;
        call_into(model, self.along, &state, along);
        call_into(model, self.normals, &state, normals);
        call_into(model, self.jacobian, &state, columns);
        let own = columns.len() / n;
        matrix.clear();
        for &(point, axis) in &self.held {
            let rows = if axis == Axis::X { &along } else { &normals };
            matrix.extend_from_slice(&rows[point * n..(point + 1) * n]);
        }
        for row in 0..own {
            matrix.extend(columns.iter().skip(row).step_by(own));
        }
    }

    /// The same as a matrix.
    fn matrix(&self, model: &ProgramModel, at: (&[f64], &[f64])) -> DMatrix<f64> {
        let work = &mut *self.work.borrow_mut();
        self.write_matrix(model, at, work);
        DMatrix::from_row_slice(at.0.len(), at.0.len(), &work.matrix)
    }
}

pub(super) fn call(model: &ProgramModel, function: usize, state: &State<'_, f64>) -> Vec<f64> {
    let mut out = Vec::new();
    call_into(model, function, state, &mut out);
    out
}

/// Writes what a function says.
pub(super) fn call_into(model: &ProgramModel, function: usize, state: &State<'_, f64>, out: &mut Vec<f64>) {
    let size = Model::<f64>::signature(model, function).map_or(0, |s| s.rows * s.columns);
    out.resize(size, 0.0);
    // Lengths come from the model itself; a refusal would be a fault of ours, seen in the numbers.
    if model.evaluate(function, state, out).is_err() {
        out.fill(f64::NAN);
    }
}
