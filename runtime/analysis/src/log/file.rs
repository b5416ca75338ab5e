//! A file of measurements, opened once.
use super::hash::{Hash, Hashing};
use super::header::{self, Header, Kind};
use super::kept::Shelf;
use super::lines::Lines;
use super::mapping::Mapping;
use super::reader::Reader;
use super::sparse::Found;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::input;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A log, or a table of postures or impacts: CSV or gzip CSV in SI units. Its header was read; rows are read when they are
/// needed, in blocks, so that it may be of any length. Clones share what is known of the file.
#[derive(Debug, Clone)]
pub struct Log {
    path: PathBuf,
    mapping: Mapping,
    header: Arc<Header>,
    hash: Hash,
    shelf: Shelf,
    sparse: Found,
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
        let header = Arc::new(header::read(&path, &mut Lines::open(&path)?, &mapping)?);
        let mapping = header.mapping.clone();
        Ok(Self {
            path,
            mapping,
            header,
            hash: Hash::default(),
            shelf: Shelf::default(),
            sparse: Found::default(),
        })
    }

    /// The same file under another mapping; the hash of its bytes stays known, and which of its columns are empty.
    ///
    /// # Errors
    /// As [`Log::with_mapping`].
    pub fn mapped(&self, mapping: Mapping) -> Result<Self, Diagnostics> {
        let (hash, sparse) = (Arc::clone(&self.hash), Arc::clone(&self.sparse));
        Ok(Self { hash, sparse, ..Self::with_mapping(&self.path, mapping)? })
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
        self.header.kind
    }

    /// Names of all columns, as the mapping has them.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.header.columns.iter().map(|column| column.name.as_str())
    }

    /// Whether there is such a column.
    pub fn has(&self, name: &str) -> bool {
        self.columns().any(|column| column == name)
    }

    /// A pass over all rows. The file is opened when the first of them is read, unless the last pass that came to the end
    /// was over the same columns and few enough rows to keep them.
    pub fn rows(&self) -> Reader {
        Reader::of_log(self)
    }

    /// FNV-1a of the file's bytes. Any pass that came to the end has found it, otherwise they are read for it.
    ///
    /// # Errors
    /// A file that cannot be read any more.
    pub fn hash(&self) -> Result<u64, Diagnostic> {
        let cannot = |error| Diagnostic::error(format!("cannot read the file: {error}")).in_file(&self.path);
        if self.hash.get().is_none() {
            let mut source = Hashing::new(input::open(&self.path).map_err(cannot)?, &self.hash);
            io::copy(&mut source, &mut io::sink()).map_err(cannot)?;
        }
        self.hash.get().copied().ok_or_else(|| cannot(io::ErrorKind::UnexpectedEof.into()))
    }

    /// Whether the other is a clone of it.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.header, &other.header)
    }

    pub(super) fn header(&self) -> &Arc<Header> {
        &self.header
    }

    pub(super) fn found_sparse(&self) -> &Found {
        &self.sparse
    }

    pub(super) fn shelf(&self) -> &Shelf {
        &self.shelf
    }

    /// The lines behind the header; whoever reads all of them finds the hash.
    pub(super) fn lines(&self) -> Result<Lines, Diagnostics> {
        let mut lines = match self.hash.get() {
            Some(_) => Lines::open(&self.path)?,
            None => Lines::hashed(&self.path, &self.hash)?,
        };
        if header::read(&self.path, &mut lines, &self.mapping)? == *self.header {
            return Ok(lines);
        }
        let error = Diagnostic::error("the columns of the file have changed since it was opened");
        Err(error.in_file(&self.path).help("let no other program write it meanwhile").into())
    }
}
