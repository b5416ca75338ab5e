//! Cells of one speed, and what those that were computed say of others.
use super::block::{Block, depths};
use super::known;
use crate::gait::map::Cell;

/// How far apart cells may be between which is interpolated.
pub(super) const WIDEST: usize = 20;

/// Cells, row after row.
pub(super) struct Field {
    pub size: [usize; 2],
    pub cells: Vec<Cell>,
    /// Of columns and of rows, how often blocks are halved until they are an end.
    depths: [Vec<u8>; 2],
    /// Those between which is interpolated.
    nodes: Vec<bool>,
}

impl Field {
    pub fn new(size: [usize; 2]) -> Self {
        let count = size[0] * size[1];
        let depths = size.map(|count| depths(count, WIDEST));
        Self { size, cells: vec![Cell::UNKNOWN; count], depths, nodes: vec![false; count] }
    }

    pub fn place(&self, [x, y]: [usize; 2]) -> usize {
        y * self.size[0] + x
    }

    pub fn get(&self, at: [usize; 2]) -> Cell {
        self.cells[self.place(at)]
    }

    /// From now on the cell is one of those between which is interpolated.
    pub fn make_node(&mut self, at: [usize; 2]) {
        let place = self.place(at);
        self.nodes[place] = true;
    }

    /// Whether it is one of them.
    pub fn is_node(&self, at: [usize; 2]) -> bool {
        self.nodes[self.place(at)]
    }

    /// The square of the next speed of a node, if the cell is one; `Err`: nothing is interpolated across it.
    fn square(&self, at: [usize; 2]) -> Result<Option<f64>, ()> {
        let place = self.place(at);
        if !self.nodes[place] || !known(&self.cells[place]) {
            return Ok(None);
        }
        self.cells[place].next_speed.map(|speed| Some(speed * speed)).ok_or(())
    }

    /// The next speed in a cell of a block as all nodes have it: squares on cubics along the rows, then across them.
    pub fn between(&self, block: &Block, at: [usize; 2]) -> Option<f64> {
        root(self.across(0, block, at, |_| true))
    }

    /// The next speed in the middle of a block along an axis, as nodes that are less deep along that axis have it.
    pub fn predicted(&self, axis: usize, block: &Block, at: [usize; 2]) -> Option<f64> {
        let (depths, other) = (&self.depths[axis], 1 - axis);
        root(self.across(other, block, at, |place| depths[place] < depths[at[axis]]))
    }

    /// The square in a cell between values along the lines of an axis (0: rows) that count: cubics along these lines, then one across them.
    fn across(
        &self,
        axis: usize,
        block: &Block,
        at: [usize; 2],
        counts: impl Fn(usize) -> bool,
    ) -> Option<f64> {
        let ([first, last], [low, high]) = (block.ends[axis], block.ends[1 - axis]);
        let line = |place: usize| {
            if !counts(place) {
                return Ok(None);
            }
            let mut cell = at;
            cell[1 - axis] = place;
            // Nodes of other blocks on a line through this one are too far apart; beside it they may be somewhat farther.
            let own = (last - first).div_ceil(2);
            let most = if (low..=high).contains(&place) { own } else { 2 * own };
            self.along(axis, cell, most)
        };
        interpolated(at[1 - axis], self.size[1 - axis], WIDEST, line)
    }

    /// The square in a cell by nodes of its row or column alone, if those around it are not farther apart than so many cells.
    fn along(&self, axis: usize, at: [usize; 2], most: usize) -> Result<Option<f64>, ()> {
        let node = |place: usize| {
            let mut cell = at;
            cell[axis] = place;
            self.square(cell)
        };
        match node(at[axis]) {
            Ok(None) => Ok(interpolated(at[axis], self.size[axis], most, node)),
            found => found,
        }
    }
}

fn root(square: Option<f64>) -> Option<f64> {
    square.filter(|square| *square > 0.0).map(f64::sqrt)
}

/// The value at a place of a line: its own, or by the cubic through the nearest two on either side, or as many as there are; none beyond the
/// outermost ones, nor where those around it are farther apart than `most`. `value` has those that are known, `Err`: nothing beyond it counts.
fn interpolated(
    at: usize,
    count: usize,
    most: usize,
    value: impl Fn(usize) -> Result<Option<f64>, ()>,
) -> Option<f64> {
    if let Some(here) = value(at).ok()? {
        return Some(here);
    }
    let find = |from: usize, down: bool| -> Option<(f64, f64)> {
        for step in 1..=WIDEST {
            let place =
                if down { from.checked_sub(step)? } else { Some(from + step).filter(|x| *x < count)? };
            if let Some(found) = value(place).ok()? {
                return Some((place as f64, found));
            }
        }
        None
    };
    let mut nodes = vec![find(at, true)?, find(at, false)?];
    if nodes[1].0 - nodes[0].0 > most as f64 {
        return None;
    }
    let outward = |from: (f64, f64), down: bool| find(from.0 as usize, down);
    let outer = [outward(nodes[0], true), outward(nodes[1], false)];
    let further = match outer {
        [None, Some(upper)] => outward(upper, false),
        [Some(lower), None] => outward(lower, true),
        _ => None,
    };
    nodes.extend(outer.into_iter().chain([further]).flatten());
    Some(polynomial(&nodes, at as f64))
}

/// The polynomial through points (Lagrange).
fn polynomial(points: &[(f64, f64)], x: f64) -> f64 {
    let weight = |k: usize| {
        let others = points.iter().enumerate().filter(|(j, _)| *j != k);
        others.map(|(_, (other, _))| (x - other) / (points[k].0 - other)).product::<f64>()
    };
    (0..points.len()).map(|k| weight(k) * points[k].1).sum()
}

#[cfg(test)]
mod tests {
    use super::super::block::Block;
    use super::Field;
    use crate::gait::map::Cell;
    use crate::gait::reason::Reason;

    #[test]
    fn cubics_of_the_square_come_back_and_nothing_passes_a_cell_that_fails() {
        let mut field = Field::new([33, 20]);
        let whole = Block { ends: [[0, 32], [0, 19]] };
        let square = |[x, y]: [usize; 2]| {
            let [x, y] = [x as f64 / 10.0, y as f64 / 10.0];
            20.0 + x - 0.3 * x * x * x + y * y * x - 0.2 * y * y * y
        };
        for x in (0..33).step_by(4) {
            for y in [0, 3, 6, 11, 16, 19] {
                let place = field.place([x, y]);
                field.cells[place] = Cell::passing(square([x, y]).sqrt());
                field.make_node([x, y]);
            }
        }
        for at in [[1, 1], [5, 11], [8, 12], [31, 18], [32, 1]] {
            let found = field.between(&whole, at).unwrap();
            assert!((found - square(at).sqrt()).abs() < 1e-12, "{at:?}: {found}");
        }
        // Nodes on a line through a block that are farther apart than its own say nothing.
        let small = Block { ends: [[5, 7], [6, 16]] };
        assert!(field.between(&small, [6, 11]).is_none());
        // Columns 0, 16 and 32 are ends of the whole, 8 and 24 of halves: of them alone a parabola remains.
        let found = field.predicted(0, &whole, [8, 11]).unwrap();
        assert!((found - square([8, 11]).sqrt()).abs() > 1e-6, "{found}");
        // There is something to go by as long as rows on either side have it.
        for y in [11, 0, 3, 16, 19] {
            assert!(field.between(&whole, [5, 11]).is_some(), "{y}");
            let place = field.place([8, y]);
            field.cells[place] = Cell::failing(Reason::FallsBack);
        }
        assert_eq!(field.between(&whole, [5, 11]), None);
    }
}
