//! Which stretches of which logs show the same motion: what must not judge what it has taught.
use super::survey::Survey;
use crate::measure::{repeats, shared};
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
struct RepeatedMotion {
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
    motions: Vec<RepeatedMotion>,
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
                new.motions.push(RepeatedMotion { start, length, periodic, first: 0, cells: 0 });
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

    /// How long a cell is, s.
    pub(super) fn stretch(&self) -> f64 {
        self.motions.iter().map(|motion| motion.length).sum::<f64>() / self.cells().max(1) as f64
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
            let of = |(index, motion): (usize, &RepeatedMotion)| vec![index % FOLDS; motion.cells];
            return self.motions.iter().enumerate().flat_map(of).collect();
        }
        let cells = self.cells();
        (0..cells).map(|cell| cell * WITHIN / cells).collect()
    }
}

impl RepeatedMotion {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::JointPositions as Seen;

    /// A log at 100 Hz of a motion with this period, beginning at a phase (s) of it; time runs from `start`.
    fn log(duration: f64, period: f64, phase: f64, start: f64) -> Survey {
        let count = (100.0 * duration) as usize;
        let time: Vec<f64> = (0..count).map(|i| start + 0.01 * i as f64).collect();
        let w = std::f64::consts::TAU / period;
        let signal = |a: f64, b: f64| -> Vec<f64> {
            time.iter()
                .map(|t| t - start + phase)
                .map(|t| 0.4 * (a * w * t).sin() + 0.3 * (b * w * t).cos())
                .collect()
        };
        let motion = Seen { positions: vec![signal(1.0, 3.0), signal(2.0, 5.0)], time };
        Survey { motion, ..Survey::default() }
    }

    #[test]
    fn the_same_phase_is_the_same_cell_in_all_logs() {
        let motions = Motions::new(&[log(20.0, 8.0, 0.0, 3.0), log(18.0, 8.0, 2.5, 100.0)]);
        assert_eq!((motions.different(), motions.repetitions.len()), (1, 3), "{:?}", motions.repetitions);
        for i in 0..700 {
            // Away from the edges of cells: shifts are known to a hundredth of a second.
            let t = 0.01 * f64::from(i);
            let width = 8.0 / motions.cells() as f64;
            if !(0.1..0.9).contains(&(t / width).fract()) {
                continue;
            }
            let cell = motions.cell(0, 3.0 + t);
            assert_eq!(cell, motions.cell(0, 11.0 + t), "a period later");
            assert_eq!(cell, motions.cell(1, 100.0 + t - 2.5 + 8.0), "in the other log, at {t} s");
        }
    }

    #[test]
    fn different_motions_share_no_cell_and_no_fold() {
        let surveys: Vec<Survey> =
            (0..5).map(|k| log(9.0, 11.0 + 7.3 * f64::from(k * k), 1.7 * f64::from(k), 0.0)).collect();
        let motions = Motions::new(&surveys);
        assert_eq!(motions.different(), 5, "{:?}", motions.repetitions);
        let folds = motions.folds();
        for (one, other) in [(0, 1), (2, 4), (1, 3)] {
            let own: Vec<usize> = (0..90).map(|i| motions.cell(one, 0.1 * f64::from(i))).collect();
            let others: Vec<usize> = (0..90).map(|i| motions.cell(other, 0.1 * f64::from(i))).collect();
            assert!(own.iter().all(|cell| !others.contains(cell)));
            assert_ne!(folds[own[0]], folds[others[0]]);
            assert!(own.iter().all(|cell| folds[*cell] == folds[own[0]]));
        }
        assert_eq!(folds.len(), motions.cells());
    }
}
