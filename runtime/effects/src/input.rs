//! Files from outside: opened once or more often, whatever they are.
//!
//! A log is read several times (its header, its cut-off, its samples), a pipe gives its bytes but once. Where
//! [`keep_pipes`] was called, as the command line does, [`open`] keeps the bytes of pipes and devices in a temporary
//! file without a name (in `TMPDIR`, by default `/tmp`): every reader after the first sees them from their beginning.
//! Only what somebody reads is kept, so that a bad first line is told at once.
use std::collections::HashMap;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// Texts that are read as a whole and are larger than this are refused; the largest descriptions have a few hundred
/// kilobytes.
pub const LARGEST_TEXT: u64 = 64 << 20;

/// Device and number of a file.
type Key = (u64, u64);
static KEPT: OnceLock<Mutex<HashMap<Key, Arc<Mutex<Kept>>>>> = OnceLock::new();

/// From now on pipes and devices can be read again, as long as the program runs.
pub fn keep_pipes() {
    KEPT.get_or_init(Mutex::default);
}

/// Opens a file for reading.
///
/// # Errors
/// Those of the system.
pub fn open(path: &Path) -> io::Result<Box<dyn Read + Send>> {
    let metadata = std::fs::metadata(path)?;
    let (Some(all), Some(key)) = (KEPT.get(), key(path, &metadata)) else {
        return Ok(Box::new(File::open(path)?));
    };
    let mut all = locked(all);
    if let Some(kept) = all.get(&key) {
        return Ok(Box::new(Again { kept: Arc::clone(kept), at: 0 }));
    }
    let kept = Arc::new(Mutex::new(Kept::new(File::open(path)?)?));
    all.insert(key, Arc::clone(&kept));
    Ok(Box::new(Again { kept, at: 0 }))
}

/// All bytes of a file that is a text.
///
/// # Errors
/// Those of the system; more than [`LARGEST_TEXT`].
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.take(LARGEST_TEXT + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LARGEST_TEXT {
        let message = format!("it has more than {} MB", LARGEST_TEXT >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

/// The text of a file.
///
/// # Errors
/// As [`read`]; not UTF-8.
pub fn read_to_string(path: &Path) -> io::Result<String> {
    String::from_utf8(read(path)?).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        io::Error::new(io::ErrorKind::InvalidData, format!("it is not UTF-8 text (byte {valid})"))
    })
}

/// By what a file is known that gives its bytes once; `None` for all others. What lies in `/dev` may share its place
/// with an open file, whatever that is: some systems go on there instead of beginning again.
#[cfg(unix)]
fn key(path: &Path, metadata: &Metadata) -> Option<Key> {
    use std::os::unix::fs::MetadataExt;
    let once = !metadata.is_file() && !metadata.is_dir();
    (once || path.starts_with("/dev")).then(|| (metadata.dev(), metadata.ino()))
}

/// Elsewhere pipes have no path of that kind.
#[cfg(not(unix))]
fn key(_: &Path, _: &Metadata) -> Option<Key> {
    None
}

/// Bytes read so far, and where more come from.
struct Kept {
    source: File,
    copy: File,
    length: u64,
    ended: bool,
}

impl Kept {
    fn new(source: File) -> io::Result<Self> {
        let copy = nameless(&std::env::temp_dir()).map_err(cannot_keep)?;
        Ok(Self { source, copy, length: 0, ended: false })
    }

    fn read_at(&mut self, at: u64, buffer: &mut [u8]) -> io::Result<usize> {
        if at < self.length {
            let most = usize::try_from(self.length - at).unwrap_or(usize::MAX).min(buffer.len());
            self.copy.seek(SeekFrom::Start(at))?;
            return self.copy.read(&mut buffer[..most]);
        }
        if self.ended || buffer.is_empty() {
            return Ok(0);
        }
        let count = self.source.read(buffer)?;
        self.ended = count == 0;
        self.copy.seek(SeekFrom::Start(self.length)).map_err(cannot_keep)?;
        self.copy.write_all(&buffer[..count]).map_err(cannot_keep)?;
        self.length += count as u64;
        Ok(count)
    }
}

/// A reader from the beginning.
struct Again {
    kept: Arc<Mutex<Kept>>,
    at: u64,
}

impl Read for Again {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = locked(&self.kept).read_at(self.at, buffer)?;
        self.at += count as u64;
        Ok(count)
    }
}

/// What a thread that panicked left is whole: bytes are counted after they are written.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file that only this process knows: its name is taken away at once, so that nothing is left however it ends.
fn nameless(folder: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let mut attempt = 0;
    loop {
        let path = folder.join(format!("bipedc-pipe-{}-{attempt}", std::process::id()));
        match options.open(&path) {
            Ok(file) => {
                std::fs::remove_file(&path)?;
                return Ok(file);
            }
            // Left by a process of this number that was stopped between the two.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < 1000 => attempt += 1,
            Err(error) => return Err(error),
        }
    }
}

fn cannot_keep(error: io::Error) -> io::Error {
    let folder = std::env::temp_dir();
    let message = format!(
        "cannot keep what the pipe gives in {}: {error} (TMPDIR names another folder)",
        folder.display()
    );
    io::Error::new(error.kind(), message)
}
