//! The model as the comparison sees it.
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::model::{Argument, CallError, Model, State};
use std::fmt;

/// States of the robot, one after the other.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Batch<'a> {
    /// How many states.
    pub count: usize,
    /// Configurations, `count × nq`, state after state; m, rad, quaternion x y z w.
    pub q: &'a [f64],
    /// Velocities, `count × nv`; floating base: linear, angular, in its own axes.
    pub v: &'a [f64],
    /// Time derivatives of the components of `v`, `count × nv`.
    pub a: &'a [f64],
}

impl<'a> Batch<'a> {
    /// The states in these slices, `count × nq` and `count × nv` long.
    pub fn new(count: usize, [q, v, a]: [&'a [f64]; 3]) -> Self {
        Self { count, q, v, a }
    }
}

/// Why a model gave no torques.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EvaluationError(
    /// What went wrong.
    pub String,
);

impl fmt::Display for EvaluationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for EvaluationError {}

/// Anything that predicts the generalised forces of many states.
///
/// A batch evaluator implements it itself; for one that takes a state at a time there is [`ModelTorques`].
pub trait InverseDynamics {
    /// Length of one configuration.
    fn nq(&self) -> usize;
    /// Length of one velocity.
    fn nv(&self) -> usize;
    /// Writes the generalised forces into `tau`, `count × nv`, in the order of `v`; N, N m.
    ///
    /// # Errors
    /// The model could not be evaluated; `tau` has no meaning then.
    fn torques(&mut self, batch: &Batch<'_>, tau: &mut [f64]) -> Result<(), EvaluationError>;
}

/// A [`Model`]'s function `inverse_dynamics`, one state at a time, without external forces.
pub struct ModelTorques<'a> {
    model: &'a dyn Model<f64>,
    function: usize,
    forces: Vec<f64>,
    parameters: Vec<f64>,
}

impl<'a> ModelTorques<'a> {
    /// Looks the function up.
    ///
    /// # Errors
    /// The model has no `inverse_dynamics`.
    pub fn new(model: &'a dyn Model<f64>) -> Result<Self, Diagnostic> {
        let function = model.function("inverse_dynamics").ok_or_else(|| {
            Diagnostic::error("the model has no function `inverse_dynamics`")
                .help("add it to what is generated from the description")
        })?;
        let forces = vec![0.0; model.argument_length(Argument::Forces)];
        Ok(Self { model, function, forces, parameters: Vec::new() })
    }

    /// Inertial or base parameters, for models that take them at run time.
    pub fn with_parameters(mut self, parameters: &[f64]) -> Self {
        self.parameters = parameters.to_vec();
        self
    }
}

impl InverseDynamics for ModelTorques<'_> {
    fn nq(&self) -> usize {
        self.model.nq()
    }
    fn nv(&self) -> usize {
        self.model.nv()
    }
    fn torques(&mut self, batch: &Batch<'_>, tau: &mut [f64]) -> Result<(), EvaluationError> {
        let (nq, nv) = (self.nq(), self.nv());
        for (i, tau) in tau.chunks_exact_mut(nv.max(1)).enumerate().take(batch.count) {
            let state = State::new()
                .with(Argument::Q, &batch.q[i * nq..(i + 1) * nq])
                .with(Argument::V, &batch.v[i * nv..(i + 1) * nv])
                .with(Argument::A, &batch.a[i * nv..(i + 1) * nv])
                .with(Argument::Forces, &self.forces)
                .with(Argument::Parameters, &self.parameters);
            self.model.evaluate(self.function, &state, tau).map_err(refused)?;
        }
        Ok(())
    }
}

fn refused(error: CallError) -> EvaluationError {
    EvaluationError(match error {
        CallError::UnknownFunction => "the model has no such function".to_owned(),
        CallError::WrongLength { argument, expected } => {
            format!("the model needs {expected} values for `{}`", argument.name())
        }
        CallError::WrongOutput { expected } => format!("the model gives {expected} values"),
    })
}
