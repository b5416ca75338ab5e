//! Inverse dynamics of many states with one workspace, for comparisons with logs.
use bipedc_analysis::compare::{Batch, EvaluationError, InverseDynamics};
use bipedc_compiler::compile::CompiledModel;
use bipedc_compiler::program::Evaluator;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::{Argument, State};

/// A compiled model's function `inverse_dynamics`.
pub struct ProgramTorques {
    evaluator: Evaluator,
    workspace: Vec<f64>,
    nq: usize,
    nv: usize,
}

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
        let evaluator = Evaluator::new(&function.program);
        let workspace = evaluator.workspace();
        Ok(Self { evaluator, workspace, nq: compiled.tree.nq, nv: compiled.tree.nv })
    }
}

impl InverseDynamics for ProgramTorques {
    fn nq(&self) -> usize {
        self.nq
    }
    fn nv(&self) -> usize {
        self.nv
    }
    fn torques(&mut self, batch: &Batch<'_>, tau: &mut [f64]) -> Result<(), EvaluationError> {
        let (nq, nv) = (self.nq, self.nv);
        for (i, tau) in tau.chunks_exact_mut(nv.max(1)).enumerate().take(batch.count) {
            let state = State::new()
                .with(Argument::Q, &batch.q[i * nq..(i + 1) * nq])
                .with(Argument::V, &batch.v[i * nv..(i + 1) * nv])
                .with(Argument::A, &batch.a[i * nv..(i + 1) * nv]);
            self.evaluator.run(&state, &mut self.workspace, tau);
        }
        Ok(())
    }
}
