//! A table as it stands, before anything is understood: for those who tell what a file holds, and what is wrong with it.
use super::fields::{character, split};
use super::header::{index_of, wrong_separator};
use super::lines::Lines;
use super::value::is_absent;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Lines of a file as fields. [`super::Reader`] refuses what no calculation can do with; here rows of any length and fields of
/// any kind pass.
pub struct RawRows {
    file: PathBuf,
    lines: Lines,
    names: Option<Vec<String>>,
    /// Of a file without names: its first line, with its number.
    first: Option<(usize, String)>,
    fields: Vec<Range<usize>>,
    text: String,
}

/// A line of a table.
#[derive(Debug, Clone, Copy)]
pub struct RawRow<'a> {
    /// Its number in the file, from 1.
    pub line: usize,
    text: &'a str,
    fields: &'a [Range<usize>],
}

/// What stands in a field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Field<'a> {
    /// A finite number.
    Number(f64),
    /// Nothing, or NaN.
    Absent,
    /// No number, or none that is finite.
    Text(&'a str),
}

impl RawRows {
    /// Opens a CSV or gzip CSV file and reads its names; a first line that begins with a number is a row, not a header.
    ///
    /// # Errors
    /// Not readable, empty, not text, names that stand twice, other separators than commas.
    pub fn open(path: &Path) -> Result<Self, Diagnostics> {
        let file = path.to_path_buf();
        let mut rows = Self {
            lines: Lines::open(path)?,
            file,
            names: None,
            first: None,
            fields: Vec::new(),
            text: String::new(),
        };
        let Some((number, line)) = rows.lines.next()? else {
            let help = "the first line names the columns, such as `time,left_knee/position`";
            return Err(Diagnostic::error("the file is empty").in_file(path).help(help).into());
        };
        let line = line.to_owned();
        rows.divide(number, &line)?;
        let names: Vec<&str> = rows.fields.iter().map(|range| &line[range.clone()]).collect();
        if let Some(error) = wrong_separator(&line, &names) {
            return Err(error.in_file(path).at(number, 1).into());
        }
        if names[0].parse::<f64>().is_ok() {
            rows.first = Some((number, line));
            return Ok(rows);
        }
        let mut errors = Vec::new();
        index_of(&names, &mut errors, |error, k| {
            error.in_file(path).at(number, character(&line, rows.fields[k].start))
        });
        if !errors.is_empty() {
            return Err(Diagnostics(errors));
        }
        rows.names = Some(names.into_iter().map(str::to_owned).collect());
        Ok(rows)
    }

    /// Names of the columns; `None` if the file has none.
    pub fn names(&self) -> Option<&[String]> {
        self.names.as_deref()
    }

    /// The file, for messages.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The next line; `None` at the end.
    ///
    /// # Errors
    /// What is no text; quotation marks that enclose no field.
    pub fn next_row(&mut self) -> Result<Option<RawRow<'_>>, Diagnostic> {
        let number = match self.first.take() {
            Some((number, text)) => {
                self.text = text;
                number
            }
            None => {
                let Some((number, line)) = self.lines.next()? else { return Ok(None) };
                self.text.clear();
                self.text.push_str(line);
                number
            }
        };
        // Both are of `self`, and only the fields change.
        let text = std::mem::take(&mut self.text);
        let divided = self.divide(number, &text);
        self.text = text;
        divided?;
        Ok(Some(RawRow { line: number, text: &self.text, fields: &self.fields }))
    }

    fn divide(&mut self, number: usize, line: &str) -> Result<(), Diagnostic> {
        split(line, &mut self.fields).map_err(|quote| {
            Diagnostic::error("a quotation mark does not enclose a whole field")
                .in_file(&self.file)
                .at(number, character(line, quote.offset))
                .help("remove the quotation marks")
        })
    }
}

impl<'a> RawRow<'a> {
    /// How many fields it has.
    pub fn width(&self) -> usize {
        self.fields.len()
    }

    /// A field, from 0; beyond the last one there is nothing.
    pub fn field(&self, index: usize) -> Field<'a> {
        let Some(text) = self.fields.get(index).map(|range| &self.text[range.clone()]) else {
            return Field::Absent;
        };
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Field::Number(number),
            _ if is_absent(text) => Field::Absent,
            _ => Field::Text(text),
        }
    }

    /// A field as it stands.
    pub fn text(&self, index: usize) -> &'a str {
        self.fields.get(index).map_or("", |range| &self.text[range.clone()])
    }
}
