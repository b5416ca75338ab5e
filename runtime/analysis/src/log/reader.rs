//! Rows of a table, one at a time.
use super::fields::{character, split};
use super::file::Log;
use super::header::{self, Column, Header, Kind};
use super::in_time::{InTime, Repairs};
use super::kept::Kept;
use super::lines::Lines;
use super::mapping::{ForceFrame, Mapping};
use super::names::may_be_absent;
use super::sparse::Sparse;
use super::spikes::Spikes;
use super::value::{is_absent, parse};
use super::wraps::{Unwrapped, Wraps};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// After so many errors in rows, reading stops: the rest would be more of the same.
pub const MOST_ERRORS: usize = 10;
/// After the first error the reader looks for others in so many lines more.
const LINES_AFTER_ERROR: usize = 10_000;

/// Reads a table row by row; memory does not grow with the file.
pub struct Reader {
    file: PathBuf,
    origin: Origin,
    /// The log that is read, if it is one.
    log: Option<Log>,
    header: Arc<Header>,
    /// Indices into `header.columns`; the leading column first.
    selected: Vec<usize>,
    fields: Vec<Range<usize>>,
    /// Rows that were read and not given away yet.
    in_time: InTime,
    /// Whether the last line was read.
    ended: bool,
    rows: usize,
    /// Samples of the selected positions that may be glitches.
    spikes: Spikes,
    wraps: Wraps,
    /// Columns (indices into `header.columns`) in which numbers were missing.
    incomplete: Vec<(usize, Absent)>,
    /// What the log may keep, as far as it was read.
    keeping: Option<Kept>,
}

/// Where rows come from.
enum Origin {
    /// The lines behind the header.
    Text(Lines),
    /// A log that is not open yet: which columns are wanted may still change.
    Closed,
    /// What an earlier reader of the log left.
    Kept(Arc<Kept>),
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
        let reader = Self::new(log.path(), Origin::Closed, Arc::clone(log.header()));
        Self { log: Some(log.clone()), ..reader }
    }

    fn new(path: &Path, origin: Origin, header: Arc<Header>) -> Self {
        let mut reader = Self {
            file: path.to_path_buf(),
            origin,
            log: None,
            header,
            selected: Vec::new(),
            fields: Vec::new(),
            in_time: InTime::default(),
            ended: false,
            rows: 0,
            spikes: Spikes::default(),
            wraps: Wraps::default(),
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

    /// Whether a column of the file is read under another name, so that its own says nothing.
    pub fn is_renamed(&self, column: &Column) -> bool {
        let mapped = &self.header.mapping.columns;
        let other = |c: &Column| c.field == column.field && mapped.contains_key(&c.name);
        !mapped.contains_key(&column.name) && self.header.columns.iter().any(other)
    }
    /// The line of a mapping file that names a column: file, line and column.
    pub fn named_by(&self, name: &str) -> Option<(&Path, (usize, usize))> {
        let mapping = &self.header.mapping;
        let source = mapping.columns.get(name).filter(|source| source.position.0 > 0)?;
        Some((mapping.file.as_deref()?, source.position))
    }
    /// How empty a column of a log is, if it is too empty to be of use; see [`Log::sparse`].
    pub fn sparse(&self, name: &str) -> Option<&Sparse> {
        self.log.as_ref()?.sparse(name)
    }

    /// The axes of a foot's vector, such as `left_foot/force`.
    pub fn frame(&self, vector: &str) -> ForceFrame {
        self.header.mapping.frames.get(vector).copied().unwrap_or_default()
    }

    /// Chooses what rows consist of: the leading column (time or number), then these, in this order.
    ///
    /// Returns the names that the file does not have; rows have no place for them. Columns that nobody chose
    /// are not even parsed. Of what is no [`Log`] columns are chosen before the first row is read.
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
        self.wraps = Wraps::of(names.iter().copied().filter(|_| self.header.kind == Kind::Time));
        // Whatever was kept, or would have been, is of other columns.
        self.keeping = None;
        (self.in_time, self.ended) = (InTime::default(), false);
        if self.log.is_some() {
            self.origin = Origin::Closed;
        }
        missing
    }

    /// Names of what rows consist of, the leading column first.
    pub(super) fn selected_names(&self) -> impl Iterator<Item = String> {
        self.selected.iter().map(|&index| self.header.columns[index].name.clone())
    }

    /// Reads the next row into `row` (length 1 + number of selected columns); `None` at the end of the file.
    ///
    /// Rows of a log come in the order of their times: rows that are some lines late are sorted in, rows that repeat a time are
    /// left out, see [`Reader::repairs`]. Rows in which a selected column is empty or NaN are passed over and counted, see
    /// [`Reader::incomplete`]; only a centre of pressure may be absent and then is NaN.
    ///
    /// # Errors
    /// Text or infinite fields, empty or NaN ones in tables of postures or impacts and as times, more or fewer fields
    /// than the header, time that stands still or runs back. Up to [`MOST_ERRORS`] are collected.
    pub fn next_row(&mut self, row: &mut Vec<f64>) -> Result<Option<Row>, Diagnostics> {
        self.begin()?;
        while let Some(line) = self.next_in_time(row)? {
            self.rows += 1;
            if self.is_complete(line, row) {
                return Ok(Some(Row { line }));
            }
        }
        Ok(None)
    }

    /// What was put right in the time stamps of what was read so far.
    pub fn repairs(&self) -> Repairs {
        if let Origin::Kept(kept) = &self.origin { kept.repairs } else { self.in_time.repairs() }
    }

    /// Angles to which whole turns were added in what was read so far.
    pub fn unwrapped(&self) -> Vec<Unwrapped> {
        if let Origin::Kept(kept) = &self.origin {
            kept.unwrapped.clone()
        } else {
            self.wraps.found().cloned().collect()
        }
    }

    /// The next row, complete or not: its line.
    fn next_in_time(&mut self, row: &mut Vec<f64>) -> Result<Option<usize>, Diagnostics> {
        if let Origin::Kept(kept) = &self.origin {
            let Some((line, values)) = kept.row(self.rows) else { return Ok(None) };
            row.clear();
            row.extend_from_slice(values);
            return Ok(Some(line));
        }
        loop {
            // Only times can be out of order.
            if let Some(line) = self.in_time.next(self.ended || self.header.kind != Kind::Time, row) {
                self.wraps.unwrap(line, row);
                self.keeping.take_if(|kept| !kept.take(line, row));
                return Ok(Some(line));
            }
            if self.ended {
                self.keep();
                return Ok(None);
            }
            self.read_on(row)?;
        }
    }

    /// Reads one line, or after an error so many more as may have others.
    fn read_on(&mut self, row: &mut Vec<f64>) -> Result<(), Diagnostics> {
        let mut errors = Vec::new();
        let mut first_bad = 0;
        loop {
            let found = errors.len();
            match self.read(row, &mut errors) {
                Ok(more) => self.ended = !more,
                Err(error) => {
                    self.keeping = None;
                    errors.push(error);
                    return Err(Diagnostics(errors));
                }
            }
            if errors.is_empty() {
                return Ok(());
            }
            if found == 0 {
                self.keeping = None;
                first_bad = self.number();
            }
            let enough = errors.len() >= MOST_ERRORS || self.number() > first_bad + LINES_AFTER_ERROR;
            if self.ended || enough {
                errors.truncate(MOST_ERRORS);
                return Err(Diagnostics(errors));
            }
        }
    }

    /// How many rows were given so far, complete or not.
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
        let (Origin::Closed, Some(log)) = (&self.origin, &self.log) else { return Ok(()) };
        let log = log.clone();
        let passed = self.rows;
        if passed == 0 {
            if let Some(kept) = log.shelf().get(&self.selected) {
                self.origin = Origin::Kept(kept);
                return Ok(());
            }
            self.keeping = Some(Kept::of(&self.selected));
        }
        self.origin = Origin::Text(log.lines()?);
        let mut row = Vec::new();
        for _ in 0..passed {
            self.next_in_time(&mut row)?;
        }
        Ok(())
    }

    /// Whether a row has all its numbers; those of a log that are absent are counted.
    fn is_complete(&mut self, line: usize, row: &[f64]) -> bool {
        let mut complete = true;
        if self.header.kind == Kind::Time {
            for (&index, _) in self.selected.iter().zip(row).filter(|(_, value)| value.is_nan()) {
                let column = &self.header.columns[index];
                if !may_be_absent(&column.name) {
                    note_absent(&mut self.incomplete, index, column, line);
                    complete = false;
                }
            }
        }
        complete
    }

    /// At the end of a log without errors: later readers of these columns need not read it again.
    fn keep(&mut self) {
        if let (Some(log), Some(mut kept)) = (&self.log, self.keeping.take()) {
            kept.repairs = self.in_time.repairs();
            kept.unwrapped = self.wraps.found().cloned().collect();
            log.shelf().put(kept);
        }
    }

    /// The line that was read last.
    fn number(&self) -> usize {
        if let Origin::Text(lines) = &self.origin { lines.number() } else { 0 }
    }

    /// One line, false at the end. Errors of single fields go to `errors`.
    fn read(&mut self, row: &mut Vec<f64>, errors: &mut Vec<Diagnostic>) -> Result<bool, Diagnostic> {
        row.clear();
        let Self { origin, header, selected, fields, file, spikes, in_time, .. } = self;
        let Origin::Text(lines) = origin else { return Ok(false) };
        let Some((number, line)) = lines.next()? else { return Ok(false) };
        let mut report = |error: Diagnostic, offset: usize| {
            errors.push(error.in_file(file).at(number, character(line, offset)));
        };
        if let Err((error, offset)) = divide(line, header.fields, fields) {
            report(error, offset);
            return Ok(true);
        }
        for (place, &index) in selected.iter().enumerate() {
            let column = &header.columns[index];
            let range = &fields[column.field];
            // A log may have holes, but a sample without a time is nowhere.
            if header.kind == Kind::Time && place > 0 && is_absent(&line[range.clone()]) {
                row.push(f64::NAN);
                continue;
            }
            match parse(&line[range.clone()], column) {
                Ok(value) => row.push(value),
                Err(error) => report(error, range.start),
            }
        }
        if row.len() < selected.len() {
            return Ok(true);
        }
        if header.kind != Kind::Time {
            in_time.pass(number, row);
            return Ok(true);
        }
        // Where rows are out of order nothing can be said of the way from one to the next.
        if in_time.is_next(row[0]) {
            let place = |k: usize| character(line, fields[header.columns[selected[k]].field].start);
            errors.extend(spikes.next(number, row, &place).into_iter().map(|error| error.in_file(file)));
        }
        if let Err((error, wrong)) = in_time.take(number, row) {
            let start = fields[header.columns[selected[0]].field].start;
            let column = if wrong == number { character(line, start) } else { 0 };
            errors.push(error.in_file(file).at(wrong, column));
        }
        Ok(true)
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

fn note_absent(list: &mut Vec<(usize, Absent)>, index: usize, column: &Column, line: usize) {
    match list.iter_mut().find(|(known, _)| *known == index) {
        Some((_, absent)) => absent.rows += 1,
        None => list.push((index, Absent { column: column.name.clone(), rows: 1, line })),
    }
}

fn ragged(found: usize, expected: usize) -> Diagnostic {
    Diagnostic::error(format!("the row has {found} fields, the header {expected}"))
        .help("was the file cut off here, or is a comma used in numbers?")
}
