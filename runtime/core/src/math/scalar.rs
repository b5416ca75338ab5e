//! The three operations on `f64` and `f32` that `core` lacks.
//!
//! Fused multiply-add never becomes a call into a mathematical library: where the target has no
//! instruction for it, it is a multiplication and an addition.

macro_rules! scalar_operations {
    ($scalar:ident: $fused:ident $instruction:ident $sqrt:ident; $set:ident $get:ident $fmadd:ident $root:ident; $vdup:ident $vget:ident $vfma:ident $vsqrt:ident) => {
        /// `a * b + c`, one rounding where the target has the instruction.
        #[inline(always)]
        pub(crate) fn $fused(a: $scalar, b: $scalar, c: $scalar) -> $scalar {
            #[cfg(all(
                feature = "std",
                any(all(target_arch = "x86_64", target_feature = "fma"), target_arch = "aarch64")
            ))]
            {
                // One intrinsic instead of five nested calls: rustc compiles generated code faster.
                $scalar::mul_add(a, b, c)
            }
            #[cfg(all(not(feature = "std"), target_arch = "x86_64", target_feature = "fma"))]
            {
                use core::arch::x86_64::*;
                // SAFETY: the feature is enabled for the whole compilation.
                #[allow(unused_unsafe)]
                unsafe {
                    $get($fmadd($set(a), $set(b), $set(c)))
                }
            }
            #[cfg(all(not(feature = "std"), target_arch = "aarch64"))]
            {
                use core::arch::aarch64::*;
                // SAFETY: Advanced SIMD belongs to the base of the architecture.
                #[allow(unused_unsafe)]
                unsafe {
                    $vget::<0>($vfma($vdup(c), $vdup(a), $vdup(b)))
                }
            }
            #[cfg(not(any(all(target_arch = "x86_64", target_feature = "fma"), target_arch = "aarch64")))]
            {
                a * b + c
            }
        }

        /// `a * b + c` with one rounding; one instruction where it is inlined into a function that has it.
        #[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
        #[inline(always)]
        pub(crate) fn $instruction(a: $scalar, b: $scalar, c: $scalar) -> $scalar {
            #[cfg(feature = "std")]
            {
                $scalar::mul_add(a, b, c)
            }
            #[cfg(not(feature = "std"))]
            {
                use core::arch::x86_64::*;
                // SAFETY: only what runs on a processor that has it computes with these numbers, see `dispatch`.
                #[allow(unused_unsafe)]
                unsafe {
                    $get($fmadd($set(a), $set(b), $set(c)))
                }
            }
        }

        /// Square root, correctly rounded.
        #[inline(always)]
        pub(crate) fn $sqrt(x: $scalar) -> $scalar {
            #[cfg(feature = "std")]
            {
                $scalar::sqrt(x)
            }
            #[cfg(all(not(feature = "std"), target_arch = "x86_64", target_feature = "sse2"))]
            {
                use core::arch::x86_64::*;
                // SAFETY: the feature is enabled for the whole compilation.
                #[allow(unused_unsafe)]
                unsafe {
                    $get($root($set(x)))
                }
            }
            #[cfg(all(not(feature = "std"), target_arch = "aarch64"))]
            {
                use core::arch::aarch64::*;
                // SAFETY: Advanced SIMD belongs to the base of the architecture.
                #[allow(unused_unsafe)]
                unsafe {
                    $vget::<0>($vsqrt($vdup(x)))
                }
            }
            #[cfg(all(
                not(feature = "std"),
                not(all(target_arch = "x86_64", target_feature = "sse2")),
                not(target_arch = "aarch64")
            ))]
            {
                nalgebra::ComplexField::sqrt(x)
            }
        }
    };
}

scalar_operations!(f64: fused_f64 instruction_f64 sqrt_f64; _mm_set_sd _mm_cvtsd_f64 _mm_fmadd_sd _mm_sqrt_pd; vdup_n_f64 vget_lane_f64 vfma_f64 vsqrt_f64);
scalar_operations!(f32: fused_f32 instruction_f32 sqrt_f32; _mm_set_ss _mm_cvtss_f32 _mm_fmadd_ss _mm_sqrt_ss; vdup_n_f32 vget_lane_f32 vfma_f32 vsqrt_f32);
