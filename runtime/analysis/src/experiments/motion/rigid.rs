//! The rigid-body model at the samples of a recording.
use crate::robot::inertial_parameters::InertialParameters;
use crate::robot::{Batch, Trajectory};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::model::{Argument, Model, State};

/// The functions of a model that the diagnosis needs.
#[derive(Clone, Copy)]
pub(super) struct Rigid<'a> {
    model: &'a (dyn Model<f64> + Sync),
    inverse_dynamics: usize,
    regressor: usize,
    /// Length of a configuration.
    pub nq: usize,
    /// Length of a velocity.
    pub nv: usize,
    /// Number of inertial parameters.
    pub parameters: usize,
}

impl<'a> Rigid<'a> {
    /// Looks the functions up.
    pub fn new(model: &'a (dyn Model<f64> + Sync)) -> Result<Self, Diagnostic> {
        let function = |name: &str| {
            model.function(name).ok_or_else(|| {
                Diagnostic::error(format!("the model has no function `{name}`"))
                    .help("add it to what is generated from the description")
            })
        };
        let regressor = function("inverse_dynamics_regressor")?;
        let parameters = model.signature(regressor).map_or(0, |s| s.columns);
        Ok(Self {
            model,
            inverse_dynamics: function("inverse_dynamics")?,
            regressor,
            nq: model.nq(),
            nv: model.nv(),
            parameters,
        })
    }

    fn evaluate(&self, function: usize, [q, v, a]: [&[f64]; 3], output: &mut [f64]) {
        let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::A, a);
        // Lengths come from the model itself; a refusal would be a fault of this crate, seen in the numbers.
        if self.model.evaluate(function, &state, output).is_err() {
            output.fill(f64::NAN);
        }
    }

    /// Generalised forces of all samples, `samples × nv`.
    pub fn inverse_dynamics(&self, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
        let mut tau = vec![0.0; v.len()];
        for (i, tau) in tau.chunks_exact_mut(self.nv).enumerate() {
            self.evaluate(self.inverse_dynamics, self.sample(i, q, v, a), tau);
        }
        tau
    }

    /// A column of the mass matrix (kg m², kg) at about `count` of the states, `states × nv`.
    pub fn inertia_column(&self, states: &Trajectory, coordinate: usize, count: usize) -> Vec<f64> {
        let samples = states.v.len() / self.nv.max(1);
        let still = vec![0.0; self.nv];
        let mut pushed = still.clone();
        pushed[coordinate] = 1.0;
        let at = |i: usize| {
            let q = &states.q[i * self.nq..(i + 1) * self.nq];
            let [heavy, held] = [&pushed, &still].map(|a| self.inverse_dynamics(q, &still, a));
            heavy.into_iter().zip(held).map(|(heavy, held)| heavy - held).collect::<Vec<f64>>()
        };
        (0..samples).step_by((samples / count).max(1)).flat_map(at).collect()
    }

    /// What forces are more at rest if a coordinate of the configuration is more by `step` (N m, N), at about `count` of the states, `states × nv`.
    pub fn displaced(&self, states: &Trajectory, coordinate: usize, (step, count): (f64, usize)) -> Vec<f64> {
        let samples = states.v.len() / self.nv.max(1);
        let still = vec![0.0; self.nv];
        let at = |i: usize| {
            let here = &states.q[i * self.nq..(i + 1) * self.nq];
            let mut there = here.to_vec();
            there[coordinate] += step;
            let [more, held] = [&there[..], here].map(|q| self.inverse_dynamics(q, &still, &still));
            more.into_iter().zip(held).map(|(more, held)| more - held).collect::<Vec<f64>>()
        };
        (0..samples).step_by((samples / count).max(1)).flat_map(at).collect()
    }

    /// What the states let a coordinate of the velocity resist: its entry on the diagonal of the mass matrix (kg m², kg), and
    /// the slope of its force over the coordinate of the configuration at `position` (N m/rad, N/m). One pair per sample.
    pub fn resistance(&self, states: &Trajectory, (position, velocity): (usize, usize)) -> Vec<[f64; 2]> {
        const STEP: f64 = 1e-5;
        let of = |tau: Vec<f64>| -> Vec<f64> { tau.into_iter().skip(velocity).step_by(self.nv).collect() };
        let still = vec![0.0; states.v.len()];
        let mut pushed = still.clone();
        pushed.iter_mut().skip(velocity).step_by(self.nv).for_each(|a| *a = 1.0);
        let [mut ahead, mut behind] = [states.q.clone(), states.q.clone()];
        ahead.iter_mut().skip(position).step_by(self.nq).for_each(|q| *q += STEP);
        behind.iter_mut().skip(position).step_by(self.nq).for_each(|q| *q -= STEP);
        let [heavy, held] = [&pushed, &still].map(|a| of(self.inverse_dynamics(&states.q, &still, a)));
        let [more, less] = [&ahead, &behind].map(|q| of(self.inverse_dynamics(q, &states.v, &states.a)));
        let inertia = heavy.iter().zip(&held).map(|(a, b)| a - b);
        let slope = more.iter().zip(&less).map(|(a, b)| (a - b) / (2.0 * STEP));
        inertia.zip(slope).map(|(inertia, slope)| [inertia, slope]).collect()
    }

    /// Calls `visit` with the sample's number and its regressor, `nv × parameters`, column after column.
    pub fn regressors(&self, states: &Batch<'_>, mut visit: impl FnMut(usize, &[f64])) {
        let mut regressor = vec![0.0; self.nv * self.parameters];
        for i in 0..states.count {
            self.evaluate(self.regressor, self.sample(i, states.q, states.v, states.a), &mut regressor);
            visit(i, &regressor);
        }
    }

    /// Generalised forces of a unit of mass and of first moment of each body, `states × bodies × 4 × nv`.
    pub fn moments(&self, states: &Trajectory) -> Vec<f64> {
        let of_body = InertialParameters::PER_BODY * self.nv;
        let mut all = Vec::new();
        self.regressors(&states.batch(), |_, regressor| {
            regressor.chunks_exact(of_body).for_each(|body| all.extend_from_slice(&body[..4 * self.nv]));
        });
        all
    }

    fn sample<'s>(&self, i: usize, q: &'s [f64], v: &'s [f64], a: &'s [f64]) -> [&'s [f64]; 3] {
        let (nq, nv) = (self.nq, self.nv);
        [&q[i * nq..(i + 1) * nq], &v[i * nv..(i + 1) * nv], &a[i * nv..(i + 1) * nv]]
    }
}
