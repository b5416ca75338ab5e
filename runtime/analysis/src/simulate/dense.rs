//! Small dense factorisations on slices that the caller keeps: nalgebra's allocate for sizes known at run time only.

/// A function compiled twice: as it is, and for processors with 256 bit registers, which are asked for at run time. Both
/// do the same operations in the same order.
macro_rules! wide {
    ($(#[$meta:meta])* fn $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)? $body:block) => {
        $(#[$meta])*
        pub(super) fn $name($($argument: $type),*) $(-> $result)? {
            #[inline(always)]
            fn plain($($argument: $type),*) $(-> $result)? $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn wide($($argument: $type),*) $(-> $result)? {
                    plain($($argument),*)
                }
                if std::arch::is_x86_feature_detected!("avx2") {
                    // SAFETY: the processor has what the function is compiled for.
                    return unsafe { wide($($argument),*) };
                }
            }
            plain($($argument),*)
        }
    };
}

/// Columns that are worked on side by side. Every row of a matrix takes a whole multiple, see [`row_length`]; what lies beyond
/// its columns is of no use, and computed along.
const SIDE: usize = 4;

/// Neighbours in a row.
type Chunk = [f64; SIDE];

/// Numbers from one row of a matrix with so many columns to the next.
pub(super) fn row_length(columns: usize) -> usize {
    columns.next_multiple_of(SIDE)
}

/// Chunks that hold the first `columns`.
fn chunks(columns: usize) -> usize {
    columns.div_ceil(SIDE)
}

fn whole(a: &[f64]) -> &[Chunk] {
    a.as_chunks().0
}

fn whole_mut(a: &mut [f64]) -> &mut [Chunk] {
    a.as_chunks_mut().0
}

/// Neighbours in rows and columns.
type Tile = [Chunk; SIDE];

/// A tile from the block of rows `i`; rows that are missing below the last one are zero.
#[inline(always)]
fn tile(a: &[Chunk], length: usize, i: usize, j: usize) -> Tile {
    let at = i * SIDE * length + j;
    if let Some(a) = a.get(at..at + 3 * length + 1) {
        return [a[0], a[length], a[2 * length], a[3 * length]];
    }
    std::array::from_fn(|k| a.get(at + k * length).copied().unwrap_or_default())
}

#[inline(always)]
fn put(a: &mut [Chunk], length: usize, i: usize, j: usize, tile: &Tile) {
    let at = i * SIDE * length + j;
    if let Some(a) = a.get_mut(at..at + 3 * length + 1) {
        [a[0], a[length], a[2 * length], a[3 * length]] = *tile;
        return;
    }
    for (k, row) in tile.iter().enumerate() {
        if let Some(a) = a.get_mut(at + k * length) {
            *a = *row;
        }
    }
}

#[inline(always)]
fn less(x: Chunk, factor: f64, y: Chunk) -> Chunk {
    std::array::from_fn(|i| x[i] - factor * y[i])
}

/// `target − Lᵀ Y`, from the last row of L on.
#[inline(always)]
fn less_product(mut target: Tile, l: &Tile, y: &Tile) -> Tile {
    for k in (0..SIDE).rev() {
        target = std::array::from_fn(|i| less(target[i], l[k][i], y[k]));
    }
    target
}

/// `Lᵀ Y = B` with L on the diagonal.
#[inline(always)]
fn solve_tile(l: &Tile, mut b: Tile) -> Tile {
    for k in (0..SIDE).rev() {
        b[k] = b[k].map(|x| x * l[k][k]);
        for i in 0..k {
            b[i] = less(b[i], l[k][i], b[k]);
        }
    }
    b
}

/// L of a tile on the diagonal with `rows` rows; `None`: not positive definite.
#[inline(always)]
fn factor_tile(mut a: Tile, rows: usize) -> Option<Tile> {
    for k in rows..SIDE {
        a[k][k] = 1.0;
    }
    let mut definite = true;
    for k in (0..SIDE).rev() {
        let rest = a[k][k];
        // Written so that NaN fails too.
        definite &= rest > 0.0 && rest < f64::INFINITY;
        let reciprocal = rest.sqrt().recip();
        a[k] = a[k].map(|x| x * reciprocal);
        a[k][k] = reciprocal;
        for i in 0..k {
            a[i] = less(a[i], a[k][i], a[k]);
        }
    }
    definite.then_some(a)
}

fn is_zero(tile: &Tile) -> bool {
    tile.iter().flatten().all(|x| *x == 0.0)
}

/// Which chunks of columns of a block of rows are not zero: a bit each, the last for all that have none of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Filled(u64);

impl Filled {
    fn has(self, chunk: usize) -> bool {
        self.0 >> chunk.min(63) & 1 == 1
    }
}

wide! {
    /// What is not zero in the blocks of rows of a matrix with so many columns.
    fn survey(a: &[f64], columns: usize, filled: &mut Vec<Filled>) {
        let length = chunks(columns).max(1);
        filled.clear();
        for block in whole(a).chunks(SIDE * length) {
            let mut bits = 0;
            for c in 0..length {
                let mut joined = [0; SIDE];
                for row in block.chunks_exact(length) {
                    joined = std::array::from_fn(|i| joined[i] | row[c][i].abs().to_bits());
                }
                bits |= u64::from(joined.iter().any(|bits| *bits != 0)) << c.min(63);
            }
            filled.push(Filled(bits));
        }
    }
}

wide! {
    /// Turns the lower triangle of `a` (`n` rows and columns) into L with `a = Lᵀ L`, with reciprocals on the diagonal.
    /// `false`: the matrix is not positive definite; `a` is of no use then.
    ///
    /// From the last row on: limbs come before what carries them, and what is zero between them stays zero and is passed
    /// over (Featherstone, 2005).
    fn factor(a: &mut [f64], n: usize) -> bool {
        let length = chunks(n);
        let a = &mut whole_mut(a)[..n * length];
        for k in (0..length).rev() {
            let Some(own) = factor_tile(tile(a, length, k, k), n - k * SIDE) else { return false };
            put(a, length, k, k, &own);
            for i in 0..k {
                let l = solve_tile(&own, tile(a, length, k, i));
                put(a, length, k, i, &l);
                if is_zero(&l) {
                    continue;
                }
                for j in 0..=i {
                    let y = tile(a, length, k, j);
                    let rest = less_product(tile(a, length, i, j), &l, &y);
                    put(a, length, i, j, &rest);
                }
            }
        }
        true
    }
}

wide! {
    /// `Lᵀ Y = B` in place, `B` with `columns` columns; `filled` are its blocks of rows, then Y's.
    fn forward(l: &[f64], n: usize, b: &mut [f64], columns: usize, filled: &mut [Filled]) {
        let (length, l) = (chunks(n), &whole(l)[..n * chunks(n)]);
        let (width, b) = (chunks(columns), &mut whole_mut(b)[..n * chunks(columns)]);
        for k in (0..length).rev() {
            let own = tile(l, length, k, k);
            let full = filled[k];
            for c in (0..width).filter(|c| full.has(*c)) {
                let y = solve_tile(&own, tile(b, width, k, c));
                put(b, width, k, c, &y);
            }
            for i in 0..k {
                let factors = tile(l, length, k, i);
                if is_zero(&factors) {
                    continue;
                }
                filled[i].0 |= full.0;
                for c in (0..width).filter(|c| full.has(*c)) {
                    let y = tile(b, width, k, c);
                    let rest = less_product(tile(b, width, i, c), &factors, &y);
                    put(b, width, i, c, &rest);
                }
            }
        }
    }
}

/// A block of a column; what is missing below its end is zero.
#[inline(always)]
fn block(b: &[f64], at: usize) -> Chunk {
    let own = &b[at * SIDE..];
    own.first_chunk()
        .copied()
        .unwrap_or_else(|| std::array::from_fn(|i| own.get(i).copied().unwrap_or_default()))
}

#[inline(always)]
fn put_block(b: &mut [f64], at: usize, block: Chunk) {
    b[at * SIDE..].iter_mut().zip(block).for_each(|(b, x)| *b = x);
}

wide! {
    /// `Lᵀ y = b` in place.
    fn forward_one(l: &[f64], n: usize, b: &mut [f64]) {
        let (length, l) = (chunks(n), &whole(l)[..n * chunks(n)]);
        for k in (0..length).rev() {
            let own = tile(l, length, k, k);
            let mut y = block(b, k);
            for at in (0..SIDE).rev() {
                y[at] *= own[at][at];
                for i in 0..at {
                    y[i] -= own[at][i] * y[at];
                }
            }
            put_block(b, k, y);
            for (j, x) in whole_mut(b).iter_mut().enumerate().take(k) {
                let rows = tile(l, length, k, j);
                *x = (0..SIDE).rev().fold(*x, |x, at| less(x, y[at], rows[at]));
            }
        }
    }
}

wide! {
    /// `L x = b` in place.
    fn backward(l: &[f64], n: usize, b: &mut [f64]) {
        let (length, l) = (chunks(n), &whole(l)[..n * chunks(n)]);
        for i in 0..length {
            let own = tile(l, length, i, i);
            let mut x = less_rows(l, length, i, 0..i, b);
            for at in 0..SIDE {
                for j in 0..at {
                    x[at] -= own[at][j] * x[j];
                }
                x[at] *= own[at][at];
            }
            put_block(b, i, x);
        }
    }
}

wide! {
    /// `Yᵀ Y`; `Y` has `columns` columns, `filled` are its blocks of rows.
    fn gram(y: &[f64], columns: usize, filled: &[Filled], g: &mut [f64]) {
        let length = chunks(columns);
        let (y, g) = (whole(y), &mut whole_mut(g)[..columns * length]);
        for i in 0..length {
            for j in 0..=i {
                let mut sum = [[0.0; SIDE]; SIDE];
                for (b, full) in filled.iter().enumerate() {
                    if full.has(i) && full.has(j) {
                        let (down, along) = (tile(y, length, b, i), tile(y, length, b, j));
                        for k in 0..SIDE {
                            sum = std::array::from_fn(|r| std::array::from_fn(|c| sum[r][c] + down[k][r] * along[k][c]));
                        }
                    }
                }
                put(g, length, i, j, &sum);
                if i != j {
                    put(g, length, j, i, &std::array::from_fn(|k| std::array::from_fn(|l| sum[l][k])));
                }
            }
        }
    }
}

wide! {
    /// `out + xᵀ A` in place: every row of `A` by its factor. `A` has as many columns as `out`.
    fn add_rows(a: &[f64], x: &[f64], out: &mut [f64]) {
        const TOGETHER: usize = 3;
        let (length, a) = (chunks(out.len()).max(1), whole(a));
        let (wide, rest) = out.as_chunks_mut::<{ TOGETHER * SIDE }>();
        let done = TOGETHER * wide.len();
        for (c, out) in wide.iter_mut().enumerate() {
            let mut sum: [Chunk; TOGETHER] = std::array::from_fn(|k| whole(out)[k]);
            for (row, factor) in a.chunks_exact(length).zip(x) {
                let row = &row[c * TOGETHER..][..TOGETHER];
                sum = std::array::from_fn(|k| std::array::from_fn(|i| sum[k][i] + factor * row[k][i]));
            }
            out.copy_from_slice(sum.as_flattened());
        }
        for (c, out) in rest.chunks_mut(SIDE).enumerate() {
            let mut sum = [0.0; SIDE];
            sum[..out.len()].copy_from_slice(out);
            for (row, factor) in a.chunks_exact(length).zip(x) {
                sum = std::array::from_fn(|i| sum[i] + factor * row[done + c][i]);
            }
            out.copy_from_slice(&sum[..out.len()]);
        }
    }
}

wide! {
    /// `A x`: `A` has as many columns as `x`.
    fn dots(a: &[f64], x: &[f64], out: &mut [f64]) {
        for (row, out) in a.chunks_exact(row_length(x.len()).max(1)).zip(out) {
            *out = dot(&row[..x.len()], x);
        }
    }
}

/// Eliminates below the diagonal in the block of columns `k`, with exchanges of whole rows. `false`: singular.
#[inline(always)]
fn eliminate_panel(a: &mut [Chunk], n: usize, k: usize, order: &mut Vec<usize>) -> bool {
    let length = chunks(n);
    for (side, at) in (k * SIDE..n.min((k + 1) * SIDE)).enumerate() {
        let size = |row: usize| a[row * length + k][side].abs();
        let (mut pivot, mut largest) = (at, size(at));
        for row in at + 1..n {
            if size(row) > largest {
                (pivot, largest) = (row, size(row));
            }
        }
        if largest <= f64::MIN_POSITIVE || !largest.is_finite() {
            return false;
        }
        if pivot != at {
            let (upper, lower) = a.split_at_mut(pivot * length);
            upper[at * length..][..length].swap_with_slice(&mut lower[..length]);
        }
        order.push(pivot);
        let own = a[at * length + k];
        let reciprocal = own[side].recip();
        // What stands left of the pivot are factors.
        let own: Chunk = std::array::from_fn(|i| if i > side { own[i] } else { 0.0 });
        for target in a[(at + 1) * length..].chunks_exact_mut(length) {
            let factor = target[k][side] * reciprocal;
            target[k] = less(target[k], factor, own);
            target[k][side] = factor;
        }
    }
    true
}

wide! {
    /// Factors `a` (`n` rows and columns) in place by elimination with row exchanges, which `order` takes down.
    /// `false`: singular to working precision.
    fn eliminate(a: &mut [f64], n: usize, order: &mut Vec<usize>) -> bool {
        order.clear();
        let length = chunks(n);
        let a = &mut whole_mut(a)[..n * length];
        // What lies beyond the columns would reach the answer as zero times what it is.
        for row in a.chunks_exact_mut(length.max(1)) {
            row[length - 1][n - (length - 1) * SIDE..].fill(0.0);
        }
        for k in 0..length {
            if !eliminate_panel(a, n, k, order) {
                return false;
            }
            for c in k + 1..length {
                let (own, mut upper) = (tile(a, length, k, k), tile(a, length, k, c));
                for i in 1..SIDE {
                    for j in 0..i {
                        upper[i] = less(upper[i], own[i][j], upper[j]);
                    }
                }
                put(a, length, k, c, &upper);
                for i in k + 1..length {
                    let (factors, mut target) = (tile(a, length, i, k), tile(a, length, i, c));
                    for s in 0..SIDE {
                        target = std::array::from_fn(|r| less(target[r], factors[r][s], upper[s]));
                    }
                    put(a, length, i, c, &target);
                }
            }
        }
        true
    }
}

wide! {
    /// Solves `a x = b` in place with what [`eliminate`] left. `false`: no finite solution.
    fn substitute(a: &[f64], n: usize, order: &[usize], b: &mut [f64]) -> bool {
        for (k, &pivot) in order.iter().enumerate() {
            b.swap(k, pivot);
        }
        let (length, a) = (chunks(n), &whole(a)[..n * chunks(n)]);
        for i in 0..length {
            let own = tile(a, length, i, i);
            let mut x = less_rows(a, length, i, 0..i, b);
            for at in 1..SIDE {
                for j in 0..at {
                    x[at] -= own[at][j] * x[j];
                }
            }
            put_block(b, i, x);
        }
        for i in (0..length).rev() {
            let own = tile(a, length, i, i);
            let mut x = less_rows(a, length, i, i + 1..length, b);
            for at in (0..SIDE.min(n - i * SIDE)).rev() {
                for j in at + 1..SIDE {
                    x[at] -= own[at][j] * x[j];
                }
                x[at] /= own[at][at];
            }
            put_block(b, i, x);
        }
        b[..n].iter().all(|x| x.is_finite())
    }
}

/// A block of `b` less some of its rows of `a` times other blocks.
#[inline(always)]
fn less_rows(a: &[Chunk], length: usize, i: usize, others: std::ops::Range<usize>, b: &[f64]) -> Chunk {
    let mut sums = [[0.0; SIDE]; SIDE];
    for j in others {
        let (rows, x) = (tile(a, length, i, j), block(b, j));
        sums = std::array::from_fn(|k| std::array::from_fn(|c| sums[k][c] + rows[k][c] * x[c]));
    }
    let own = block(b, i);
    std::array::from_fn(|k| {
        let [a, b, c, d] = sums[k];
        own[k] - ((a + b) + (c + d))
    })
}

/// Four sums side by side: one would wait for itself.
#[inline(always)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; SIDE];
    let (a4, a_rest) = a.as_chunks::<SIDE>();
    let (b4, b_rest) = b.as_chunks::<SIDE>();
    for (x, y) in a4.iter().zip(b4) {
        sums = std::array::from_fn(|i| sums[i] + x[i] * y[i]);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// Numbers that look random; the same every time.
    fn numbers(count: usize) -> Vec<f64> {
        (0..count).map(|i| ((i * i + 7 * i) as f64 * 0.731).sin()).collect()
    }

    fn positive(n: usize) -> DMatrix<f64> {
        let a = DMatrix::from_row_slice(n, n, &numbers(n * n));
        &a * a.transpose() + DMatrix::identity(n, n) * 0.1
    }

    /// With rows of whole chunks, and something beyond the columns.
    fn padded(a: &DMatrix<f64>) -> Vec<f64> {
        let mut rows = vec![f64::NAN; a.nrows() * row_length(a.ncols())];
        for (to, from) in rows.chunks_exact_mut(row_length(a.ncols())).zip(a.row_iter()) {
            to.iter_mut().zip(from.iter()).for_each(|(to, from)| *to = *from);
        }
        rows
    }

    #[test]
    fn agree_with_nalgebra() {
        for (n, columns) in [(9, 5), (8, 4), (6, 11), (1, 1)] {
            let d = positive(n);
            let mut l = padded(&d);
            assert!(factor(&mut l, n));
            let mut b = DMatrix::from_fn(n, columns, |i, j| ((3 * i + 5 * j + 1) as f64).sin());
            // The last columns are zero but in the last row, as where a limb has contacts of its own.
            b.view_mut((0, columns.min(4)), (n - 1, columns - columns.min(4))).fill(0.0);
            let mut y = padded(&b);
            y.iter_mut().filter(|y| y.is_nan()).for_each(|y| *y = 0.0);
            let mut filled = Vec::new();
            survey(&y, columns, &mut filled);
            assert!(n <= SIDE || (filled[0].has(0) && !filled[0].has(1)));
            let mut product = vec![0.0; columns];
            let x = numbers(n);
            add_rows(&y, &x, &mut product);
            let expected = b.transpose() * DVector::from_row_slice(&x);
            assert!((DVector::from_row_slice(&product) - expected).amax() < 1e-12);
            let mut other = vec![0.0; n];
            dots(&y, &product, &mut other);
            let expected = &b * DVector::from_row_slice(&product);
            assert!((DVector::from_row_slice(&other) - expected).amax() < 1e-12);
            forward(&l, n, &mut y, columns, &mut filled);
            let mut g = vec![0.0; columns * row_length(columns)];
            gram(&y, columns, &filled, &mut g);
            let expected = b.transpose() * d.clone().try_inverse().unwrap() * &b;
            let found = DMatrix::from_fn(columns, columns, |i, j| g[i * row_length(columns) + j]);
            assert!((found - &expected).amax() < 1e-10 * expected.amax());
            let mut x = numbers(n);
            let right = DVector::from_row_slice(&x);
            forward_one(&l, n, &mut x);
            backward(&l, n, &mut x);
            assert!((&d * DVector::from_row_slice(&x) - &right).amax() < 1e-12);
        }
    }

    #[test]
    fn elimination_solves_and_refuses() {
        let mut order = Vec::new();
        for n in [1, 7, 8, 13] {
            let a = DMatrix::from_row_slice(n, n, &numbers(n * n)) + DMatrix::identity(n, n) * 0.3;
            let mut factors = padded(&a);
            assert!(eliminate(&mut factors, n, &mut order));
            // Any number of right sides.
            for scale in [1.0, -3.0] {
                let mut x: Vec<f64> = (1..=n).map(|i| scale * (i as f64).cos()).collect();
                let right = DVector::from_row_slice(&x);
                assert!(substitute(&factors, n, &order, &mut x));
                assert!((&a * DVector::from_row_slice(&x) - right).amax() < 1e-10);
            }
        }
        let singular = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 4.0]);
        assert!(!eliminate(&mut padded(&singular), 2, &mut order));
        assert!(!factor(&mut padded(&DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 2.0, 1.0])), 2));
        assert!(!factor(&mut [f64::NAN; 4], 1));
    }
}
