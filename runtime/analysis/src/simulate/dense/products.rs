//! Sums of rows and of products.
use super::four::Four;
use super::tiles::{Chunk, SIDE, chunks, put, row_length, rows, whole, whole_mut, wide};

wide! {
    /// `out + xᵀ A` in place: every row of `A` by its factor. `A` has as many columns as `out`.
    fn add_rows(a: &[f64], x: &[f64], out: &mut [f64]) {
        const TOGETHER: usize = 3;
        let (length, a) = (chunks(out.len()).max(1), whole(a));
        let (out, last) = out.as_chunks_mut::<SIDE>();
        let ends = out.len();
        let mut at = 0;
        while at + TOGETHER <= ends {
            add_chunks::<F, TOGETHER>(a, length, x, at, &mut out[at..]);
            at += TOGETHER;
        }
        while at < ends {
            add_chunks::<F, 1>(a, length, x, at, &mut out[at..]);
            at += 1;
        }
        if !last.is_empty() {
            let mut sum = [[0.0; SIDE]];
            sum[0].iter_mut().zip(&*last).for_each(|(sum, out)| *sum = *out);
            add_chunks::<F, 1>(a, length, x, ends, &mut sum);
            last.iter_mut().zip(sum[0]).for_each(|(out, sum)| *out = sum);
        }
    }
}

/// To the first `N` chunks of `out` every row's chunks from `first` on by its factor.
#[inline(always)]
fn add_chunks<F: Four, const N: usize>(
    a: &[Chunk],
    length: usize,
    x: &[f64],
    first: usize,
    out: &mut [Chunk],
) {
    let Some(out) = out.first_chunk_mut::<N>() else { return };
    let mut sum = [F::of(&[0.0; SIDE]); N];
    sum.iter_mut().zip(&*out).for_each(|(sum, out)| *sum = F::of(out));
    for (row, factor) in a.chunks_exact(length).zip(x) {
        let row = &row[first..first + N];
        for k in 0..N {
            sum[k] = sum[k].plus(*factor, F::of(&row[k]));
        }
    }
    sum.iter().zip(out).for_each(|(sum, out)| sum.put(out));
}

wide! {
    /// `A x`: `A` has as many columns as `x`.
    fn dots(a: &[f64], x: &[f64], out: &mut [f64]) {
        for (row, out) in a.chunks_exact(row_length(x.len()).max(1)).zip(out) {
            *out = dot(&row[..x.len()], x);
        }
    }
}

wide! {
    /// `Aᵀ` into `out`: `A` has so many rows and columns.
    fn transpose(a: &[f64], size: [usize; 2], out: &mut [f64]) {
        let [down, along] = size.map(chunks);
        let (a, out) = (&whole(a)[..size[0] * along], &mut whole_mut(out)[..size[1] * down]);
        for i in 0..down {
            for j in 0..along {
                put(out, down, j, i, &F::turned(rows::<F>(a, along, i, j)));
            }
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
