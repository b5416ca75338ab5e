//! A compiled regressor as identification reads it.
use bipedc_analysis::identify::BatchRegressor;
use bipedc_analysis::robot::Batch;
use bipedc_compiler::program::{BatchColumns, Program};

/// Chosen columns of a compiled regressor.
pub struct ProgramRegressor(BatchColumns);

impl ProgramRegressor {
    /// The columns `chosen` of `program`, which has `nv` rows and gives them column after column.
    pub fn new(program: &Program, coordinates: (usize, usize), chosen: &[usize]) -> Self {
        Self(BatchColumns::new(program, coordinates, chosen))
    }
}

impl BatchRegressor for ProgramRegressor {
    fn nq(&self) -> usize {
        self.0.coordinates().0
    }
    fn nv(&self) -> usize {
        self.0.coordinates().1
    }
    fn pattern(&self) -> &[Vec<usize>] {
        self.0.pattern()
    }
    fn evaluate(&self, batch: &Batch<'_>, out: &mut [f64]) {
        self.0.evaluate(batch.count, [batch.q, batch.v, batch.a], out);
    }
}
