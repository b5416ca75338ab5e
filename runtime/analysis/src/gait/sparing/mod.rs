//! Maps of which most cells are interpolated: blocks of cells are halved until what was computed of them is what the cells around
//! say of it.
//!
//! Smooth is the square of the next speed, an energy: near where steps fall back the speed itself begins like a square root.
mod block;
mod field;
mod fill;

use super::map::{Cell, MapRequest};
use super::reason::Reason;
use super::workers::Watch;
use fill::Fill;
use serde::Serialize;

/// What is interpolated, and how closely.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sparing {
    /// Largest deviation of an interpolated next speed from the computed one, as a part of the speed of the map.
    pub tolerance: f64,
    /// Maps of a speed that have fewer cells are computed cell by cell.
    pub from_cells: usize,
    /// The axis along which cells have most of their work in common: those of one value of it are computed one after another.
    pub shared: usize,
    /// Both axes between which extremes are looked for.
    pub bounds: [[f64; 2]; 2],
}

/// What of a speed's map is interpolated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interpolation {
    /// Cells that were computed.
    pub computed: usize,
    /// Cells that were not.
    pub interpolated: usize,
    /// Cells that were interpolated and then computed to see how far off that is.
    pub checked: usize,
    /// The largest deviation of their next speeds, per s; none: no cell that has one was checked.
    pub largest_deviation: Option<f64>,
    /// From which deviation on more cells are computed, per s.
    pub tolerance: f64,
}

impl Sparing {
    /// Whether cells of a map with so many columns and rows are interpolated.
    pub fn interpolates(&self, [columns, rows]: [usize; 2]) -> bool {
        columns > 1 && rows > 1 && columns * rows >= self.from_cells
    }
}

impl MapRequest {
    /// Cells of a map, as [`MapRequest::cells`] has them, of which those are interpolated that are as smooth as `sparing` asks for; of
    /// each speed, what was interpolated (none: nothing). `at` computes the cell of a place's parameters for the speed with an index.
    ///
    /// Interpolated cells among the `known` ones count as missing. When `watch` asks for an end nothing is interpolated.
    pub fn cells_sparing(
        &self,
        known: &[Cell],
        sparing: &Sparing,
        watch: &Watch<'_>,
        at: impl Fn(&[f64], usize) -> Cell + Sync,
    ) -> (Vec<Cell>, Vec<Option<Interpolation>>) {
        let ([columns, rows], speeds) = (self.size(), self.speeds.len());
        let mut cells = vec![Cell::UNKNOWN; columns * rows * speeds];
        let mut found = Vec::new();
        for k in 0..speeds {
            let known: Vec<Cell> = (0..columns * rows)
                .map(|place| known.get(place * speeds + k).copied().filter(|cell| !cell.interpolated))
                .map(|cell| cell.unwrap_or(Cell::UNKNOWN))
                .collect();
            let part = |part: f64| (watch.advance)((k as f64 + part) / speeds as f64);
            let own = Watch { advance: &part, stop: watch.stop };
            let (own, interpolation) = if (watch.stop)() {
                (known, None)
            } else {
                let tolerance = sparing.tolerance * self.speeds[k];
                Fill::new(self, (sparing, tolerance), &own, known, |values: &[f64]| at(values, k)).filled()
            };
            found.push(interpolation);
            own.into_iter().enumerate().for_each(|(place, cell)| cells[place * speeds + k] = cell);
        }
        (cells, found)
    }
}

/// Whether something is known of a cell.
fn known(cell: &Cell) -> bool {
    cell.reason != Reason::NotComputed
}
