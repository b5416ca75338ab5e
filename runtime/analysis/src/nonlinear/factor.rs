//! L D Lᵀ of a sparse symmetric matrix without exchanges of pivots, in dense blocks (a multifrontal method): what a block leaves is handed to the block above it in
//! the elimination tree, so that nearly all work is products of dense matrices.
use super::dense;
use super::side_by_side::side_by_side;
use super::stack::Stack;
use super::symbolic::{Block, Structure};
use clarabel::algebra::CscMatrix;
use clarabel::qdldl::{QDLDLFactorisation, QDLDLSettingsBuilder};
use std::ops::Range;

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
    /// Parts of the tree that are factorised side by side, in the order of their blocks.
    branches: Vec<Branch>,
    /// For the blocks above all branches.
    stack: Stack,
}

/// A block of the tree with all blocks below it.
#[derive(Debug, Clone)]
struct Branch {
    blocks: Range<usize>,
    stack: Stack,
    /// Positive pivots; none: one is zero or no number.
    positive: Option<usize>,
}

/// No branch has more of the work than one of so many has in the mean.
const BRANCHES: f64 = 8.0;
/// Nor less than this part of that: it would not be worth the while.
const LEAST: f64 = 0.02;
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
        let blocks = &structure.blocks;
        let branch = |range: Range<usize>| Branch {
            stack: Stack::new(blocks, range.clone()),
            blocks: range,
            positive: None,
        };
        let branches = branches(blocks);
        Some(Self {
            values: vec![0.0; begins[begins.len() - 1]],
            branches: branches.into_iter().map(branch).collect(),
            stack: Stack::new(blocks, 0..blocks.len()),
            structure,
            begins,
            places,
            positive: 0,
        })
    }

    /// Factorises; false: a pivot is zero or no number.
    pub fn factorise(&mut self, matrix: &[f64]) -> bool {
        self.values.fill(0.0);
        for (&place, value) in self.places.iter().zip(matrix) {
            self.values[place] += value;
        }
        self.factorise_branches();
        match self.factorise_above() {
            Some(positive) => self.positive = positive,
            None => return false,
        }
        true
    }

    fn factorise_branches(&mut self) {
        let (blocks, begins) = (&self.structure.blocks, &self.begins);
        let (mut rest, mut first) = (&mut self.values[..], 0);
        let mut jobs = Vec::with_capacity(self.branches.len());
        for branch in &mut self.branches {
            let [begin, end] = [begins[branch.blocks.start], begins[branch.blocks.end]];
            let (own, behind) = std::mem::take(&mut rest)[begin - first..].split_at_mut(end - begin);
            (rest, first) = (behind, end);
            jobs.push((branch, own));
        }
        side_by_side(jobs, |(branch, own)| {
            branch.stack.clear();
            branch.positive = branch.stack.eliminate(blocks, branch.blocks.clone(), (begins, own));
        });
    }

    /// What is above the branches, which hand on to it. The number of all positive pivots.
    fn factorise_above(&mut self) -> Option<usize> {
        let (blocks, begins) = (&self.structure.blocks, &self.begins);
        self.stack.clear();
        let (mut positive, mut next) = (0, 0);
        let end = blocks.len()..blocks.len();
        let ranges = self.branches.iter().map(|branch| (branch.blocks.clone(), Some(branch)));
        for (range, branch) in ranges.chain([(end, None)]) {
            let own = &mut self.values[begins[next]..begins[range.start]];
            positive += self.stack.eliminate(blocks, next..range.start, (begins, own))?;
            if let Some(branch) = branch {
                positive += branch.positive?;
                let root = &blocks[branch.blocks.end - 1];
                self.stack.push(root, branch.stack.left(root));
            }
            next = range.end;
        }
        Some(positive)
    }

    /// Number of positive pivots.
    pub fn positive(&self) -> usize {
        self.positive
    }

    /// Solves in place.
    pub fn solve(&self, right: &mut [f64]) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function is compiled for.
            return unsafe { self.solve_wide(right) };
        }
        self.substitute(right);
    }

    /// The same operations, compiled for wide registers whatever the rest of the program is compiled for.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn solve_wide(&self, right: &mut [f64]) {
        self.substitute(right);
    }

    #[inline(always)]
    fn substitute(&self, right: &mut [f64]) {
        let mut x: Vec<f64> = self.structure.order.iter().map(|&k| right[k]).collect();
        let most = self.structure.blocks.iter().map(|block| block.below.len()).max().unwrap_or(0);
        let mut room = vec![0.0; most];
        for (index, block) in self.structure.blocks.iter().enumerate() {
            let (own, height) = self.columns(index);
            let inside = &mut x[block.first..block.first + block.width];
            for (k, column) in own.chunks_exact(height).enumerate() {
                let (value, rest) = (inside[k], &mut inside[k + 1..]);
                rest.iter_mut().zip(&column[k + 1..]).for_each(|(x, l)| *x -= value * l);
            }
            let below = &mut room[..block.below.len()];
            dense::times((own, height, block.width), inside, below);
            block.below.iter().zip(below).for_each(|(&row, sum)| x[row] -= *sum);
        }
        for (index, block) in self.structure.blocks.iter().enumerate().rev() {
            let (own, height) = self.columns(index);
            let below = &mut room[..block.below.len()];
            below.iter_mut().zip(&block.below).for_each(|(to, &row)| *to = x[row]);
            let inside = &mut x[block.first..block.first + block.width];
            for (k, column) in own.chunks_exact(height).enumerate() {
                inside[k] = inside[k] / column[k] - dense::dot(&column[block.width..], below);
            }
            for (k, column) in own.chunks_exact(height).enumerate().rev() {
                inside[k] -= dense::dot(&column[k + 1..block.width], &inside[k + 1..]);
            }
        }
        self.structure.order.iter().zip(x).for_each(|(&column, value)| right[column] = value);
    }

    /// Columns of a block, one after the other, and their length: L with D on its diagonal.
    fn columns(&self, index: usize) -> (&[f64], usize) {
        let block = &self.structure.blocks[index];
        let values = &self.values[self.begins[index]..self.begins[index + 1]];
        (values, block.width + block.below.len())
    }
}

/// An order of elimination with little fill.
fn ordering(columns: &[usize], rows: &[usize]) -> Option<Vec<usize>> {
    let n = columns.len() - 1;
    let matrix = CscMatrix::new(n, n, columns.to_vec(), rows.to_vec(), vec![1.0; rows.len()]);
    let settings = QDLDLSettingsBuilder::default().regularize_enable(false).logical(true).build().ok()?;
    QDLDLFactorisation::new(&matrix, Some(settings)).ok().map(|found| found.perm)
}

/// Blocks with all below them, by their ranges, that can be eliminated side by side.
fn branches(blocks: &[Block]) -> Vec<Range<usize>> {
    let mut work = vec![0.0; blocks.len()];
    let mut begins: Vec<usize> = (0..blocks.len()).collect();
    for (index, block) in blocks.iter().enumerate() {
        let height = block.width + block.below.len();
        work[index] = (block.width * height * height) as f64;
        for &child in &block.children {
            work[index] += work[child];
            begins[index] = begins[index].min(begins[child]);
        }
    }
    let roots = || (0..blocks.len()).filter(|&k| blocks[k].below.is_empty());
    let most = roots().map(|root| work[root]).sum::<f64>() / BRANCHES;
    let (mut open, mut found): (Vec<usize>, _) = (roots().collect(), Vec::new());
    while let Some(index) = open.pop() {
        if work[index] > most {
            open.extend(&blocks[index].children);
        } else if work[index] >= LEAST * most {
            found.push(begins[index]..index + 1);
        }
    }
    found.sort_by_key(|range| range.start);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four bands with dense last columns, definite and not: the residual of a solution, and the signs of pivots against those of an
    /// elimination of the whole matrix (Sylvester).
    #[test]
    fn solutions_and_signs_are_those_of_the_whole_matrix() {
        let (n, dense, band, part) = (160, 12, 5, 40);
        let mut state = 7u64;
        let mut number = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        let (mut columns, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for column in 0..n {
            for row in 0..=column {
                let near = column - row <= band && column / part == row / part;
                if near || column >= n - dense {
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
        assert!(factor.branches.len() > 1, "none is worked on side by side");
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
