//! A file of measurements: opened once for its header, hashed once.
use bipedc_analysis::log::{Kind, Mapping, Reader};
use bipedc_analysis::measure::Source;
use bipedc_analysis::robot::{BaseKind, JointLayout};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// A log, or a table of postures or impacts: CSV or gzip CSV in SI units. Its header was read; rows are read when they are
/// needed, in blocks, so that it may be of any length.
#[derive(Debug, Clone)]
pub struct Log {
    path: PathBuf,
    mapping: Mapping,
    kind: Kind,
    columns: Vec<String>,
    source: OnceLock<Source>,
}

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// Joint torques of a robot whose base rests.
    Efforts,
    /// Motion of the base and forces below the feet.
    Contacts,
    /// Static postures on force plates.
    Postures,
    /// Velocities before and after impacts.
    Impacts,
}

impl Content {
    /// What samples run over.
    pub fn abscissa(self) -> &'static str {
        match self {
            Self::Efforts | Self::Contacts => "time",
            Self::Postures => "posture",
            Self::Impacts => "impact",
        }
    }
}

impl Log {
    /// Opens a file whose columns have our names, such as `left_knee/position` (rad) and `left_knee/effort` (N m).
    ///
    /// # Errors
    /// Not readable, empty, no kind of table, columns that stand twice.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Diagnostics> {
        Self::with_mapping(path, Mapping::default())
    }

    /// Opens a file whose columns have other names, factors or signs ([`Mapping::open`] reads them from TOML).
    ///
    /// # Errors
    /// As [`Log::open`]; mapped columns that do not exist.
    pub fn with_mapping(path: impl AsRef<Path>, mapping: Mapping) -> Result<Self, Diagnostics> {
        let path = path.as_ref().to_path_buf();
        let reader = Reader::open(&path, &mapping)?;
        let columns = reader.columns().map(|column| column.name.clone()).collect();
        Ok(Self { kind: reader.kind(), columns, path, mapping, source: OnceLock::new() })
    }

    /// The same file under another mapping; what is known of its bytes stays known.
    pub(crate) fn mapped(&self, mapping: Mapping) -> Result<Self, Diagnostics> {
        Ok(Self { source: self.source.clone(), ..Self::with_mapping(&self.path, mapping)? })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names, factors and signs of its columns.
    pub fn mapping(&self) -> &Mapping {
        &self.mapping
    }

    /// What a row is.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Names of all columns, as the mapping has them.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(String::as_str)
    }

    /// Whether there is such a column.
    pub fn has(&self, name: &str) -> bool {
        self.columns().any(|column| column == name)
    }

    /// Path and hash, for provenance; its samples are not counted yet.
    ///
    /// # Errors
    /// A file that cannot be read any more.
    pub fn source(&self) -> Result<Source, Diagnostic> {
        if let Some(source) = self.source.get() {
            return Ok(source.clone());
        }
        let source = Source::of(&self.path, 0)?;
        Ok(self.source.get_or_init(|| source).clone())
    }

    /// What the file holds for this robot.
    pub fn content(&self, subject: &JointLayout) -> Content {
        let has = |part: &str| self.columns().any(|column| column.contains(part));
        let moves = subject.base != BaseKind::Fixed && has("base/position");
        match self.kind {
            Kind::Posture => Content::Postures,
            Kind::Impact => Content::Impacts,
            Kind::Time if moves && has("/force/") => Content::Contacts,
            Kind::Time => Content::Efforts,
        }
    }
}
