//! Positive definite matrices: factors `Lᵀ L`, what they solve, and products `Yᵀ Y`.
use super::tiles::{
    SIDE, block, chunks, factor_tile, is_zero, less_rows, put, put_block, rows, solve_tile, take_product,
    tile, whole, whole_mut, wide,
};

/// Which chunks of columns of a block of rows are not zero: a bit each, the last for all that have none of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(in crate::simulate) struct Filled(u64);

impl Filled {
    pub(super) fn has(self, chunk: usize) -> bool {
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
                let l = solve_tile(&own, rows::<F>(a, length, k, i));
                put(a, length, k, i, &l);
                let l = tile(a, length, k, i);
                if is_zero(&l) {
                    continue;
                }
                for j in 0..=i {
                    take_product::<F>(a, length, [k, i, j], &l);
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
            let (others, full) = filled.split_at_mut(k);
            let full = full[0];
            for c in (0..width).filter(|c| full.has(*c)) {
                let y = solve_tile(&own, rows::<F>(b, width, k, c));
                put(b, width, k, c, &y);
            }
            for (i, other) in others.iter_mut().enumerate() {
                let factors = tile(l, length, k, i);
                if is_zero(&factors) {
                    continue;
                }
                other.0 |= full.0;
                for c in (0..width).filter(|c| full.has(*c)) {
                    take_product::<F>(b, width, [k, i, c], &factors);
                }
            }
        }
    }
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
                let (own, mut sum) = (rows::<F>(l, length, k, j), F::of(x));
                for at in (0..SIDE).rev() {
                    sum = sum.less(y[at], own[at]);
                }
                sum.put(x);
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
            let mut x = less_rows::<F>(l, length, i, 0..i, b);
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
                let mut sum = [F::of(&[0.0; SIDE]); SIDE];
                for (b, full) in filled.iter().enumerate() {
                    if full.has(i) && full.has(j) {
                        let (down, along) = (tile(y, length, b, i), rows::<F>(y, length, b, j));
                        for k in 0..SIDE {
                            for r in 0..SIDE {
                                sum[r] = sum[r].plus(down[k][r], along[k]);
                            }
                        }
                    }
                }
                put(g, length, i, j, &sum);
                if i != j {
                    put(g, length, j, i, &F::turned(sum));
                }
            }
        }
    }
}
