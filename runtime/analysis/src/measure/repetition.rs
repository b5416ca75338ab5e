//! Motions that repeat themselves, within a log or between two: held-out data that show the same motion again judge
//! too kindly.
use crate::parallel::parallel;
use bipedc_effects::diagnostic::Diagnostic;
use std::ops::Range;

/// Finest and coarsest grid on which motions are held against each other, s.
const STEPS: (f64, f64) = (0.01, 0.1);
/// Most points of the grid; what comes later in a log is not looked at.
const POINTS: usize = 3000;
/// Mean squared difference, as a part of twice the variance, below which two stretches are the same motion.
const SAME: f64 = 0.02;
/// So many times the least difference is as good.
const AS_GOOD: f64 = 1.5;
/// A motion has left where it was when it differs by so much.
const OTHER: f64 = 0.3;
/// Stretches must overlap by at least this part of the shorter log.
const OVERLAP: f64 = 0.15;
/// Joints that vary by less than this do not count; rad, m.
const STILL: f64 = 5e-3;

/// So many lags a processor looks at together.
const LAGS: usize = 64;

/// Positions of the joints over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct JointPositions {
    /// Times of the samples, s.
    pub time: Vec<f64>,
    /// One signal per joint, by the same order in all logs of a robot.
    pub positions: Vec<Vec<f64>>,
}

impl JointPositions {
    /// Adds a later sample. Memory is bounded: of what comes after the part that is ever looked at, one sample
    /// (up to which to interpolate) and the last one (for the duration) are kept.
    pub(crate) fn push(&mut self, time: f64, positions: &[f64]) {
        let beyond = self.time.first().map_or(f64::INFINITY, |first| first + STEPS.1 * POINTS as f64);
        if self.time.len() > 1 && self.time[self.time.len() - 2] > beyond {
            self.time.pop();
            self.positions.iter_mut().for_each(|signal| signal.truncate(signal.len().saturating_sub(1)));
        }
        self.time.push(time);
        self.positions.iter_mut().zip(positions).for_each(|(signal, q)| signal.push(*q));
    }

    fn duration(&self) -> f64 {
        self.time.last().zip(self.time.first()).map_or(0.0, |(last, first)| last - first)
    }

    /// The signals on a grid from the first sample, NaN where the log has a gap.
    fn grid(&self, step: f64) -> Vec<Vec<f64>> {
        let (Some(first), Some(last)) = (self.time.first(), self.time.last()) else { return Vec::new() };
        let count = (((last - first) / step) as usize + 1).min(POINTS);
        let points: Vec<Option<(usize, f64)>> =
            (0..count).map(|i| self.place(first + i as f64 * step, step)).collect();
        let at = |signal: &Vec<f64>| {
            points
                .iter()
                .map(|p| p.map_or(f64::NAN, |(i, part)| signal[i] + part * (signal[i + 1] - signal[i])))
                .collect()
        };
        self.positions.iter().map(at).collect()
    }

    /// The sample before a time and the part of the way to the next; `None` in gaps.
    fn place(&self, time: f64, step: f64) -> Option<(usize, f64)> {
        let after = self.time.partition_point(|t| *t <= time).clamp(1, self.time.len().max(2) - 1);
        let (a, b) = (*self.time.get(after - 1)?, *self.time.get(after)?);
        (b - a <= 2.0 * step).then(|| (after - 1, ((time - a) / (b - a)).clamp(0.0, 1.0)))
    }
}

fn step(duration: f64) -> f64 {
    (duration / POINTS as f64).clamp(STEPS.0, STEPS.1)
}

/// Whether a log repeats its motion: the period, s.
pub fn repeats(motion: &JointPositions) -> Option<f64> {
    let step = step(motion.duration());
    let grid = motion.grid(step);
    let count = grid.first()?.len();
    let least = ((count as f64 * OVERLAP) as usize).max(20);
    let difference = |lag: usize, most: f64| mismatch(&grid, &grid, lag as isize, (least, most));
    let left = (1..count).find(|&lag| difference(lag, OTHER).is_some_and(|d| d > OTHER))?;
    let lag = dips(left..count.saturating_sub(least), |lag| difference(lag, AS_GOOD * SAME))?;
    Some(step * refined(&grid, &grid, lag as isize, least))
}

/// Whether two logs show the same motion: by how much later it is in the second, s.
pub fn shared(one: &JointPositions, other: &JointPositions) -> Option<f64> {
    let step = step(one.duration().max(other.duration()));
    let (a, b) = (one.grid(step), other.grid(step));
    let (n, m) = (a.first()?.len(), b.first()?.len());
    let least = ((n.min(m) as f64 * OVERLAP) as usize).max(20);
    let lags = n + m;
    let difference = |k: usize| mismatch(&a, &b, k as isize - n as isize, (least, AS_GOOD * SAME));
    let lag = dips(0..lags, difference)?;
    Some(step * refined(&a, &b, lag as isize - n as isize, least))
}

/// The first dip that is deep enough; what is no dip may be any number above [`AS_GOOD`] times [`SAME`].
fn dips(range: Range<usize>, difference: impl Fn(usize) -> Option<f64> + Sync) -> Option<usize> {
    let chunks: Vec<usize> = range.clone().step_by(LAGS).collect();
    let of_chunk = |first: usize| first..(first + LAGS).min(range.end);
    let at = |k: usize| Some((k, difference(k)?));
    let values =
        parallel(chunks.len(), |k| of_chunk(chunks[k]).filter_map(at).collect::<Vec<(usize, f64)>>());
    let values = values.concat();
    let mut best = values.iter().copied().filter(|(_, d)| *d < SAME).min_by(|a, b| a.1.total_cmp(&b.1))?;
    // The first of several equally good ones is the period itself.
    if let Some(first) = values.iter().find(|(_, d)| *d < (AS_GOOD * best.1).max(0.5 * SAME)) {
        best = *first;
    }
    let near = values.iter().filter(|(k, _)| k.abs_diff(best.0) < 10);
    near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| *k)
}

/// The lag in steps, by a parabola through its neighbours.
fn refined(a: &[Vec<f64>], b: &[Vec<f64>], lag: isize, least: usize) -> f64 {
    let at = |lag: isize| mismatch(a, b, lag, (least, f64::INFINITY));
    let shift = match (at(lag - 1), at(lag), at(lag + 1)) {
        (Some(l), Some(c), Some(r)) if l + r > 2.0 * c => 0.5 * (l - r) / (l + r - 2.0 * c),
        _ => 0.0,
    };
    lag as f64 + shift
}

/// Mean squared difference of `a(t)` and `b(t + lag)` over the joints that move, over twice the variance; `None` if
/// they overlap too little. Of what is larger than `most` it is only said that it is, as soon as that is certain.
fn mismatch(a: &[Vec<f64>], b: &[Vec<f64>], lag: isize, (least, most): (usize, f64)) -> Option<f64> {
    let mut parts = (0.0, 0.0);
    let joints = a.len() as f64;
    for (a, b) in a.iter().zip(b) {
        let from = (-lag).max(0) as usize;
        let to = (b.len() as isize - lag).clamp(0, a.len() as isize) as usize;
        if to < from + least {
            return None;
        }
        let (mut n, mut difference, mut sum, mut squares) = (0.0, 0.0, 0.0, 0.0);
        for i in from..to {
            let (x, y) = (a[i], b[(i as isize + lag) as usize]);
            if x.is_finite() && y.is_finite() {
                n += 1.0;
                difference += (x - y) * (x - y);
                sum += x;
                squares += x * x;
            }
        }
        if n < least as f64 {
            return None;
        }
        let variance = squares / n - (sum / n).powi(2);
        if variance > STILL * STILL {
            // Every joint has the same say, however far it swings.
            parts = (parts.0 + difference / n / (2.0 * variance), parts.1 + 1.0);
            if parts.0 > most * joints {
                return Some(f64::INFINITY);
            }
        }
    }
    (parts.1 > 0.0).then(|| parts.0 / parts.1)
}

/// Warnings about repetition: `judge` is the validation log, if there is one.
pub(crate) fn warnings(train: &JointPositions, judge: Option<&JointPositions>) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    if let Some(judge) = judge {
        if let Some(shift) = shared(train, judge) {
            let message = format!(
                "the validation log shows the motion of the training log again, {shift:.2} s later: held-out errors are optimistic"
            );
            found.push(Diagnostic::warning(message).help("validate on another motion"));
        }
    } else if let Some(period) = repeats(train) {
        let message = format!(
            "the log repeats its motion every {period:.2} s, so that blocks of it judge on a motion that was learnt: held-out errors are optimistic"
        );
        found.push(Diagnostic::warning(message).help("give a log of another motion with --validate"));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two joints that repeat after `period`, sampled at 100 Hz.
    fn motion(duration: f64, period: f64, drift: f64) -> JointPositions {
        let time: Vec<f64> = (0..(100.0 * duration) as usize).map(|i| 0.01 * i as f64).collect();
        let w = std::f64::consts::TAU / period;
        let of = |f: &dyn Fn(f64) -> f64| time.iter().map(|t| f(*t) + drift * (0.37 * t * t).sin()).collect();
        let hip = of(&|t| 0.4 * (3.0 * w * t).sin() + 0.2 * (5.0 * w * t).cos());
        let knee = of(&|t| 0.3 * (2.0 * w * t).cos() + 0.2 * (7.0 * w * t).sin());
        JointPositions { time, positions: vec![hip, knee] }
    }

    #[test]
    fn the_period_is_found() {
        let period = repeats(&motion(30.0, 7.3, 0.0)).unwrap();
        assert!((period - 7.3).abs() < 0.01, "{period}");
        assert_eq!(repeats(&motion(30.0, 7.3, 0.3)), None, "a chirp on top repeats nothing");
        assert_eq!(repeats(&motion(8.0, 7.3, 0.0)), None, "a tenth more than one period is no repetition");
    }

    #[test]
    fn the_same_motion_in_two_logs() {
        let whole = motion(30.0, 100.0, 0.3);
        let part = |from: usize, to: usize| JointPositions {
            time: whole.time[from..to].to_vec(),
            positions: whole.positions.iter().map(|q| q[from..to].to_vec()).collect(),
        };
        let shift = shared(&part(0, 1800), &part(600, 3000)).unwrap();
        assert!((shift + 6.0).abs() < 0.02, "{shift}");
        assert_eq!(shared(&part(0, 1500), &part(1500, 3000)), None);
    }

    #[test]
    fn of_a_long_motion_little_is_kept_and_nothing_changes() {
        let whole = motion(2000.0, 37.3, 0.0);
        let mut kept = JointPositions { time: Vec::new(), positions: vec![Vec::new(); 2] };
        for (i, &time) in whole.time.iter().enumerate() {
            kept.push(time, &[whole.positions[0][i], whole.positions[1][i]]);
        }
        assert!(kept.time.len() < 30_010, "{}", kept.time.len());
        assert!(kept.positions.iter().all(|signal| signal.len() == kept.time.len()));
        assert_eq!(kept.time.last(), whole.time.last());
        assert!(repeats(&whole).is_some());
        assert_eq!(repeats(&kept), repeats(&whole));
        let short = motion(40.0, 37.3, 0.0);
        assert_eq!(shared(&kept, &short), shared(&whole, &short));
    }

    #[test]
    fn nothing_at_all_repeats_nothing() {
        assert_eq!(repeats(&JointPositions::default()), None);
        let still = JointPositions { time: vec![0.0, 1.0, 2.0], positions: vec![vec![0.0; 3]] };
        assert_eq!(repeats(&still), None);
        assert_eq!(shared(&still, &JointPositions::default()), None);
    }
}
