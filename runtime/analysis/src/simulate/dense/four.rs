//! Four numbers side by side: as an array, or in a register. A compiler that is left to find them puts numbers together in one build
//! and not in the next, at twice the instructions.
use super::tiles::Chunk;

/// Four numbers. Multiplication and addition are rounded apart everywhere.
pub(in crate::simulate) trait Four: Copy {
    fn of(numbers: &Chunk) -> Self;
    fn put(self, numbers: &mut Chunk);
    /// `self − factor · y`
    fn less(self, factor: f64, y: Self) -> Self;
    /// `self + factor · y`
    fn plus(self, factor: f64, y: Self) -> Self;
    fn times(self, factor: f64) -> Self;
    /// `self + x · y`, each with its own.
    fn plus_each(self, x: Self, y: Self) -> Self;
    /// Of each of four the sum `(a + b) + (c + d)`.
    fn sums(four: [Self; 4]) -> Chunk;
    /// Rows as columns.
    fn turned(four: [Self; 4]) -> [Self; 4];
}

impl Four for Chunk {
    #[inline(always)]
    fn of(numbers: &Chunk) -> Self {
        *numbers
    }
    #[inline(always)]
    fn put(self, numbers: &mut Chunk) {
        *numbers = self;
    }
    #[inline(always)]
    fn less(self, factor: f64, y: Self) -> Self {
        std::array::from_fn(|i| self[i] - factor * y[i])
    }
    #[inline(always)]
    fn plus(self, factor: f64, y: Self) -> Self {
        std::array::from_fn(|i| self[i] + factor * y[i])
    }
    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        self.map(|x| x * factor)
    }
    #[inline(always)]
    fn plus_each(self, x: Self, y: Self) -> Self {
        std::array::from_fn(|i| self[i] + x[i] * y[i])
    }
    #[inline(always)]
    fn sums(four: [Self; 4]) -> Chunk {
        four.map(|[a, b, c, d]| (a + b) + (c + d))
    }
    #[inline(always)]
    fn turned(four: [Self; 4]) -> [Self; 4] {
        std::array::from_fn(|i| four.map(|row| row[i]))
    }
}

#[cfg(target_arch = "x86_64")]
pub(in crate::simulate) use register::Register;

#[cfg(target_arch = "x86_64")]
mod register {
    use super::{Chunk, Four};
    use std::arch::x86_64::{
        __m256d, _mm256_add_pd, _mm256_hadd_pd, _mm256_loadu_pd, _mm256_mul_pd, _mm256_permute2f128_pd,
        _mm256_set1_pd, _mm256_storeu_pd, _mm256_sub_pd, _mm256_unpackhi_pd, _mm256_unpacklo_pd,
    };

    /// A register of 256 bits, for what is compiled for processors that have it: nothing else may name this type.
    #[derive(Clone, Copy)]
    pub(in crate::simulate) struct Register(__m256d);

    // SAFETY of all below: `wide!` asks the processor before it calls what is made of these, and references are to four numbers.
    impl Four for Register {
        #[inline(always)]
        fn of(numbers: &Chunk) -> Self {
            Self(unsafe { _mm256_loadu_pd(numbers.as_ptr()) })
        }
        #[inline(always)]
        fn put(self, numbers: &mut Chunk) {
            unsafe { _mm256_storeu_pd(numbers.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn less(self, factor: f64, y: Self) -> Self {
            Self(unsafe { _mm256_sub_pd(self.0, _mm256_mul_pd(_mm256_set1_pd(factor), y.0)) })
        }
        #[inline(always)]
        fn plus(self, factor: f64, y: Self) -> Self {
            Self(unsafe { _mm256_add_pd(self.0, _mm256_mul_pd(_mm256_set1_pd(factor), y.0)) })
        }
        #[inline(always)]
        fn times(self, factor: f64) -> Self {
            Self(unsafe { _mm256_mul_pd(self.0, _mm256_set1_pd(factor)) })
        }
        #[inline(always)]
        fn plus_each(self, x: Self, y: Self) -> Self {
            Self(unsafe { _mm256_add_pd(self.0, _mm256_mul_pd(x.0, y.0)) })
        }
        #[inline(always)]
        fn sums([i, j, k, l]: [Self; 4]) -> Chunk {
            let mut sums = [0.0; 4];
            unsafe {
                // Halves hold a + b and c + d of two rows each.
                let (ij, kl) = (_mm256_hadd_pd(i.0, j.0), _mm256_hadd_pd(k.0, l.0));
                let (lower, upper) =
                    (_mm256_permute2f128_pd::<0x20>(ij, kl), _mm256_permute2f128_pd::<0x31>(ij, kl));
                _mm256_storeu_pd(sums.as_mut_ptr(), _mm256_add_pd(lower, upper));
            }
            sums
        }
        #[inline(always)]
        fn turned([i, j, k, l]: [Self; 4]) -> [Self; 4] {
            unsafe {
                let (ij, kl) = (_mm256_unpacklo_pd(i.0, j.0), _mm256_unpacklo_pd(k.0, l.0));
                let (up_ij, up_kl) = (_mm256_unpackhi_pd(i.0, j.0), _mm256_unpackhi_pd(k.0, l.0));
                [
                    Self(_mm256_permute2f128_pd::<0x20>(ij, kl)),
                    Self(_mm256_permute2f128_pd::<0x20>(up_ij, up_kl)),
                    Self(_mm256_permute2f128_pd::<0x31>(ij, kl)),
                    Self(_mm256_permute2f128_pd::<0x31>(up_ij, up_kl)),
                ]
            }
        }
    }
}
