//! `--set a=1 b=2`: only the first is the option's.
use bipedc_effects::diagnostic::Diagnostic;
use clap::Error;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::path::Path;

const HELP: &str = "every NAME=VALUE needs its own --set, or commas: --set a=1 --set b=2, --set a=1,b=2";

/// An error of the command line that says, of an argument like `b=2` which belongs to nothing, how it is given.
pub fn explained(mut error: Error) -> Error {
    let stray = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(text)) => error.kind() == ErrorKind::UnknownArgument && is_assignment(text),
        _ => false,
    };
    if stray {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![HELP.into()]));
    }
    error
}

/// Refuses an assignment that stands where a file is expected.
///
/// # Errors
/// It is one, and no such file exists.
pub fn refuse(file: &Path) -> Result<(), Diagnostic> {
    let text = file.display().to_string();
    match is_assignment(&text) && !file.exists() {
        true => Err(Diagnostic::error(format!("`{text}` belongs to no option")).help(HELP)),
        false => Ok(()),
    }
}

fn is_assignment(text: &str) -> bool {
    text.contains('=') && !text.starts_with('-')
}
