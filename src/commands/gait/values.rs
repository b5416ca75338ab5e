//! Values of parameters as they are typed, and where results go.
use crate::terminal::failure::Failure;
use crate::terminal::output;
use bipedc::gait::{Assignment, Over, Range};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::{Ledger, write_with_folders};
use std::path::Path;

/// Exit code of what was interrupted, as shells have it.
pub const INTERRUPTED: u8 = 130;

/// `NAME=X`.
pub fn assignment(text: &str) -> Result<Assignment, String> {
    let (name, value) = text.split_once('=').ok_or("write NAME=X, such as step_length=0.4")?;
    let number: f64 = value.trim().parse().map_err(|_| format!("`{value}` is no number"))?;
    if !number.is_finite() {
        return Err(format!("`{value}` is not finite"));
    }
    Ok((name.trim().to_owned(), number))
}

/// `NAME=A:B:N`.
pub fn over(text: &str) -> Result<Over, String> {
    let wrong = "write NAME=A:B:N, such as step_length=0.2:1:100";
    let (name, range) = text.split_once('=').ok_or(wrong)?;
    Ok(Over {
        name: name.trim().to_owned(),
        range: self::range(range).map_err(|why| format!("{why}: {wrong}"))?,
    })
}

/// `A:B:N`.
pub fn range(text: &str) -> Result<Range, String> {
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let &[low, high, count] = &parts[..] else { return Err(format!("`{text}` is no range")) };
    let number = |text: &str| text.parse::<f64>().map_err(|_| format!("`{text}` is no number"));
    let count = count.parse().map_err(|_| format!("`{count}` is no number of values"))?;
    Ok(Range { low: number(low)?, high: number(high)?, count })
}

/// Notes a file among what is written.
pub fn note(ledger: &mut Ledger, option: &str, path: Option<&Path>) -> Result<(), Diagnostic> {
    path.map_or(Ok(()), |path| ledger.writes(option, path))
}

/// Writes a text if somewhere is given, and says so on the error stream.
pub fn write(path: Option<&Path>, text: impl FnOnce() -> String) -> Result<(), Failure> {
    if let Some(path) = path {
        write_with_folders(path, &text())?;
        output::remark(&format!("wrote {}", path.display()));
    }
    Ok(())
}
