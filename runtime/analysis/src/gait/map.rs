//! Maps: the next mid-stance speed over two gait parameters, for several speeds (thesis 7.2.1).
use super::functions::GaitModel;
use super::pair::StepPair;
use super::reason::{Assumptions, Reason};
use super::workers::{Watch, in_parallel};

/// What a map is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct MapRequest {
    /// Values of all parameters; those of the axes are replaced.
    pub values: Vec<f64>,
    /// Parameters of the first step where it is another one than the second; `None`: both are the cell's.
    pub from: Option<Vec<f64>>,
    /// Parameter (index) and values of both axes: columns, then rows.
    pub axes: [(usize, Vec<f64>); 2],
    /// φ̇_m of the first step, per s.
    pub speeds: Vec<f64>,
    /// What a step has to satisfy beside passing its dead centre.
    pub assume: Assumptions,
}

/// What comes of the second step, for one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// φ̇_m of the second step, per s, where it passes its dead centre, also if an assumption does not hold.
    pub next_speed: Option<f64>,
    /// Whether all holds, or what does not.
    pub reason: Reason,
    /// It was not computed: cells around it say so.
    pub interpolated: bool,
}

impl Cell {
    /// Nothing is known of it.
    pub const UNKNOWN: Self = Self::failing(Reason::NotComputed);

    /// A step that passes its dead centre with this speed (per s).
    pub const fn passing(next_speed: f64) -> Self {
        Self { next_speed: Some(next_speed), reason: Reason::Passes, interpolated: false }
    }

    /// A step that does not reach its dead centre.
    pub const fn failing(reason: Reason) -> Self {
        Self { next_speed: None, reason, interpolated: false }
    }

    /// The next speed where all holds.
    pub fn good(&self) -> Option<f64> {
        self.next_speed.filter(|_| self.reason == Reason::Passes)
    }
}

impl MapRequest {
    /// Numbers of columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.axes[0].1.len(), self.axes[1].1.len()]
    }

    /// All parameters of the cell in this column and row.
    pub fn at(&self, column: usize, row: usize) -> Vec<f64> {
        let mut values = self.values.clone();
        for ((parameter, axis), index) in self.axes.iter().zip([column, row]) {
            values[*parameter] = axis[index];
        }
        values
    }
}

impl GaitModel<'_> {
    /// Cells of a map, as [`MapRequest::cells`] has them.
    pub fn map(&self, request: &MapRequest, known: Vec<Cell>, watch: &Watch<'_>) -> Vec<Cell> {
        request.cells(known, watch, |to| {
            let pair = self.pair(None, request.from.as_deref().unwrap_or(to), to);
            request.speeds.iter().map(|&speed| cell(&pair, speed, request.assume)).collect()
        })
    }
}

impl MapRequest {
    /// Cells of a map, row after row, in each row column after column, of each as many as speeds; `at` computes those of the
    /// parameters of a place.
    ///
    /// `known` has what is known already: as many cells, or none; those that are [`Reason::NotComputed`] are computed, on all
    /// processors. When `watch` asks for an end, what is missing stays so.
    pub fn cells(
        &self,
        known: Vec<Cell>,
        watch: &Watch<'_>,
        at: impl Fn(&[f64]) -> Vec<Cell> + Sync,
    ) -> Vec<Cell> {
        let ([columns, rows], speeds) = (self.size(), self.speeds.len());
        let mut cells = known;
        cells.resize(columns * rows * speeds, Cell::UNKNOWN);
        let width = columns * speeds;
        let missing = |row: &usize| {
            cells[row * width..(row + 1) * width].iter().any(|cell| cell.reason == Reason::NotComputed)
        };
        let open: Vec<usize> = (0..rows).filter(missing).collect();
        let found = {
            let known = &cells;
            in_parallel(open.len(), watch, |job| {
                let row = open[job];
                self.row(row, &known[row * width..(row + 1) * width], &at)
            })
        };
        for (job, found) in found {
            let row = open[job];
            cells[row * width..(row + 1) * width].copy_from_slice(&found);
        }
        cells
    }

    fn row(&self, row: usize, known: &[Cell], at: &impl Fn(&[f64]) -> Vec<Cell>) -> Vec<Cell> {
        let speeds = self.speeds.len();
        let column = |(column, known): (usize, &[Cell])| {
            if known.iter().all(|cell| cell.reason != Reason::NotComputed) {
                return known.to_vec();
            }
            at(&self.at(column, row))
        };
        known.chunks(speeds.max(1)).enumerate().flat_map(column).collect()
    }
}

/// The second step of a pair, for one speed.
fn cell(pair: &StepPair<'_, '_>, speed: f64, assume: Assumptions) -> Cell {
    match pair.next_speed(speed) {
        Err(why) => Cell::failing(Reason::from(&why)),
        Ok(next) => {
            let violated = if assume.any() { assume.violated(&pair.margins(speed)) } else { None };
            Cell { reason: violated.unwrap_or(Reason::Passes), ..Cell::passing(next) }
        }
    }
}
