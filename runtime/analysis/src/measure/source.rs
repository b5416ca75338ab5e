//! Which log was read.
use crate::log::Log;
use bipedc_effects::diagnostic::Diagnostic;
use serde::{Deserialize, Serialize};

/// Where data came from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DataSource {
    /// Path as given.
    pub file: String,
    /// FNV-1a hash of the bytes, 16 hex digits.
    pub hash: String,
    /// Samples (rows) that count.
    pub samples: usize,
}

impl Log {
    /// Path and hash, for provenance; its samples are not counted yet. [`Log::hash`] says what that costs.
    ///
    /// # Errors
    /// A file that cannot be read any more.
    pub fn source(&self) -> Result<DataSource, Diagnostic> {
        let hash = format!("{:016x}", self.hash()?);
        Ok(DataSource { file: self.path().display().to_string(), hash, samples: 0 })
    }
}
