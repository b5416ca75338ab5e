//! What a program reads and what it is going to write.
use super::target::{Target, folder_of, followed};
use crate::diagnostic::Diagnostic;
use std::path::{Path, PathBuf};

/// Endings of files that logs, pictures and pages never replace.
const SOURCES: [&str; 6] = ["toml", "urdf", "xacro", "xml", "rs", "md"];

/// The files of one run: outputs must be neither inputs nor one another, whatever links and detours their names take.
#[derive(Debug, Clone, Default)]
pub struct Ledger {
    read: Vec<Entry>,
    written: Vec<Entry>,
}

#[derive(Debug, Clone)]
struct Entry {
    /// Such as `the log` or `--out`.
    what: String,
    identity: Identity,
}

/// Equal if and only if two names are one file.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Identity {
    /// Device and number on it, which hard links share.
    #[cfg(unix)]
    Present(u64, u64),
    /// Of a file that is not there yet, or where files have no numbers: without links.
    Place(PathBuf),
}

impl Ledger {
    /// Notes an input; `what` names it in messages, as in "the log".
    pub fn reads(&mut self, what: &str, path: &Path) {
        if let Some(identity) = identity(path) {
            self.read.push(Entry { what: what.to_owned(), identity });
        }
    }

    /// Notes an output; `what` is its option.
    ///
    /// # Errors
    /// It is an input or another output; a folder; read-only; a description, a gait or code that is there.
    pub fn writes(&mut self, what: &str, path: &Path) -> Result<(), Diagnostic> {
        self.writes_source(what, path)?;
        let is_source = path.extension().is_some_and(|ending| SOURCES.iter().any(|source| ending == *source));
        if is_source && path.is_file() {
            let message = format!("{what} would replace a file that people write");
            let help = format!("give {what} another name; nothing was written");
            return Err(Diagnostic::error(message).in_file(path).help(help));
        }
        Ok(())
    }

    /// The same for descriptions, gaits and code, which replace their like.
    ///
    /// # Errors
    /// It is an input or another output; a folder; read-only.
    pub fn writes_source(&mut self, what: &str, path: &Path) -> Result<(), Diagnostic> {
        Target::at(path)?;
        let Some(identity) = identity(path) else { return Ok(()) };
        let refused = |message: String| {
            let help = format!("give {what} another name; nothing was written");
            Err(Diagnostic::error(message).in_file(path).help(help))
        };
        if let Some(input) = self.read.iter().find(|entry| entry.identity == identity) {
            return refused(format!("{what} would overwrite {}", input.what));
        }
        if let Some(other) = self.written.iter().find(|entry| entry.identity == identity) {
            return refused(format!("{what} and {} name the same file", other.what));
        }
        self.written.push(Entry { what: what.to_owned(), identity });
        Ok(())
    }

    /// Notes a folder that is filled with files of this ending, such as `svg`. Comes after all [`Self::writes`].
    ///
    /// # Errors
    /// It is a file, or such a file in it is an input or another output.
    pub fn fills(&self, what: &str, folder: &Path, ending: &str) -> Result<(), Diagnostic> {
        let has_ending = |path: &Path| path.extension().is_some_and(|extension| extension == ending);
        let refused = |other: &str| {
            let help = format!("give {what} a folder of its own; nothing was written");
            Err(Diagnostic::error(format!("{what} might overwrite {other}")).in_file(folder).help(help))
        };
        if std::fs::metadata(folder).is_ok_and(|metadata| !metadata.is_dir()) {
            return Err(Diagnostic::error(format!("{what} takes a folder, this is a file"))
                .in_file(folder)
                .help("give a folder; one that is missing is made"));
        }
        let present = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let present: Vec<_> =
            present.filter(|path| has_ending(path)).filter_map(|path| identity(&path)).collect();
        let inside = future(folder);
        for entry in self.read.iter().chain(&self.written) {
            let planned = matches!(&entry.identity, Identity::Place(place)
                if has_ending(place) && place.parent() == Some(inside.as_path()));
            if planned || present.contains(&entry.identity) {
                return refused(&entry.what);
            }
        }
        Ok(())
    }
}

/// None of devices and pipes: they are written to by several, and what is read from them is gone.
fn identity(path: &Path) -> Option<Identity> {
    match std::fs::metadata(path) {
        Ok(metadata) if !metadata.is_file() => None,
        #[cfg(unix)]
        Ok(metadata) => {
            use std::os::unix::fs::MetadataExt;
            Some(Identity::Present(metadata.dev(), metadata.ino()))
        }
        #[cfg(not(unix))]
        Ok(_) => Some(Identity::Place(path.canonicalize().unwrap_or_else(|_| path.to_path_buf()))),
        Err(_) => Some(Identity::Place(future(path))),
    }
}

/// The place of a file, by way of the nearest folder that is there.
fn future(path: &Path) -> PathBuf {
    if let Ok(place) = path.canonicalize() {
        return place;
    }
    let place = followed(path);
    let folder = folder_of(&place);
    let near = folder.ancestors().find_map(|near| {
        let near_or_here = if near.as_os_str().is_empty() { Path::new(".") } else { near };
        Some((near_or_here.canonicalize().ok()?, folder.strip_prefix(near).ok()?))
    });
    let folder = near.map_or_else(|| folder.to_path_buf(), |(near, rest)| near.join(rest));
    place.file_name().map_or_else(|| folder.clone(), |name| folder.join(name))
}
