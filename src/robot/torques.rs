//! A compiled inverse dynamics as comparisons with logs read it.
use bipedc_analysis::parallel::parallel;
use bipedc_analysis::robot::{Batch, EvaluationError, InverseDynamics};
use bipedc_compiler::compile::CompiledModel;
use bipedc_compiler::program::BatchStates;
use bipedc_effects::diagnostic::Diagnostic;

/// States that one core evaluates at a time.
const PART: usize = 2048;

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
        let (nq, nv) = self.0.coordinates();
        let parts = parallel(batch.count.div_ceil(PART), |part| {
            let (first, end) = (part * PART, ((part + 1) * PART).min(batch.count));
            let mut tau = vec![0.0; (end - first) * nv];
            let states = [
                &batch.q[first * nq..end * nq],
                &batch.v[first * nv..end * nv],
                &batch.a[first * nv..end * nv],
            ];
            self.0.evaluate(end - first, states, &mut tau);
            tau
        });
        for (tau, part) in tau.chunks_mut((PART * nv).max(1)).zip(parts) {
            tau.copy_from_slice(&part);
        }
        Ok(())
    }
}
