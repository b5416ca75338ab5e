//! Why a step of several phases is not made.
use bipedc_analysis::gait::Reason;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_runtime::control::Refusal;

/// A step, or a phase of it, is not made.
#[derive(Debug, Clone, PartialEq)]
pub struct Refused {
    /// In one word.
    pub reason: Reason,
    /// In words.
    pub why: Diagnostic,
}

impl Refused {
    pub(super) fn new(reason: Reason, message: impl Into<String>) -> Self {
        Self { reason, why: Diagnostic::error(message) }
    }

    /// The controller's refusal in a phase.
    pub(super) fn of_controller(phase: &str, refusal: Refusal) -> Self {
        let reason = match refusal {
            Refusal::PhaseTurnsBack => Reason::TurnsBack,
            Refusal::SingularOutputs => Reason::Singular,
            _ => Reason::NotFinite,
        };
        Self::new(reason, format!("phase `{phase}`: {refusal}"))
    }
}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.why.message)
    }
}

impl From<Refused> for Diagnostic {
    fn from(refused: Refused) -> Self {
        refused.why
    }
}

impl From<Refused> for Diagnostics {
    fn from(refused: Refused) -> Self {
        refused.why.into()
    }
}

/// What is no property of the step: a function is missing, a fault of the compiler.
impl From<Diagnostic> for Refused {
    fn from(why: Diagnostic) -> Self {
        Self { reason: Reason::NotFinite, why }
    }
}
