//! Which log was read.
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::input;
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead, BufReader};
use std::path::Path;

/// Where data came from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Source {
    /// Path as given.
    pub file: String,
    /// FNV-1a hash of the bytes, 16 hex digits.
    pub hash: String,
    /// Samples (rows) that count.
    pub samples: usize,
}

impl Source {
    /// A file with the hash of its bytes.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn of(path: &Path, samples: usize) -> Result<Self, Diagnostic> {
        let hash =
            hash(path).map_err(|e| Diagnostic::error(format!("cannot read the file: {e}")).in_file(path))?;
        Ok(Self { file: path.display().to_string(), hash: format!("{hash:016x}"), samples })
    }
}

/// FNV-1a of a file of any length.
fn hash(path: &Path) -> io::Result<u64> {
    let mut source = BufReader::with_capacity(1 << 16, input::open(path)?);
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    loop {
        let piece = source.fill_buf()?;
        if piece.is_empty() {
            return Ok(hash);
        }
        for byte in piece {
            hash = (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
        let count = piece.len();
        source.consume(count);
    }
}
