//! What one pass over a file tells of its clock and its columns, in memory that does not depend on its length.
use bipedc_analysis::log::{Field, usual_step};
use bipedc_effects::magnitude;
use serde::Serialize;

/// Steps that are looked at before the sampling step is known, as readers of logs do.
const PROBE: usize = 4096;
/// A pause of more steps than this is a gap; readers bridge shorter ones.
const GAP_STEPS: f64 = 3.5;
/// Steps that differ by more from the median are uneven.
const UNEVEN: f64 = 0.01;

/// How a log is sampled.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sampling {
    /// Name of the column with the time stamps, as in the file.
    pub column: String,
    /// First time stamp, s.
    pub from_s: f64,
    /// Last time stamp, s.
    pub to_s: f64,
    /// Between them, s.
    pub duration_s: f64,
    /// Median step of the first rows, s.
    pub step_s: f64,
    /// One over it, Hz.
    pub rate_hz: f64,
    /// Shortest step forwards, s.
    pub shortest_s: f64,
    /// Longest step that is no gap, s.
    pub longest_s: f64,
    /// Steps that are no gaps and differ from the median by more than 1 %.
    pub uneven: usize,
    /// Pauses of more than 3.5 steps.
    pub gaps: usize,
    /// The longest of them.
    pub largest_gap: Option<Gap>,
    /// Rows with the time stamp of the row before.
    pub doubled: usize,
    /// The first such line.
    pub first_doubled: Option<usize>,
    /// Rows with an earlier time stamp than the row before.
    pub backward: usize,
    /// The first such line.
    pub first_backward: Option<usize>,
    /// Rows without a time stamp.
    pub without_time: usize,
}

/// A pause of a log.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gap {
    /// s
    pub length_s: f64,
    /// Time stamp before it, s.
    pub from_s: f64,
    /// Line of the row behind it.
    pub line: usize,
}

/// Collects steps.
#[derive(Debug, Default)]
pub(super) struct Clock {
    first: Option<f64>,
    last: Option<f64>,
    largest: f64,
    /// Steps forwards with the time before them and the line behind them, until the median is known.
    waiting: Vec<(f64, f64, usize)>,
    step: Option<f64>,
    shortest: f64,
    longest: f64,
    uneven: usize,
    gaps: usize,
    largest_gap: Option<Gap>,
    doubled: (usize, Option<usize>),
    backward: (usize, Option<usize>),
    without_time: usize,
}

impl Clock {
    pub fn new() -> Self {
        Self { shortest: f64::INFINITY, largest: f64::NEG_INFINITY, ..Self::default() }
    }

    /// The next row's time, in the unit of the file.
    pub fn take(&mut self, time: Option<f64>, line: usize) {
        let Some(time) = time else {
            self.without_time += 1;
            return;
        };
        self.first.get_or_insert(time);
        self.largest = self.largest.max(time);
        let Some(last) = self.last.replace(time) else { return };
        let note = |counter: &mut (usize, Option<usize>)| {
            counter.0 += 1;
            counter.1.get_or_insert(line);
        };
        if time == last {
            note(&mut self.doubled);
        } else if time < last {
            note(&mut self.backward);
        } else if let Some(step) = self.step {
            self.judge(step, (time - last, last, line));
        } else {
            self.waiting.push((time - last, last, line));
            if self.waiting.len() >= PROBE {
                self.settle();
            }
        }
    }

    /// Now the median is known.
    fn settle(&mut self) {
        let waiting = std::mem::take(&mut self.waiting);
        let mut steps: Vec<f64> = waiting.iter().map(|(step, ..)| *step).collect();
        if steps.is_empty() {
            return;
        }
        let step = usual_step(&mut steps, self.largest);
        self.step = Some(step);
        waiting.into_iter().for_each(|one| self.judge(step, one));
    }

    fn judge(&mut self, median: f64, (step, from, line): (f64, f64, usize)) {
        if step > GAP_STEPS * median {
            self.gaps += 1;
            if self.largest_gap.is_none_or(|gap| step > gap.length_s) {
                self.largest_gap = Some(Gap { length_s: step, from_s: from, line });
            }
            return;
        }
        self.shortest = self.shortest.min(step);
        self.longest = self.longest.max(step);
        self.uneven += usize::from((step - median).abs() > UNEVEN * median);
    }

    /// The median step in the unit of the file; none before two rows.
    pub fn step(&mut self) -> Option<f64> {
        self.settle_if_waiting();
        self.step
    }

    fn settle_if_waiting(&mut self) {
        if self.step.is_none() {
            self.settle();
        }
    }

    /// All of it in seconds: `factor` seconds are one unit of the file.
    pub fn sampling(mut self, column: &str, factor: f64) -> Option<Sampling> {
        let step = self.step()? * factor;
        let (from, to) = (self.first? * factor, self.largest * factor);
        Some(Sampling {
            column: column.to_owned(),
            from_s: from,
            to_s: to,
            duration_s: to - from,
            step_s: step,
            rate_hz: 1.0 / step,
            shortest_s: self.shortest * factor,
            longest_s: self.longest * factor,
            uneven: self.uneven,
            gaps: self.gaps,
            largest_gap: self.largest_gap.map(|gap| Gap {
                length_s: gap.length_s * factor,
                from_s: gap.from_s * factor,
                line: gap.line,
            }),
            doubled: self.doubled.0,
            first_doubled: self.doubled.1,
            backward: self.backward.0,
            first_backward: self.backward.1,
            without_time: self.without_time,
        })
    }
}

/// Values of a column that a calculation cannot use.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unusable {
    /// Rows with such a value.
    pub rows: usize,
    /// The first such line.
    pub line: usize,
    /// What stands there.
    pub example: String,
}

/// Collects the values of a column.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Values {
    pub least: f64,
    pub most: f64,
    pub numbers: usize,
    pub missing: usize,
    pub first_missing: Option<usize>,
    pub unusable: Option<Unusable>,
}

impl Values {
    pub fn new() -> Self {
        Self {
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
            numbers: 0,
            missing: 0,
            first_missing: None,
            unusable: None,
        }
    }

    /// The next row's field; `limited`: numbers beyond what SI units have are refused.
    pub fn take(&mut self, field: Field<'_>, text: &str, line: usize, limited: bool) {
        match field {
            Field::Number(x) if !limited || x.abs() <= magnitude::LARGEST => {
                self.least = self.least.min(x);
                self.most = self.most.max(x);
                self.numbers += 1;
            }
            Field::Absent => {
                self.missing += 1;
                self.first_missing.get_or_insert(line);
            }
            _ => match &mut self.unusable {
                Some(unusable) => unusable.rows += 1,
                None => {
                    let example = bipedc_effects::diagnostic::shorten(text);
                    self.unusable = Some(Unusable { rows: 1, line, example });
                }
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_gaps_and_stamps_that_do_not_go_forwards() {
        let mut clock = Clock::new();
        // 5000 rows of 1 ms, so that the median is known before the odd rows come.
        (0..5000).for_each(|k| clock.take(Some(f64::from(k)), 2 + k as usize));
        for (time, line) in [(5000.5, 10), (5000.5, 11), (5000.0, 12), (5100.0, 13), (5101.0, 14)] {
            clock.take(Some(time), line);
        }
        clock.take(None, 15);
        let sampling = clock.sampling("t", 1e-3).unwrap();
        assert_eq!((sampling.step_s, sampling.uneven, sampling.gaps), (1e-3, 1, 1));
        assert_eq!(sampling.largest_gap.unwrap(), Gap { length_s: 0.1, from_s: 5.0, line: 13 });
        assert_eq!((sampling.doubled, sampling.first_doubled), (1, Some(11)));
        assert_eq!((sampling.backward, sampling.first_backward, sampling.without_time), (1, Some(12), 1));
        assert!((sampling.duration_s - 5.101).abs() < 1e-12 && (sampling.longest_s - 1.5e-3).abs() < 1e-12);
        assert_eq!(Clock::new().sampling("t", 1.0), None);
    }
}
