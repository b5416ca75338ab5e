//! Tables of numbers in and out.
use crate::run::{Failure, failure, text};
use std::fmt::Write as _;
use std::path::Path;

/// Columns of a CSV file without its header.
///
/// # Errors
/// A file that cannot be read, or a cell that is no number: with its line.
pub fn read(file: &Path) -> Result<Vec<Vec<f64>>, Failure> {
    let text = text(file)?;
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for (line, row) in text.lines().enumerate().skip(1) {
        for (k, cell) in row.split(',').filter(|cell| !cell.trim().is_empty()).enumerate() {
            let value = cell
                .trim()
                .parse()
                .map_err(|_| failure(format!("{}:{}: `{cell}` is no number", file.display(), line + 1)))?;
            if columns.len() <= k {
                columns.push(Vec::new());
            }
            columns[k].push(value);
        }
    }
    Ok(columns)
}

/// Writes named columns of the same length.
///
/// # Errors
/// A file that cannot be written.
pub fn write(file: &Path, columns: &[(String, &[f64])]) -> Result<(), Failure> {
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let mut text = names.join(",");
    text.push('\n');
    for row in 0..columns.first().map_or(0, |(_, values)| values.len()) {
        for (k, (_, values)) in columns.iter().enumerate() {
            // Writing into a string cannot fail.
            let _ = write!(text, "{}{:.9e}", if k == 0 { "" } else { "," }, values[row]);
        }
        text.push('\n');
    }
    std::fs::write(file, text).map_err(|e| failure(format!("{}: {e}", file.display())))
}
