//! Blocks eliminated one after the other, in products of dense matrices.
use super::symbolic::Block;
use nalgebra::{DMatrixView, DMatrixViewMut, Dyn};
use std::ops::Range;

/// What blocks leave to those above them, the last on top: children come right before their parent.
#[derive(Debug, Clone)]
pub(super) struct Stack {
    left: Vec<f64>,
    top: usize,
    scratch: Vec<f64>,
}

/// Columns that are eliminated one by one before the others of their block are told.
const PANEL: usize = 24;
/// Columns that are updated at once: only what is on and below the diagonal is wanted.
const STRIP: usize = 48;
/// Products of so few columns are summed one by one.
const FEW: usize = 4;

impl Stack {
    /// Large enough for these blocks.
    pub fn new(blocks: &[Block], range: Range<usize>) -> Self {
        let (mut top, mut most) = (0, 0);
        for block in &blocks[range] {
            let own = block.below.len().pow(2);
            most = most.max(top + own);
            top = top + own
                - block.children.iter().map(|&child| blocks[child].below.len().pow(2)).sum::<usize>();
        }
        Self { left: vec![0.0; most], top: 0, scratch: Vec::new() }
    }

    /// Nothing is on it.
    pub fn clear(&mut self) {
        self.top = 0;
    }

    /// All that is on it.
    pub fn left(&self) -> &[f64] {
        &self.left[..self.top]
    }

    /// Eliminates some blocks in a row, whose columns and rows are these numbers. Positive pivots; none: one is zero or no number.
    pub fn eliminate(
        &mut self,
        blocks: &[Block],
        range: Range<usize>,
        (begins, values): (&[usize], &mut [f64]),
    ) -> Option<usize> {
        let first = begins[range.start];
        let mut positive = 0;
        for index in range {
            let own = &mut values[begins[index] - first..begins[index + 1] - first];
            positive += self.block(blocks, index, own)?;
        }
        Some(positive)
    }

    fn block(&mut self, blocks: &[Block], index: usize, own: &mut [f64]) -> Option<usize> {
        let block = &blocks[index];
        let (width, below) = (block.width, block.below.len());
        let children = || block.children.iter().map(|&child| &blocks[child].place_above);
        let begin = self.top - children().map(|places| places.len().pow(2)).sum::<usize>();
        let (handed, free) = self.left.split_at_mut(self.top);
        let mut rest = &handed[begin..];
        for places in children() {
            take_in(own, (width, below), places, rest);
            rest = &rest[places.len().pow(2)..];
        }
        let positive = eliminate(own, width, below, &mut self.scratch)?;
        let left = &mut free[..below * below];
        leave(own, (width, below), left, &mut self.scratch);
        let mut rest = &handed[begin..];
        for places in children() {
            hand_on(left, (width, below), places, rest);
            rest = &rest[places.len().pow(2)..];
        }
        if begin < self.top {
            self.left.copy_within(self.top..self.top + below * below, begin);
        }
        self.top = begin + below * below;
        Some(positive)
    }

    /// What a block elsewhere leaves.
    pub fn push(&mut self, left: &[f64]) {
        self.left[self.top..self.top + left.len()].copy_from_slice(left);
        self.top += left.len();
    }
}

/// Adds what a child leaves to the columns of a block itself; only places on and below the diagonal.
fn take_in(own: &mut [f64], (width, below): (usize, usize), places: &[usize], handed: &[f64]) {
    let (height, size) = (width + below, places.len());
    for (j, &column) in places.iter().enumerate().take_while(|(_, column)| **column < width) {
        let to = &mut own[column * height..(column + 1) * height];
        let values = &handed[j * size + j..(j + 1) * size];
        places[j..].iter().zip(values).for_each(|(&row, value)| to[row] += value);
    }
}

/// Adds the rest of it to what the block leaves.
fn hand_on(left: &mut [f64], (width, below): (usize, usize), places: &[usize], handed: &[f64]) {
    let size = places.len();
    for j in places.partition_point(|place| *place < width)..size {
        let to = &mut left[(places[j] - width) * below..(places[j] - width + 1) * below];
        let values = &handed[j * size + j..(j + 1) * size];
        places[j..].iter().zip(values).for_each(|(&row, value)| to[row - width] += value);
    }
}

/// C −= A B, or C = −A B: C from an offset with columns `stride` apart, A likewise, B column after column.
fn subtract(
    (c, stride, adds): (&mut [f64], usize, bool),
    (a, a_stride): (&[f64], usize),
    b: &[f64],
    [rows, inner, columns]: [usize; 3],
) {
    if rows == 0 || columns == 0 || inner == 0 {
        return;
    }
    if inner <= FEW {
        for (j, factors) in b.chunks_exact(inner).enumerate() {
            // Nothing above the diagonal is wanted.
            let c = &mut c[j * stride + j..j * stride + rows];
            if !adds {
                c.fill(0.0);
            }
            for (k, factor) in factors.iter().enumerate() {
                let a = &a[k * a_stride + j..k * a_stride + rows];
                c.iter_mut().zip(a).for_each(|(c, a)| *c -= factor * a);
            }
        }
        return;
    }
    let a = DMatrixView::from_slice_with_strides_generic(a, Dyn(rows), Dyn(inner), Dyn(1), Dyn(a_stride));
    let b = DMatrixView::from_slice_with_strides_generic(b, Dyn(inner), Dyn(columns), Dyn(1), Dyn(inner));
    let mut c =
        DMatrixViewMut::from_slice_with_strides_generic(c, Dyn(rows), Dyn(columns), Dyn(1), Dyn(stride));
    c.gemm(-1.0, &a, &b, f64::from(u8::from(adds)));
}

/// Columns of a block become L, its diagonal D. The number of positive pivots; none: one is zero or no number.
fn eliminate(own: &mut [f64], width: usize, below: usize, scratch: &mut Vec<f64>) -> Option<usize> {
    let height = width + below;
    let mut positive = 0;
    for begin in (0..width).step_by(PANEL) {
        let end = (begin + PANEL).min(width);
        for k in begin..end {
            let pivot = own[k * height + k];
            if pivot == 0.0 || !pivot.is_finite() {
                return None;
            }
            positive += usize::from(pivot > 0.0);
            let (column, rest) = own[k * height..].split_at_mut(height);
            for j in k + 1..end {
                let factor = column[j] / pivot;
                if factor != 0.0 {
                    let to = &mut rest[(j - k - 1) * height + j..(j - k) * height];
                    to.iter_mut().zip(&column[j..]).for_each(|(to, l)| *to -= factor * l);
                }
            }
            column[k + 1..].iter_mut().for_each(|l| *l /= pivot);
        }
        for first in (end..width).step_by(STRIP) {
            let columns = STRIP.min(width - first);
            turned(own, (begin..end, height), first..first + columns, scratch);
            let (done, open) = own.split_at_mut(first * height);
            let shape = [height - first, end - begin, columns];
            subtract(
                (&mut open[first..], height, true),
                (&done[begin * height + first..], height),
                scratch,
                shape,
            );
        }
    }
    Some(positive)
}

/// D Lᵀ of these columns and rows, column after column.
fn turned(
    own: &[f64],
    (columns, height): (std::ops::Range<usize>, usize),
    rows: std::ops::Range<usize>,
    out: &mut Vec<f64>,
) {
    out.clear();
    for row in rows {
        out.extend(columns.clone().map(|k| own[k * height + row] * own[k * height + k]));
    }
}

/// What the eliminated columns of a block leave to the rows below, on and below the diagonal.
fn leave(own: &[f64], (width, below): (usize, usize), left: &mut [f64], scratch: &mut Vec<f64>) {
    let height = width + below;
    for first in (0..below).step_by(STRIP) {
        let columns = STRIP.min(below - first);
        turned(own, (0..width, height), width + first..width + first + columns, scratch);
        let shape = [below - first, width, columns];
        let to = &mut left[first * below + first..];
        subtract((to, below, false), (&own[width + first..], height), scratch, shape);
    }
}
