//! Texts that are ready to take their places, and one writer at a time.
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::{Output, sweep};
use bipedc_effects::input;
use std::fs::File;
use std::io;
use std::path::Path;

/// A text that waits beside its file, down on the disk; a file that is there hands on its permissions.
///
/// # Errors
/// Read-only files and folders (also for the superuser, who could), and what the system refuses.
pub fn prepared(path: &Path, text: &str) -> Result<Output, Diagnostic> {
    let mut output = Output::create(path)?.durable();
    output.put(text)?;
    output.finish()?;
    Ok(output)
}

/// Keeps others from amending the same robot; released when dropped.
#[derive(Debug)]
pub struct Lock {
    _folder: Option<File>,
}

impl Lock {
    /// Locks the folder of a file, and clears away what killed processes left there beside these files.
    ///
    /// # Errors
    /// Another process holds it. Where the system cannot lock folders, nothing is locked.
    pub fn of_folder(file: &Path, written: &[&Path]) -> Result<Self, Diagnostic> {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let Ok(handle) = File::open(folder) else { return Ok(Self { _folder: None }) };
        match handle.try_lock() {
            Err(std::fs::TryLockError::WouldBlock) => {
                Err(Diagnostic::error("another bipedc is amending this robot just now")
                    .in_file(folder)
                    .help("wait until it is done"))
            }
            Err(std::fs::TryLockError::Error(_)) => Ok(Self { _folder: None }),
            Ok(()) => {
                written.iter().for_each(|path| sweep(path));
                Ok(Self { _folder: Some(handle) })
            }
        }
    }
}

/// Reads a text; `None` if there is no such file.
///
/// # Errors
/// Files that are unreadable, not UTF-8 or larger than 64 MB.
pub fn read_text(path: &Path) -> Result<Option<String>, Diagnostic> {
    let problem = |message: String| Err(Diagnostic::error(message).in_file(path));
    match std::fs::metadata(path) {
        Ok(metadata) if metadata.len() > input::LARGEST_TEXT => {
            return problem(format!("the file has {} MB, expected less than 64", metadata.len() >> 20));
        }
        _ => {}
    }
    match input::read(path).map(String::from_utf8) {
        Ok(Ok(text)) => Ok(Some(text)),
        Ok(Err(error)) => {
            problem(format!("the file is not UTF-8 text (byte {})", error.utf8_error().valid_up_to()))
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => problem(format!("cannot read the file: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_writer_at_a_time() {
        let folder = std::env::temp_dir().join(format!("bipedc_lock_{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("biped.toml");
        let held = Lock::of_folder(&file, &[]).unwrap();
        if held._folder.is_some() {
            assert!(Lock::of_folder(&file, &[]).is_err());
        }
        drop(held);
        assert!(Lock::of_folder(&file, &[]).is_ok());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
