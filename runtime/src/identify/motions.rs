//! Which stretches of which logs show the same motion: what must not judge what it has taught.
use super::survey::Survey;
use crate::diagnose::gate::{repeats, shared};
use serde::Serialize;

/// Stretches of motion into which the data are cut, over all logs.
const CELLS: usize = 24;
/// Folds for choices, at most.
const FOLDS: usize = 6;
/// Folds of one motion: few, so that what a fold holds back differs from the rest nearly as other motions do.
const WITHIN: usize = 4;
/// So many different motions make folds of whole motions; fewer are cut.
const ENOUGH: usize = 4;

/// A motion seen more than once.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Repetition {
    /// A log repeats itself.
    Within {
        /// Index of the log.
        log: usize,
        /// s
        period: f64,
    },
    /// A log shows the motion of an earlier one.
    Between {
        /// Index of the earlier log.
        earlier: usize,
        /// Index of the log.
        log: usize,
        /// By how much later the motion comes in it, s.
        shift: f64,
    },
}

/// A log among the motions.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    /// Index of the motion.
    motion: usize,
    /// Time of the log minus time of the motion, s.
    offset: f64,
}

/// A motion, wherever it is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Motion {
    /// Time of the motion at which it begins, s.
    start: f64,
    /// Until it ends, or repeats; s.
    length: f64,
    periodic: bool,
    /// First cell, and how many.
    first: usize,
    cells: usize,
}

/// All logs, cut into cells: stretches of motion, whatever log and repetition they come from.
#[derive(Debug, Clone, PartialEq)]
pub struct Motions {
    places: Vec<Place>,
    motions: Vec<Motion>,
    /// What was seen again.
    pub repetitions: Vec<Repetition>,
}

impl Motions {
    /// Compares all logs with themselves and with each other.
    pub fn new(surveys: &[Survey]) -> Self {
        let mut new = Self { places: Vec::new(), motions: Vec::new(), repetitions: Vec::new() };
        let mut references: Vec<usize> = Vec::new();
        for (log, survey) in surveys.iter().enumerate() {
            let period = repeats(&survey.motion);
            new.repetitions.extend(period.map(|period| Repetition::Within { log, period }));
            let (start, end) = span(survey);
            let seen = references.iter().enumerate().find_map(|(motion, &earlier)| {
                shared(&surveys[earlier].motion, &survey.motion).map(|shift| (motion, earlier, shift))
            });
            if let Some((motion, earlier, shift)) = seen {
                new.repetitions.push(Repetition::Between { earlier, log, shift });
                let offset = start - span(&surveys[earlier]).0 + shift;
                new.places.push(Place { motion, offset });
                new.motions[motion].widen(start - offset, end - offset, period);
            } else {
                new.places.push(Place { motion: references.len(), offset: 0.0 });
                references.push(log);
                let length = period.unwrap_or(end - start);
                let periodic = period.is_some();
                new.motions.push(Motion { start, length, periodic, first: 0, cells: 0 });
            }
        }
        new.cut();
        new
    }

    fn cut(&mut self) {
        let total: f64 = self.motions.iter().map(|m| m.length).sum();
        let mut first = 0;
        for motion in &mut self.motions {
            let share = CELLS as f64 * motion.length / total.max(f64::MIN_POSITIVE);
            (motion.first, motion.cells) = (first, (share.round() as usize).max(2));
            first += motion.cells;
        }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.motions.iter().map(|motion| motion.cells).sum()
    }

    /// The cell of a time of a log.
    pub fn cell(&self, log: usize, time: f64) -> usize {
        let place = self.places[log];
        let motion = self.motions[place.motion];
        let since = time - place.offset - motion.start;
        let since = if motion.periodic { since.rem_euclid(motion.length) } else { since };
        let part = since / motion.length.max(f64::MIN_POSITIVE);
        motion.first + ((part * motion.cells as f64).max(0.0) as usize).min(motion.cells - 1)
    }

    /// Number of different motions.
    pub fn different(&self) -> usize {
        self.motions.len()
    }

    /// Which fold each cell belongs to: whole motions if there are enough of them, else stretches of them.
    pub fn folds(&self) -> Vec<usize> {
        if self.motions.len() >= ENOUGH {
            let of = |(index, motion): (usize, &Motion)| vec![index % FOLDS; motion.cells];
            return self.motions.iter().enumerate().flat_map(of).collect();
        }
        let cells = self.cells();
        (0..cells).map(|cell| cell * WITHIN / cells).collect()
    }
}

impl Motion {
    fn widen(&mut self, start: f64, end: f64, period: Option<f64>) {
        if self.periodic {
            return;
        }
        if let Some(period) = period {
            (self.periodic, self.length) = (true, period);
            return;
        }
        let last = (self.start + self.length).max(end);
        self.start = self.start.min(start);
        self.length = last - self.start;
    }
}

fn span(survey: &Survey) -> (f64, f64) {
    let time = &survey.motion.time;
    (time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(0.0))
}
