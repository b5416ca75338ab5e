//! Rows of a table, one at a time.
use super::fields::{character, split};
use super::file::Log;
use super::header::{self, Column, Header, Kind};
use super::kept::Kept;
use super::lines::Lines;
use super::mapping::{ForceFrame, Mapping};
use super::names::{may_be_absent, shorten};
use super::spikes::Spikes;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::magnitude;
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// After so many errors in rows, reading stops: the rest would be more of the same.
pub const MOST_ERRORS: usize = 10;
/// A time, whatever its unit, before the unit is known.
const LARGEST_TIME: f64 = 1e30;
/// After the first error the reader looks for others in so many lines more.
const LINES_AFTER_ERROR: usize = 10_000;

/// Reads a table row by row; memory does not grow with the file.
pub struct Reader {
    file: PathBuf,
    origin: Origin,
    header: Arc<Header>,
    /// Indices into `header.columns`; the leading column first.
    selected: Vec<usize>,
    fields: Vec<Range<usize>>,
    last_time: f64,
    rows: usize,
    /// Samples of the selected positions that may be glitches.
    spikes: Spikes,
    /// Columns (indices into `header.columns`) in which numbers were missing.
    incomplete: Vec<(usize, Absent)>,
    /// What the log may keep, as far as it was read.
    keeping: Option<(Log, Kept)>,
}

/// Where rows come from.
enum Origin {
    /// The lines behind the header.
    Text(Lines),
    /// A log that is not open yet: which columns are wanted may still change.
    Closed(Log),
    /// What an earlier reader of the log left.
    Kept(Log, Arc<Kept>),
}

/// Samples of a log's column that are empty or NaN. Their rows are passed over: a gap.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Absent {
    /// Name of the column.
    pub column: String,
    /// Rows without a number.
    pub rows: usize,
    /// The first such line in the file, from 1.
    pub line: usize,
}

/// A row was read into the caller's buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Its line in the file, from 1.
    pub line: usize,
}

impl Reader {
    /// Opens a CSV or gzip CSV file and reads its header.
    ///
    /// # Errors
    /// Not readable, empty, not text, no kind of table, duplicate columns, mapped columns that do not exist.
    pub fn open(path: &Path, mapping: &Mapping) -> Result<Self, Diagnostics> {
        Self::with_lines(path, Lines::open(path), mapping)
    }

    /// Reads from any source; `path` is for messages.
    ///
    /// # Errors
    /// As [`Reader::open`].
    pub fn from_source(path: &Path, source: Box<dyn Read>, mapping: &Mapping) -> Result<Self, Diagnostics> {
        Self::with_lines(path, Lines::new(path, source), mapping)
    }

    fn with_lines(
        path: &Path,
        lines: Result<Lines, Diagnostic>,
        mapping: &Mapping,
    ) -> Result<Self, Diagnostics> {
        let mut lines = lines?;
        let header = header::read(path, &mut lines, mapping)?;
        Ok(Self::new(path, Origin::Text(lines), Arc::new(header)))
    }

    /// The rows of a log, from its first.
    pub(super) fn of_log(log: &Log) -> Self {
        Self::new(log.path(), Origin::Closed(log.clone()), Arc::clone(log.header()))
    }

    fn new(path: &Path, origin: Origin, header: Arc<Header>) -> Self {
        let mut reader = Self {
            file: path.to_path_buf(),
            origin,
            header,
            selected: Vec::new(),
            fields: Vec::new(),
            last_time: f64::NAN,
            rows: 0,
            spikes: Spikes::default(),
            incomplete: Vec::new(),
            keeping: None,
        };
        reader.select::<&str>(&[]);
        reader
    }

    /// The file, for messages.
    pub fn file(&self) -> &Path {
        &self.file
    }
    /// What a row is.
    pub fn kind(&self) -> Kind {
        self.header.kind
    }
    /// All columns under our names, the selected and the ignored ones.
    pub fn columns(&self) -> impl Iterator<Item = &Column> {
        self.header.columns.iter()
    }
    /// Whether the mapping names the leading column, and so says its unit.
    pub fn leading_is_mapped(&self) -> bool {
        self.header.mapped
    }
    /// Whether there is such a column.
    pub fn has(&self, name: &str) -> bool {
        self.header.columns.iter().any(|c| c.name == name)
    }

    /// The axes of a foot's vector, such as `left_foot/force`.
    pub fn frame(&self, vector: &str) -> ForceFrame {
        self.header.mapping.frames.get(vector).copied().unwrap_or_default()
    }

    /// Chooses what rows consist of: the leading column (time or number), then these, in this order.
    ///
    /// Returns the names that the file does not have; rows have no place for them. Columns that nobody chose
    /// are not even parsed.
    pub fn select<S: AsRef<str>>(&mut self, names: &[S]) -> Vec<String> {
        let find = |name: &str| self.header.columns.iter().position(|c| c.name == name);
        let mut missing = Vec::new();
        let mut selected: Vec<usize> = find(self.header.kind.column()).into_iter().collect();
        for name in names {
            match find(name.as_ref()) {
                Some(index) => selected.push(index),
                None => missing.push(name.as_ref().to_owned()),
            }
        }
        self.selected = selected;
        let names: Vec<&str> =
            self.selected.iter().map(|&index| self.header.columns[index].name.as_str()).collect();
        self.spikes = Spikes::of(&names);
        // Whatever was kept, or would have been, is of other columns.
        self.keeping = None;
        if let Origin::Kept(log, _) = &self.origin {
            self.origin = Origin::Closed(log.clone());
        }
        missing
    }

    /// Reads the next row into `row` (length 1 + number of selected columns); `None` at the end of the file.
    ///
    /// Rows of a log in which a selected column is empty or NaN are passed over and counted, see
    /// [`Reader::incomplete`]; only a centre of pressure may be absent and then is NaN.
    ///
    /// # Errors
    /// Text or infinite fields, empty or NaN ones in tables of postures or impacts and as times, more or fewer fields
    /// than the header, time that stands still or runs back. Up to [`MOST_ERRORS`] are collected.
    pub fn next_row(&mut self, row: &mut Vec<f64>) -> Result<Option<Row>, Diagnostics> {
        self.begin()?;
        if let Origin::Kept(..) = &self.origin {
            return Ok(self.again(row));
        }
        let mut errors = Vec::new();
        let mut first_bad = 0;
        loop {
            let found = errors.len();
            let line = match self.read(row, &mut errors) {
                Ok(line) => line,
                Err(error) => {
                    self.keeping = None;
                    errors.push(error);
                    return Err(Diagnostics(errors));
                }
            };
            if found == 0 && errors.is_empty() {
                match line {
                    Some((_, false)) => continue,
                    Some((line, true)) => return Ok(Some(Row { line })),
                    None => {
                        self.keep();
                        return Ok(None);
                    }
                }
            }
            if found == 0 {
                self.keeping = None;
                first_bad = self.number();
            }
            let enough = errors.len() >= MOST_ERRORS || self.number() > first_bad + LINES_AFTER_ERROR;
            if line.is_none() || enough {
                errors.truncate(MOST_ERRORS);
                return Err(Diagnostics(errors));
            }
        }
    }

    /// How many rows were read so far.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns with missing numbers in what was read so far, the worst first.
    pub fn incomplete(&self) -> Vec<&Absent> {
        let mut list: Vec<&Absent> = self.incomplete.iter().map(|(_, absent)| absent).collect();
        list.sort_by_key(|absent| std::cmp::Reverse(absent.rows));
        list
    }

    /// Opens a log, or takes what was kept of these columns; so many rows as were read already are passed over.
    fn begin(&mut self) -> Result<(), Diagnostics> {
        let Origin::Closed(log) = &self.origin else { return Ok(()) };
        let log = log.clone();
        if self.rows == 0 {
            if let Some(kept) = log.shelf().get(&self.selected) {
                self.origin = Origin::Kept(log, kept);
                return Ok(());
            }
            self.keeping = Some((log.clone(), Kept::of(&self.selected)));
        }
        let mut lines = log.lines()?;
        for _ in 0..self.rows {
            lines.next()?;
        }
        self.origin = Origin::Text(lines);
        Ok(())
    }

    /// The next complete row of those that were kept.
    fn again(&mut self, row: &mut Vec<f64>) -> Option<Row> {
        row.clear();
        let Origin::Kept(_, kept) = &self.origin else { return None };
        while let Some((line, values)) = kept.row(self.rows) {
            self.rows += 1;
            let mut complete = true;
            for (&index, value) in self.selected.iter().zip(values) {
                let column = &self.header.columns[index];
                if self.header.kind == Kind::Time && value.is_nan() && !may_be_absent(&column.name) {
                    note_absent(&mut self.incomplete, index, column, line);
                    complete = false;
                }
            }
            if complete {
                row.extend_from_slice(values);
                return Some(Row { line });
            }
        }
        None
    }

    /// At the end of a log without errors: later readers of these columns need not read it again.
    fn keep(&mut self) {
        if let Some((log, kept)) = self.keeping.take() {
            log.shelf().put(kept);
        }
    }

    /// The line that was read last.
    fn number(&self) -> usize {
        if let Origin::Text(lines) = &self.origin { lines.number() } else { 0 }
    }

    /// One line: its number and whether it is complete, or `None` at the end. Errors of single fields go to `errors`.
    fn read(
        &mut self,
        row: &mut Vec<f64>,
        errors: &mut Vec<Diagnostic>,
    ) -> Result<Option<(usize, bool)>, Diagnostic> {
        row.clear();
        let Self { origin, header, selected, fields, file, incomplete, spikes, keeping, .. } = self;
        let Origin::Text(lines) = origin else { return Ok(None) };
        let Some((number, line)) = lines.next()? else { return Ok(None) };
        self.rows += 1;
        let mut report = |error: Diagnostic, offset: usize| {
            errors.push(error.in_file(file).at(number, character(line, offset)));
        };
        if let Err((error, offset)) = divide(line, header.fields, fields) {
            report(error, offset);
            return Ok(Some((number, true)));
        }
        let mut complete = true;
        for (place, &index) in selected.iter().enumerate() {
            let column = &header.columns[index];
            let range = &fields[column.field];
            // A log may have holes, but a sample without a time is nowhere.
            if header.kind == Kind::Time && place > 0 && is_absent(&line[range.clone()], column) {
                note_absent(incomplete, index, column, number);
                row.push(f64::NAN);
                complete = false;
                continue;
            }
            match parse(&line[range.clone()], column) {
                Ok(value) => row.push(value),
                Err(error) => report(error, range.start),
            }
        }
        if header.kind == Kind::Time && row.len() == selected.len() {
            if let Some(error) = out_of_order(self.last_time, row[0]) {
                report(error, fields[header.columns[selected[0]].field].start);
            }
            self.last_time = row[0];
            let place = |k: usize| character(line, fields[header.columns[selected[k]].field].start);
            errors.extend(spikes.next(number, row, &place).into_iter().map(|error| error.in_file(file)));
        }
        keeping.take_if(|(_, kept)| !kept.take(number, row));
        Ok(Some((number, complete)))
    }
}

/// The fields of a line, as many as are expected; else what is wrong, and at which byte.
fn divide(line: &str, expected: usize, fields: &mut Vec<Range<usize>>) -> Result<(), (Diagnostic, usize)> {
    split(line, fields).map_err(|quote| {
        let error = Diagnostic::error("a quotation mark does not enclose a whole field");
        (error.help("remove the quotation marks"), quote.offset)
    })?;
    if fields.len() == expected { Ok(()) } else { Err((ragged(fields.len(), expected), 0)) }
}

/// Whether a column that must be there is empty or NaN.
fn is_absent(text: &str, column: &Column) -> bool {
    let nan = || text.trim_start_matches(['+', '-']).eq_ignore_ascii_case("nan");
    (text.is_empty() || nan()) && !may_be_absent(&column.name)
}

fn note_absent(list: &mut Vec<(usize, Absent)>, index: usize, column: &Column, line: usize) {
    match list.iter_mut().find(|(known, _)| *known == index) {
        Some((_, absent)) => absent.rows += 1,
        None => list.push((index, Absent { column: column.name.clone(), rows: 1, line })),
    }
}

/// Time must increase; `last` is NaN before the first row, which passes both comparisons.
fn out_of_order(last: f64, time: f64) -> Option<Diagnostic> {
    if time == last {
        let help = "every sample needs its own time: remove the repeated row, or log time with more digits";
        return Some(Diagnostic::error(format!("time stands still at {time} s")).help(help));
    }
    let help = "sort the rows by time, or split the file where a new recording starts";
    (time < last).then(|| Diagnostic::error(format!("time runs back from {last} s to {time} s")).help(help))
}

/// Parses one field and applies the mapping.
fn parse(text: &str, column: &Column) -> Result<f64, Diagnostic> {
    let name = shorten(&column.name);
    if text.is_empty() {
        return if may_be_absent(&column.name) {
            Ok(f64::NAN)
        } else {
            let help = "every row needs a number here: repair the recording, or remove the row";
            Err(Diagnostic::error(format!("`{name}`: the field is empty, expected a number")).help(help))
        };
    }
    let Ok(raw) = text.parse::<f64>() else {
        return Err(Diagnostic::error(format!("`{name}`: expected a number, found `{}`", shorten(text)))
            .help("numbers are written like 12, -0.5 or 1.2e-3, without a unit"));
    };
    let value = column.factor * raw + column.offset;
    // Times in nanoseconds are told as such once their steps are known.
    let largest = if column.name == "time" { LARGEST_TIME } else { magnitude::LARGEST };
    if value.abs() <= largest || raw.is_nan() && may_be_absent(&column.name) {
        return Ok(value);
    }
    let what = if raw.is_nan() { "NaN (not a number)" } else { "infinite or too large" };
    let more = if value.is_finite() { format!(" (at most {largest:e})") } else { String::new() };
    Err(Diagnostic::error(format!("`{name}`: the value is {what}{more}: `{}`", shorten(text)))
        .help("remove the row or repair the recording"))
}

fn ragged(found: usize, expected: usize) -> Diagnostic {
    Diagnostic::error(format!("the row has {found} fields, the header {expected}"))
        .help("was the file cut off here, or is a comma used in numbers?")
}
