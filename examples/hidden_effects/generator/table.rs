//! Measurement files.
use super::{Failure, failure};
use std::fmt::Write;
use std::path::Path;

/// Columns of numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    columns: Vec<(String, usize, Vec<f64>)>,
}

impl Table {
    /// Adds a column that is written with so many decimals.
    pub fn push(&mut self, name: impl Into<String>, decimals: usize, values: Vec<f64>) {
        self.columns.push((name.into(), decimals, values));
    }

    /// The values of a column as they are written.
    #[cfg(test)]
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|column| column.0 == name).map(|column| column.2.as_slice())
    }

    /// The largest size in all columns whose names end so; 0 without any.
    pub fn largest(&self, end: &str) -> f64 {
        let columns = self.columns.iter().filter(|column| column.0.ends_with(end));
        columns.flat_map(|column| &column.2).fold(0.0, |largest: f64, x| largest.max(x.abs()))
    }

    /// How many times larger than all but a hundredth of a column's values its largest one is, at most of all columns whose names end so.
    pub fn peak(&self, end: &str) -> f64 {
        let columns = self.columns.iter().filter(|column| column.0.ends_with(end));
        columns.fold(0.0, |peak, column| {
            let mut sizes: Vec<f64> = column.2.iter().filter(|x| x.is_finite()).map(|x| x.abs()).collect();
            sizes.sort_unstable_by(f64::total_cmp);
            let usual = sizes.get(sizes.len() * 99 / 100).copied().unwrap_or(f64::INFINITY);
            peak.max(sizes.last().map_or(0.0, |largest| largest / usual.max(f64::MIN_POSITIVE)))
        })
    }

    /// Comma-separated with a header; NaN is an empty cell.
    pub fn text(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|column| column.0.as_str()).collect();
        let mut text = names.join(",") + "\n";
        let rows = self.columns.first().map_or(0, |column| column.2.len());
        for row in 0..rows {
            for (i, (_, decimals, values)) in self.columns.iter().enumerate() {
                if i > 0 {
                    text.push(',');
                }
                if values[row].is_finite() {
                    // Adding zero turns −0 into 0. Writing to a string cannot fail.
                    let _ = write!(text, "{:.decimals$}", values[row] + 0.0);
                }
            }
            text.push('\n');
        }
        text
    }

    /// Writes it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        write_text(path, &self.text())
    }
}

/// Writes a file by way of a temporary one.
///
/// # Errors
/// It cannot be written.
pub fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    let temporary = path.with_extension("partial");
    let written = std::fs::write(&temporary, text).and_then(|()| std::fs::rename(&temporary, path));
    written.map_err(|e| failure(format!("{}: {e}", path.display())))
}
