//! Efforts between their samples.
use crate::measure::Recording;
use crate::signal::{Grid, Spline, resample};
use std::ops::Range;

/// Clocks whose samples are this near to an even grid (in steps) count as even.
const EVEN: f64 = 1e-3;

/// The logged efforts of a stretch as they act: quintic splines, exact at the samples, by joint.
pub(super) struct Input {
    /// Log's clock, s.
    start: f64,
    splines: Vec<Spline>,
    /// By joint, s.
    delays: Vec<f64>,
}

impl Input {
    /// `None` for a stretch of fewer than eight samples. All joints have efforts.
    pub fn new(recording: &Recording, segment: Range<usize>, delays: &[f64]) -> Option<Self> {
        let time = &recording.time[segment.clone()];
        let (first, last) = (*time.first()?, *time.last()?);
        let step = (last - first) / (time.len() - 1).max(1) as f64;
        let off = |(k, t): (usize, &f64)| (t - first - k as f64 * step).abs() > EVEN * step;
        let uneven = time.iter().enumerate().any(off);
        let grid = Grid::covering(first, recording.step, first, last);
        let spline = |effort: &Option<Vec<f64>>| {
            let values = &effort.as_ref()?[segment.clone()];
            if uneven {
                Spline::new(&resample(time, values, grid), recording.step)
            } else {
                Spline::new(values, step)
            }
        };
        let splines = recording.effort.iter().map(spline).collect::<Option<_>>()?;
        Some(Self { start: first, splines, delays: delays.to_vec() })
    }

    /// Reported efforts that act at this time of the log's clock, N m.
    pub fn at(&self, time: f64) -> Vec<f64> {
        let late = self.splines.iter().zip(&self.delays);
        late.map(|(spline, delay)| spline.at(time - delay - self.start)[0]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two joints, the second one 0.05 s late; once with an even clock, once with one that wanders.
    #[test]
    fn efforts_are_those_logged_a_delay_before() {
        for wander in [0.0, 0.2] {
            let step = 0.01;
            let time: Vec<f64> =
                (0..200).map(|i| 3.0 + step * (f64::from(i) + wander * f64::from(i).sin())).collect();
            let effort: Vec<f64> = time.iter().map(|t| (3.0 * t).sin()).collect();
            let effort = vec![Some(effort.clone()), Some(effort)];
            let recording = Recording { time, effort, step, ..Recording::default() };
            let input = Input::new(&recording, 0..200, &[0.0, 0.05]).unwrap();
            for t in [3.5, 3.777, 4.5] {
                let [now, late] = input.at(t)[..] else { panic!() };
                let tolerance = if wander == 0.0 { 1e-9 } else { 1e-6 };
                assert!((now - (3.0 * t).sin()).abs() < tolerance, "{now}");
                assert!((late - (3.0 * (t - 0.05)).sin()).abs() < tolerance, "{late}");
            }
        }
    }
}
