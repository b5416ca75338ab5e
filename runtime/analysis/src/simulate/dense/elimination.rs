//! Any square matrix: elimination with row exchanges.
use super::tiles::{
    Chunk, SIDE, chunks, less, less_rows, put, put_block, rows, tile, whole, whole_mut, wide,
};

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
        a[at * length + k][side] = reciprocal;
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
    /// Factors `a` (`n` rows and columns) in place by elimination with row exchanges, which `order` takes down; pivots become their
    /// reciprocals, for which solutions would wait.
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
                let (own, mut upper) = (tile(a, length, k, k), rows::<F>(a, length, k, c));
                for i in 1..SIDE {
                    for j in 0..i {
                        upper[i] = upper[i].less(own[i][j], upper[j]);
                    }
                }
                put(a, length, k, c, &upper);
                for i in k + 1..length {
                    let (factors, mut target) = (tile(a, length, i, k), rows::<F>(a, length, i, c));
                    for s in 0..SIDE {
                        for r in 0..SIDE {
                            target[r] = target[r].less(factors[r][s], upper[s]);
                        }
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
            let mut x = less_rows::<F>(a, length, i, 0..i, b);
            for at in 1..SIDE {
                for j in 0..at {
                    x[at] -= own[at][j] * x[j];
                }
            }
            put_block(b, i, x);
        }
        for i in (0..length).rev() {
            let own = tile(a, length, i, i);
            let mut x = less_rows::<F>(a, length, i, i + 1..length, b);
            for at in (0..SIDE.min(n - i * SIDE)).rev() {
                for j in at + 1..SIDE {
                    x[at] -= own[at][j] * x[j];
                }
                x[at] *= own[at][at];
            }
            put_block(b, i, x);
        }
        b[..n].iter().all(|x| x.is_finite())
    }
}
