//! All samples of all logs, folded into triangles: per stretch of motion one for every motor and every joint.
use super::super::design::Design;
use super::super::motions::Motions;
use super::super::reading::Reading;
use super::super::triangle::Triangle;
use super::driven::Driven;
use super::laws::Laws;
use super::rows::{JointRows, motor_columns, motor_torque};
use super::signals::{Chunk, Making, each};
use bipedc_effects::diagnostic::Diagnostics;

/// Samples that are evaluated together.
const BATCH: usize = 256;

/// Rows of motors and joints as triangles.
///
/// A motor's triangle has its laws as unknowns; with instruments these come first, as many. A joint's triangle has the
/// unknowns of its channel, with instruments these first, and last the stiffness of its own spring where it has one: its
/// column is minus the torque per stiffness, so that the spring's torque stands on the left of (4.32).
#[derive(Debug, Clone, PartialEq)]
pub struct Folded {
    /// By stretch of motion, by motor with a spring.
    pub motors: Vec<Vec<Triangle>>,
    /// By stretch of motion, by channel of the design.
    pub joints: Vec<Vec<Triangle>>,
    /// Drives of `motors`.
    pub elastic: Vec<usize>,
    /// By channel: index among `elastic` of its spring.
    pub springs: Vec<Option<usize>>,
    /// Whether instruments come first.
    pub instruments: bool,
    /// Laws of the motors.
    pub laws: Laws,
}

/// What is folded, and how.
pub struct Folding<'a, 'd> {
    pub design: &'a Design<'d>,
    pub drives: &'a [Driven<'a>],
    pub laws: Laws,
    /// Per drive, rad/s of the motor shaft.
    pub slow: &'a [f64],
    pub instruments: bool,
}

impl Folded {
    fn new(folding: &Folding<'_, '_>, cells: usize) -> Self {
        let seen =
            |driven: &Driven<'_>| folding.design.channels.iter().any(|c| c.joint == Some(driven.joint));
        let elastic: Vec<usize> = (0..folding.drives.len())
            .filter(|&t| folding.drives[t].drive.is_elastic() && seen(&folding.drives[t]))
            .collect();
        let copies = if folding.instruments { 2 } else { 1 };
        let spring =
            |joint: Option<usize>| elastic.iter().position(|&t| Some(folding.drives[t].joint) == joint);
        let springs: Vec<Option<usize>> = folding.design.channels.iter().map(|c| spring(c.joint)).collect();
        let joints = || {
            let channels = folding.design.channels.iter().zip(&springs);
            channels.map(|(c, s)| Triangle::new(copies * c.places.len() + usize::from(s.is_some()))).collect()
        };
        Self {
            motors: vec![vec![Triangle::new(copies * folding.laws.count()); elastic.len()]; cells],
            joints: (0..cells).map(|_| joints()).collect(),
            elastic,
            springs,
            instruments: folding.instruments,
            laws: folding.laws,
        }
    }

    /// Rows of a motor.
    pub fn motor_rows(&self, motor: usize) -> usize {
        self.motors.iter().map(|cell| cell[motor].rows()).sum()
    }
}

/// Reads logs and folds them in.
///
/// # Errors
/// Those of the reader.
pub fn fold(
    folding: &Folding<'_, '_>,
    logs: &[Reading<'_>],
    motions: &Motions,
) -> Result<Folded, Diagnostics> {
    let mut folded = Folded::new(folding, motions.cells());
    let making = Making {
        layout: folding.design.layout,
        drives: folding.drives,
        slow: folding.slow,
        split: folding.instruments,
    };
    let mut rows = JointRows::new(folding.design, folding.drives);
    let mut others = JointRows::new(folding.design, folding.drives);
    for (index, reading) in logs.iter().enumerate() {
        let mut visit = |chunk: &Chunk, instruments: Option<&Chunk>| {
            let cells: Vec<usize> = chunk.time.iter().map(|time| motions.cell(index, *time)).collect();
            let mut first = 0;
            while first < cells.len() {
                let same = cells[first..].iter().take(BATCH).take_while(|c| **c == cells[first]).count();
                let piece = first..first + same;
                folded.add_motors(folding, chunk, instruments, piece.clone(), cells[first]);
                folded.add_joints([&mut rows, &mut others], chunk, instruments, piece, cells[first]);
                first += same;
            }
        };
        each(reading, &making, &mut visit)?;
    }
    Ok(folded)
}

impl Folded {
    fn add_motors(
        &mut self,
        folding: &Folding<'_, '_>,
        chunk: &Chunk,
        instruments: Option<&Chunk>,
        range: std::ops::Range<usize>,
        cell: usize,
    ) {
        for (k, &t) in self.elastic.iter().enumerate() {
            let (drive, motor) = (folding.drives[t].drive, &chunk.motors[t]);
            let other = instruments.map(|chunk| &chunk.motors[t]);
            let counts = |i: &usize| motor.turns[*i] && other.is_none_or(|o| o.turns[*i]);
            let mut rows = Vec::new();
            for i in range.clone().filter(counts) {
                let mut row = Vec::new();
                if let Some(other) = other {
                    motor_columns(drive, other, folding.laws, i, &mut row);
                }
                motor_columns(drive, motor, folding.laws, i, &mut row);
                row.push(motor_torque(drive, motor, i));
                rows.push(row);
            }
            absorb(&mut self.motors[cell][k], &rows);
        }
    }

    fn add_joints(
        &mut self,
        [rows, others]: [&mut JointRows<'_, '_>; 2],
        chunk: &Chunk,
        instruments: Option<&Chunk>,
        range: std::ops::Range<usize>,
        cell: usize,
    ) {
        let count = range.len();
        let piece = rows.evaluate(chunk, range.clone());
        let other = instruments.map(|chunk| (chunk, others.evaluate(chunk, range)));
        let (mut columns, mut instrument) = (Vec::new(), Vec::new());
        for channel in 0..self.springs.len() {
            rows.columns(channel, chunk, &piece, &mut columns);
            if let Some((chunk, piece)) = &other {
                others.columns(channel, chunk, piece, &mut instrument);
            }
            let mut kept = Vec::new();
            for i in 0..count {
                let ([known, per_stiffness], counts) = rows.torque(channel, chunk, &piece, i);
                let both =
                    other.as_ref().is_none_or(|(chunk, piece)| others.torque(channel, chunk, piece, i).1);
                if counts && both {
                    let mut row: Vec<f64> = instrument.iter().skip(i).step_by(count).copied().collect();
                    row.extend(columns.iter().skip(i).step_by(count));
                    row.extend(self.springs[channel].map(|_| -per_stiffness));
                    row.push(known);
                    kept.push(row);
                }
            }
            absorb(&mut self.joints[cell][channel], &kept);
        }
    }
}

/// Takes in rows that are all numbers.
fn absorb(triangle: &mut Triangle, rows: &[Vec<f64>]) {
    let finite: Vec<&Vec<f64>> = rows.iter().filter(|row| row.iter().all(|x| x.is_finite())).collect();
    let width = triangle.columns() + 1;
    let mut packed = Vec::with_capacity(width * finite.len());
    for k in 0..width {
        packed.extend(finite.iter().map(|row| row[k]));
    }
    triangle.absorb(finite.len(), &mut packed);
}
