//! Runs the diagnosis on cases and judges its answers.
mod amended;
mod answer;
mod case;
mod examples;
mod judge;
mod logs;
mod parameters;
mod report;

pub use case::cases;
pub use examples::examples;
pub use judge::Scored;
pub use report::{page, table};
#[cfg(test)]
pub use {case::error_with, examples::read as example_truth};

use std::path::PathBuf;
use std::time::Duration;

/// What all runs share.
#[derive(Debug, Clone)]
pub struct Context {
    /// `bipedc`
    pub program: PathBuf,
    /// Of the project.
    pub root: PathBuf,
    /// For logs.
    pub folder: PathBuf,
    /// Further arguments of the diagnosis.
    pub with: Vec<String>,
    /// For one diagnosis.
    pub patience: Duration,
}
