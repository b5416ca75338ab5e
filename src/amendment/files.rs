//! Files that appear whole or not at all, and one writer at a time.
use bipedc_runtime::diagnostic::Diagnostic;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Files larger than this are no descriptions and no histories.
const SIZE_LIMIT: u64 = 64 << 20;

/// A text that waits beside its file. [`Self::commit`] puts it there in one step; dropped, it leaves no trace.
#[derive(Debug)]
pub struct Replacement {
    temporary: PathBuf,
    path: PathBuf,
    committed: bool,
}

impl Replacement {
    /// Writes the text beside the file, down to the disk. A file that is there hands on its permissions.
    ///
    /// # Errors
    /// Read-only files and folders (also for the superuser, who could), and what the system refuses.
    pub fn prepare(path: &Path, text: &str) -> Result<Self, Diagnostic> {
        // Through links: renaming onto a link would replace the link.
        let path = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        refuse_read_only(&path)?;
        let mut name = path.file_name().unwrap_or_default().to_os_string();
        // One name for all: the lock keeps others away, and what a killed process left is written over.
        name.push(".amend.tmp");
        let temporary = path.with_file_name(name);
        let prepared = Self { temporary, path, committed: false };
        prepared.write(text).map_err(|error| cannot_write(&prepared.path, &error))?;
        Ok(prepared)
    }

    fn write(&self, text: &str) -> io::Result<()> {
        let mut file = File::create(&self.temporary)?;
        if let Ok(metadata) = std::fs::metadata(&self.path) {
            file.set_permissions(metadata.permissions())?;
        }
        file.write_all(text.as_bytes())?;
        file.sync_all()
    }

    /// Puts the text in its place.
    ///
    /// # Errors
    /// What the system refuses; then the file is as it was.
    pub fn commit(mut self) -> Result<(), Diagnostic> {
        std::fs::rename(&self.temporary, &self.path).map_err(|error| cannot_write(&self.path, &error))?;
        self.committed = true;
        Ok(())
    }
}

impl Drop for Replacement {
    fn drop(&mut self) {
        if !self.committed {
            // Nothing to be done if even that fails: the file's name says what it is.
            let _ = std::fs::remove_file(&self.temporary);
        }
    }
}

fn refuse_read_only(path: &Path) -> Result<(), Diagnostic> {
    let read_only = |path: &Path| std::fs::metadata(path).is_ok_and(|m| m.permissions().readonly());
    let error = |what: &str, path: &Path| {
        Err(Diagnostic::error(format!("the {what} is read-only: nothing was changed"))
            .in_file(path)
            .help("allow writing to it, or copy the robot's folder and amend the copy"))
    };
    if read_only(path) {
        return error("file", path);
    }
    match path.parent().filter(|folder| cfg!(unix) && read_only(folder)) {
        Some(folder) => error("folder", folder),
        None => Ok(()),
    }
}

fn cannot_write(path: &Path, error: &io::Error) -> Diagnostic {
    Diagnostic::error(format!("cannot write the file: {error}; it is as it was"))
        .in_file(path)
        .help("is there space, and may you write to this folder?")
}

/// Keeps others from amending the same robot; released when dropped.
#[derive(Debug)]
pub struct Lock {
    _folder: Option<File>,
}

impl Lock {
    /// Locks the folder of a file.
    ///
    /// # Errors
    /// Another process holds it. Where the system cannot lock folders, nothing is locked.
    pub fn of_folder(file: &Path) -> Result<Self, Diagnostic> {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let Ok(handle) = File::open(folder) else { return Ok(Self { _folder: None }) };
        match handle.try_lock() {
            Err(std::fs::TryLockError::WouldBlock) => {
                Err(Diagnostic::error("another bipedc is amending this robot just now")
                    .in_file(folder)
                    .help("wait until it is done"))
            }
            Err(std::fs::TryLockError::Error(_)) => Ok(Self { _folder: None }),
            Ok(()) => Ok(Self { _folder: Some(handle) }),
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
        Ok(metadata) if metadata.len() > SIZE_LIMIT => {
            return problem(format!("the file has {} MB, expected less than 64", metadata.len() >> 20));
        }
        _ => {}
    }
    match std::fs::read(path).map(String::from_utf8) {
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
    fn a_replacement_that_is_dropped_leaves_no_trace() {
        let folder = std::env::temp_dir().join(format!("bipedc_replacement_{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.toml");
        std::fs::write(&path, "old").unwrap();
        drop(Replacement::prepare(&path, "new").unwrap());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        Replacement::prepare(&path, "new").unwrap().commit().unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1, "temporaries are left");
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn one_writer_at_a_time() {
        let folder = std::env::temp_dir().join(format!("bipedc_lock_{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("biped.toml");
        let held = Lock::of_folder(&file).unwrap();
        if held._folder.is_some() {
            assert!(Lock::of_folder(&file).is_err());
        }
        drop(held);
        assert!(Lock::of_folder(&file).is_ok());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
