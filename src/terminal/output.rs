//! Printing: results to the output stream, messages and progress to the error stream.
use bipedc_analysis::report::NextStep;
use bipedc_effects::diagnostic::{Diagnostic, Severity};
use bipedc_effects::files::to_standard_output;
use serde::Serialize;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::Path;

/// Prints a text. A reader that went away (`bipedc … | head`) has read enough: no error.
///
/// # Errors
/// Any other refusal of the system, such as a full disk.
pub fn print(text: &str) -> io::Result<()> {
    let mut out = stream();
    forgive(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// Says that a file was written, and which command goes on from there.
///
/// # Errors
/// As [`print()`].
pub fn written(file: &Path, next: &NextStep, json: bool) -> io::Result<()> {
    if json {
        return print_json(&serde_json::json!({ "wrote": file.display().to_string(), "next": next.command }));
    }
    print(&format!("wrote {}\nnext, {}:\n  {}\n", file.display(), next.why, next.command))
}

/// Prints a value as JSON with a line end.
///
/// # Errors
/// As [`print()`].
pub fn print_json(value: &impl Serialize) -> io::Result<()> {
    let mut out = io::BufWriter::new(stream());
    let written = serde_json::to_writer_pretty(&mut out, value).map_err(io::Error::from);
    forgive(written.and_then(|()| writeln!(out)).and_then(|()| out.flush()))?;
    // What is still buffered after a broken pipe is nobody's: dropping the buffer must not try again.
    let _ = out.into_parts();
    Ok(())
}

/// The output stream, unless a result was sent there (`--out /dev/stdout`): then words go to the error stream.
fn stream() -> Box<dyn Write> {
    if to_standard_output() { Box::new(io::stderr().lock()) } else { Box::new(io::stdout().lock()) }
}

fn forgive(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        Err(error) => {
            Err(io::Error::new(error.kind(), format!("cannot write to the output stream: {error}")))
        }
        Ok(()) => Ok(()),
    }
}

/// Says something on the error stream that is no result.
pub fn remark(text: &str) {
    // Nobody is left to tell when the error stream itself is gone.
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Prints errors and warnings to the error stream, in colour on a terminal.
pub fn diagnostics(list: &[Diagnostic]) {
    let mut err = io::stderr().lock();
    let colour = err.is_terminal() && std::env::var_os("NO_COLOR").is_none();
    for diagnostic in list {
        let text = diagnostic.to_string();
        let text = if colour { coloured(diagnostic.severity, &text) } else { text };
        // Nobody is left to tell when the error stream itself is gone.
        let _ = writeln!(err, "{text}\n");
    }
}

fn coloured(severity: Severity, text: &str) -> String {
    let colour = match severity {
        Severity::Error => "\u{1b}[1;31m",
        Severity::Warning => "\u{1b}[1;33m",
    };
    match text.split_once(':') {
        Some((kind, rest)) => format!("{colour}{kind}\u{1b}[0m:{rest}"),
        None => text.to_owned(),
    }
}

/// A diagnostic in JSON.
#[derive(Serialize)]
pub struct Message {
    message: String,
    file: Option<String>,
    line: Option<usize>,
    column: Option<usize>,
    help: Option<String>,
}

impl Message {
    /// All messages of one severity.
    pub fn all(list: &[Diagnostic], severity: Severity) -> Vec<Self> {
        list.iter().filter(|diagnostic| diagnostic.severity == severity).map(Self::new).collect()
    }

    fn new(diagnostic: &Diagnostic) -> Self {
        Self {
            message: diagnostic.message.clone(),
            file: diagnostic.file.as_ref().map(|file| file.display().to_string()),
            line: diagnostic.position.map(|(line, _)| line),
            column: diagnostic.position.map(|(_, column)| column).filter(|&column| column > 0),
            help: diagnostic.help.clone(),
        }
    }
}
