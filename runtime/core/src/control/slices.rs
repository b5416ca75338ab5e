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

pub(crate) fn copy<R: Copy>(from: &[R], to: &mut [R]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}
