//! Why a command gave up.
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::process::ExitCode;

/// Everything found wrong; printed on the error stream, exit code 1.
#[derive(Debug)]
pub struct Failure(pub Vec<Diagnostic>);

/// What commands return.
pub type Outcome = Result<ExitCode, Failure>;

impl From<Diagnostic> for Failure {
    fn from(diagnostic: Diagnostic) -> Self {
        Self(vec![diagnostic])
    }
}

impl From<Diagnostics> for Failure {
    fn from(diagnostics: Diagnostics) -> Self {
        Self(diagnostics.0)
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Diagnostic::error(error.to_string()).into()
    }
}
