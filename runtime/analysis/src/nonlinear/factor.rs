//! L D Lᵀ of a sparse symmetric matrix without exchanges of pivots, in dense blocks (a multifrontal method): what a block leaves is handed to the block above it in
//! the elimination tree, so that nearly all work is products of dense matrices.
use super::symbolic::Structure;
use clarabel::algebra::CscMatrix;
use clarabel::qdldl::{QDLDLFactorisation, QDLDLSettingsBuilder};
use nalgebra::{DMatrixView, DMatrixViewMut, DVector, Dyn};

/// A factor with the structure that it keeps from one matrix to the next.
pub(super) struct Factor {
    structure: Structure,
    /// Of each block its columns with the rows below, column after column: first the matrix, then L with D on its diagonal.
    values: Vec<f64>,
    /// Where each block begins in `values`, and the end of all.
    begins: Vec<usize>,
    /// Of each element of the matrix: its place in `values`.
    places: Vec<usize>,
    positive: usize,
    /// What blocks leave to those above them, the last on top: children come right before their parent.
    left: Vec<f64>,
    scratch: Vec<f64>,
}

/// Columns that are eliminated one by one before the others of their block are told.
const PANEL: usize = 24;
/// Columns that are updated at once: only what is on and below the diagonal is wanted.
const STRIP: usize = 48;
/// Products of so few columns are summed one by one.
const FEW: usize = 4;

impl Factor {
    /// For matrices with this upper triangle (columns, rows), ordered by approximate minimum degree. None: it has no such ordering.
    pub fn new(columns: &[usize], rows: &[usize]) -> Option<Self> {
        let n = columns.len() - 1;
        let order = ordering(columns, rows)?;
        let structure = Structure::new((columns, rows), &order);
        let mut begins = vec![0];
        for block in &structure.blocks {
            begins.push(begins[begins.len() - 1] + block.width * (block.width + block.below.len()));
        }
        let mut places = Vec::with_capacity(rows.len());
        for column in 0..n {
            for &row in &rows[columns[column]..columns[column + 1]] {
                let (a, b) = (structure.place[row], structure.place[column]);
                let (column, row) = (a.min(b), a.max(b));
                let index = structure.block_of[column];
                let block = &structure.blocks[index];
                let height = block.width + block.below.len();
                let local = match row.checked_sub(block.first + block.width) {
                    None => row - block.first,
                    Some(_) => block.width + block.below.binary_search(&row).ok()?,
                };
                places.push(begins[index] + (column - block.first) * height + local);
            }
        }
        let left = vec![0.0; most_left(&structure)];
        let values = vec![0.0; begins[begins.len() - 1]];
        Some(Self { structure, values, begins, places, positive: 0, left, scratch: Vec::new() })
    }

    /// Factorises; false: a pivot is zero or no number.
    pub fn factorise(&mut self, matrix: &[f64]) -> bool {
        self.values.fill(0.0);
        for (&place, value) in self.places.iter().zip(matrix) {
            self.values[place] += value;
        }
        self.positive = 0;
        // Where the top of what is left lies.
        let mut top = 0;
        for index in 0..self.structure.blocks.len() {
            let block = &self.structure.blocks[index];
            let (width, below) = (block.width, block.below.len());
            let own = &mut self.values[self.begins[index]..self.begins[index + 1]];
            let children = || block.children.iter().map(|&child| &self.structure.blocks[child].place_above);
            let begin = top - children().map(|places| places.len().pow(2)).sum::<usize>();
            let (handed, free) = self.left.split_at_mut(top);
            let mut rest = &handed[begin..];
            for places in children() {
                take_in(own, (width, below), places, rest);
                rest = &rest[places.len().pow(2)..];
            }
            let Some(positive) = eliminate(own, width, below, &mut self.scratch) else { return false };
            self.positive += positive;
            let left = &mut free[..below * below];
            leave(own, (width, below), left, &mut self.scratch);
            let mut rest = &handed[begin..];
            for places in children() {
                hand_on(left, (width, below), places, rest);
                rest = &rest[places.len().pow(2)..];
            }
            self.left.copy_within(top..top + below * below, begin);
            top = begin + below * below;
        }
        true
    }

    /// Number of positive pivots.
    pub fn positive(&self) -> usize {
        self.positive
    }

    /// Solves in place.
    pub fn solve(&self, right: &mut [f64]) {
        let mut x = DVector::from_iterator(right.len(), self.structure.order.iter().map(|&k| right[k]));
        let most = self.structure.blocks.iter().map(|block| block.below.len()).max().unwrap_or(0);
        let mut room = DVector::zeros(most);
        for (index, block) in self.structure.blocks.iter().enumerate() {
            let own = self.columns(index);
            let rows = own.rows(block.width, block.below.len());
            for k in 0..block.width {
                let (value, rest) = (x[block.first + k], block.width - k - 1);
                x.rows_mut(block.first + k + 1, rest).axpy(-value, &own.column(k).rows(k + 1, rest), 1.0);
            }
            let mut below = room.rows_mut(0, block.below.len());
            below.gemv(1.0, &rows, &x.rows(block.first, block.width), 0.0);
            block.below.iter().zip(below.iter()).for_each(|(&row, sum)| x[row] -= sum);
        }
        for (index, block) in self.structure.blocks.iter().enumerate().rev() {
            let own = self.columns(index);
            let rows = own.rows(block.width, block.below.len());
            let mut below = room.rows_mut(0, block.below.len());
            below.iter_mut().zip(&block.below).for_each(|(to, &row)| *to = x[row]);
            for k in 0..block.width {
                x[block.first + k] /= own[(k, k)];
            }
            x.rows_mut(block.first, block.width).gemv_tr(-1.0, &rows, &below, 1.0);
            for k in (0..block.width).rev() {
                let rest = block.width - k - 1;
                let sum = own.column(k).rows(k + 1, rest).dot(&x.rows(block.first + k + 1, rest));
                x[block.first + k] -= sum;
            }
        }
        self.structure.order.iter().zip(x.iter()).for_each(|(&column, &value)| right[column] = value);
    }

    /// Columns of a block: L with D on its diagonal.
    fn columns(&self, index: usize) -> DMatrixView<'_, f64> {
        let block = &self.structure.blocks[index];
        let values = &self.values[self.begins[index]..self.begins[index + 1]];
        DMatrixView::from_slice(values, block.width + block.below.len(), block.width)
    }
}

/// An order of elimination with little fill.
fn ordering(columns: &[usize], rows: &[usize]) -> Option<Vec<usize>> {
    let n = columns.len() - 1;
    let matrix = CscMatrix::new(n, n, columns.to_vec(), rows.to_vec(), vec![1.0; rows.len()]);
    let settings = QDLDLSettingsBuilder::default().regularize_enable(false).logical(true).build().ok()?;
    QDLDLFactorisation::new(&matrix, Some(settings)).ok().map(|found| found.perm)
}

/// Numbers that blocks leave at once, at most.
fn most_left(structure: &Structure) -> usize {
    let (mut top, mut most) = (0, 0);
    for block in &structure.blocks {
        let own = block.below.len().pow(2);
        most = most.max(top + own);
        let handed: usize =
            block.children.iter().map(|&child| structure.blocks[child].below.len().pow(2)).sum();
        top = top + own - handed;
    }
    most
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A band with dense last columns, definite and not: the residual of a solution, and the signs of pivots against those of an
    /// elimination of the whole matrix (Sylvester).
    #[test]
    fn solutions_and_signs_are_those_of_the_whole_matrix() {
        let (n, dense, band) = (160, 12, 5);
        let mut state = 7u64;
        let mut number = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        let (mut columns, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for column in 0..n {
            for row in 0..=column {
                if column - row <= band || column >= n - dense {
                    rows.push(row);
                    let large = if column % 3 == 0 { -6.0 } else { 6.0 };
                    values.push(if row == column { large + number() } else { number() });
                }
            }
            columns.push(rows.len());
        }
        let mut whole = nalgebra::DMatrix::zeros(n, n);
        for column in 0..n {
            for place in columns[column]..columns[column + 1] {
                whole[(rows[place], column)] = values[place];
                whole[(column, rows[place])] = values[place];
            }
        }
        let mut factor = Factor::new(&columns, &rows).unwrap();
        // A second matrix of the same structure leaves nothing of the first.
        let other: Vec<f64> = values.iter().map(|x| 2.0 * x).collect();
        assert!(factor.factorise(&other) && factor.factorise(&values));
        let positive = whole.clone().symmetric_eigenvalues().iter().filter(|x| **x > 0.0).count();
        assert_eq!(factor.positive(), positive);
        let right: Vec<f64> = (0..n).map(|_| number()).collect();
        let mut x = right.clone();
        factor.solve(&mut x);
        let [solved, wanted] = [&x, &right].map(|x| nalgebra::DVector::from_column_slice(x));
        let residual = &whole * solved - wanted;
        assert!(residual.amax() < 1e-10, "{}", residual.amax());
        assert!(!factor.factorise(&vec![0.0; values.len()]));
        // Nor does one that cannot be factorised, however far it came.
        let mut broken = values.clone();
        broken[values.len() / 2] = f64::NAN;
        assert!(!factor.factorise(&broken) && factor.factorise(&values));
        let mut again = right;
        factor.solve(&mut again);
        assert_eq!(again, x);
    }
}
