//! Arrays of angles in lanes of 256 bits.
//!
//! Not in wider ones: while a register of 512 bits is at work, Intel's processors close one of the two ports at which scalar
//! products and sums are done, and the function behind the sines takes up to twice as long.

#[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
use super::x86::{FusedF32x4, FusedF32x8, FusedF64x2, FusedF64x4};
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
use super::{F32x4, F32x8, F64x2, F64x4};
#[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
use super::{FusedF32, FusedF64};
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
use crate::math::kernel::common;
use crate::math::kernel::{Kernel, any};

/// Lane after lane: each is a full register, so they gain nothing from each other.
#[inline(always)]
pub(crate) fn each<V: Kernel, const N: usize>(angles: [V; N]) -> ([V; N], [V; N]) {
    let (mut sines, mut cosines) = (angles, angles);
    for (sine, cosine) in sines.iter_mut().zip(&mut cosines) {
        (*sine, *cosine) = any(*sine);
    }
    (sines, cosines)
}

/// Scalars packed into lanes: blocks of the wide type, then what is left, padded.
///
/// Not `together`: each block has its own branch to the slow path; compiled for a better target, branches between them keep the compiler from joining
/// scalars to registers of 512 bits. `together`: one for all, by which constants are loaded once. Blocks go to the slow path by value either way: the
/// array would be passed by reference, and kept in memory where the fast path wants it in registers.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
macro_rules! packed {
    ($inline:meta, $name:ident, $scalar:ident, $narrow:ident $half:literal, $wide:ident $full:literal, $together:literal) => {
        /// Angles packed into lanes, the same bits as one by one.
        #[$inline]
        pub(crate) fn $name<const N: usize>(angles: [$scalar; N]) -> ([$scalar; N], [$scalar; N]) {
            let (mut sines, mut cosines) = ([$scalar::default(); N], [$scalar::default(); N]);
            let (blocks, rest) = angles.as_chunks::<$full>();
            let (sine_blocks, sine_rest) = sines.as_chunks_mut::<$full>();
            let (cosine_blocks, cosine_rest) = cosines.as_chunks_mut::<$full>();
            // Which of these is left is known at compile time.
            let (wide, narrow) = (N % $full > $half, N % $full > 1);
            // Every block by a function of lanes, a scalar that is left by one of scalars.
            macro_rules! each {
                ($lanes:path, $one:path) => {
                    for ((x, sine), cosine) in blocks.iter().zip(sine_blocks).zip(cosine_blocks) {
                        let (s, c) = $lanes($wide::from_array(*x));
                        (*sine, *cosine) = (s.to_array(), c.to_array());
                    }
                    if wide {
                        let (s, c) = $lanes($wide::from_array(padded(rest)));
                        unpad(&s.to_array(), sine_rest);
                        unpad(&c.to_array(), cosine_rest);
                    } else if narrow {
                        let (s, c) = $lanes($narrow::from_array(padded(rest)));
                        unpad(&s.to_array(), sine_rest);
                        unpad(&c.to_array(), cosine_rest);
                    } else if let ([x], [sine], [cosine]) = (rest, sine_rest, cosine_rest) {
                        (*sine, *cosine) = $one(*x);
                    }
                };
            }
            // No short circuit: the comparisons merge into one branch.
            let within = || {
                let blocks = blocks.iter().fold(true, |all, x| all & $wide::from_array(*x).within());
                let rest = if wide {
                    $wide::from_array(padded(rest)).within()
                } else if narrow {
                    $narrow::from_array(padded(rest)).within()
                } else {
                    rest.iter().all(|x| x.within())
                };
                blocks & rest
            };
            const TOGETHER: bool = $together;
            if !TOGETHER {
                each!(any, any);
            } else if within() {
                each!(common, common);
            } else {
                each!(Kernel::lane_by_lane, any);
            }
            (sines, cosines)
        }
    };
}

/// The first elements from a slice, zeros after them.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[inline(always)]
fn padded<T: Copy + Default, const N: usize>(values: &[T]) -> [T; N] {
    let mut block = [T::default(); N];
    for (to, from) in block.iter_mut().zip(values) {
        *to = *from;
    }
    block
}

/// As many elements as the slice takes.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[inline(always)]
fn unpad<T: Copy, const N: usize>(block: &[T; N], values: &mut [T]) {
    for (to, from) in values.iter_mut().zip(block) {
        *to = *from;
    }
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
packed!(inline, all_f64, f64, F64x2 2, F64x4 4, false);
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
packed!(inline, all_f32, f32, F32x4 4, F32x8 8, false);
// Instructions of a better processor: never in a function of their own, which would be compiled without them.
#[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
packed!(inline(always), all_fused_f64, FusedF64, FusedF64x2 2, FusedF64x4 4, true);
#[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
packed!(inline(always), all_fused_f32, FusedF32, FusedF32x4 4, FusedF32x8 8, true);

/// Scalars in loops that the compiler can vectorise, with one branch for all of them.
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
mod looped {
    use super::{Kernel, each};
    use crate::math::kernel::common;

    /// As many `f64` as 256 bits hold; what is left is padded to half of that.
    const BLOCK: usize = 4;
    const HALF: usize = BLOCK / 2;

    /// Any angles.
    #[cold]
    #[inline(never)]
    fn slow<V: Kernel, const N: usize>(angles: &[V; N]) -> ([V; N], [V; N]) {
        each(*angles)
    }

    /// Angles of the common range.
    #[inline(always)]
    fn block<V: Kernel, const N: usize>(angles: &[V; N], sines: &mut [V], cosines: &mut [V]) {
        let (mut s, mut c) = (*angles, *angles);
        for (s, c) in s.iter_mut().zip(&mut c) {
            (*s, *c) = common(*s);
        }
        sines.iter_mut().zip(s).for_each(|(to, from)| *to = from);
        cosines.iter_mut().zip(c).for_each(|(to, from)| *to = from);
    }

    /// The first elements, and the first one again where there are too few.
    #[inline(always)]
    fn padded<V: Kernel, const N: usize>(angles: &[V], first: V) -> [V; N] {
        let mut block = [first; N];
        block.iter_mut().zip(angles).for_each(|(to, from)| *to = *from);
        block
    }

    /// The same bits as one by one.
    #[inline(always)]
    pub(crate) fn all<V: Kernel, const N: usize>(angles: [V; N]) -> ([V; N], [V; N]) {
        // No short circuit: the comparisons merge into one branch.
        if !angles.iter().fold(true, |all, x| all & x.within()) {
            return slow(&angles);
        }
        let (mut sines, mut cosines) = (angles, angles);
        let (blocks, rest) = angles.as_chunks::<BLOCK>();
        let (sine_blocks, sine_rest) = sines.as_chunks_mut::<BLOCK>();
        let (cosine_blocks, cosine_rest) = cosines.as_chunks_mut::<BLOCK>();
        for ((x, sine), cosine) in blocks.iter().zip(sine_blocks).zip(cosine_blocks) {
            block(x, sine, cosine);
        }
        // Which of these runs is known at compile time.
        if let &[first, ..] = rest {
            if N % BLOCK > HALF {
                block(&padded::<V, BLOCK>(rest, first), sine_rest, cosine_rest);
            } else if N % BLOCK > 1 {
                block(&padded::<V, HALF>(rest, first), sine_rest, cosine_rest);
            } else {
                block(&[first], sine_rest, cosine_rest);
            }
        }
        (sines, cosines)
    }
}
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub(crate) use looped::{all as all_f64, all as all_f32};
