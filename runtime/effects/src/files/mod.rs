//! The one way in which files are written: whole or not at all, and never onto what was read.
//!
//! A file grows beside its place and goes there by a rename, so that nobody ever sees half of it and a failure leaves what was
//! there. Links are followed, permissions kept; devices and pipes are written directly. A [`Ledger`] refuses, before any
//! work is done, outputs that would overwrite an input or one another.
mod ledger;
mod output;
mod target;
mod temporary;

pub use ledger::Ledger;
pub use output::{Batch, Output, to_standard_output};
pub use temporary::{remove_all as remove_temporaries, sweep};

use crate::diagnostic::Diagnostic;
use std::io::{self, ErrorKind};
use std::path::Path;

/// Writes a text into a folder that is there.
///
/// # Errors
/// Folders, read-only files, and what the system refuses; then the file is as it was.
pub fn write(path: &Path, text: &str) -> Result<(), Diagnostic> {
    let mut output = Output::create(path)?;
    output.put(text)?;
    output.commit()
}

/// The same, making missing folders.
///
/// # Errors
/// As [`write()`].
pub fn write_with_folders(path: &Path, text: &str) -> Result<(), Diagnostic> {
    let mut output = Output::create_with_folders(path)?;
    output.put(text)?;
    output.commit()
}

fn cannot_write(path: &Path, error: &io::Error) -> Diagnostic {
    let help = match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "make room on the disk, or choose a place on another"
        }
        ErrorKind::FileTooLarge => "raise the limit on the size of files (ulimit -f)",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "choose a place in a folder that you may write to"
        }
        ErrorKind::NotFound | ErrorKind::NotADirectory => {
            "make the folder first, or choose a place in another"
        }
        _ => "is there space, and may you write to this folder?",
    };
    Diagnostic::error(format!("cannot write the file: {error}")).in_file(path).help(help)
}
