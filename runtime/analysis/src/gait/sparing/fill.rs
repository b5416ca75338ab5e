//! One speed's map, from a few cells to all.
use super::block::{Block, three};
use super::field::{Field, WIDEST};
use super::{Interpolation, Sparing, known};
use crate::gait::map::{Cell, MapRequest};
use crate::gait::workers::{Watch, in_parallel};
use std::collections::{BTreeMap, BTreeSet};

/// Nodes of a block have to be predicted this many times as closely as is asked of what is interpolated between them.
const SAFETY: f64 = 4.0;
/// Of so many interpolated cells one is computed.
const CHECKED: u64 = 200;
/// Cells that one worker computes in one go.
const TOGETHER: usize = 3;

/// A column and a row.
type At = [usize; 2];

/// A map that is being filled.
pub(super) struct Fill<'a, F> {
    request: &'a MapRequest,
    sparing: &'a Sparing,
    /// Largest deviation of an interpolated speed, per s.
    tolerance: f64,
    watch: &'a Watch<'a>,
    /// Cells that were computed before.
    known: Vec<Cell>,
    at: F,
    field: Field,
    /// Blocks that are interpolated.
    leaves: Vec<Block>,
    /// Cells that were interpolated before they were computed.
    checked: BTreeSet<At>,
    /// How many cells were computed.
    done: usize,
}

impl<'a, F: Fn(&[f64]) -> Cell + Sync> Fill<'a, F> {
    pub fn new(
        request: &'a MapRequest,
        (sparing, tolerance): (&'a Sparing, f64),
        watch: &'a Watch<'a>,
        known: Vec<Cell>,
        at: F,
    ) -> Self {
        let field = Field::new(request.size());
        Self {
            request,
            sparing,
            tolerance,
            watch,
            known,
            at,
            field,
            leaves: Vec::new(),
            checked: BTreeSet::new(),
            done: 0,
        }
    }

    /// All cells, and what was interpolated; none: nothing, or the end came early.
    pub fn filled(mut self) -> (Vec<Cell>, Option<Interpolation>) {
        let [columns, rows] = self.field.size;
        let all = columns * rows;
        let whole = if !self.sparing.interpolates(self.field.size) {
            let every = (0..columns).flat_map(|x| (0..rows).map(move |y| [x, y])).collect();
            self.compute(every, 0).then_some(None)
        } else {
            self.refined().map(Some)
        };
        // Before everything is known, nobody has seen whether what is interpolated holds.
        let ended = whole.is_none();
        for (cell, before) in self.field.cells.iter_mut().zip(&self.known) {
            if cell.interpolated && (ended || known(before)) || !known(cell) {
                *cell = *before;
            }
        }
        let counted = |found: Interpolation| {
            let interpolated = self.field.cells.iter().filter(|cell| cell.interpolated).count();
            Interpolation { computed: all - interpolated, interpolated, ..found }
        };
        let found = whole.flatten().map(counted);
        (self.field.cells, found)
    }

    /// Computes and interpolates until everything is known and nothing that was computed to see is off; none: an end was asked for.
    fn refined(&mut self) -> Option<Interpolation> {
        let blocks = Block::all(self.field.size, WIDEST);
        let corners: BTreeSet<At> = blocks.iter().flat_map(Block::corners).collect();
        self.compute(corners.iter().copied().collect(), 2 * blocks.len()).then_some(())?;
        corners.into_iter().for_each(|at| self.field.make_node(at));
        self.halve(blocks)?;
        loop {
            self.interpolate();
            let open = self.to_be_checked();
            self.compute(open.iter().copied().collect(), 0).then_some(())?;
            let none = open.is_empty();
            self.checked.extend(open);
            // What lies between others was right once, and need not be so with more of them.
            let wrong: Vec<At> = self.checked.iter().copied().filter(|&at| self.is_off(at)).collect();
            if none && wrong.is_empty() {
                break;
            }
            let again = self.opened(&wrong);
            self.halve(again)?;
        }
        Some(self.interpolation())
    }

    /// Blocks become such as are interpolated, in halves of halves.
    fn halve(&mut self, mut blocks: Vec<Block>) -> Option<()> {
        while !blocks.is_empty() {
            let nodes: BTreeSet<At> = blocks.iter().flat_map(Block::nodes).collect();
            self.compute(nodes.iter().copied().collect(), blocks.len()).then_some(())?;
            nodes.into_iter().for_each(|at| self.field.make_node(at));
            let mut next = Vec::new();
            for block in blocks {
                match [0, 1].map(|axis| !self.is_smooth(&block, axis)) {
                    [false, false] => self.leaves.push(block),
                    axes => next.extend(block.parts(axes).filter(Block::has_middle)),
                }
            }
            blocks = next;
        }
        Some(())
    }

    /// Whether the middles of a block along an axis are what its ends, and those around, say of them.
    fn is_smooth(&self, block: &Block, axis: usize) -> bool {
        let [first, last] = block.ends[axis];
        let (middle, other) = (usize::midpoint(first, last), 1 - axis);
        if middle == first {
            return true;
        }
        three(block.ends[other]).all(|line| {
            let at = |place: usize| if axis == 0 { [place, line] } else { [line, place] };
            let known = self.field.get(at(middle));
            let same = [first, last].iter().all(|&end| self.field.get(at(end)).reason == known.reason);
            let Some(speed) = known.next_speed else { return same };
            let most = self.tolerance / SAFETY;
            same && self
                .field
                .predicted(axis, block, at(middle))
                .is_some_and(|found| (found - speed).abs() <= most)
        })
    }

    /// Fills all blocks that are settled.
    fn interpolate(&mut self) {
        for block in std::mem::take(&mut self.leaves) {
            for at in block.cells() {
                let place = self.field.place(at);
                if self.is_open(at) {
                    self.field.cells[place] = self.between(&block, at);
                }
            }
            self.leaves.push(block);
        }
    }

    /// An interpolated cell of a block; unknown where a cell on its border contradicts.
    fn between(&self, block: &Block, at: At) -> Cell {
        // Where columns are not all alike there are but two of them, and so with rows.
        let alike = [0, 1].map(|axis| {
            let [first, last] = block.ends[axis];
            if last - first < 2 { at[axis] } else { first }
        });
        let Cell { next_speed, reason, .. } = self.field.get(alike);
        if next_speed.is_none() {
            return Cell { interpolated: true, ..Cell::failing(reason) };
        }
        let speed = self.field.between(block, at);
        speed.map_or(Cell::UNKNOWN, |speed| Cell { interpolated: true, reason, ..Cell::passing(speed) })
    }

    /// Cells that are to be computed: some of those that are interpolated, those that cannot be, and the extremes.
    fn to_be_checked(&self) -> BTreeSet<At> {
        let size = self.field.size;
        let all = || (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
        let mut found: BTreeSet<At> = all().filter(|&at| drawn(at)).collect();
        let inside = |at: &At| {
            let mut axes = self.request.axes.iter().zip(at).zip(self.sparing.bounds);
            axes.all(|(((_, values), &k), [low, high])| (low..=high).contains(&values[k]))
        };
        let good = all().filter(inside).filter_map(|at| Some((self.field.get(at).good()?, at)));
        found.extend(good.clone().reduce(|a, b| if b.0 > a.0 { b } else { a }).map(|(_, at)| at));
        found.extend(good.reduce(|a, b| if b.0 < a.0 { b } else { a }).map(|(_, at)| at));
        found.retain(|&at| self.field.get(at).interpolated);
        found.extend(all().filter(|&at| !known(&self.field.get(at))));
        found
    }

    /// What a block has in a cell that was computed, if it is interpolated there.
    fn predicted(&self, at: At) -> Option<Cell> {
        let block = self.leaves.iter().find(|block| block.holds(at))?;
        Some(self.between(block, at))
    }

    /// How far what was interpolated is from what was computed, per s; none: there is no speed, or nothing was interpolated.
    fn deviation(&self, at: At) -> Option<f64> {
        let (predicted, found) = (self.predicted(at)?.next_speed, self.field.get(at).next_speed);
        match (predicted, found) {
            (Some(predicted), Some(found)) => Some((predicted - found).abs()),
            (None, None) => None,
            _ => Some(f64::INFINITY),
        }
    }

    /// Whether what was interpolated is not what was computed.
    fn is_off(&self, at: At) -> bool {
        let other = self.predicted(at).is_some_and(|predicted| predicted.reason != self.field.get(at).reason);
        other || self.deviation(at).is_some_and(|deviation| deviation > self.tolerance)
    }

    /// Parts of all blocks around cells that are off; they are interpolated no more.
    fn opened(&mut self, wrong: &[At]) -> Vec<Block> {
        let own: Vec<Block> =
            self.leaves.iter().copied().filter(|block| wrong.iter().any(|&at| block.holds(at))).collect();
        if own.is_empty() {
            return own;
        }
        let (open, kept): (Vec<Block>, Vec<Block>) =
            self.leaves.iter().partition(|block| own.iter().any(|own| own.touches(block)));
        self.leaves = kept;
        for at in open.iter().flat_map(Block::cells) {
            let place = self.field.place(at);
            if self.field.cells[place].interpolated {
                self.field.cells[place] = Cell::UNKNOWN;
            }
        }
        open.iter().flat_map(|block| block.parts([true; 2])).filter(Block::has_middle).collect()
    }

    /// Whether a cell was not computed yet.
    fn is_open(&self, at: At) -> bool {
        let cell = self.field.get(at);
        cell.interpolated || !known(&cell)
    }

    /// Computes cells that are not known yet; `false`: an end was asked for. So many blocks will be halved afterwards, as far as anybody knows.
    fn compute(&mut self, mut wanted: Vec<At>, blocks: usize) -> bool {
        for &at in &wanted {
            let place = self.field.place(at);
            if self.is_open(at) && known(&self.known[place]) {
                self.field.cells[place] = self.known[place];
            }
        }
        wanted.retain(|&at| self.is_open(at));
        let jobs = jobs(wanted, self.sparing.shared.min(1));
        let (before, count) = (self.done, jobs.iter().map(Vec::len).sum::<usize>());
        // What is left is known when it is done; blocks have come to some four cells each.
        let left = 4.0 * blocks as f64;
        let advance = |part: f64| {
            let now = before as f64 + part * count as f64;
            (self.watch.advance)(now / ((before + count) as f64 + left));
        };
        let watch = Watch { advance: &advance, stop: self.watch.stop };
        let (request, at) = (self.request, &self.at);
        let found = in_parallel(jobs.len(), &watch, |job| {
            let cells = jobs[job].iter().map(|&[x, y]| at(&request.at(x, y)));
            cells.collect::<Vec<_>>()
        });
        let mut computed = 0;
        for (job, cells) in found {
            for (&at, cell) in jobs[job].iter().zip(cells) {
                let place = self.field.place(at);
                self.field.cells[place] = cell;
                computed += 1;
            }
        }
        self.done += computed;
        // Few cells have all begun before anybody is asked.
        computed == count && (count == 0 || !(self.watch.stop)())
    }

    /// What became of cells that were checked.
    fn interpolation(&self) -> Interpolation {
        let checked = || self.checked.iter().filter(|&&at| !self.field.is_node(at));
        Interpolation {
            computed: 0,
            interpolated: 0,
            checked: checked().count(),
            largest_deviation: checked().filter_map(|&at| self.deviation(at)).reduce(f64::max),
            tolerance: self.tolerance,
        }
    }
}

/// Whether a cell is one of those that are computed if they were interpolated: always the same ones (a hash of the place).
fn drawn([x, y]: At) -> bool {
    let mut hash = (x as u64) << 32 | y as u64;
    for factor in [0xbf58_476d_1ce4_e5b9_u64, 0x94d0_49bb_1331_11eb] {
        hash = (hash ^ hash >> 30).wrapping_add(0x9e37_79b9_7f4a_7c15).wrapping_mul(factor);
    }
    (hash ^ hash >> 31).is_multiple_of(CHECKED)
}

/// Cells in parts for workers: those with the same value of the shared axis one after another, the first part of every value before all
/// second ones, so that what they share is found by one worker while others are elsewhere.
fn jobs(cells: Vec<At>, shared: usize) -> Vec<Vec<At>> {
    let mut by_value: BTreeMap<usize, Vec<At>> = BTreeMap::new();
    cells.into_iter().for_each(|at| by_value.entry(at[shared]).or_default().push(at));
    let mut parts: Vec<(usize, Vec<At>)> = by_value
        .into_values()
        .flat_map(|cells| cells.chunks(TOGETHER).map(<[At]>::to_vec).enumerate().collect::<Vec<_>>())
        .collect();
    parts.sort_by_key(|(turn, _)| *turn);
    parts.into_iter().map(|(_, cells)| cells).collect()
}
