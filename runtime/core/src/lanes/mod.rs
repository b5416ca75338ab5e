//! Several states side by side: types that hold 4, 8 or 16 numbers and compute like one.
//!
//! They are the registers of the target where it has registers of that width, and pairs of narrower ones
//! elsewhere. The target is what the crate is compiled for: build with `-C target-cpu=native` (or
//! `x86-64-v3`, `x86-64-v4`), because the default x86-64 target has neither wide registers nor fused
//! multiply-add. Long functions should be instantiated with [`F64Native`] and [`F32Native`] only, and larger
//! batches be taken in several calls: the compiler needs minutes where a type of four registers meets
//! thousands of statements and the 16 registers of the default target, and the code is no faster. Each lane has the same bits as the scalar type at equal target features.

mod arrays;
#[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
mod fused;
mod pair;
mod scalar;
mod two;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod x86;

#[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
pub use fused::{FusedF32, FusedF64};
pub use pair::Pair;
pub use two::{Twice, Two, TwoF64, both, store, two};

/// The number that `f64` becomes on a processor with fused multiply-add: itself, where there is nothing to choose.
#[cfg(not(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma"))))]
pub type FusedF64 = f64;
/// The number that `f32` becomes there.
#[cfg(not(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma"))))]
pub type FusedF32 = f32;

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub use x86::{F32x4, F64x2};

/// Two `f64`.
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub type F64x2 = Pair<f64>;
/// Four `f32`.
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub type F32x4 = Pair<Pair<f32>>;

#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
pub use x86::{F32x8, F64x4};

/// Four `f64`.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
pub type F64x4 = Pair<F64x2>;
/// Eight `f32`.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
pub type F32x8 = Pair<F32x4>;

#[cfg(all(target_arch = "x86_64", target_feature = "avx512f"))]
pub use x86::{F32x16, F64x8};

/// Eight `f64`.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx512f")))]
pub type F64x8 = Pair<F64x4>;
/// Sixteen `f32`.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx512f")))]
pub type F32x16 = Pair<F32x8>;

/// The widest lanes of `f64` that are one register of the target.
#[cfg(all(target_arch = "x86_64", target_feature = "avx512f"))]
pub type F64Native = F64x8;
/// The widest lanes of `f32` that are one register of the target.
#[cfg(all(target_arch = "x86_64", target_feature = "avx512f"))]
pub type F32Native = F32x16;
/// The widest lanes of `f64` that are one register of the target.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", not(target_feature = "avx512f")))]
pub type F64Native = F64x4;
/// The widest lanes of `f32` that are one register of the target.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", not(target_feature = "avx512f")))]
pub type F32Native = F32x8;
/// The widest lanes of `f64` that are one register of the target.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
pub type F64Native = F64x2;
/// The widest lanes of `f32` that are one register of the target.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
pub type F32Native = F32x4;
/// How many lanes [`F64Native`] has.
pub const F64_NATIVE_LANES: usize = size_of::<F64Native>() / size_of::<f64>();
/// How many lanes [`F32Native`] has.
pub const F32_NATIVE_LANES: usize = size_of::<F32Native>() / size_of::<f32>();
