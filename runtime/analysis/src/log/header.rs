//! The first row: which kind of table it is and which columns it has.
use super::fields::{character, split};
use super::lines::Lines;
use super::mapping::Mapping;
use super::names::{list, shorten};
use super::reader::MOST_ERRORS;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::spelling::suggest;
use std::collections::HashMap;
use std::path::Path;

/// What a row of the table is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// `time` (s): a sample of a log.
    Time,
    /// `posture` (number): the average over one static posture.
    Posture,
    /// `impact` (number): one impact of a foot.
    Impact,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Time, Self::Posture, Self::Impact];
    /// The name of the first column.
    pub const fn column(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Posture => "posture",
            Self::Impact => "impact",
        }
    }
}

/// A column under our name.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Our name, after the mapping.
    pub name: String,
    /// Which field of a row it is, from 0.
    pub field: usize,
    /// value = factor · field + offset
    pub factor: f64,
    /// In the unit of the column.
    pub offset: f64,
}

/// The header, understood.
#[derive(Debug, PartialEq)]
pub(super) struct Header {
    pub kind: Kind,
    /// Fields per row.
    pub fields: usize,
    /// In the order of the file, mapped ones last.
    pub columns: Vec<Column>,
    /// Whether the mapping says what the leading column is, and so in which unit.
    pub mapped: bool,
    /// What was said of its columns, patterns as the columns that they stand for.
    pub mapping: Mapping,
}

/// Reads the header line.
pub(super) fn read(file: &Path, lines: &mut Lines, mapping: &Mapping) -> Result<Header, Diagnostics> {
    match lines.next()? {
        Some((number, line)) => parse(file, line, number, mapping),
        None => {
            let help = "the first line names the columns, such as `time,left_knee/position`";
            Err(Diagnostic::error("the file is empty").in_file(file).help(help).into())
        }
    }
}

/// Understands the header line.
fn parse(file: &Path, line: &str, number: usize, mapping: &Mapping) -> Result<Header, Diagnostics> {
    let at = |d: Diagnostic, offset: usize| d.in_file(file).at(number, character(line, offset));
    let mut fields = Vec::new();
    split(line, &mut fields).map_err(|e| {
        let error = Diagnostic::error("a quotation mark in the header does not enclose a whole name");
        Diagnostics(vec![at(error, e.offset).help("close it on the same line, or drop the quotation marks")])
    })?;
    let names: Vec<&str> = fields.iter().map(|f| &line[f.clone()]).collect();
    if let Some(error) = wrong_separator(line, &names).or_else(|| no_names(&names)) {
        return Err(Diagnostics(vec![at(error, 0)]));
    }
    let mut errors = Vec::new();
    let index = index_of(&names, &mut errors, |error, k| at(error, fields[k].start));
    let mapping = mapping.of_columns(&names).map_err(Diagnostics)?;
    let columns = apply(&mapping, &names, &index, &mut errors);
    let kind =
        Kind::ALL.into_iter().find(|k| columns.iter().any(|c| c.name == k.column() && is_first(c, &mapping)));
    match kind {
        Some(kind) if errors.is_empty() => {
            let mapped = mapping.columns.contains_key(kind.column());
            Ok(Header { kind, fields: names.len(), columns, mapped, mapping })
        }
        Some(_) => Err(Diagnostics(errors)),
        None => {
            errors.push(at(no_kind(&names), 0));
            Err(Diagnostics(errors))
        }
    }
}

/// Where each name stands; names that stand twice are errors, `at` their field.
pub(super) fn index_of<'n>(
    names: &[&'n str],
    errors: &mut Vec<Diagnostic>,
    at: impl Fn(Diagnostic, usize) -> Diagnostic,
) -> HashMap<&'n str, usize> {
    let mut index = HashMap::new();
    for (i, name) in names.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
        if let Some(first) = index.insert(*name, i)
            && errors.len() < MOST_ERRORS
        {
            let message =
                format!("column `{}` appears twice: as number {} and {}", shorten(name), first + 1, i + 1);
            errors.push(at(Diagnostic::error(message), i).help("remove or rename one of them"));
        }
    }
    index
}

/// The leading column is the first of the file unless the mapping file names it.
fn is_first(column: &Column, mapping: &Mapping) -> bool {
    column.field == 0 || mapping.columns.contains_key(&column.name)
}

fn apply(
    mapping: &Mapping,
    names: &[&str],
    index: &HashMap<&str, usize>,
    errors: &mut Vec<Diagnostic>,
) -> Vec<Column> {
    let hidden = |name: &str| name.is_empty() || mapping.hides(name);
    let mut columns: Vec<_> = names
        .iter()
        .enumerate()
        .filter(|(_, name)| !hidden(name))
        .map(|(field, name)| Column { name: (*name).to_owned(), field, factor: 1.0, offset: 0.0 })
        .collect();
    for (name, source) in &mapping.columns {
        let wanted = source.column.as_ref().unwrap_or(name);
        match index.get(wanted.as_str()) {
            Some(&field) => {
                columns.push(Column {
                    name: name.clone(),
                    field,
                    factor: source.factor,
                    offset: source.offset,
                });
            }
            None => errors.push(unknown_source(mapping, source.position, wanted, names)),
        }
    }
    columns
}

fn unknown_source(mapping: &Mapping, position: (usize, usize), wanted: &str, names: &[&str]) -> Diagnostic {
    let mut error = Diagnostic::error(format!("the log has no column `{}`", shorten(wanted)));
    if let Some(file) = &mapping.file {
        error = error.in_file(file).at(position.0, position.1);
    }
    let otherwise = || format!("columns of the log: {}", list(names.iter().copied(), 12));
    error.help(suggest(wanted, names.iter().copied(), otherwise))
}

/// Semicolons or tabs where commas are expected.
pub(super) fn wrong_separator(line: &str, names: &[&str]) -> Option<Diagnostic> {
    let separator = [(';', "semicolons"), ('\t', "tabs")].into_iter().find(|(c, _)| line.contains(*c));
    let (1, Some((_, name))) = (names.len(), separator) else { return None };
    let error = Diagnostic::error(format!("the columns are separated by {name}, expected commas"));
    Some(error.help("export the file with commas between columns and points in numbers"))
}

/// A first line of numbers.
fn no_names(names: &[&str]) -> Option<Diagnostic> {
    names[0].parse::<f64>().is_ok().then(|| {
        let first = shorten(names[0]);
        Diagnostic::error(format!("no header row: the first line starts with the number {first}"))
            .help(
                "put the names of the columns into the first line, such as `time,left_knee/position`; of joint states that \
                 `ros2 topic echo --csv` printed `bipedc log --csv` makes such a log",
            )
    })
}

fn no_kind(names: &[&str]) -> Diagnostic {
    let message = format!(
        "the first column is `{}`, expected `time` (a log), `posture` or `impact`",
        shorten(names[0])
    );
    let help = match names.iter().find(|n| Kind::ALL.iter().any(|k| k.column() == **n)) {
        Some(name) => format!("move column `{name}` to the front"),
        None => format!(
            "name it in a mapping file: time = \"{}\"; `bipedc log` proposes such a file",
            shorten(names[0])
        ),
    };
    Diagnostic::error(message).help(help)
}
