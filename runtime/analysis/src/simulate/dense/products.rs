//! Sums of rows and of products.
use super::tiles::{Chunk, SIDE, chunks, row_length, whole, wide};

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

/// Four sums side by side: one would wait for itself.
#[inline(always)]
pub(in crate::simulate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; SIDE];
    let (a4, a_rest) = a.as_chunks::<SIDE>();
    let (b4, b_rest) = b.as_chunks::<SIDE>();
    for (x, y) in a4.iter().zip(b4) {
        sums = std::array::from_fn(|i| sums[i] + x[i] * y[i]);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
