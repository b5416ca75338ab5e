//! A log in overlapping pieces, each of one stretch of time without gaps.
use super::beginning::without_jolt;
use super::in_time::Repairs;
use super::names::shorten;
use super::reader::{Reader, Row};
use super::table::no_rows;
use super::wraps::Unwrapped;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::collections::VecDeque;
use std::ops::Range;

/// Rows that are read before the sampling step is known.
const PROBE: usize = 4096;
/// A pause of more steps than this is a gap; shorter ones (two lost samples) are bridged by interpolation.
const GAP_STEPS: f64 = 3.5;
/// Steps may differ by so much and still count as equal: times are logged with few digits.
const UNIFORM: f64 = 0.01;
/// Steps that are longer are no seconds, s.
const SLOWEST: f64 = 0.999;
/// A block has at least so many samples, so that short logs are one block.
const BLOCK: usize = 1 << 14;
/// Most gaps that get a warning of their own.
pub const MOST_GAPS: usize = 10;

/// The sampling step, from the first rows of a log.
pub struct Sampling {
    reader: Reader,
    first: VecDeque<(Row, Vec<f64>)>,
    step: f64,
    /// That the log begins with a jolt, whose rows were left out.
    jolt: Option<Diagnostic>,
}

impl Sampling {
    /// Reads the first rows (columns as selected in the reader) and takes the median step.
    ///
    /// # Errors
    /// As [`Reader::next_row`]; no row or only one; times that are no seconds, unless the mapping says so.
    pub fn probe(mut reader: Reader) -> Result<Self, Diagnostics> {
        let mut first = VecDeque::new();
        let mut values = Vec::new();
        while first.len() < PROBE {
            let Some(row) = reader.next_row(&mut values)? else { break };
            first.push_back((row, values.clone()));
        }
        let mut steps: Vec<f64> =
            first.iter().zip(first.iter().skip(1)).map(|(a, b)| b.1[0] - a.1[0]).collect();
        if steps.is_empty() {
            let error = match first.front() {
                None => no_rows(&reader),
                Some((row, _)) => Diagnostic::error("the log has only one row")
                    .in_file(reader.file())
                    .at(row.line, 0)
                    .help("velocities and accelerations need at least a second of samples"),
            };
            return Err(Diagnostics(vec![error]));
        }
        let latest = first.back().map_or(0.0, |(_, values)| values[0]);
        let step = usual_step(&mut steps, latest);
        match first.front().and_then(|(row, _)| other_unit(&reader, *row, step)) {
            Some(error) => Err(Diagnostics(vec![error])),
            None => {
                let jolt = without_jolt(&reader, &mut first);
                Ok(Self { reader, first, step, jolt })
            }
        }
    }

    /// The median step, s.
    pub fn step(&self) -> f64 {
        self.step
    }
}

/// The usual one of at least one step between time stamps, the latest of which is given: the median. Where rounding of the stamps
/// shows in it (in seconds since 1970 they are multiples of 0.24 µs, and so is every step), the mean of those near it.
pub fn usual_step(steps: &mut [f64], latest: f64) -> f64 {
    /// Rounding of time stamps, in parts of a step, that shows in the rate of a log.
    const COARSE: f64 = 1e-7;
    let middle = steps.len() / 2;
    let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    if latest.abs() * f64::EPSILON <= COARSE * median {
        return median;
    }
    let near = || steps.iter().filter(|step| (**step - median).abs() <= 0.5 * median.abs());
    near().sum::<f64>() / near().count().max(1) as f64
}

/// Robots are sampled between 10 Hz and 10 kHz: steps beyond that tell the unit of the time column.
fn other_unit(reader: &Reader, row: Row, step: f64) -> Option<Diagnostic> {
    if step < SLOWEST || reader.leading_is_mapped() {
        return None;
    }
    let (unit, scale) = match step {
        1e5.. => ("nanoseconds", "1e-9"),
        100.0.. => ("microseconds", "1e-6"),
        _ => ("milliseconds", "1e-3"),
    };
    let message =
        format!("the samples are {step} s apart: the column `time` seems to be in {unit}, expected seconds");
    let help = format!(
        "say so in a mapping file (--mapping): time = {{ scale = {scale} }}; if it really is in seconds: time = {{ scale = 1 }}"
    );
    Some(Diagnostic::error(message).in_file(reader.file()).at(row.line, 0).help(help))
}

/// What was seen of the sampling while the log was read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SamplingReport {
    /// Shortest and longest step that is no gap, s.
    pub steps: Option<(f64, f64)>,
    /// Line of the first step that differs from the median by more than a hundredth.
    pub first_uneven: Option<usize>,
    /// Number of gaps.
    pub gaps: usize,
    /// Stretches without gaps that had samples to judge.
    pub segments: usize,
    /// Warnings about gaps and stretches too short to use.
    pub warnings: Vec<Diagnostic>,
}

/// One piece of a log.
#[derive(Debug)]
pub struct Block<'a> {
    /// Times of the samples, s.
    pub time: &'a [f64],
    /// The selected columns without the time, each as long as `time`.
    pub columns: &'a [Vec<f64>],
    /// The samples that this block is there for, never none; those around them feed the filter.
    pub core: Range<usize>,
    /// Time at which the stretch without gaps began, s.
    pub start: f64,
    /// Whether all steps are equal, so that nothing needs to be resampled.
    pub uniform: bool,
}

/// Cuts a log into blocks. Memory: a block and its overlaps, whatever the length of the file.
///
/// The core of a block leaves out the samples within `trim` seconds of the ends of its stretch (the ends of
/// the log, and both sides of a gap) and those less than `overlap` samples from where the block was cut.
/// All cores together are all other samples, each once, but for those that [`Blocks::between`] leaves out.
pub struct Blocks {
    sampling: Sampling,
    overlap: usize,
    trim: f64,
    /// First and last time that count, s.
    limits: (f64, f64),
    time: Vec<f64>,
    columns: Vec<Vec<f64>>,
    /// Samples before this index were in a core or dropped.
    done: usize,
    start: f64,
    pending: Option<(Row, Vec<f64>)>,
    at_end: bool,
    /// Whether missing numbers were reported.
    noted: bool,
    report: SamplingReport,
}

impl Blocks {
    /// `overlap` in samples, `trim` in s.
    pub fn new(sampling: Sampling, overlap: usize, trim: f64) -> Self {
        let width = sampling.first.front().map_or(1, |(_, values)| values.len()) - 1;
        Self {
            sampling,
            overlap,
            trim,
            limits: (f64::NEG_INFINITY, f64::INFINITY),
            time: Vec::new(),
            columns: vec![Vec::new(); width],
            done: 0,
            start: 0.0,
            pending: None,
            at_end: false,
            noted: false,
            report: SamplingReport::default(),
        }
    }

    /// Only samples from the first to the second of these times (of the log's own clock, s) count; others still feed the
    /// filter.
    pub fn between(self, from: Option<f64>, to: Option<f64>) -> Self {
        let limits = (from.unwrap_or(f64::NEG_INFINITY), to.unwrap_or(f64::INFINITY));
        Self { limits, ..self }
    }

    /// What was seen so far; complete after the last block.
    pub fn report(&self) -> &SamplingReport {
        &self.report
    }
    /// The reader behind it.
    pub fn reader(&self) -> &Reader {
        &self.sampling.reader
    }

    /// The next block with a core that is not empty; `None` at the end.
    ///
    /// # Errors
    /// As [`Reader::next_row`].
    pub fn next_block(&mut self) -> Result<Option<Block<'_>>, Diagnostics> {
        loop {
            if self.at_end && self.pending.is_none() {
                self.note_incomplete();
                return Ok(None);
            }
            let ended = self.fill()?;
            let core = self.core(ended);
            if ended {
                self.at_end |= self.pending.is_none();
                self.note_segment(&core);
            }
            if core.is_empty() {
                continue;
            }
            self.done = core.end;
            let core = self.within(core);
            if !core.is_empty() {
                let uniform = self.is_uniform();
                let (time, columns, start) = (&self.time, &self.columns, self.start);
                return Ok(Some(Block { time, columns, core, start, uniform }));
            }
        }
    }

    /// Drops what is no longer needed and reads until the block is full (false) or its stretch ends (true).
    fn fill(&mut self) -> Result<bool, Diagnostics> {
        if let Some((row, values)) = self.pending.take() {
            self.clear(self.time.len());
            self.done = 0;
            self.start = values[0];
            self.push(row, &values);
        } else {
            self.clear(self.done.saturating_sub(self.overlap));
        }
        let more = BLOCK.max(4 * self.overlap) + self.overlap;
        self.time.reserve_exact(more);
        self.columns.iter_mut().for_each(|column| column.reserve_exact(more));
        let full = self.time.len() + more;
        while self.time.len() < full {
            let Some((row, values)) = self.next_row()? else { return Ok(true) };
            let Some(&last) = self.time.last() else {
                self.start = values[0];
                self.push(row, &values);
                continue;
            };
            if values[0] - last > GAP_STEPS * self.sampling.step {
                self.note_gap(row, last, values[0]);
                self.pending = Some((row, values));
                return Ok(true);
            }
            self.push(row, &values);
        }
        Ok(false)
    }

    fn clear(&mut self, count: usize) {
        self.time.drain(..count);
        for column in &mut self.columns {
            column.drain(..count);
        }
        self.done = self.done.saturating_sub(count);
    }

    fn next_row(&mut self) -> Result<Option<(Row, Vec<f64>)>, Diagnostics> {
        if let Some(row) = self.sampling.first.pop_front() {
            return Ok(Some(row));
        }
        let mut values = Vec::with_capacity(self.columns.len() + 1);
        Ok(self.sampling.reader.next_row(&mut values)?.map(|row| (row, values)))
    }

    fn push(&mut self, row: Row, values: &[f64]) {
        if let Some(&last) = self.time.last() {
            let step = values[0] - last;
            let (shortest, longest) = self.report.steps.unwrap_or((step, step));
            self.report.steps = Some((shortest.min(step), longest.max(step)));
            if self.report.first_uneven.is_none() && !self.is_even(step) {
                self.report.first_uneven = Some(row.line);
            }
        }
        self.time.push(values[0]);
        for (column, value) in self.columns.iter_mut().zip(&values[1..]) {
            column.push(*value);
        }
    }

    fn is_even(&self, step: f64) -> bool {
        (step - self.sampling.step).abs() <= UNIFORM * self.sampling.step
    }

    fn is_uniform(&self) -> bool {
        self.time.windows(2).all(|pair| self.is_even(pair[1] - pair[0]))
    }

    fn core(&self, ended: bool) -> Range<usize> {
        // Half a step of slack: 0.5 s after 0.1 s is not exactly 0.6 s.
        let slack = 0.5 * self.sampling.step;
        let Some(&last) = self.time.last() else { return 0..0 };
        let begin = self.time.partition_point(|t| *t < self.start + self.trim - slack).max(self.done);
        let cut = if ended { 0 } else { self.overlap };
        let end = self
            .time
            .partition_point(|t| *t <= last - self.trim + slack)
            .min(self.time.len().saturating_sub(cut));
        begin..end.max(begin)
    }

    /// Those samples of a core whose times count.
    fn within(&self, core: Range<usize>) -> Range<usize> {
        let begin = core.start.max(self.time.partition_point(|t| *t < self.limits.0));
        let end = core.end.min(self.time.partition_point(|t| *t <= self.limits.1));
        begin..end.max(begin)
    }

    fn note_gap(&mut self, row: Row, from: f64, to: f64) {
        self.report.gaps += 1;
        if self.report.gaps <= MOST_GAPS {
            let message = format!(
                "gap of {:.4} s in the log, from {from} s to {to} s (the sampling step is {:.4} s)",
                to - from,
                self.sampling.step
            );
            let help = format!(
                "derivatives across a gap are not trusted: {} s on either side are left out of the error",
                self.trim
            );
            self.report.warnings.push(
                Diagnostic::warning(message).in_file(self.sampling.reader.file()).at(row.line, 0).help(help),
            );
        }
    }

    /// Says once, at the end of the log, where numbers were missing.
    fn note_incomplete(&mut self) {
        if std::mem::replace(&mut self.noted, true) {
            return;
        }
        let reader = &self.sampling.reader;
        self.report.warnings.extend(repaired(reader));
        self.report.warnings.extend(self.sampling.jolt.take());
        let absent = reader.incomplete();
        for column in absent.iter().take(MOST_GAPS) {
            let message = format!(
                "`{}` is empty or NaN in {} of {} rows, first in this line: these rows do not count",
                shorten(&column.column),
                column.rows,
                reader.rows()
            );
            let help = "one or two lost samples are bridged by interpolation, longer stretches are gaps";
            self.report
                .warnings
                .push(Diagnostic::warning(message).in_file(reader.file()).at(column.line, 0).help(help));
        }
        if absent.len() > MOST_GAPS {
            let message = format!("{} columns have missing numbers; {MOST_GAPS} are listed", absent.len());
            self.report.warnings.push(Diagnostic::warning(message).in_file(reader.file()));
        }
    }

    /// Counts a stretch that has ended; one that gave no sample deserves a warning.
    fn note_segment(&mut self, core: &Range<usize>) {
        let Some((&last, length)) = self.time.last().map(|t| (t, self.time.len())) else { return };
        if self.done > 0 || !core.is_empty() {
            self.report.segments += 1;
        } else if self.report.gaps > 0 && self.report.gaps <= MOST_GAPS {
            let message =
                format!("{length} samples from {} s to {last} s are too short a stretch to use", self.start);
            let help = format!("a stretch between gaps must last more than {} s", 2.0 * self.trim);
            self.report
                .warnings
                .push(Diagnostic::warning(message).in_file(self.sampling.reader.file()).help(help));
        }
    }
}

/// What had to be put right in time stamps and angles.
fn repaired(reader: &Reader) -> Vec<Diagnostic> {
    let Repairs { late, doubled } = reader.repairs();
    let rows = reader.rows() + doubled.0;
    let said = |(count, line): (usize, usize), what: &str, help: &str| {
        let message = format!("{count} of {rows} rows {what}");
        (count > 0)
            .then(|| Diagnostic::warning(message).in_file(reader.file()).at(line, 0).help(help.to_owned()))
    };
    let sorted = said(
        late,
        "stand behind rows of a later time, first in this line: they were sorted in",
        "the recorder or its export does not keep the order; nothing else is to be done",
    );
    let left_out = said(
        doubled,
        "repeat the time of another row, first in this line: they were left out",
        "if they are samples of their own, log time with more digits",
    );
    [sorted, left_out]
        .into_iter()
        .flatten()
        .chain(reader.unwrapped().iter().map(|angle| turned(reader, angle)))
        .collect()
}

fn turned(reader: &Reader, angle: &Unwrapped) -> Diagnostic {
    let Unwrapped { column, times, line } = angle;
    let message = format!(
        "`{column}` jumps by a whole turn {times} times, first in this line: it is read as one angle that goes on"
    );
    Diagnostic::warning(message)
        .in_file(reader.file())
        .at(*line, 0)
        .help("it was wrapped at ±π or the like; nothing else is to be done")
}

#[cfg(test)]
mod tests {
    use super::usual_step;

    #[test]
    fn stamps_since_1970_keep_their_rate() {
        for begin in [0.0, 1.7e9 + 0.123_457] {
            let stamps: Vec<f64> = (0..2000).map(|k| begin + 0.005 * f64::from(k)).collect();
            let mut steps: Vec<f64> = stamps.windows(2).map(|pair| pair[1] - pair[0]).collect();
            // A gap and a hurried sample do not count.
            (steps[7], steps[11]) = (0.4, 1e-4);
            let step = usual_step(&mut steps, stamps[1999]);
            assert!((step / 0.005 - 1.0).abs() < 1e-7, "{begin}: {step}");
        }
        assert_eq!(usual_step(&mut [0.01], 1.7e9), 0.01);
    }
}
