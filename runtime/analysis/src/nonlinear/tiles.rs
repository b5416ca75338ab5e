//! Products of the small dense matrices of an elimination, in tiles of C − A B that stay in registers. Blocks are too small for what packs both factors first.
//!
//! Sums are those of a product by nalgebra, bit by bit: from C on where a side is small, else from zero with fused operations where the processor has them.

/// Columns of a tile.
pub(super) const SIDE: usize = 4;

/// Up to so many rows, columns or products are summed from C on, each rounded.
const SMALL: usize = 5;
/// Products that are summed before they are taken from C.
const LONGEST: usize = 256;

/// From C on; from zero, fused and not.
const IN_PLACE: u8 = 0;
const FUSED: u8 = 1;
const APART: u8 = 2;

/// A matrix from an element on: its columns are `stride` apart.
pub(super) type From<'a> = (&'a [f64], usize);

/// What a product is taken from, and whether what stands there counts.
pub(super) struct Target<'a> {
    pub values: &'a mut [f64],
    pub stride: usize,
    pub counts: bool,
}

/// C − A B on and below the diagonal; above it anything. Of B four columns side by side, row after row, then the next four.
#[inline(always)]
pub(super) fn subtract<const FMA: bool>(
    c: &mut Target<'_>,
    a: From<'_>,
    b: &[[f64; SIDE]],
    [rows, inner, columns]: [usize; 3],
) {
    if rows <= SMALL || columns <= SMALL || inner <= SMALL {
        return subtract_in_place(c, a, b, [rows, inner, columns]);
    }
    let counted = c.counts;
    for first in (0..inner).step_by(LONGEST) {
        let last = inner.min(first + LONGEST);
        c.counts = counted || first > 0;
        for (k, b) in b.chunks_exact(inner).enumerate() {
            let a = (&a.0[first * a.1..], a.1);
            if FMA {
                strip::<FUSED>(c, a, &b[first..last], [rows, columns, k * SIDE]);
            } else {
                strip::<APART>(c, a, &b[first..last], [rows, columns, k * SIDE]);
            }
        }
    }
}

/// The same with each product rounded, and taken from C by itself.
#[inline(always)]
pub(super) fn subtract_in_place(
    c: &mut Target<'_>,
    a: From<'_>,
    b: &[[f64; SIDE]],
    [rows, inner, columns]: [usize; 3],
) {
    for (k, b) in b.chunks_exact(inner).enumerate() {
        strip::<IN_PLACE>(c, a, b, [rows, columns, k * SIDE]);
    }
}

/// Four columns from this one on.
#[inline(always)]
fn strip<const SUMS: u8>(
    c: &mut Target<'_>,
    a: From<'_>,
    b: &[[f64; SIDE]],
    [rows, columns, column]: [usize; 3],
) {
    let columns = SIDE.min(columns - column);
    // Rows above the diagonal, where there are any, fill the last tile.
    let mut row = column - column.min((rows - column).wrapping_neg() % SIDE);
    while row + 2 * SIDE <= rows {
        tile::<{ 2 * SIDE }, SUMS>(c, a, b, [row, column, columns]);
        row += 2 * SIDE;
    }
    if row + SIDE <= rows {
        tile::<SIDE, SUMS>(c, a, b, [row, column, columns]);
        row += SIDE;
    }
    while row < rows {
        tile::<1, SUMS>(c, a, b, [row, column, columns]);
        row += 1;
    }
}

#[inline(always)]
fn tile<const ROWS: usize, const SUMS: u8>(
    c: &mut Target<'_>,
    (a, stride): From<'_>,
    b: &[[f64; SIDE]],
    [row, column, columns]: [usize; 3],
) {
    let mut sums = [[0.0; ROWS]; SIDE];
    let begin = column * c.stride + row;
    if SUMS == IN_PLACE && c.counts {
        for (j, sums) in sums.iter_mut().enumerate().take(columns) {
            sums.copy_from_slice(&c.values[begin + j * c.stride..][..ROWS]);
        }
    }
    for (b, a) in b.iter().zip(a[row..].chunks(stride)) {
        let Some(a) = a.first_chunk::<ROWS>() else { continue };
        for (sums, b) in sums.iter_mut().zip(b) {
            for (sum, a) in sums.iter_mut().zip(a) {
                *sum = match SUMS {
                    IN_PLACE => *sum - b * a,
                    FUSED => a.mul_add(*b, *sum),
                    _ => *sum + a * b,
                };
            }
        }
    }
    for (j, sums) in sums.iter().enumerate().take(columns) {
        let to = &mut c.values[begin + j * c.stride..][..ROWS];
        for (to, sum) in to.iter_mut().zip(sums) {
            *to = match (SUMS, c.counts) {
                (IN_PLACE, _) => *sum,
                (_, true) => *to - sum,
                (_, false) => -sum,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(k: usize) -> f64 {
        ((k * 7919 + 13) % 1009) as f64 / 97.0 - 5.0
    }

    /// C − A B in one element, by sums of products in turn.
    fn element<const FMA: bool>(counts: bool, c: f64, factors: &[(f64, f64)], small: bool) -> f64 {
        let start = if counts { c } else { 0.0 };
        if small {
            return factors.iter().fold(start, |sum, (a, b)| sum - b * a);
        }
        factors.chunks(LONGEST).fold(start, |rest, factors| {
            let sum = |sum: f64, (a, b): &(f64, f64)| if FMA { a.mul_add(*b, sum) } else { sum + a * b };
            rest - factors.iter().fold(0.0, sum)
        })
    }

    fn compared<const FMA: bool>([rows, inner, columns]: [usize; 3]) {
        let (first, height) = (inner, rows + inner + 3);
        let a: Vec<f64> = (0..height * inner).map(number).collect();
        let factor = |k: usize, j: usize| if j < columns { number(400 + j * inner + k) } else { f64::NAN };
        let turned = (0..columns.div_ceil(SIDE)).flat_map(|tile| (0..inner).map(move |k| (tile, k)));
        let b: Vec<[f64; SIDE]> =
            turned.map(|(tile, k)| std::array::from_fn(|j| factor(k, tile * SIDE + j))).collect();
        for counts in [true, false] {
            let before: Vec<f64> = (0..height * columns).map(|k| number(k + 99)).collect();
            let mut c = before.clone();
            let mut to = Target { values: &mut c, stride: height, counts };
            subtract::<FMA>(&mut to, (&a[first..], height), &b, [rows, inner, columns]);
            let small = [rows, inner, columns].iter().any(|side| *side <= SMALL);
            for (j, i) in (0..columns).flat_map(|j| (j..rows).map(move |i| (j, i))) {
                let factors: Vec<(f64, f64)> =
                    (0..inner).map(|k| (a[k * height + first + i], factor(k, j))).collect();
                let wanted = element::<FMA>(counts, before[j * height + i], &factors, small);
                assert_eq!(c[j * height + i], wanted, "{rows} {inner} {columns}, {i} {j}, {counts}");
            }
        }
    }

    #[test]
    fn tiles_give_the_sums_of_every_element_whatever_their_sides_are() {
        for shape in [[3, 9, 3], [9, 5, 9], [9, 1, 9], [61, 7, 13], [40, 12, 40], [50, 300, 48], [6, 6, 6]] {
            compared::<true>(shape);
            compared::<false>(shape);
        }
    }
}
