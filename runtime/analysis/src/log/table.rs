//! A small table as a whole: postures, impacts, short logs.
use super::header::Kind;
use super::names::shorten;
use super::reader::Reader;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};

/// Most numbers that a table may hold: 128 MiB. Longer logs are read in [`super::Blocks`].
pub const LARGEST_TABLE: usize = 1 << 24;

/// Columns of numbers, equally long.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// What a row is.
    pub kind: Kind,
    /// Names of the columns; the first is `time`, `posture` or `impact`.
    pub names: Vec<String>,
    /// One per name, SI units.
    pub columns: Vec<Vec<f64>>,
    /// The line of each row in the file, from 1.
    pub lines: Vec<usize>,
}

impl Table {
    /// Reads what is left of a file; `names` as in [`Reader::select`], missing ones are left out.
    ///
    /// # Errors
    /// As [`Reader::next_row`]; no row at all; more than [`LARGEST_TABLE`] numbers.
    pub fn read<S: AsRef<str>>(mut reader: Reader, names: &[S]) -> Result<Self, Diagnostics> {
        reader.select(names);
        let kind = reader.kind();
        let mut found = vec![kind.column().to_owned()];
        found.extend(names.iter().map(|n| n.as_ref().to_owned()).filter(|n| reader.has(n)));
        let mut table =
            Self { kind, columns: vec![Vec::new(); found.len()], names: found, lines: Vec::new() };
        let mut values = Vec::new();
        while let Some(row) = reader.next_row(&mut values)? {
            for (column, value) in table.columns.iter_mut().zip(&values) {
                column.push(*value);
            }
            table.lines.push(row.line);
            if table.lines.len() * table.names.len() > LARGEST_TABLE {
                let message = format!("the table has more than {LARGEST_TABLE} numbers");
                return Err(Diagnostics(vec![Diagnostic::error(message).in_file(reader.file())]));
            }
        }
        if table.lines.is_empty() {
            return Err(Diagnostics(vec![no_rows(&reader)]));
        }
        Ok(table)
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// One column.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.names.iter().position(|n| n == name).map(|i| self.columns[i].as_slice())
    }
}

/// A header without rows.
pub(super) fn no_rows(reader: &Reader) -> Diagnostic {
    if let Some(absent) = reader.incomplete().first() {
        let name = shorten(&absent.column);
        return Diagnostic::error(format!(
            "no row of the log is complete: `{name}` is empty or NaN in {} of {} rows",
            absent.rows,
            reader.rows()
        ))
        .in_file(reader.file())
        .at(absent.line, 0)
        .help("leave the column out if it was never recorded");
    }
    Diagnostic::error("the file has a header but no rows")
        .in_file(reader.file())
        .help("was the recording stopped before its first sample, or the file cut off?")
}
