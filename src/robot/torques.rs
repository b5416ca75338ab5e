//! A compiled inverse dynamics as comparisons with logs read it.
use bipedc_analysis::robot::{Batch, EvaluationError, InverseDynamics};
use bipedc_compiler::compile::CompiledModel;
use bipedc_compiler::program::BatchStates;
use bipedc_effects::diagnostic::Diagnostic;

/// A compiled model's function `inverse_dynamics`.
pub struct ProgramTorques(BatchStates);

impl ProgramTorques {
    /// Looks the function up.
    ///
    /// # Errors
    /// The model was compiled without it.
    pub fn new(compiled: &CompiledModel) -> Result<Self, Diagnostic> {
        let function = compiled.functions.iter().find(|f| f.name == "inverse_dynamics").ok_or_else(|| {
            Diagnostic::error("the model has no function `inverse_dynamics`")
                .help("add it to what is generated from the description")
        })?;
        Ok(Self(BatchStates::new(&function.program, (compiled.tree.nq, compiled.tree.nv))))
    }
}

impl InverseDynamics for ProgramTorques {
    fn nq(&self) -> usize {
        self.0.coordinates().0
    }
    fn nv(&self) -> usize {
        self.0.coordinates().1
    }
    fn torques(&mut self, batch: &Batch<'_>, tau: &mut [f64]) -> Result<(), EvaluationError> {
        self.0.evaluate(batch.count, [batch.q, batch.v, batch.a], tau);
        Ok(())
    }
}
