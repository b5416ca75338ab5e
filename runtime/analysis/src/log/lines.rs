//! Lines of a text file, plain or gzip, in bounded memory.
use super::hash::{Hash, Hashing};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::input;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Longest line in bytes. A file without line ends must not fill the memory; ten thousand columns fit.
pub const LONGEST_LINE: usize = 1 << 20;

/// Most blank lines in a row: an archive of a megabyte can hold a thousand million of them.
pub const MOST_BLANK: usize = 1 << 20;

/// The lines of a file, counted from 1; blank ones are skipped but counted.
pub(super) struct Lines {
    file: PathBuf,
    source: Box<dyn BufRead>,
    /// Bytes of the present line, without its end.
    buffer: Vec<u8>,
    /// Number of the present line.
    number: usize,
}

impl Lines {
    /// Opens a file; gzip is recognised by its first two bytes, not by its name.
    pub fn open(path: &Path) -> Result<Self, Diagnostic> {
        Self::new(path, input::open(path).map_err(|e| cannot_read(path, &e))?)
    }

    /// The same; whoever reads to the end leaves the hash of the file's bytes in `hash`.
    pub fn hashed(path: &Path, hash: &Hash) -> Result<Self, Diagnostic> {
        let source = input::open(path).map_err(|e| cannot_read(path, &e))?;
        Self::new(path, Box::new(Hashing::new(source, hash)))
    }

    /// Reads from any source; `path` is for messages.
    pub fn new(path: &Path, source: Box<dyn Read>) -> Result<Self, Diagnostic> {
        let mut raw = BufReader::with_capacity(1 << 16, source);
        let magic = raw.fill_buf().map_err(|e| cannot_read(path, &e))?;
        let gzip = magic.starts_with(&[0x1f, 0x8b]);
        if let Some(name) = foreign_format(magic) {
            return Err(Diagnostic::error(format!("this is {name}, not a table of text"))
                .in_file(path)
                .help("export the log as CSV; gzip (`.csv.gz`) is the only compression read"));
        }
        let source: Box<dyn BufRead> = if gzip {
            Box::new(BufReader::with_capacity(1 << 16, flate2::bufread::MultiGzDecoder::new(raw)))
        } else {
            Box::new(raw)
        };
        Ok(Self { file: path.to_path_buf(), source, buffer: Vec::new(), number: 0 })
    }

    /// The number of the line returned last, from 1.
    pub fn number(&self) -> usize {
        self.number
    }

    /// The next line that is not blank with its number, `None` at the end.
    pub fn next(&mut self) -> Result<Option<(usize, &str)>, Diagnostic> {
        let before = self.number;
        loop {
            self.buffer.clear();
            let limit = LONGEST_LINE as u64 + 1;
            let result = (&mut self.source).take(limit).read_until(b'\n', &mut self.buffer);
            let read = result.map_err(|e| cannot_read(&self.file, &e).at(self.number + 1, 0))?;
            if read == 0 {
                return Ok(None);
            }
            self.number += 1;
            if self.buffer.len() > LONGEST_LINE {
                return Err(self.too_long());
            }
            if self.number == 1 && self.buffer.starts_with(b"\xef\xbb\xbf") {
                // A byte order mark, as spreadsheets write it, is not part of the first name.
                self.buffer.drain(..3);
            }
            while self.buffer.last().is_some_and(|b| matches!(b, b'\n' | b'\r')) {
                self.buffer.pop();
            }
            if !self.buffer.iter().all(u8::is_ascii_whitespace) {
                break;
            }
            if self.number - before > MOST_BLANK {
                return Err(self
                    .here(format!("more than {MOST_BLANK} blank lines in a row"), 0)
                    .help("remove them; was the recording damaged?"));
            }
        }
        match std::str::from_utf8(&self.buffer) {
            Ok(line) => match self.strange(line, before == 0) {
                None => Ok(Some((self.number, line))),
                Some(error) => Err(error),
            },
            Err(e) => {
                let text = String::from_utf8_lossy(&self.buffer[..e.valid_up_to()]);
                Err(self
                    .here("the text is not UTF-8".to_owned(), text.chars().count() + 1)
                    .help("save the file as UTF-8; UTF-16 and binary files are not read"))
            }
        }
    }

    /// Bytes that text may have and a table has not.
    fn strange(&self, line: &str, is_header: bool) -> Option<Diagnostic> {
        if let Some(place) = line.find('\0') {
            return Some(self.nul(line[..place].chars().count() + 1));
        }
        // Files of old had nothing else at the ends of lines: all of them would be one.
        is_header.then(|| line.find('\r')).flatten().map(|place| {
            self.here(
                "a carriage return (\\r) stands within the line".to_owned(),
                line[..place].chars().count() + 1,
            )
            .help("save the file with lines that end with \\n or \\r\\n")
        })
    }

    fn here(&self, message: String, column: usize) -> Diagnostic {
        Diagnostic::error(message).in_file(&self.file).at(self.number, column)
    }

    /// What a file system leaves where data were promised and never written.
    fn nul(&self, column: usize) -> Diagnostic {
        self.here("the file has NUL bytes (\\0): it is not all text".to_owned(), column).help(
            "did the recorder lose power? Cut the file before this line; UTF-16 and binary files are not read",
        )
    }

    fn too_long(&self) -> Diagnostic {
        if let Some(place) = self.buffer.iter().position(|byte| *byte == 0) {
            return self.nul(String::from_utf8_lossy(&self.buffer[..place]).chars().count() + 1);
        }
        let commas = self.buffer.iter().filter(|byte| **byte == b',').count();
        let help = match commas {
            0 => "a row ends with a line feed (\\n); is this a CSV file?".to_owned(),
            _ => format!(
                "a row ends with a line feed (\\n), this one goes on after {commas} commas: keep `time` and the columns of \
                 joints, base and feet"
            ),
        };
        self.here(format!("line {} is longer than {LONGEST_LINE} bytes", self.number), 0).help(help)
    }
}

fn cannot_read(path: &Path, error: &io::Error) -> Diagnostic {
    Diagnostic::error(format!("cannot read the file: {error}"))
        .in_file(path)
        .help("check that the path is right, that the file may be read and that it was copied completely")
}

/// Formats that users hand over by mistake.
fn foreign_format(start: &[u8]) -> Option<&'static str> {
    const KNOWN: [(&[u8], &str); 8] = [
        (b"PK\x03\x04", "a ZIP archive or a spreadsheet"),
        (b"\x28\xb5\x2f\xfd", "a Zstandard archive"),
        (b"\xfd7zXZ", "an XZ archive"),
        (b"BZh", "a bzip2 archive"),
        (b"\x89HDF", "an HDF5 or MATLAB 7.3 file"),
        (b"MATLAB", "a MATLAB file"),
        (b"#ROSBAG", "a ROS bag"),
        (b"\x89MCAP", "an MCAP file"),
    ];
    KNOWN.iter().find(|(magic, _)| start.starts_with(magic)).map(|(_, name)| *name)
}
