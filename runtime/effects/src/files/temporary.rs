//! Files that wait beside their place, and those of them that must not outlive the program.
use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::{Mutex, MutexGuard};

/// What names of temporary files end with.
const ENDING: &str = ".bipedc-tmp";
/// Of a file's name, so many bytes are part of its temporary's: names have at most 255.
const LONGEST: usize = 200;

/// All temporary files of this program. Held during renames, so that no signal comes between them.
static ALL: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn all() -> MutexGuard<'static, Vec<PathBuf>> {
    // A list of paths is whole even if a thread died with it in hand.
    ALL.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// A file beside its place. Dropped before [`settle`], it leaves no trace.
#[derive(Debug)]
pub(super) struct Temporary {
    path: PathBuf,
    settled: bool,
}

impl Temporary {
    /// Makes one beside this file.
    pub fn beside(place: &Path) -> io::Result<(Self, File)> {
        let mut list = all();
        for number in 0_u32.. {
            let mut name = prefix(place);
            name.push(format!("{}-{number}{ENDING}", process::id()));
            let path = place.with_file_name(name);
            // Never through something that somebody else has put there.
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => {
                    list.push(path.clone());
                    return Ok((Self { path, settled: false }, file));
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(ErrorKind::AlreadyExists.into())
    }
}

/// Puts temporaries in their places, one after the other; the index of the one that failed comes with the error.
pub(super) fn settle(waiting: &mut [(&mut Temporary, &Path)]) -> Result<(), (usize, io::Error)> {
    let mut list = all();
    for (index, (temporary, place)) in waiting.iter_mut().enumerate() {
        std::fs::rename(&temporary.path, place).map_err(|error| (index, error))?;
        temporary.settled = true;
        list.retain(|path| *path != temporary.path);
    }
    Ok(())
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.settled {
            // Nothing to be done if even that fails: the file's name says what it is.
            let _ = std::fs::remove_file(&self.path);
            all().retain(|path| *path != self.path);
        }
    }
}

/// Removes all temporary files of this program, which is about to end: nothing can be written any more.
pub fn remove_all() {
    let list = all();
    for path in list.iter() {
        let _ = std::fs::remove_file(path);
    }
    // Who wants to write now waits for the end.
    std::mem::forget(list);
}

/// Removes what killed programs left beside a file. Only for those who know that nobody else is writing it.
pub fn sweep(place: &Path) {
    let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (Ok(entries), prefix) = (std::fs::read_dir(folder), prefix(place)) else { return };
    let is_left = |name: &OsString| {
        let (name, prefix) = (name.as_encoded_bytes(), prefix.as_encoded_bytes());
        let number = name.strip_prefix(prefix).and_then(|rest| rest.strip_suffix(ENDING.as_bytes()));
        number.is_some_and(|number| number.iter().all(|byte| byte.is_ascii_digit() || *byte == b'-'))
    };
    for entry in entries.flatten().filter(|entry| is_left(&entry.file_name())) {
        let _ = std::fs::remove_file(entry.path());
    }
}

/// Such as `.run.csv.`
fn prefix(place: &Path) -> OsString {
    let mut prefix = OsString::from(".");
    let name = place.file_name().unwrap_or_default();
    match name.to_str() {
        Some(text) => {
            let fits = (0..=LONGEST.min(text.len())).rev().find(|at| text.is_char_boundary(*at));
            prefix.push(&text[..fits.unwrap_or(0)]);
        }
        None if name.len() <= LONGEST => prefix.push(name),
        None => {}
    }
    prefix.push(".");
    prefix
}
