//! Torques that make outputs vanish.
use super::Feedback;
use super::program::{Program, Work};
use super::signals::{Reader, Signal};
use crate::robot::BaseKind;
use crate::simulate::dense::{eliminate, row_length, substitute};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};
use bipedc_runtime::model::{Argument, Model, State};

/// Pivots below this part of the largest element mean that the outputs cannot be driven.
const SINGULAR: f64 = 1e-10;

/// What drives one phase.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseOutputs {
    /// The outputs h(q).
    pub program: Program,
    /// What makes them vanish.
    pub feedback: Feedback,
}

/// Virtual constraints as they stand in a scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    /// What formulas speak of.
    pub signals: Vec<Signal>,
    /// By phase; a phase without outputs is left to the servos.
    pub phases: Vec<Option<PhaseOutputs>>,
    /// Joints with actuators, by index.
    pub actuated: Vec<usize>,
    /// Torques are clipped at these, N m, by joint; infinite: not at all.
    pub limits: Vec<f64>,
}

impl Outputs {
    /// Whether a phase has outputs.
    pub fn drive(&self, phase: usize) -> bool {
        self.phases.get(phase).is_some_and(Option::is_some)
    }
}

/// The input–output linearising controller of [`Outputs`] on a model:
/// `u = (L_g L_f h)⁻¹ (v − L_f² h)` with the constrained dynamics of the phase; with fewer outputs than actuators the least
/// torques that do it.
///
/// In phases without outputs it leaves all commands as they are; in the others joints without actuators get none.
pub struct VirtualConstraints<'a> {
    model: &'a dyn Model<f64>,
    outputs: &'a Outputs,
    /// `constrained_dynamics_of_…`, by phase.
    dynamics: Vec<usize>,
    workspace: Workspace,
}

struct Workspace {
    reader: Reader,
    work: Work,
    tau: Vec<f64>,
    /// Accelerations and forces without torques, then with one of each actuator.
    free: Vec<f64>,
    driven: Vec<f64>,
    /// What a torque adds to accelerations and forces: one row for each actuator.
    response: Vec<f64>,
    gradient: Vec<f64>,
    row: Vec<f64>,
    matrix: Vec<f64>,
    right: Vec<f64>,
    small: Vec<f64>,
    factors: Factors,
}

/// Of an elimination.
#[derive(Default)]
struct Factors {
    matrix: Vec<f64>,
    /// Row exchanges.
    order: Vec<usize>,
}

impl<'a> VirtualConstraints<'a> {
    /// Looks up the constrained dynamics of the phases, by their names in the order of the outputs' phases.
    ///
    /// # Errors
    /// The model lacks a function.
    pub fn new(
        model: &'a dyn Model<f64>,
        base: BaseKind,
        outputs: &'a Outputs,
        dynamics: &[&str],
    ) -> Result<Self, Diagnostic> {
        let find = |name: &&str| {
            model.function(name).ok_or_else(|| {
                Diagnostic::error(format!("the model has no function `{name}`"))
                    .help("add it to what is generated from the description")
            })
        };
        let dynamics = dynamics.iter().map(find).collect::<Result<Vec<usize>, _>>()?;
        let size = dynamics
            .iter()
            .filter_map(|&function| model.signature(function))
            .map(|s| s.rows * s.columns)
            .max()
            .unwrap_or(0);
        let (nv, drives) = (model.nv(), outputs.actuated.len());
        let workspace = Workspace {
            reader: Reader::new(model, base, outputs.signals.clone())?,
            work: Work::default(),
            tau: vec![0.0; nv],
            free: vec![0.0; size],
            driven: vec![0.0; size],
            response: vec![0.0; drives * size],
            gradient: vec![0.0; outputs.signals.len()],
            row: vec![0.0; nv],
            matrix: Vec::with_capacity(drives * drives),
            right: Vec::with_capacity(drives),
            small: Vec::with_capacity(drives * drives),
            factors: Factors {
                matrix: Vec::with_capacity(drives * row_length(drives)),
                order: Vec::with_capacity(drives),
            },
        };
        Ok(Self { model, outputs, dynamics, workspace })
    }

    /// The outputs and their rates.
    pub fn outputs(&mut self, phase: usize, q: &[f64], v: &[f64]) -> Vec<[f64; 2]> {
        let Some(Some(wanted)) = self.outputs.phases.get(phase) else { return Vec::new() };
        let work = &mut self.workspace;
        work.row.fill(0.0);
        let jets = work.reader.read(self.model, q, v, &work.row);
        wanted.program.run(jets, &mut work.work);
        let of = |i| {
            let jet = wanted.program.output_at(i, &work.work);
            [jet.value, jet.rate]
        };
        (0..wanted.program.outputs()).map(of).collect()
    }

    /// Torques of the actuators, in their order, into `workspace.right`.
    fn solve(
        &mut self,
        phase: usize,
        wanted: &PhaseOutputs,
        (q, v): (&[f64], &[f64]),
    ) -> Result<(), Refusal> {
        let Self { model, outputs, workspace, .. } = self;
        let function = self.dynamics[phase];
        workspace.respond((*model, function), &outputs.actuated, q, v);
        let size = model.signature(function).map_or(0, |s| s.rows * s.columns);
        workspace.demand(*model, wanted, (size, outputs.actuated.len()), (q, v));
        let (count, drives) = (wanted.program.outputs(), outputs.actuated.len());
        let solved = if count == drives {
            solve(&workspace.matrix, &mut workspace.right, &mut workspace.factors)
        } else {
            least(workspace, count, drives)
        };
        if solved { Ok(()) } else { Err(Refusal::SingularOutputs) }
    }
}

impl Controller<f64> for VirtualConstraints<'_> {
    fn command(
        &mut self,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        let outputs = self.outputs;
        let Some(Some(wanted)) = outputs.phases.get(observed.phase) else { return Ok(()) };
        self.solve(observed.phase, wanted, (observed.q, observed.v))?;
        commands.fill(JointCommand::Torque(0.0));
        for (&joint, &torque) in outputs.actuated.iter().zip(&self.workspace.right) {
            let limit = outputs.limits[joint];
            commands[joint] = JointCommand::Torque(torque.clamp(-limit, limit));
        }
        Ok(())
    }
}

impl Workspace {
    /// Accelerations without torques and what each torque adds: they are affine in the torques.
    fn respond(
        &mut self,
        (model, function): (&dyn Model<f64>, usize),
        actuated: &[usize],
        q: &[f64],
        v: &[f64],
    ) {
        let first = model.nv() - model.joints();
        let size = model.signature(function).map_or(0, |s| s.rows * s.columns);
        let call = |tau: &[f64], out: &mut [f64]| {
            let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::Tau, tau);
            // Lengths come from the model itself; a refusal would be a fault of this crate, seen in the numbers.
            if model.evaluate(function, &state, &mut out[..size]).is_err() {
                out.fill(f64::NAN);
            }
        };
        self.tau.fill(0.0);
        call(&self.tau, &mut self.free);
        for (k, &joint) in actuated.iter().enumerate() {
            self.tau[first + joint] = 1.0;
            call(&self.tau, &mut self.driven);
            self.tau[first + joint] = 0.0;
            let response = &mut self.response[k * size..(k + 1) * size];
            for ((to, with), without) in response.iter_mut().zip(&self.driven).zip(&self.free) {
                *to = with - without;
            }
        }
    }

    /// `L_g L_f h` (row after row) and `v − L_f² h`; `size` of the dynamics, and number of actuators.
    fn demand(
        &mut self,
        model: &dyn Model<f64>,
        wanted: &PhaseOutputs,
        (size, drives): (usize, usize),
        (q, v): (&[f64], &[f64]),
    ) {
        let nv = model.nv();
        let jets = self.reader.read(model, q, v, &self.free[..nv]);
        wanted.program.run(jets, &mut self.work);
        self.matrix.clear();
        self.right.clear();
        for output in 0..wanted.program.outputs() {
            let jet = wanted.program.output_at(output, &self.work);
            self.right.push(wanted.feedback.at(jet.value, jet.rate) - jet.acceleration);
            wanted.program.gradient(output, &mut self.work, &mut self.gradient);
            self.row.fill(0.0);
            for (index, &factor) in self.gradient.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
                self.reader.add_row(index, factor, &mut self.row);
            }
            let row = &self.row;
            let along = |response: &[f64]| row.iter().zip(response).map(|(a, b)| a * b).sum::<f64>();
            self.matrix.extend(self.response.chunks_exact(size).take(drives).map(along));
        }
    }
}

/// `u = Aᵀ (A Aᵀ)⁻¹ b` into `right`.
fn least(workspace: &mut Workspace, outputs: usize, drives: usize) -> bool {
    workspace.small.clear();
    for a in workspace.matrix.chunks_exact(drives) {
        let dot = |b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        workspace.small.extend(workspace.matrix.chunks_exact(drives).map(dot));
    }
    if !solve(&workspace.small, &mut workspace.right, &mut workspace.factors) {
        return false;
    }
    workspace.small.clear();
    for k in 0..drives {
        workspace
            .small
            .push((0..outputs).map(|i| workspace.matrix[i * drives + k] * workspace.right[i]).sum());
    }
    std::mem::swap(&mut workspace.small, &mut workspace.right);
    true
}

/// `A x = b` into `b`, A row after row; `false`: A is singular.
fn solve(a: &[f64], b: &mut [f64], Factors { matrix, order }: &mut Factors) -> bool {
    let n = b.len();
    let length = row_length(n);
    matrix.clear();
    matrix.resize(n * length, 0.0);
    for (to, from) in matrix.chunks_exact_mut(length).zip(a.chunks_exact(n)) {
        to[..n].copy_from_slice(from);
    }
    let largest = a.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if !eliminate(matrix, n, order) || (0..n).any(|k| matrix[k * length + k].abs() <= SINGULAR * largest) {
        return false;
    }
    // What is no number in `b` stays none: that is not the matrix's fault.
    substitute(matrix, n, order, b);
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elimination_solves_and_says_when_it_cannot() {
        let a = [0.0, 2.0, 1.0, 1.0, -1.0, 0.5, 3.0, 0.0, 2.0];
        let x = [1.0, -2.0, 0.5];
        let mut b: Vec<f64> =
            a.chunks_exact(3).map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect();
        let mut factors = Factors::default();
        assert!(solve(&a, &mut b, &mut factors));
        assert!(b.iter().zip(x).all(|(b, x)| (b - x).abs() < 1e-14), "{b:?}");
        assert!(!solve(&[1.0, 2.0, 2.0, 4.0], &mut [1.0, 1.0], &mut factors));
        assert!(!solve(&[f64::NAN], &mut [1.0], &mut factors));
    }
}
