//! Kinds of effects by their names.
use bipedc_compiler::description::suggest;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{self, KINDS};

/// Refuses kinds that the library does not know.
///
/// # Errors
/// With the closest name.
pub fn demand_kind(name: &str) -> Result<&'static effect::Kind, Diagnostic> {
    effect::kind(name).ok_or_else(|| {
        let help = suggest(name, KINDS.iter().map(|kind| kind.name), "kinds");
        Diagnostic::error(format!("there is no effect `{name}`"))
            .help(help + "; bipedc effects lists them all")
    })
}
