//! Elements of slices without a panic: what lies beyond reads as zero and is not written.
use crate::real::Scalar;

pub(crate) fn get<R: Scalar>(of: &[R], index: usize) -> R {
    of.get(index).copied().unwrap_or(R::constant(0.0))
}

pub(crate) fn set<R>(into: &mut [R], index: usize, value: R) {
    if let Some(element) = into.get_mut(index) {
        *element = value;
    }
}

/// Columns of a matrix with so many rows. (`chunks_exact` divides by their number, and a compiler that does not see that it is not 0 keeps a panic.)
pub(crate) fn columns<R>(matrix: &[R], rows: usize) -> impl Iterator<Item = &[R]> {
    let mut rest = if rows == 0 { None } else { Some(matrix) };
    core::iter::from_fn(move || {
        let (column, others) = rest?.split_at_checked(rows)?;
        rest = Some(others);
        Some(column)
    })
}

pub(crate) fn copy<R: Copy>(from: &[R], to: &mut [R]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}
