//! Blocks eliminated one after the other, in products of dense matrices.
use super::symbolic::Block;
use super::tiles::{SIDE, Target, subtract, subtract_in_place};
use std::ops::Range;

/// What blocks leave to those above them, the last on top: children come right before their parent. Blocks of odd levels have a side of their own, so that what a block
/// leaves stands where it stays while it takes its children's from the other side.
#[derive(Debug, Clone)]
pub(super) struct Stack {
    sides: [Side; 2],
    scratch: Vec<[f64; SIDE]>,
}

#[derive(Debug, Clone, Default)]
struct Side {
    left: Vec<f64>,
    top: usize,
}

/// Columns that are eliminated one by one before the others of their block are told.
const PANEL: usize = 24;
/// Columns that are updated at once: only what is on and below the diagonal is wanted.
const STRIP: usize = 48;

impl Stack {
    /// Large enough for these blocks.
    pub fn new(blocks: &[Block], range: Range<usize>) -> Self {
        let (mut tops, mut most) = ([0; 2], [0; 2]);
        for block in &blocks[range] {
            let side = block.level % 2;
            tops[side] += block.below.len().pow(2);
            most[side] = most[side].max(tops[side]);
            tops[1 - side] -= handed_on(blocks, block);
        }
        Self { sides: most.map(|most| Side { left: vec![0.0; most], top: 0 }), scratch: Vec::new() }
    }

    /// Nothing is on it.
    pub fn clear(&mut self) {
        self.sides.iter_mut().for_each(|side| side.top = 0);
    }

    /// What this block left, the only one whose block above was not eliminated yet.
    pub fn left(&self, block: &Block) -> &[f64] {
        let side = &self.sides[block.level % 2];
        &side.left[..side.top]
    }

    /// Eliminates some blocks in a row, whose columns and rows are these numbers. Positive pivots; none: one is zero or no number.
    pub fn eliminate(
        &mut self,
        blocks: &[Block],
        range: Range<usize>,
        matrix: (&[usize], &mut [f64]),
    ) -> Option<usize> {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
            // SAFETY: the processor has what the function is compiled for.
            return unsafe { self.eliminate_wide(blocks, range, matrix) };
        }
        self.each::<{ cfg!(target_arch = "aarch64") }>(blocks, range, matrix)
    }

    /// The same, compiled for wide registers whatever the rest of the program is compiled for.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn eliminate_wide(
        &mut self,
        blocks: &[Block],
        range: Range<usize>,
        matrix: (&[usize], &mut [f64]),
    ) -> Option<usize> {
        self.each::<true>(blocks, range, matrix)
    }

    #[inline(always)]
    fn each<const FMA: bool>(
        &mut self,
        blocks: &[Block],
        range: Range<usize>,
        (begins, values): (&[usize], &mut [f64]),
    ) -> Option<usize> {
        let first = begins[range.start];
        let mut positive = 0;
        for index in range {
            let own = &mut values[begins[index] - first..begins[index + 1] - first];
            positive += self.block::<FMA>(blocks, index, own)?;
        }
        Some(positive)
    }

    #[inline(always)]
    fn block<const FMA: bool>(&mut self, blocks: &[Block], index: usize, own: &mut [f64]) -> Option<usize> {
        let block = &blocks[index];
        let (width, below) = (block.width, block.below.len());
        let children = || block.children.iter().map(|&child| &blocks[child]);
        let [even, odd] = &mut self.sides;
        let (to, from) = if block.level.is_multiple_of(2) { (even, odd) } else { (odd, even) };
        let begin = from.top - handed_on(blocks, block);
        let mut rest = &from.left[begin..from.top];
        for child in children() {
            take_in(own, (width, below), child, rest);
            rest = &rest[child.below.len().pow(2)..];
        }
        let positive = eliminate::<FMA>(own, (width, below), &mut self.scratch)?;
        let left = &mut to.left[to.top..to.top + below * below];
        leave::<FMA>(own, (width, below), left, &mut self.scratch);
        let mut rest = &from.left[begin..from.top];
        for child in children() {
            hand_on(left, (width, below), child, rest);
            rest = &rest[child.below.len().pow(2)..];
        }
        from.top = begin;
        to.top += below * below;
        Some(positive)
    }

    /// What a block elsewhere leaves.
    pub fn push(&mut self, block: &Block, left: &[f64]) {
        let side = &mut self.sides[block.level % 2];
        side.left[side.top..side.top + left.len()].copy_from_slice(left);
        side.top += left.len();
    }
}

/// Numbers that children of a block leave to it.
fn handed_on(blocks: &[Block], block: &Block) -> usize {
    block.children.iter().map(|&child| blocks[child].below.len().pow(2)).sum()
}

/// Adds what a child leaves to the columns of a block itself; only places on and below the diagonal.
#[inline(always)]
fn take_in(own: &mut [f64], (width, below): (usize, usize), child: &Block, handed: &[f64]) {
    let (height, size) = (width + below, child.below.len());
    for (j, column) in child.columns_above().take_while(|(_, column)| *column < width) {
        let to = &mut own[column * height..(column + 1) * height];
        add(to, 0, child, (j, &handed[j * size..(j + 1) * size]));
    }
}

/// Adds the rest of it to what the block leaves.
#[inline(always)]
fn hand_on(left: &mut [f64], (width, below): (usize, usize), child: &Block, handed: &[f64]) {
    let size = child.below.len();
    for (j, column) in child.columns_above().skip_while(|(_, column)| *column < width) {
        let to = &mut left[(column - width) * below..(column - width + 1) * below];
        add(to, width, child, (j, &handed[j * size..(j + 1) * size]));
    }
}

/// Adds a child's column from its diagonal on to one that begins with this row.
#[inline(always)]
fn add(to: &mut [f64], first: usize, child: &Block, (j, values): (usize, &[f64])) {
    for &[begin, above, count] in &child.runs_above {
        let passed = j.saturating_sub(begin);
        if passed < count {
            let to = &mut to[above + passed - first..above + count - first];
            to.iter_mut().zip(&values[begin + passed..begin + count]).for_each(|(to, value)| *to += value);
        }
    }
}

/// Columns of a block become L, its diagonal D. The number of positive pivots; none: one is zero or no number.
#[inline(always)]
fn eliminate<const FMA: bool>(
    own: &mut [f64],
    (width, below): (usize, usize),
    scratch: &mut Vec<[f64; SIDE]>,
) -> Option<usize> {
    let height = width + below;
    let mut positive = 0;
    for begin in (0..width).step_by(PANEL) {
        let end = (begin + PANEL).min(width);
        for first in (begin..end).step_by(SIDE) {
            let last = (first + SIDE).min(end);
            // Columns before are those of the matrix still: what is taken away is a quotient times an element.
            turned(own, (begin..first, height), first..last, scratch, |x, pivot| x / pivot);
            let (done, open) = own.split_at_mut(first * height);
            if first > begin {
                let to = &mut Target { values: &mut open[first..], stride: height, counts: true };
                let shape = [height - first, first - begin, last - first];
                subtract_in_place(to, (&done[begin * height + first..], height), scratch, shape);
            }
            positive += few_columns(&mut open[..(last - first) * height], first, height)?;
        }
        for k in begin..end {
            let column = &mut own[k * height + k..(k + 1) * height];
            let pivot = column[0];
            column[1..].iter_mut().for_each(|l| *l /= pivot);
        }
        for first in (end..width).step_by(STRIP) {
            let columns = STRIP.min(width - first);
            turned(own, (begin..end, height), first..first + columns, scratch, |l, pivot| l * pivot);
            let (done, open) = own.split_at_mut(first * height);
            let to = &mut Target { values: &mut open[first..], stride: height, counts: true };
            let shape = [height - first, end - begin, columns];
            subtract::<FMA>(to, (&done[begin * height + first..], height), scratch, shape);
        }
    }
    Some(positive)
}

/// Takes columns, of which the first has its diagonal in this row, from those behind them. Positive pivots, as above.
#[inline(always)]
fn few_columns(columns: &mut [f64], first: usize, height: usize) -> Option<usize> {
    let mut positive = 0;
    for k in 0..columns.len() / height {
        let (column, rest) = columns[k * height..].split_at_mut(height);
        let pivot = column[first + k];
        if pivot == 0.0 || !pivot.is_finite() {
            return None;
        }
        positive += usize::from(pivot > 0.0);
        for (j, to) in rest.chunks_exact_mut(height).enumerate() {
            let row = first + k + 1 + j;
            let factor = column[row] / pivot;
            to[row..].iter_mut().zip(&column[row..]).for_each(|(to, l)| *to -= factor * l);
        }
    }
    Some(positive)
}

/// What an operation makes of elements of these columns and rows and of their column's pivot: four rows side by side, column after column, then the next four.
#[inline(always)]
fn turned(
    own: &[f64],
    (columns, height): (Range<usize>, usize),
    rows: Range<usize>,
    out: &mut Vec<[f64; SIDE]>,
    operation: impl Fn(f64, f64) -> f64,
) {
    out.clear();
    for first in rows.clone().step_by(SIDE) {
        let count = SIDE.min(rows.end - first);
        for k in columns.clone() {
            let (mut four, pivot) = ([0.0; SIDE], own[k * height + k]);
            let elements = &own[k * height + first..][..count];
            four.iter_mut().zip(elements).for_each(|(to, x)| *to = operation(*x, pivot));
            out.push(four);
        }
    }
}

/// What the eliminated columns of a block leave to the rows below, on and below the diagonal.
#[inline(always)]
fn leave<const FMA: bool>(
    own: &[f64],
    (width, below): (usize, usize),
    left: &mut [f64],
    scratch: &mut Vec<[f64; SIDE]>,
) {
    let height = width + below;
    for first in (0..below).step_by(STRIP) {
        let columns = STRIP.min(below - first);
        let rows = width + first..width + first + columns;
        turned(own, (0..width, height), rows, scratch, |l, pivot| l * pivot);
        let to = &mut Target { values: &mut left[first * below + first..], stride: below, counts: false };
        let shape = [below - first, width, columns];
        subtract::<FMA>(to, (&own[width + first..], height), scratch, shape);
    }
}
