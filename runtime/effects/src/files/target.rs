//! What stands at a place where a file is to be written.
use super::cannot_write;
use crate::diagnostic::Diagnostic;
use std::fs::{File, Metadata};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Links to links that are followed, as many as systems do.
const LINKS: usize = 40;

/// How a place is written.
#[derive(Debug)]
pub(super) enum Target {
    /// A regular file, or nothing yet: beside it, then a rename. No link is left in `place`.
    File { place: PathBuf, present: Option<Metadata> },
    /// A device, a pipe or a socket: directly.
    Stream,
    /// What this program writes to already, under another name such as `/dev/stdout`.
    Standard(Standard, File),
}

/// The program's own streams.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Standard {
    Output,
    Error,
}

impl Target {
    /// Looks at a place.
    ///
    /// # Errors
    /// Folders, read-only files and folders (also for the superuser, who could write them), places that cannot be looked at.
    pub fn at(path: &Path) -> Result<Self, Diagnostic> {
        match std::fs::metadata(path) {
            Ok(present) if present.is_dir() => Err(is_folder(path)),
            Ok(present) => match standard(path, &present)? {
                Some((which, file)) => Ok(Self::Standard(which, file)),
                None if !present.is_file() => Ok(Self::Stream),
                None => {
                    let place = path.canonicalize().map_err(|error| cannot_write(path, &error))?;
                    refuse_read_only(&place, true)?;
                    Ok(Self::File { place, present: Some(present) })
                }
            },
            Err(error) if error.kind() == ErrorKind::NotFound => {
                let place = followed(path);
                if has_no_name(path) || has_no_name(&place) {
                    return Err(is_folder(path));
                }
                refuse_read_only(&place, false)?;
                Ok(Self::File { place, present: None })
            }
            Err(error) => Err(cannot_write(path, &error)),
        }
    }
}

/// Where links lead that end nowhere: there the file is made, as shells do.
pub(super) fn followed(path: &Path) -> PathBuf {
    let mut place = path.to_path_buf();
    for _ in 0..LINKS {
        let Ok(next) = std::fs::read_link(&place) else { break };
        place = folder_of(&place).join(next);
    }
    place
}

/// The folder of a file; `.` for a bare name.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Nothing, `..`, or a trailing separator, which only folders have.
fn has_no_name(path: &Path) -> bool {
    let last = path.as_os_str().as_encoded_bytes().last().copied();
    path.file_name().is_none() || last.is_some_and(|byte| std::path::is_separator(char::from(byte)))
}

fn is_folder(path: &Path) -> Diagnostic {
    Diagnostic::error("cannot write the file: this is a folder").in_file(path).help("give the name of a file")
}

/// A rename would replace what its owner has locked, where `>` of a shell does not.
fn refuse_read_only(place: &Path, is_there: bool) -> Result<(), Diagnostic> {
    let read_only = |path: &Path| std::fs::metadata(path).is_ok_and(|m| m.permissions().readonly());
    let error = |what: &str, path: &Path| {
        Err(Diagnostic::error(format!("the {what} is read-only: nothing was changed"))
            .in_file(path)
            .help("allow writing to it, or choose another place (to amend: a copy of the robot's folder)"))
    };
    let folder = folder_of(place);
    if is_there && read_only(place) {
        return error("file", place);
    }
    if cfg!(unix) && read_only(folder) { error("folder", folder) } else { Ok(()) }
}

/// The own stream that is this file: its position is shared, so that nothing is written over.
#[cfg(unix)]
fn standard(path: &Path, present: &Metadata) -> Result<Option<(Standard, File)>, Diagnostic> {
    use std::os::fd::AsFd;
    use std::os::unix::fs::MetadataExt;
    let own = [
        (Standard::Output, io::stdout().as_fd().try_clone_to_owned()),
        (Standard::Error, io::stderr().as_fd().try_clone_to_owned()),
    ];
    // A stream that was closed is none.
    for (which, stream) in
        own.into_iter().filter_map(|(which, stream)| Some((which, File::from(stream.ok()?))))
    {
        let is_same = stream.metadata().is_ok_and(|m| (m.dev(), m.ino()) == (present.dev(), present.ino()));
        if !is_same {
            continue;
        }
        let by_another_name = !(path.starts_with("/dev") || path.starts_with("/proc"));
        if present.is_file() && by_another_name {
            return Err(Diagnostic::error("the output of the program goes to this file already")
                .in_file(path)
                .help("choose another file for one of them"));
        }
        return Ok(Some((which, stream)));
    }
    Ok(None)
}

#[cfg(not(unix))]
fn standard(_: &Path, _: &Metadata) -> Result<Option<(Standard, File)>, Diagnostic> {
    Ok(None)
}
