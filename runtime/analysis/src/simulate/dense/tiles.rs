//! Rows in chunks and tiles of four, which a processor works on side by side.
use super::four::Four;

/// A function compiled twice: as it is, and for processors with 256 bit registers, which are asked for at run time. Both
/// do the same operations in the same order. `F` in it is the [`Four`] of either.
macro_rules! wide {
    ($(#[$meta:meta])* fn $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)? $body:block) => {
        $(#[$meta])*
        pub(in crate::simulate) fn $name($($argument: $type),*) $(-> $result)? {
            #[inline(always)]
            fn plain<F: $crate::simulate::dense::four::Four>($($argument: $type),*) $(-> $result)? $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn wide($($argument: $type),*) $(-> $result)? {
                    plain::<$crate::simulate::dense::four::Register>($($argument),*)
                }
                if std::arch::is_x86_feature_detected!("avx2") {
                    // SAFETY: the processor has what the function is compiled for.
                    return unsafe { wide($($argument),*) };
                }
            }
            plain::<$crate::simulate::dense::tiles::Chunk>($($argument),*)
        }
    };
}

/// Columns that are worked on side by side. Every row of a matrix takes a whole multiple, see [`row_length`]; what lies beyond
/// its columns is of no use, and computed along.
pub(super) const SIDE: usize = 4;

/// Neighbours in a row.
pub(super) type Chunk = [f64; SIDE];

/// Numbers from one row of a matrix with so many columns to the next.
pub(in crate::simulate) fn row_length(columns: usize) -> usize {
    columns.next_multiple_of(SIDE)
}

/// Chunks that hold the first `columns`.
pub(super) fn chunks(columns: usize) -> usize {
    columns.div_ceil(SIDE)
}

pub(super) fn whole(a: &[f64]) -> &[Chunk] {
    a.as_chunks().0
}

pub(super) fn whole_mut(a: &mut [f64]) -> &mut [Chunk] {
    a.as_chunks_mut().0
}

/// Neighbours in rows and columns.
pub(super) type Tile = [Chunk; SIDE];

/// A tile from the block of rows `i`; rows that are missing below the last one are zero.
#[inline(always)]
pub(super) fn tile(a: &[Chunk], length: usize, i: usize, j: usize) -> Tile {
    let at = i * SIDE * length + j;
    if let Some(a) = a.get(at..at + 3 * length + 1) {
        return [a[0], a[length], a[2 * length], a[3 * length]];
    }
    std::array::from_fn(|k| a.get(at + k * length).copied().unwrap_or_default())
}

/// The same in registers.
#[inline(always)]
pub(super) fn rows<F: Four>(a: &[Chunk], length: usize, i: usize, j: usize) -> [F; SIDE] {
    let at = i * SIDE * length + j;
    if let Some(a) = a.get(at..at + 3 * length + 1) {
        return [F::of(&a[0]), F::of(&a[length]), F::of(&a[2 * length]), F::of(&a[3 * length])];
    }
    let mut rows = [F::of(&[0.0; SIDE]); SIDE];
    for (k, row) in rows.iter_mut().enumerate() {
        if let Some(a) = a.get(at + k * length) {
            *row = F::of(a);
        }
    }
    rows
}

#[inline(always)]
pub(super) fn put<F: Four>(a: &mut [Chunk], length: usize, i: usize, j: usize, tile: &[F; SIDE]) {
    let at = i * SIDE * length + j;
    if let Some(a) = a.get_mut(at..at + 3 * length + 1) {
        tile[0].put(&mut a[0]);
        tile[1].put(&mut a[length]);
        tile[2].put(&mut a[2 * length]);
        tile[3].put(&mut a[3 * length]);
        return;
    }
    for (k, row) in tile.iter().enumerate() {
        if let Some(a) = a.get_mut(at + k * length) {
            row.put(a);
        }
    }
}

#[inline(always)]
pub(super) fn less(x: Chunk, factor: f64, y: Chunk) -> Chunk {
    std::array::from_fn(|i| x[i] - factor * y[i])
}

/// From the rows `i` of `a`, at the chunk `j`, `Lᵀ` times the rows `k`, from the last row of L on.
#[inline(always)]
pub(super) fn take_product<F: Four>(a: &mut [Chunk], length: usize, [k, i, j]: [usize; 3], l: &Tile) {
    let y = rows::<F>(a, length, k, j);
    let mut target = rows::<F>(a, length, i, j);
    for k in (0..SIDE).rev() {
        for i in 0..SIDE {
            target[i] = target[i].less(l[k][i], y[k]);
        }
    }
    put(a, length, i, j, &target);
}

/// `Lᵀ Y = B` with L on the diagonal.
#[inline(always)]
pub(super) fn solve_tile<F: Four>(l: &Tile, mut b: [F; SIDE]) -> [F; SIDE] {
    for k in (0..SIDE).rev() {
        b[k] = b[k].times(l[k][k]);
        for i in 0..k {
            b[i] = b[i].less(l[k][i], b[k]);
        }
    }
    b
}

/// L of a tile on the diagonal with `rows` rows; `None`: not positive definite.
#[inline(always)]
pub(super) fn factor_tile(mut a: Tile, rows: usize) -> Option<Tile> {
    for (k, row) in a.iter_mut().enumerate().skip(rows) {
        row[k] = 1.0;
    }
    let mut definite = true;
    let mut rests = [0.0; SIDE];
    // Each row waits for a division by what the one before left, not for its root too: roots are taken together below.
    for k in (0..SIDE).rev() {
        let rest = a[k][k];
        // Written so that NaN fails too.
        definite &= rest > 0.0 && rest < f64::INFINITY;
        rests[k] = rest;
        let reciprocal = rest.recip();
        for i in 0..k {
            a[i] = less(a[i], a[k][i] * reciprocal, a[k]);
        }
    }
    let reciprocals = rests.map(|rest| rest.sqrt().recip());
    for k in 0..SIDE {
        a[k] = a[k].map(|x| x * reciprocals[k]);
        a[k][k] = reciprocals[k];
    }
    definite.then_some(a)
}

pub(super) fn is_zero(tile: &Tile) -> bool {
    tile.iter().flatten().all(|x| *x == 0.0)
}

/// A block of a column; what is missing below its end is zero.
#[inline(always)]
pub(super) fn block(b: &[f64], at: usize) -> Chunk {
    let own = &b[at * SIDE..];
    own.first_chunk()
        .copied()
        .unwrap_or_else(|| std::array::from_fn(|i| own.get(i).copied().unwrap_or_default()))
}

#[inline(always)]
pub(super) fn put_block(b: &mut [f64], at: usize, block: Chunk) {
    let own = &mut b[at * SIDE..];
    // A whole block is one store; of a length that is not known it would be a call.
    match own.first_chunk_mut() {
        Some(own) => *own = block,
        None => own.iter_mut().zip(block).for_each(|(b, x)| *b = x),
    }
}

/// A block of `b` less some of its rows of `a` times other blocks.
#[inline(always)]
pub(super) fn less_rows<F: Four>(
    a: &[Chunk],
    length: usize,
    i: usize,
    others: std::ops::Range<usize>,
    b: &[f64],
) -> Chunk {
    let mut sums = [F::of(&[0.0; SIDE]); SIDE];
    for j in others {
        let rows = rows::<F>(a, length, i, j);
        let x = match b[j * SIDE..].first_chunk() {
            Some(whole) => F::of(whole),
            None => F::of(&block(b, j)),
        };
        for k in 0..SIDE {
            sums[k] = sums[k].plus_each(rows[k], x);
        }
    }
    let (own, sums) = (block(b, i), F::sums(sums));
    std::array::from_fn(|k| own[k] - sums[k])
}

pub(super) use wide;
