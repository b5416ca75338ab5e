//! Signals of joints and motors from a log: filtered alike, differentiated, and if wanted in two independent copies.
use super::super::reading::Reading;
use super::driven::Driven;
use super::plan::Plan;
use crate::log::Block;
use crate::measure::directions::Turning;
use crate::measure::filtered::{Filtered, unusable};
use crate::measure::trajectory::Unusable;
use crate::robot::JointLayout;
use crate::signal::{Butterworth, Grid, Spline, resample};
use bipedc_effects::diagnostic::Diagnostics;
use std::ops::Range;

/// Signals of consecutive samples.
#[derive(Debug, Clone, Default)]
pub struct Chunk {
    /// s
    pub time: Vec<f64>,
    /// Configurations, `samples × nq`.
    pub q: Vec<f64>,
    /// Velocities, `samples × nv`.
    pub v: Vec<f64>,
    /// Accelerations, `samples × nv`.
    pub a: Vec<f64>,
    /// By drive; empty where the log does not show it.
    pub motors: Vec<Motor>,
}

/// Signals of one drive.
#[derive(Debug, Clone, Default)]
pub struct Motor {
    /// Of the shaft, rad, rad/s, rad/s².
    pub motion: Vec<[f64; 3]>,
    /// Filtered sign of the shaft's velocity.
    pub sign: Vec<f64>,
    /// Filtered, A.
    pub current: Vec<f64>,
    /// Whether friction has a known direction here.
    pub turns: Vec<bool>,
    /// Elongation of the spring, m (4.28); empty for stiff drives.
    pub elongation: Vec<f64>,
}

/// How signals are made.
#[derive(Debug, Clone, Copy)]
pub struct Making<'a> {
    /// Joints and base.
    pub layout: &'a JointLayout,
    /// Drives.
    pub drives: &'a [Driven<'a>],
    /// Per drive: slower than this a motor does not count as turning, rad/s.
    pub slow: &'a [f64],
    /// Whether two copies are made, of every other sample each.
    pub split: bool,
}

/// What a log is, beside its samples.
#[derive(Debug, Clone)]
pub struct Head {
    pub plan: Plan,
    /// s
    pub step: f64,
    /// Hz
    pub cutoff_hz: f64,
}

/// Regressors and, where asked for, instruments: the same signals from samples that are not among those of the former.
pub type Visit<'v> = &'v mut dyn FnMut(&Chunk, Option<&Chunk>);

/// Reads a log block by block.
///
/// # Errors
/// Those of the reader; a log without elastic drives, or one too short for the filter.
pub fn each(reading: &Reading<'_>, making: &Making<'_>, visit: Visit<'_>) -> Result<Head, Diagnostics> {
    let mut reader = reading.log.rows();
    let plan = Plan::new(&mut reader, making.layout, making.drives)?;
    let parts = if making.split { 2 } else { 1 };
    let Filtered { step, cutoff_hz, filter, mut blocks } =
        Filtered::new(reader, &reading.options, (parts, 1))?;
    let mut head = Head { plan, step, cutoff_hz };
    let short = || unusable(Unusable::TooFew, reading.log.path());
    while let Some(block) = blocks.next_block()? {
        let range = block.core.clone();
        let maker =
            Maker { making, head: &head, filter: &filter, even: Even::new(&block, step), block: &block };
        if making.split {
            let [first, second] = [0, 1].map(|part| maker.chunk(range.clone(), part));
            let (first, second) = (first.ok_or_else(short)?, second.ok_or_else(short)?);
            let (even, odd): (Vec<usize>, Vec<usize>) = (0..first.time.len()).partition(|i| i % 2 == 0);
            visit(&first.picked(&even), Some(&second.picked(&even)));
            visit(&second.picked(&odd), Some(&first.picked(&odd)));
        } else {
            visit(&maker.chunk(range, 0).ok_or_else(short)?, None);
        }
    }
    head.plan.warnings.extend(blocks.report().warnings.iter().cloned());
    Ok(head)
}

impl Chunk {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    fn picked(&self, kept: &[usize]) -> Self {
        let count = self.len().max(1);
        let rows = |values: &[f64]| -> Vec<f64> {
            let width = values.len() / count;
            kept.iter().flat_map(|&i| values[i * width..(i + 1) * width].iter().copied()).collect()
        };
        let motor = |m: &Motor| Motor {
            motion: if m.motion.is_empty() {
                Vec::new()
            } else {
                kept.iter().map(|&i| m.motion[i]).collect()
            },
            sign: rows(&m.sign),
            current: rows(&m.current),
            turns: if m.turns.is_empty() { Vec::new() } else { kept.iter().map(|&i| m.turns[i]).collect() },
            elongation: rows(&m.elongation),
        };
        Self {
            time: rows(&self.time),
            q: rows(&self.q),
            v: rows(&self.v),
            a: rows(&self.a),
            motors: self.motors.iter().map(motor).collect(),
        }
    }
}

/// The columns of a block on an even grid.
struct Even {
    grid: Grid,
    columns: Vec<Vec<f64>>,
    uniform: bool,
}

impl Even {
    fn new(block: &Block<'_>, step: f64) -> Self {
        let (first, last) = (block.time[0], block.time[block.time.len() - 1]);
        if block.uniform {
            let grid = Grid { start: first, step, count: block.time.len() };
            return Self { grid, columns: block.columns.to_vec(), uniform: true };
        }
        let grid = Grid::covering(block.start, step, first, last);
        let columns = block.columns.iter().map(|column| resample(block.time, column, grid)).collect();
        Self { grid, columns, uniform: false }
    }
}

/// Makes the signals of one block.
struct Maker<'a> {
    making: &'a Making<'a>,
    head: &'a Head,
    filter: &'a Butterworth,
    even: Even,
    block: &'a Block<'a>,
}

impl Maker<'_> {
    fn parts(&self) -> usize {
        if self.making.split { 2 } else { 1 }
    }

    /// Samples of this part of a column, filtered; every other sample if there are two parts.
    fn filtered(&self, column: &[f64], part: usize) -> Vec<f64> {
        let own: Vec<f64> = column.iter().skip(part).step_by(self.parts()).copied().collect();
        self.filter.zero_phase(&own)
    }

    fn step(&self) -> f64 {
        self.head.step * self.parts() as f64
    }

    /// Time of a sample after the first of this part, s.
    fn place(&self, sample: usize, part: usize) -> f64 {
        let since = if self.even.uniform {
            sample as f64 * self.head.step
        } else {
            self.block.time[sample] - self.even.grid.start
        };
        since - part as f64 * self.head.step
    }

    fn spline(&self, column: usize, part: usize) -> Option<Spline> {
        Spline::new(&self.filtered(&self.even.columns[column], part), self.step())
    }

    fn chunk(&self, range: Range<usize>, part: usize) -> Option<Chunk> {
        let making = self.making;
        let (bq, bv) = (making.layout.base.nq(), making.layout.base.nv());
        let joints = making.layout.joints.len();
        let count = range.len();
        let mut chunk = Chunk {
            time: self.block.time[range.clone()].to_vec(),
            q: vec![0.0; count * (bq + joints)],
            v: vec![0.0; count * (bv + joints)],
            a: vec![0.0; count * (bv + joints)],
            motors: vec![Motor::default(); making.drives.len()],
        };
        chunk
            .q
            .chunks_exact_mut((bq + joints).max(1))
            .for_each(|q| q[..bq].copy_from_slice(making.layout.base.rest()));
        for joint in 0..joints {
            let Some((column, factor)) = self.head.plan.angle(joint, making.drives) else { continue };
            let spline = self.spline(column, part)?;
            for (i, sample) in range.clone().enumerate() {
                let [q, v, a] = spline.at(self.place(sample, part)).map(|x| factor * x);
                chunk.q[i * (bq + joints) + bq + joint] = q;
                chunk.v[i * (bv + joints) + bv + joint] = v;
                chunk.a[i * (bv + joints) + bv + joint] = a;
            }
        }
        for (index, driven) in making.drives.iter().enumerate().filter(|(_, d)| d.drive.has_motor()) {
            if self.head.plan.joints[driven.joint].absent(driven.drive).is_empty() {
                chunk.motors[index] = self.motor(index, &range, part)?;
                if driven.drive.is_elastic() {
                    let (lever, radius) = (driven.drive.lever(), driven.drive.load_radius());
                    let motion = chunk.motors[index].motion.iter();
                    let q = chunk.q.chunks_exact(bq + joints).map(|q| q[bq + driven.joint]);
                    let elongation = motion.zip(q).map(|(m, q)| lever * m[0] - radius * q);
                    chunk.motors[index].elongation = elongation.collect();
                }
            }
        }
        Some(chunk)
    }

    fn motor(&self, index: usize, range: &Range<usize>, part: usize) -> Option<Motor> {
        let driven = &self.making.drives[index];
        let columns = self.head.plan.joints[driven.joint];
        let current = self.spline(columns.motor_current?, part)?;
        // A stiff drive's motor turns with its joint.
        let (column, factor) = match columns.motor_position {
            Some(column) => (column, 1.0),
            None => (columns.position?, driven.drive.gear_ratio),
        };
        let spline = self.spline(column, part)?;
        let places: Vec<f64> = range.clone().map(|sample| self.place(sample, part)).collect();
        let own = self.even.grid.count.saturating_sub(part).div_ceil(self.parts());
        let speeds: Vec<f64> = (0..own).map(|i| factor * spline.at_sample(i)[1]).collect();
        let turning = Turning { filter: self.filter, cutoff_hz: self.head.cutoff_hz, step: self.step() };
        let sign = turning.sign(&speeds);
        let turns = turning.nowhere_slow(&speeds, self.making.slow[index]);
        Some(Motor {
            motion: places.iter().map(|t| spline.at(*t).map(|x| factor * x)).collect(),
            sign: places.iter().map(|t| between(&sign, t / self.step())).collect(),
            current: places.iter().map(|t| current.at(*t)[0]).collect(),
            turns: places
                .iter()
                .map(|t| turns.get((t / self.step()).round().max(0.0) as usize).copied().unwrap_or(false))
                .collect(),
            elongation: Vec::new(),
        })
    }
}

/// Linear between samples, constant beyond.
fn between(values: &[f64], place: f64) -> f64 {
    let last = values.len().saturating_sub(1);
    let place = place.clamp(0.0, last as f64);
    let low = (place.floor() as usize).min(last);
    let part = place - low as f64;
    match (values.get(low), values.get(low + 1)) {
        (Some(a), Some(b)) => a + part * (b - a),
        (Some(a), None) => *a,
        _ => 0.0,
    }
}
