//! A compiled model that runs in process.
use super::CompiledModel;
use crate::program::{Dual, Evaluator};
use crate::tree::Twins;
use bipedc_runtime::lanes::{F32x4, F32x8, F32x16, F64x2, F64x4, F64x8};
use bipedc_runtime::{Argument, CallError, Model, Real, Signature, State};
use std::sync::Arc;

/// All functions of a robot as evaluators; the same interface as emitted code.
#[derive(Debug, Clone)]
pub struct ProgramModel {
    compiled: CompiledModel,
    evaluators: Vec<Evaluator>,
}

impl ProgramModel {
    /// Prepares the programs of `compiled`.
    pub fn new(compiled: CompiledModel) -> Self {
        let twins = Arc::new(Twins::of(&compiled.tree));
        let evaluators = compiled.functions.iter().map(|f| Evaluator::with_twins(&f.program, &twins));
        let evaluators = evaluators.collect();
        Self { compiled, evaluators }
    }

    /// What it was compiled from.
    pub fn compiled(&self) -> &CompiledModel {
        &self.compiled
    }

    /// The evaluator of one function, for repeated calls with one workspace.
    pub fn evaluator(&self, function: usize) -> Option<&Evaluator> {
        self.evaluators.get(function)
    }

    fn name_of_joint(&self, index: usize) -> Option<&str> {
        self.compiled.tree.joints.get(index).map(|joint| joint.name.as_str())
    }

    fn signature_of(&self, index: usize) -> Option<Signature<'_>> {
        self.compiled.functions.get(index).map(|f| Signature {
            name: &f.name,
            arguments: f.program.arguments,
            rows: f.rows.len(),
            columns: f.columns.len(),
        })
    }

    fn run<R: Real>(&self, index: usize, state: &State<'_, R>, output: &mut [R]) -> Result<(), CallError> {
        self.check(index, state, output)?;
        let evaluator = &self.evaluators[index];
        evaluator.run(state, &mut evaluator.workspace(), output);
        Ok(())
    }

    fn run_one(&self, index: usize, state: &State<'_, f64>, output: &mut [f64]) -> Result<(), CallError> {
        self.check(index, state, output)?;
        self.evaluators[index].run_one(state, output);
        Ok(())
    }

    fn run_eight(
        &self,
        index: usize,
        state: &State<'_, F64x8>,
        output: &mut [F64x8],
    ) -> Result<(), CallError> {
        self.check(index, state, output)?;
        self.evaluators[index].run_eight(state, output);
        Ok(())
    }

    fn check<R>(&self, function: usize, state: &State<'_, R>, output: &[R]) -> Result<(), CallError> {
        let f = self.compiled.functions.get(function).ok_or(CallError::UnknownFunction)?;
        for argument in f.program.arguments() {
            let expected = self.compiled.argument_length(argument);
            if state.get(argument).len() != expected {
                return Err(CallError::WrongLength { argument, expected });
            }
        }
        let expected = f.rows.len() * f.columns.len();
        if output.len() == expected { Ok(()) } else { Err(CallError::WrongOutput { expected }) }
    }
}

/// For each of these scalars: a generic implementation would be compiled where it is called, with the optimisation of that crate.
macro_rules! evaluated_in {
    ($run:ident: $($real:ty),*) => {
        $(impl Model<$real> for ProgramModel {
            fn nq(&self) -> usize {
                self.compiled.tree.nq
            }
            fn nv(&self) -> usize {
                self.compiled.tree.nv
            }
            fn joint_name(&self, index: usize) -> Option<&str> {
                self.name_of_joint(index)
            }
            fn joints(&self) -> usize {
                self.compiled.tree.joints.len()
            }
            fn signature(&self, index: usize) -> Option<Signature<'_>> {
                self.signature_of(index)
            }
            fn argument_length(&self, argument: Argument) -> usize {
                self.compiled.argument_length(argument)
            }
            fn evaluate(&self, index: usize, state: &State<'_, $real>, output: &mut [$real]) -> Result<(), CallError> {
                self.$run(index, state, output)
            }
        })*
    };
}

evaluated_in!(run_one: f64);
evaluated_in!(run_eight: F64x8);
evaluated_in!(run: f32, F64x2, F64x4, F32x4, F32x8, F32x16, Dual<f64>, Dual<Dual<f64>>);
