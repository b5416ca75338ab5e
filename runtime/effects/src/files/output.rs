//! A file that is being written.
use super::target::{Standard, Target, folder_of};
use super::temporary::{Temporary, settle};
use super::{cannot_write, target};
use crate::diagnostic::Diagnostic;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether a result was asked for where the program prints.
static ON_STANDARD_OUTPUT: AtomicBool = AtomicBool::new(false);

/// Whether some [`Output`] is the program's standard output, which is then no place for words.
pub fn to_standard_output() -> bool {
    ON_STANDARD_OUTPUT.load(Ordering::Relaxed)
}

/// A file that grows beside its place and goes there whole by [`Self::commit`]; dropped before that, it leaves no trace.
/// Devices and pipes get everything at once.
#[derive(Debug)]
pub struct Output {
    /// As it was given.
    path: PathBuf,
    file: BufWriter<File>,
    /// With the place it goes to; none: written directly.
    waiting: Option<(Temporary, PathBuf)>,
    /// Folders that were made for it, outer ones first. After `waiting`: they are removed when they are empty.
    folders: Folders,
    /// Whether a loss of power must not lose it.
    durable: bool,
}

impl Output {
    /// Begins to write a file into a folder that is there.
    ///
    /// # Errors
    /// Folders, read-only files and folders, and what the system refuses.
    pub fn create(path: &Path) -> Result<Self, Diagnostic> {
        Self::open(path, Folders::default())
    }

    /// The same, making missing folders.
    ///
    /// # Errors
    /// As [`Self::create`].
    pub fn create_with_folders(path: &Path) -> Result<Self, Diagnostic> {
        let folders = Folders::make(folder_of(path)).map_err(|error| cannot_write(path, &error))?;
        Self::open(path, folders)
    }

    fn open(path: &Path, folders: Folders) -> Result<Self, Diagnostic> {
        let refused = |error: io::Error| cannot_write(path, &error);
        let (file, waiting) = match Target::at(path)? {
            Target::File { place, present } => {
                let (temporary, file) = Temporary::beside(&place).map_err(refused)?;
                if let Some(present) = &present {
                    adopt(&file, present).map_err(refused)?;
                }
                (file, Some((temporary, place)))
            }
            Target::Stream => (OpenOptions::new().write(true).open(path).map_err(refused)?, None),
            Target::Standard(which, file) => {
                ON_STANDARD_OUTPUT.fetch_or(which == Standard::Output, Ordering::Relaxed);
                (file, None)
            }
        };
        let path = path.to_path_buf();
        Ok(Self { path, file: BufWriter::new(file), waiting, folders, durable: false })
    }

    /// Goes down to the disk before it takes its place.
    #[must_use]
    pub fn durable(self) -> Self {
        Self { durable: true, ..self }
    }

    /// Writes more of it.
    ///
    /// # Errors
    /// What the system refuses, such as a full disk.
    pub fn put(&mut self, text: &str) -> Result<(), Diagnostic> {
        let written = self.file.write_all(text.as_bytes());
        self.forgive(written).map_err(|error| cannot_write(&self.path, &error))
    }

    /// Puts it in its place.
    ///
    /// # Errors
    /// What the system refuses; then the file is as it was.
    pub fn commit(self) -> Result<(), Diagnostic> {
        Batch(vec![self]).commit()
    }

    /// Brings everything into the file that waits, so that only a rename is left.
    ///
    /// # Errors
    /// As [`Self::put`].
    pub fn finish(&mut self) -> Result<(), Diagnostic> {
        let flushed = self.file.flush();
        let written = self.forgive(flushed).and_then(|()| match &self.waiting {
            Some(_) if self.durable => self.file.get_ref().sync_all(),
            _ => Ok(()),
        });
        written.map_err(|error| cannot_write(&self.path, &error))
    }

    /// The reader of a pipe that went away (`--out /dev/stdout | head`) has read enough.
    fn forgive(&self, result: io::Result<()>) -> io::Result<()> {
        match result {
            Err(error) if error.kind() == ErrorKind::BrokenPipe && self.waiting.is_none() => Ok(()),
            other => other,
        }
    }
}

/// Files that go to their places together, once all of them are written: a full disk leaves every one as it was.
#[derive(Debug, Default)]
pub struct Batch(Vec<Output>);

impl Batch {
    /// One more.
    pub fn add(&mut self, output: Output) {
        self.0.push(output);
    }

    /// Puts all in their places, in the order in which they came.
    ///
    /// # Errors
    /// What the system refuses.
    pub fn commit(mut self) -> Result<(), Diagnostic> {
        for output in &mut self.0 {
            output.finish()?;
        }
        let (mut paths, mut waiting) = (Vec::new(), Vec::new());
        for output in &mut self.0 {
            if let Some((temporary, place)) = &mut output.waiting {
                waiting.push((temporary, place.as_path()));
                paths.push(&output.path);
            }
        }
        settle(&mut waiting).map_err(|(index, error)| cannot_write(paths[index], &error))?;
        self.0.iter_mut().for_each(|output| output.folders.keep());
        Ok(())
    }
}

impl Drop for Batch {
    fn drop(&mut self) {
        // The last one first: folders go when they are empty, and the first file made them.
        while self.0.pop().is_some() {}
    }
}

/// Owner and permissions of the file that it replaces.
fn adopt(file: &File, present: &Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        let own = file.metadata()?;
        if (own.uid(), own.gid()) != (present.uid(), present.gid()) {
            // Only the superuser may give files away; others write their own.
            let _ = fchown(file, Some(present.uid()), Some(present.gid()));
        }
    }
    file.set_permissions(present.permissions())
}

/// Folders that were made; those that are empty go again unless they are to be kept.
#[derive(Debug, Default)]
struct Folders(Vec<PathBuf>);

impl Folders {
    /// Makes a folder and what is missing above it.
    fn make(folder: &Path) -> io::Result<Self> {
        let missing = |folder: &&Path| !folder.as_os_str().is_empty() && std::fs::metadata(folder).is_err();
        let mut list: Vec<&Path> = folder.ancestors().take_while(missing).collect();
        list.reverse();
        let mut made = Self::default();
        for folder in list {
            match std::fs::create_dir(target::followed(folder)) {
                Ok(()) => made.0.push(folder.to_path_buf()),
                Err(error) if error.kind() == ErrorKind::AlreadyExists && folder.is_dir() => {}
                Err(error) => return Err(error),
            }
        }
        Ok(made)
    }

    fn keep(&mut self) {
        self.0.clear();
    }
}

impl Drop for Folders {
    fn drop(&mut self) {
        for folder in self.0.iter().rev() {
            // What another file was put into stays.
            let _ = std::fs::remove_dir(folder);
        }
    }
}
