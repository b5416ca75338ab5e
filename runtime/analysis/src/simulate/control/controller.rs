//! Torques that make outputs vanish.
use super::feedback::Feedback;
use super::program::{Program, Work};
use super::signals::{Reader, Signal};
use crate::robot::BaseKind;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::model::{Argument, Model, State};
use std::cell::{Cell, RefCell};

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

/// The input–output linearising controller of [`Outputs`] on a model:
/// `u = (L_g L_f h)⁻¹ (v − L_f² h)` with the constrained dynamics of the phase; with fewer outputs than actuators the least
/// torques that do it.
pub struct Controller<'a> {
    model: &'a dyn Model<f64>,
    outputs: &'a Outputs,
    /// `constrained_dynamics_of_…`, by phase.
    dynamics: Vec<usize>,
    room: RefCell<Room>,
    /// The phase in which outputs could not be driven.
    failed: Cell<Option<usize>>,
}

struct Room {
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
}

impl<'a> Controller<'a> {
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
        let room = Room {
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
        };
        Ok(Self { model, outputs, dynamics, room: RefCell::new(room), failed: Cell::new(None) })
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.model.joints()
    }

    /// Whether a phase is driven by outputs.
    pub fn drives(&self, phase: usize) -> bool {
        self.outputs.phases.get(phase).is_some_and(Option::is_some)
    }

    /// The phase, if any, in which the outputs could not be driven since this was last asked.
    pub fn failed(&self) -> Option<usize> {
        self.failed.take()
    }

    /// The outputs and their rates.
    pub fn outputs(&self, phase: usize, q: &[f64], v: &[f64]) -> Vec<[f64; 2]> {
        let Some(Some(wanted)) = self.outputs.phases.get(phase) else { return Vec::new() };
        let room = &mut *self.room.borrow_mut();
        room.row.fill(0.0);
        let jets = room.reader.read(self.model, q, v, &room.row);
        wanted.program.run(jets, &mut room.work);
        let of = |i| {
            let jet = wanted.program.output_at(i, &room.work);
            [jet.value, jet.rate]
        };
        (0..wanted.program.outputs()).map(of).collect()
    }

    /// Generalised forces in the order of `v`. NaN where the outputs cannot be driven; see [`Self::failed`].
    pub fn torque(&self, phase: usize, q: &[f64], v: &[f64], tau: &mut [f64]) {
        tau.fill(0.0);
        let Some(Some(wanted)) = self.outputs.phases.get(phase) else { return };
        let room = &mut *self.room.borrow_mut();
        let drives = self.outputs.actuated.len();
        self.respond(phase, q, v, room);
        self.demand(wanted, self.size(self.dynamics[phase]), (q, v), room);
        let count = wanted.program.outputs();
        let solved = if count == drives {
            solve(&mut room.matrix, &mut room.right)
        } else {
            least(room, count, drives)
        };
        if !solved {
            self.failed.set(Some(phase));
        }
        let first = tau.len() - self.model.joints();
        for (&joint, &u) in self.outputs.actuated.iter().zip(&room.right) {
            let limit = self.outputs.limits[joint];
            tau[first + joint] = if solved { u.clamp(-limit, limit) } else { f64::NAN };
        }
    }

    /// The same, and the accelerations and forces under them, as the constrained dynamics of the phase gives them: without
    /// calling it once more, because they are affine in the torques.
    pub fn dynamics(&self, phase: usize, q: &[f64], v: &[f64], tau: &mut [f64], out: &mut Vec<f64>) {
        self.torque(phase, q, v, tau);
        let room = &*self.room.borrow();
        let size = self.size(self.dynamics[phase]);
        out.clear();
        out.extend_from_slice(&room.free[..size]);
        let first = tau.len() - self.model.joints();
        for (&joint, response) in self.outputs.actuated.iter().zip(room.response.chunks_exact(size)) {
            let u = tau[first + joint];
            out.iter_mut().zip(response).for_each(|(out, response)| *out += u * response);
        }
    }

    fn size(&self, function: usize) -> usize {
        self.model.signature(function).map_or(0, |s| s.rows * s.columns)
    }

    fn call(&self, function: usize, q: &[f64], v: &[f64], tau: &[f64], out: &mut [f64]) {
        let size = self.size(function);
        let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::Tau, tau);
        // Lengths come from the model itself; a refusal would be a fault of this crate, seen in the numbers.
        if self.model.evaluate(function, &state, &mut out[..size]).is_err() {
            out.fill(f64::NAN);
        }
    }

    /// Accelerations without torques and what each torque adds: they are affine in the torques.
    fn respond(&self, phase: usize, q: &[f64], v: &[f64], room: &mut Room) {
        let first = self.model.nv() - self.model.joints();
        let function = self.dynamics[phase];
        let size = self.size(function);
        room.tau.fill(0.0);
        self.call(function, q, v, &room.tau, &mut room.free);
        for (k, &joint) in self.outputs.actuated.iter().enumerate() {
            room.tau[first + joint] = 1.0;
            self.call(function, q, v, &room.tau, &mut room.driven);
            room.tau[first + joint] = 0.0;
            let response = &mut room.response[k * size..(k + 1) * size];
            for ((to, with), without) in response.iter_mut().zip(&room.driven).zip(&room.free) {
                *to = with - without;
            }
        }
    }

    /// `L_g L_f h` (row after row) and `v − L_f² h`.
    fn demand(&self, wanted: &PhaseOutputs, size: usize, (q, v): (&[f64], &[f64]), room: &mut Room) {
        let nv = self.model.nv();
        let jets = room.reader.read(self.model, q, v, &room.free[..nv]);
        wanted.program.run(jets, &mut room.work);
        room.matrix.clear();
        room.right.clear();
        for output in 0..wanted.program.outputs() {
            let jet = wanted.program.output_at(output, &room.work);
            room.right.push(wanted.feedback.at(jet.value, jet.rate) - jet.acceleration);
            wanted.program.gradient(output, &mut room.work, &mut room.gradient);
            room.row.fill(0.0);
            for (index, &factor) in room.gradient.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
                room.reader.add_row(index, factor, &mut room.row);
            }
            let row = &room.row;
            let along = |response: &[f64]| row.iter().zip(response).map(|(a, b)| a * b).sum::<f64>();
            let drives = self.outputs.actuated.len();
            room.matrix.extend(room.response.chunks_exact(size).take(drives).map(along));
        }
    }
}

/// `u = Aᵀ (A Aᵀ)⁻¹ b` into `right`.
fn least(room: &mut Room, outputs: usize, drives: usize) -> bool {
    room.small.clear();
    for a in room.matrix.chunks_exact(drives) {
        let dot = |b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        room.small.extend(room.matrix.chunks_exact(drives).map(dot));
    }
    if !solve(&mut room.small, &mut room.right) {
        return false;
    }
    room.small.clear();
    for k in 0..drives {
        room.small.push((0..outputs).map(|i| room.matrix[i * drives + k] * room.right[i]).sum());
    }
    std::mem::swap(&mut room.small, &mut room.right);
    true
}

/// `A x = b` into `b` by Gaussian elimination, A row after row; `false`: A is singular.
fn solve(a: &mut [f64], b: &mut [f64]) -> bool {
    let n = b.len();
    let largest = a.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    for k in 0..n {
        let Some(pivot) = (k..n).max_by(|&i, &j| a[i * n + k].abs().total_cmp(&a[j * n + k].abs())) else {
            return false;
        };
        let size = a[pivot * n + k].abs();
        if size.is_nan() || size <= SINGULAR * largest {
            return false;
        }
        if pivot != k {
            (0..n).for_each(|j| a.swap(k * n + j, pivot * n + j));
            b.swap(k, pivot);
        }
        for i in k + 1..n {
            let factor = a[i * n + k] / a[k * n + k];
            for j in k + 1..n {
                a[i * n + j] -= factor * a[k * n + j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let rest: f64 = (k + 1..n).map(|j| a[k * n + j] * b[j]).sum();
        b[k] = (b[k] - rest) / a[k * n + k];
    }
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
        assert!(solve(&mut a.clone(), &mut b));
        assert!(b.iter().zip(x).all(|(b, x)| (b - x).abs() < 1e-14), "{b:?}");
        assert!(!solve(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 1.0]));
        assert!(!solve(&mut [f64::NAN], &mut [1.0]));
    }
}
