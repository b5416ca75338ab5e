//! Where parameters come from when nobody gives them: an estimator that works on logs.
use crate::diagnosing::{Request, estimate_files};
use crate::failure::Failure;
use crate::output;
use bipedc_analysis::diagnose::Diagnosis;
use bipedc_compiler::Robot;
use bipedc_effects::effect::Effect;
use std::path::Path;

/// What an estimator is asked.
#[derive(Debug, Clone, Copy)]
pub struct Question<'a> {
    /// As the description says, with the effects that it has.
    pub robot: &'a Robot,
    /// What to estimate. Parameters that stand in an effect are kept, missing ones are wanted.
    pub effects: &'a [Effect],
    /// The log to estimate from.
    pub training: &'a Path,
    /// The log that judges; `None`: blocks of the training log do.
    pub validation: Option<&'a Path>,
}

/// Estimates parameters of given effects.
pub trait Estimator {
    /// The effects with their parameters and error bars, in the order asked, and the errors before and after.
    ///
    /// # Errors
    /// Logs that cannot be read or do not support the estimate.
    fn estimate(&self, question: &Question<'_>) -> Result<Diagnosis, Failure>;
}

/// Estimates from logs as `bipedc diagnose` does.
#[derive(Debug, Clone, Copy)]
pub struct FromLogs;

impl Estimator for FromLogs {
    fn estimate(&self, question: &Question<'_>) -> Result<Diagnosis, Failure> {
        let mut robot = question.robot.clone();
        // An effect that is estimated anew does not stand meanwhile.
        robot.description.effects.retain(|present| {
            !question.effects.iter().any(|e| e.kind == present.kind && e.location == present.location)
        });
        let request = Request {
            log: question.training.to_path_buf(),
            validate: question.validation.map(Path::to_path_buf),
            ..Request::default()
        };
        let (diagnosis, warnings) = estimate_files(&robot, question.effects, &request)?;
        output::diagnostics(&warnings);
        Ok(diagnosis)
    }
}
