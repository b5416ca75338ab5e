//! Rows of a log in the order of their times: recorders write some a little late, and some twice.
//!
//! A few rows wait before they are given away, so that those that come late can take their places. What cannot be put right is
//! a clock that runs back: then two stretches of time would be mixed.
use bipedc_effects::diagnostic::Diagnostic;
use std::collections::VecDeque;

/// Rows that wait: so many lines late a row may be.
pub const REACH: usize = 64;
/// So many rows may have one time. More of them, and the clock is too coarse to tell samples apart.
const MOST_ALIKE: usize = 4;
/// Late rows that would be mixed with so many that were there already are a second recording, no late rows.
const MIXED: usize = 3;

/// What was put right in a log's time stamps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Rows that stood behind rows of a later time, and the first such line.
    pub late: (usize, usize),
    /// Rows that repeat the time of another and were left out, and the first such line.
    pub doubled: (usize, usize),
}

/// The rows that wait, and what is known of the clock.
#[derive(Debug, Default)]
pub(super) struct InTime {
    /// In the order of their times.
    waiting: VecDeque<Waiting>,
    /// Buffers of rows that were given away.
    spare: Vec<Vec<f64>>,
    /// Rows that came so far.
    came: usize,
    /// Time of the last row that came.
    last: Option<f64>,
    latest: Option<f64>,
    /// Time of the row that was given away last.
    given: Option<f64>,
    /// Where time ran back last, and where farthest.
    back: Option<Back>,
    farthest: Option<Back>,
    /// A clock that ran back was told of already.
    told: bool,
    repairs: Repairs,
}

#[derive(Debug)]
struct Waiting {
    line: usize,
    /// How many rows came before it.
    came: usize,
    /// Rows of this time.
    alike: usize,
    values: Vec<f64>,
}

/// A row with an earlier time than the row before it.
#[derive(Debug, Clone, Copy)]
struct Back {
    line: usize,
    came: usize,
    from: f64,
    to: f64,
}

impl InTime {
    /// Whether a row of this time comes after all others.
    pub fn is_next(&self, time: f64) -> bool {
        self.latest.is_none_or(|latest| time > latest)
    }

    /// Takes a row of a log, its time first.
    ///
    /// # Errors
    /// A clock that runs back or stands still, at this line; told once.
    pub fn take(&mut self, line: usize, row: &[f64]) -> Result<(), (Diagnostic, usize)> {
        let Some(&time) = row.first() else { return Ok(()) };
        let result = match self.place(time) {
            Some(same) => self.merge(same, line, row),
            None => self.insert(line, time, row),
        };
        self.came += 1;
        result.inspect_err(|_| self.told = true)
    }

    /// Takes a row of a table that has no clock.
    pub fn pass(&mut self, line: usize, row: &[f64]) {
        self.push(self.waiting.len(), line, row);
    }

    /// Gives the earliest row away: its line. `all`: none are waited for any more.
    pub fn next(&mut self, all: bool, row: &mut Vec<f64>) -> Option<usize> {
        if !all && self.waiting.len() <= REACH {
            return None;
        }
        let first = self.waiting.pop_front()?;
        row.clear();
        row.extend_from_slice(&first.values);
        self.given = first.values.first().copied();
        self.spare.push(first.values);
        Some(first.line)
    }

    /// What was put right so far.
    pub fn repairs(&self) -> Repairs {
        self.repairs
    }

    /// The waiting row of the same time.
    fn place(&self, time: f64) -> Option<usize> {
        let place = self.waiting.partition_point(|row| row.values[0] < time);
        self.waiting.get(place).is_some_and(|row| row.values[0] == time).then_some(place)
    }

    /// A second row of a time: what the first one lacks is taken over.
    fn merge(&mut self, place: usize, line: usize, row: &[f64]) -> Result<(), (Diagnostic, usize)> {
        let first = &mut self.waiting[place];
        let same = |(a, b): (&f64, &f64)| a == b || a.is_nan() && b.is_nan();
        let copy = first.values.iter().zip(row).all(same);
        for (value, other) in first.values.iter_mut().zip(row).filter(|(value, _)| value.is_nan()) {
            *value = *other;
        }
        first.alike += usize::from(!copy);
        let alike = first.alike;
        note(&mut self.repairs.doubled, line);
        if alike > MOST_ALIKE && !self.told {
            return Err((stands_still(row[0], alike), line));
        }
        // A stretch that was written twice, to the last digit, is no clock that ran back.
        if copy { Ok(()) } else { self.clock(line, row[0]) }
    }

    fn insert(&mut self, line: usize, time: f64, row: &[f64]) -> Result<(), (Diagnostic, usize)> {
        let next = self.is_next(time);
        let place = self.waiting.partition_point(|other| other.values[0] < time);
        let clock = self.clock(line, time);
        self.push(place, line, row);
        if !next {
            note(&mut self.repairs.late, line);
        }
        clock
    }

    fn push(&mut self, place: usize, line: usize, row: &[f64]) {
        let mut values = self.spare.pop().unwrap_or_default();
        values.clear();
        values.extend_from_slice(row);
        self.waiting.insert(place, Waiting { line, came: self.came, alike: 1, values });
    }

    /// Whether the clock has run back, as far as this row tells.
    fn clock(&mut self, line: usize, time: f64) -> Result<(), (Diagnostic, usize)> {
        let last = self.last.replace(time);
        if let Some(from) = last.filter(|last| time < *last) {
            let back = Back { line, came: self.came, from, to: time };
            self.back = Some(back);
            if self.farthest.is_none_or(|far| from - time > far.from - far.to) {
                self.farthest = Some(back);
            }
        } else if self.is_next(time) {
            self.back = None;
        }
        self.latest = Some(self.latest.map_or(time, |latest| latest.max(time)));
        if self.told {
            return Ok(());
        }
        // What waits for longer than a late row would is of another stretch of time.
        let stuck = self.waiting.back().is_some_and(|row| row.came + 2 * REACH < self.came);
        let too_late = self.given.is_some_and(|given| time <= given);
        let wrong = match self.back {
            _ if stuck => self.farthest,
            Some(back) if too_late || self.mixed(back, time) => Some(back),
            _ => None,
        };
        wrong.map_or(Ok(()), |back| Err((runs_back(back), back.line)))
    }

    /// Whether the rows since time ran back would stand between rows that came before.
    fn mixed(&self, back: Back, time: f64) -> bool {
        let between = |row: &&Waiting| row.came < back.came && (back.to..time).contains(&row.values[0]);
        self.waiting.iter().filter(between).nth(MIXED).is_some()
    }
}

fn note(counter: &mut (usize, usize), line: usize) {
    *counter = (counter.0 + 1, if counter.0 == 0 { line } else { counter.1 });
}

fn runs_back(back: Back) -> Diagnostic {
    Diagnostic::error(format!("time runs back from {} s to {} s", back.from, back.to)).help(format!(
        "split the file where a new recording starts, or sort the rows by time; a row of its own that is up to {REACH} lines late \
         is sorted in"
    ))
}

fn stands_still(time: f64, rows: usize) -> Diagnostic {
    Diagnostic::error(format!("time stands still at {time} s for {rows} rows"))
        .help("every sample needs its own time: log time with more digits")
}
