//! All samples of all logs, folded into triangles.
use super::design::{Design, Work};
use super::motions::Motions;
use super::reading::Reading;
use super::row_filter::RowFilter;
use super::triangle::Triangle;
use super::unknowns::BaseSet;
use crate::experiments::Experiment;
use crate::measure::Recording;
use bipedc_effects::diagnostic::Diagnostics;
use nalgebra::DVector;

/// Samples that are evaluated together; small, so that their regressors stay in the cache.
const BATCH: usize = 256;
/// A log whose rows are filtered is folded in stretches of at least so many lengths of that filter: each loses one.
const STRETCH: usize = 24;

/// Which rows count, and how much.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Settings {
    /// Regressor and torque pass a low-pass together and every so many-th sample is kept; 0 and 1: all samples.
    pub decimate: usize,
    /// Cut-off of the low-pass that regressor and torque pass together, Hz, where they are not decimated; none: they pass none.
    pub rows_hz: Option<f64>,
    /// Samples at which a joint is slower than this (rad/s, m/s) do not count for it: friction is not dry friction while it turns round.
    pub slow: Vec<f64>,
    /// Only of joints with dry friction.
    pub slow_if_dry: bool,
    /// Largest speed of each joint, rad/s.
    pub speed: Vec<f64>,
    /// Threads.
    pub threads: usize,
}

impl Settings {
    /// What rows of a log pass whose samples are `step` (s) apart.
    pub(super) fn row_filter(&self, step: f64) -> Option<RowFilter> {
        if self.decimate > 1 {
            return Some(RowFilter::decimation(self.decimate));
        }
        self.rows_hz.map(|cutoff| RowFilter::smooth(cutoff, step))
    }
}

/// Weights by residual, for Huber's estimator.
#[derive(Debug, Clone, PartialEq)]
pub struct Weighting {
    /// The present estimate.
    pub theta: DVector<f64>,
    /// Robust scale of each channel.
    pub scale: Vec<f64>,
    /// Residuals above this many scales weigh less.
    pub bend: f64,
}

/// What least squares needs of all samples: per cell and channel a triangle over that channel's unknowns.
#[derive(Debug, Clone, PartialEq)]
pub struct Sums {
    /// By cell, by channel.
    pub cells: Vec<Vec<Triangle>>,
    /// By channel: histogram of residuals' sizes, filled where a [`Weighting`] was given.
    pub sizes: Vec<Sizes>,
    /// By channel: rows left out because a joint with dry friction rests there.
    pub resting: Vec<usize>,
}

impl Sums {
    /// Nothing yet.
    pub fn new(design: &Design<'_>, cells: usize) -> Self {
        let empty = || design.channels.iter().map(|c| Triangle::new(c.places.len())).collect();
        Self {
            cells: (0..cells).map(|_| empty()).collect(),
            sizes: design.channels.iter().map(|_| Sizes::default()).collect(),
            resting: vec![0; design.channels.len()],
        }
    }

    /// Both together.
    pub fn add(&mut self, other: &Self) {
        for (own, other) in self.cells.iter_mut().flatten().zip(other.cells.iter().flatten()) {
            if other.rows() > 0 {
                own.add(other);
            }
        }
        for (own, other) in self.sizes.iter_mut().zip(&other.sizes) {
            own.add(other);
        }
        self.resting.iter_mut().zip(&other.resting).for_each(|(own, other)| *own += other);
    }

    /// Rows per channel.
    pub fn rows(&self, channel: usize) -> usize {
        self.cells.iter().map(|cell| cell[channel].rows()).sum()
    }
}

/// How often residuals of which size occurred: quantiles without keeping them.
#[derive(Debug, Clone, PartialEq)]
pub struct Sizes {
    counts: Vec<u64>,
}

/// Steps of the histogram: 16 per power of two, from 2⁻⁶⁰.
const STEPS: (f64, f64, usize) = (16.0, 60.0, 1920);

impl Default for Sizes {
    fn default() -> Self {
        Self { counts: vec![0; STEPS.2] }
    }
}

impl Sizes {
    fn push(&mut self, residual: f64) {
        let step = (STEPS.0 * (residual.abs().log2() + STEPS.1)).clamp(0.0, (STEPS.2 - 1) as f64);
        self.counts[step as usize] += 1;
    }

    fn add(&mut self, other: &Self) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(own, other)| *own += other);
    }

    /// The median size, within 2 %.
    pub fn median(&self) -> Option<f64> {
        let total: u64 = self.counts.iter().sum();
        let mut seen = 0;
        let step = self.counts.iter().position(|count| {
            seen += count;
            total > 0 && 2 * seen >= total
        })?;
        Some(((step as f64 + 0.5) / STEPS.0 - STEPS.1).exp2())
    }
}

/// Reads the logs and folds them in.
///
/// # Errors
/// Those of the reader.
pub fn accumulate(
    design: &Design<'_>,
    logs: &[Reading<'_>],
    motions: &Motions,
    settings: &Settings,
    weighting: Option<&Weighting>,
) -> Result<Sums, Diagnostics> {
    let mut parts = vec![Sums::new(design, motions.cells()); settings.threads.max(1)];
    for (index, reading) in logs.iter().enumerate() {
        let cell = |time: f64| motions.cell(index, time);
        let mut visit = |recording: &mut Recording| {
            let filter = settings.row_filter(recording.step);
            if recording.samples() >= filter.map_or(0, |filter| STRETCH * filter.length()) {
                fold(design, recording, &cell, settings, weighting, &mut parts);
                recording.clear();
            }
            Ok(())
        };
        let directions = design.directions(&settings.speed);
        let rest =
            Recording::each(reading.log, design.layout, &reading.options, Some(&directions), &mut visit)?;
        fold(design, &rest, &cell, settings, weighting, &mut parts);
    }
    let mut parts = parts.into_iter();
    let mut all = parts.next().unwrap_or_else(|| Sums::new(design, motions.cells()));
    parts.for_each(|part| all.add(&part));
    Ok(all)
}

/// Folds in samples that are in memory; each thread has one of `parts`.
pub fn fold(
    design: &Design<'_>,
    recording: &Recording,
    cell: &(dyn Fn(f64) -> usize + Sync),
    settings: &Settings,
    weighting: Option<&Weighting>,
    parts: &mut [Sums],
) {
    let filter = settings.row_filter(recording.step);
    let pieces: Vec<std::ops::Range<usize>> = match &filter {
        Some(filter) => recording.segments.iter().flat_map(|s| filter.pieces(s.clone())).collect(),
        None => recording.segments.iter().flat_map(batches).collect(),
    };
    let threads = parts.len();
    // Every thread has its own share, so that the same data give the same bits.
    let work = |first: usize, sums: &mut Sums| {
        let mut piece = Piece { settings, weighting, filter: filter.as_ref(), ..Piece::new(design) };
        for range in pieces.iter().skip(first).step_by(threads) {
            piece.fold(recording, range.clone(), cell, sums);
        }
    };
    if let [sums] = parts {
        return work(0, sums);
    }
    std::thread::scope(|scope| {
        for (first, sums) in parts.iter_mut().enumerate() {
            let work = &work;
            scope.spawn(move || work(first, sums));
        }
    });
}

/// A stretch of samples in pieces.
fn batches(stretch: &std::ops::Range<usize>) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
    let last = stretch.end;
    stretch.clone().step_by(BATCH).map(move |first| first..last.min(first + BATCH))
}

/// Folds in the rows of an experiment in memory, for a design made of one ([`Design::of_table`]).
pub fn fold_table(
    design: &Design<'_>,
    base: &BaseSet,
    experiment: &dyn Experiment,
    cell: &dyn Fn(f64) -> usize,
    weighting: Option<&Weighting>,
    sums: &mut Sums,
) {
    let cells: Vec<usize> = experiment.time().iter().map(|time| cell(*time)).collect();
    let mut piece = Piece { weighting, ..Piece::new(design) };
    for (index, channel) in design.channels.iter().enumerate() {
        let (Some(inertial), Some(measured)) =
            (experiment.inertial(channel.row), experiment.measured(channel.row))
        else {
            continue;
        };
        let width = inertial.columns.len();
        let mut columns = Vec::with_capacity((channel.places.len() + 1) * cells.len());
        for &k in &channel.places {
            let leading = base.leading(k);
            match inertial.columns.iter().position(|column| Some(*column) == leading) {
                Some(c) => columns.extend((0..cells.len()).map(|i| inertial.values[i * width + c])),
                None => columns.resize(columns.len() + cells.len(), 0.0),
            }
        }
        columns.extend(measured);
        piece.pack(index, &columns, &cells, &|_| true, sums);
    }
}

/// Takes one piece of a recording after the other, with memory that is kept.
struct Piece<'a> {
    design: &'a Design<'a>,
    settings: &'a Settings,
    weighting: Option<&'a Weighting>,
    filter: Option<&'a RowFilter>,
    work: Work,
    columns: Vec<f64>,
    packed: Vec<f64>,
}

impl<'a> Piece<'a> {
    fn new(design: &'a Design<'a>) -> Self {
        const NONE: &Settings = &Settings {
            decimate: 0,
            rows_hz: None,
            slow: Vec::new(),
            slow_if_dry: false,
            speed: Vec::new(),
            threads: 1,
        };
        Self {
            design,
            settings: NONE,
            weighting: None,
            filter: None,
            work: Work::default(),
            columns: Vec::new(),
            packed: Vec::new(),
        }
    }

    fn fold(
        &mut self,
        recording: &Recording,
        range: std::ops::Range<usize>,
        cell: &dyn Fn(f64) -> usize,
        sums: &mut Sums,
    ) {
        let design = self.design;
        let batch = recording.trajectory.part(range.clone());
        design.evaluate(&batch, &mut self.work);
        let filter = self.filter;
        let kept = |signal: Vec<f64>| match filter {
            Some(filter) => filter.column(&signal),
            None => signal,
        };
        let times = &recording.time[range.clone()];
        let times: Vec<f64> = filter.map_or_else(|| times.to_vec(), |f| f.places(times));
        let cells: Vec<usize> = times.iter().map(|time| cell(*time)).collect();
        for (index, channel) in design.channels.iter().enumerate() {
            let effort = match channel.joint {
                Some(joint) => match &recording.effort[joint] {
                    Some(effort) => effort[range.clone()].to_vec(),
                    None => continue,
                },
                None => vec![0.0; range.len()],
            };
            let mut columns = std::mem::take(&mut self.columns);
            let directions = (recording.directions.as_slice(), range.start);
            design.rows(index, &batch, Some(directions), &self.work, &mut columns);
            columns.extend_from_slice(&effort);
            if let Some(filter) = filter {
                columns = columns.chunks_exact(range.len()).flat_map(|c| filter.column(c)).collect();
            }
            let is_judged = !self.settings.slow_if_dry || design.directions_of(index).next().is_some();
            let slow = channel.joint.filter(|_| is_judged);
            let slow = slow.and_then(|j| self.settings.slow.get(j).copied()).unwrap_or(0.0);
            let speed = match channel.joint {
                Some(j) if slow > 0.0 => {
                    kept(recording.trajectory.velocities(j).skip(range.start).take(range.len()).collect())
                }
                _ => Vec::new(),
            };
            // Where friction may be anything, or a stop carries what it likes, nothing is learnt.
            let mut known = vec![true; range.len()];
            for direction in design.directions_of(index).filter_map(|k| recording.directions.get(k)) {
                known.iter_mut().zip(&direction.known[range.clone()]).for_each(|(known, own)| *known &= own);
            }
            if let Some(joint) = channel.joint {
                let times = &recording.time[range.clone()];
                let at_stop = recording.stops.flags(joint, times, recording.cutoff_hz);
                known.iter_mut().zip(at_stop).for_each(|(known, at_stop)| *known &= !at_stop);
            }
            let known = filter.map_or_else(|| known.clone(), |f| f.known(&known));
            sums.resting[index] += known.iter().filter(|known| !**known).count();
            let moves = |i: usize| known[i] && speed.get(i).is_none_or(|v| v.abs() >= slow);
            self.pack(index, &columns, &cells, &moves, sums);
            self.columns = columns;
        }
    }

    /// Sorts rows by cell and hands them over.
    fn pack(
        &mut self,
        channel: usize,
        columns: &[f64],
        cells: &[usize],
        counts: &dyn Fn(usize) -> bool,
        sums: &mut Sums,
    ) {
        let count = cells.len();
        let width = self.design.channels[channel].places.len() + 1;
        let finite = |i: usize| (0..width).all(|k| columns[k * count + i].is_finite());
        let mut first = 0;
        while first < count {
            let same = cells[first..].iter().take(BATCH).take_while(|c| **c == cells[first]).count();
            let rows: Vec<usize> = (first..first + same).filter(|&i| counts(i) && finite(i)).collect();
            let weights: Option<Vec<f64>> = self.weighting.map(|w| {
                rows.iter().map(|&i| self.weight(w, channel, columns, (count, i), &mut sums.sizes)).collect()
            });
            self.packed.clear();
            for column in columns.chunks_exact(count) {
                match &weights {
                    None => self.packed.extend(rows.iter().map(|&i| column[i])),
                    Some(weights) => {
                        self.packed.extend(rows.iter().zip(weights).map(|(&i, w)| w * column[i]))
                    }
                }
            }
            sums.cells[cells[first]][channel].absorb(rows.len(), &mut self.packed);
            first += same;
        }
    }

    /// Square root of Huber's weight of a row.
    fn weight(
        &self,
        weighting: &Weighting,
        channel: usize,
        columns: &[f64],
        (count, i): (usize, usize),
        sizes: &mut [Sizes],
    ) -> f64 {
        let places = &self.design.channels[channel].places;
        let model: f64 =
            places.iter().enumerate().map(|(k, &p)| weighting.theta[p] * columns[k * count + i]).sum();
        let residual = columns[places.len() * count + i] - model;
        sizes[channel].push(residual);
        let size = residual.abs() / weighting.scale[channel].max(f64::MIN_POSITIVE);
        if size > weighting.bend { (weighting.bend / size).sqrt() } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_sizes_without_keeping_them() {
        let mut sizes = Sizes::default();
        assert_eq!(sizes.median(), None);
        (1..=1001).for_each(|i| sizes.push(f64::from(i) * if i % 2 == 0 { 1e-3 } else { -1e-3 }));
        let median = sizes.median().unwrap();
        assert!((median / 0.501 - 1.0).abs() < 0.03, "{median}");
        sizes.push(0.0);
    }
}
