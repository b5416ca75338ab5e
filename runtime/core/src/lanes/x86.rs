//! Registers of x86-64 as numbers: a type for each width that the target features of this compilation have, and those with fused
//! multiply-add of functions that are compiled for a better processor (see the module `dispatch`).

use core::arch::x86_64::*;
use core::fmt;
use core::ops::{Add, Div, Mul, Neg, Sub};

use super::arrays;
#[cfg(all(feature = "dispatch", not(target_feature = "fma")))]
use super::{FusedF32, FusedF64};
use crate::Real;
#[cfg(all(feature = "dispatch", not(target_feature = "fma")))]
use crate::math::kernel::Element;
use crate::math::kernel::{Kernel, any};

/// Runs intrinsics. Only here the crate calls them.
macro_rules! vector {
    // SAFETY: every use of this macro stands under a `cfg` that has its features enabled for the whole compilation, or is of a
    // number that is computed with only where the processor has them (`dispatch`); nothing here dereferences a pointer.
    ($($body:tt)*) => {{
        #[allow(unused_unsafe)]
        unsafe { $($body)* }
    }};
}

macro_rules! operator {
    ($name:ident: $trait:ident $method:ident $intrinsic:ident) => {
        impl $trait for $name {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(vector!($intrinsic(self.0, other.0)))
            }
        }
    };
}

/// `a * b + c`, one rounding where the target has the instruction.
macro_rules! as_the_target {
    ($fmadd:ident $mul:ident $add:ident: $a:expr, $b:expr, $c:expr) => {{
        #[cfg(target_feature = "fma")]
        let sum = vector!($fmadd($a, $b, $c));
        #[cfg(not(target_feature = "fma"))]
        let sum = vector!($add($mul($a, $b), $c));
        sum
    }};
}

/// `a * b + c` with one rounding; one instruction where it is inlined into a function that has it.
#[cfg(all(feature = "dispatch", not(target_feature = "fma")))]
macro_rules! once_rounded {
    ($fmadd:ident $mul:ident $add:ident: $a:expr, $b:expr, $c:expr) => {
        vector!($fmadd($a, $b, $c))
    };
}

/// A lane type over one register; the names of its intrinsics are spelt out, because macros cannot join names.
macro_rules! register {
    (
        $(#[$doc:meta])* $name:ident: $register:ident of $scalar:ident $lanes:literal, $primitive:ident, $fused:ident;
        $set1:ident $add:ident $sub:ident $mul:ident $div:ident $sqrt:ident $fmadd:ident;
        $to_bits:ident $from_bits:ident $set1_bits:ident($int:ty) $and:ident $xor:ident
        $add_bits:ident $sub_bits:ident $shift:ident $top:literal;
        $limit:path, |$x:ident, $bound:ident| $within:expr $(;
        coefficients $load:ident)?
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub struct $name($register);

        impl $name {
            /// The lanes in order.
            #[inline(always)]
            pub fn from_array(lanes: [$scalar; $lanes]) -> Self {
                // SAFETY: both are plain numbers of the same size.
                Self(unsafe { core::mem::transmute::<[$scalar; $lanes], $register>(lanes) })
            }
            /// The lanes in order.
            #[inline(always)]
            pub fn to_array(self) -> [$scalar; $lanes] {
                // SAFETY: both are plain numbers of the same size.
                unsafe { core::mem::transmute::<$register, [$scalar; $lanes]>(self.0) }
            }
            /// A branch-free function of every lane: the loop becomes vector instructions.
            #[inline(always)]
            fn each(self, f: impl Fn($scalar) -> $scalar) -> Self {
                let mut lanes = self.to_array();
                for x in &mut lanes {
                    *x = f(*x);
                }
                Self::from_array(lanes)
            }
        }

        operator!($name: Add add $add);
        operator!($name: Sub sub $sub);
        operator!($name: Mul mul $mul);
        operator!($name: Div div $div);

        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(vector!($sub($set1(-0.0), self.0)))
            }
        }

        impl PartialEq for $name {
            fn eq(&self, other: &Self) -> bool {
                self.to_array() == other.to_array()
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.debug_tuple(stringify!($name)).field(&self.to_array()).finish()
            }
        }

        impl Real for $name {
            type Faster = Self;
            type Two = super::Twice<Self>;
            #[inline(always)]
            fn constant(value: f64) -> Self {
                Self(vector!($set1(value as $primitive)))
            }
            #[inline(always)]
            fn fused(a: Self, b: Self, c: Self) -> Self {
                Self($fused!($fmadd $mul $add: a.0, b.0, c.0))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(vector!($sqrt(self.0)))
            }
            #[inline(always)]
            fn sin_cos_all<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
                arrays::each(angles)
            }
            #[inline(always)]
            fn exp(self) -> Self {
                self.each(<$scalar as Real>::exp)
            }
            #[inline(always)]
            fn tanh(self) -> Self {
                self.each(<$scalar as Real>::tanh)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.each(<$scalar as Real>::abs)
            }
            #[inline(always)]
            fn sign(self) -> Self {
                self.each(<$scalar as Real>::sign)
            }
            #[inline(always)]
            fn larger(self, other: Self) -> Self {
                let mut lanes = self.to_array();
                for (x, y) in lanes.iter_mut().zip(other.to_array()) {
                    *x = x.larger(y);
                }
                Self::from_array(lanes)
            }
        }

        impl Kernel for $name {
            type Element = $scalar;
            #[inline(always)]
            fn within(self) -> bool {
                vector!({
                    // Without the sign bit.
                    let $x = $from_bits($and($to_bits(self.0), $set1_bits(<$int>::MAX)));
                    let $bound = $set1($limit);
                    $within
                })
            }
            #[inline(always)]
            fn rotate(turns: Self, sine: Self, cosine: Self) -> (Self, Self) {
                vector!({
                    let (turns, s, c) = ($to_bits(turns.0), $to_bits(sine.0), $to_bits(cosine.0));
                    let (zero, one, two) = ($set1_bits(0), $set1_bits(1), $set1_bits(2));
                    let swap = $and($xor(s, c), $sub_bits(zero, $and(turns, one)));
                    let sine_sign = $shift::<$top>($and(turns, two));
                    let cosine_sign = $shift::<$top>($and($add_bits(turns, one), two));
                    let sine = $xor($xor(s, swap), sine_sign);
                    let cosine = $xor($xor(c, swap), cosine_sign);
                    (Self($from_bits(sine)), Self($from_bits(cosine)))
                })
            }
            #[cold]
            #[inline(never)]
            fn lane_by_lane(self) -> (Self, Self) {
                let (mut sines, mut cosines) = (self.to_array(), self.to_array());
                for (sine, cosine) in sines.iter_mut().zip(&mut cosines) {
                    (*sine, *cosine) = any(*sine);
                }
                (Self::from_array(sines), Self::from_array(cosines))
            }
            $(
                #[inline(always)]
                fn coefficient(k: usize) -> Self {
                    const COUNT: usize = <$scalar as Element>::COEFFICIENTS.len();
                    static TABLE: Table<[$primitive; $lanes], COUNT> = {
                        let mut table = [[0.0; $lanes]; COUNT];
                        let mut k = 0;
                        while k < COUNT {
                            table[k] = [<$scalar as Element>::COEFFICIENTS[k] as $primitive; $lanes];
                            k += 1;
                        }
                        Table(table)
                    };
                    let mut table = &raw const TABLE;
                    // Nothing is read: the compiler forgets where the pointer points, and what is there.
                    #[allow(clippy::pointers_in_nomem_asm_block)]
                    // SAFETY: no instruction.
                    unsafe { core::arch::asm!("/* {0} */", inout(reg) table, options(pure, nomem, nostack, preserves_flags)) };
                    // SAFETY: it still points to the table.
                    vector!(Self($load((&raw const (*table).0[k]).cast())))
                }
            )?
        }
    };
}

/// Coefficients once for each lane. What multiplies and adds takes them from there as its third operand; where the compiler
/// can see that they are the same in all lanes, it loads one and spreads it by an instruction more.
#[cfg(all(feature = "dispatch", not(target_feature = "fma")))]
#[repr(align(32))]
struct Table<T, const N: usize>([T; N]);

register! {
    /// Two `f64`.
    F64x2: __m128d of f64 2, f64, as_the_target;
    _mm_set1_pd _mm_add_pd _mm_sub_pd _mm_mul_pd _mm_div_pd _mm_sqrt_pd _mm_fmadd_pd;
    _mm_castpd_si128 _mm_castsi128_pd _mm_set1_epi64x(i64) _mm_and_si128 _mm_xor_si128
    _mm_add_epi64 _mm_sub_epi64 _mm_slli_epi64 62;
    crate::math::COMMON_RANGE_F64, |x, bound| _mm_movemask_pd(_mm_cmple_pd(x, bound)) == 0b11
}

register! {
    /// Four `f32`.
    F32x4: __m128 of f32 4, f32, as_the_target;
    _mm_set1_ps _mm_add_ps _mm_sub_ps _mm_mul_ps _mm_div_ps _mm_sqrt_ps _mm_fmadd_ps;
    _mm_castps_si128 _mm_castsi128_ps _mm_set1_epi32(i32) _mm_and_si128 _mm_xor_si128
    _mm_add_epi32 _mm_sub_epi32 _mm_slli_epi32 30;
    crate::math::COMMON_RANGE_F32, |x, bound| _mm_movemask_ps(_mm_cmple_ps(x, bound)) == 0b1111
}

#[cfg(target_feature = "avx2")]
register! {
    /// Four `f64`.
    F64x4: __m256d of f64 4, f64, as_the_target;
    _mm256_set1_pd _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_sqrt_pd _mm256_fmadd_pd;
    _mm256_castpd_si256 _mm256_castsi256_pd _mm256_set1_epi64x(i64) _mm256_and_si256 _mm256_xor_si256
    _mm256_add_epi64 _mm256_sub_epi64 _mm256_slli_epi64 62;
    crate::math::COMMON_RANGE_F64,
    |x, bound| _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(x, bound)) == 0b1111
}

#[cfg(target_feature = "avx2")]
register! {
    /// Eight `f32`.
    F32x8: __m256 of f32 8, f32, as_the_target;
    _mm256_set1_ps _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_sqrt_ps _mm256_fmadd_ps;
    _mm256_castps_si256 _mm256_castsi256_ps _mm256_set1_epi32(i32) _mm256_and_si256 _mm256_xor_si256
    _mm256_add_epi32 _mm256_sub_epi32 _mm256_slli_epi32 30;
    crate::math::COMMON_RANGE_F32,
    |x, bound| _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(x, bound)) == 0xff
}

#[cfg(target_feature = "avx512f")]
register! {
    /// Eight `f64`.
    F64x8: __m512d of f64 8, f64, as_the_target;
    _mm512_set1_pd _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_sqrt_pd _mm512_fmadd_pd;
    _mm512_castpd_si512 _mm512_castsi512_pd _mm512_set1_epi64(i64) _mm512_and_si512 _mm512_xor_si512
    _mm512_add_epi64 _mm512_sub_epi64 _mm512_slli_epi64 62;
    crate::math::COMMON_RANGE_F64, |x, bound| _mm512_cmp_pd_mask::<_CMP_LE_OQ>(x, bound) == 0xff
}

#[cfg(target_feature = "avx512f")]
register! {
    /// Sixteen `f32`.
    F32x16: __m512 of f32 16, f32, as_the_target;
    _mm512_set1_ps _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps _mm512_sqrt_ps _mm512_fmadd_ps;
    _mm512_castps_si512 _mm512_castsi512_ps _mm512_set1_epi32(i32) _mm512_and_si512 _mm512_xor_si512
    _mm512_add_epi32 _mm512_sub_epi32 _mm512_slli_epi32 30;
    crate::math::COMMON_RANGE_F32, |x, bound| _mm512_cmp_ps_mask::<_CMP_LE_OQ>(x, bound) == 0xffff
}

#[cfg(all(feature = "dispatch", not(target_feature = "fma")))]
register! {
    /// Two [`FusedF64`], for functions that are compiled with fused multiply-adds.
    FusedF64x2: __m128d of FusedF64 2, f64, once_rounded;
    _mm_set1_pd _mm_add_pd _mm_sub_pd _mm_mul_pd _mm_div_pd _mm_sqrt_pd _mm_fmadd_pd;
    _mm_castpd_si128 _mm_castsi128_pd _mm_set1_epi64x(i64) _mm_and_si128 _mm_xor_si128
    _mm_add_epi64 _mm_sub_epi64 _mm_slli_epi64 62;
    crate::math::COMMON_RANGE_F64, |x, bound| _mm_movemask_pd(_mm_cmple_pd(x, bound)) == 0b11
}

#[cfg(all(feature = "dispatch", not(target_feature = "fma")))]
register! {
    /// Four [`FusedF32`], for functions that are compiled with fused multiply-adds.
    FusedF32x4: __m128 of FusedF32 4, f32, once_rounded;
    _mm_set1_ps _mm_add_ps _mm_sub_ps _mm_mul_ps _mm_div_ps _mm_sqrt_ps _mm_fmadd_ps;
    _mm_castps_si128 _mm_castsi128_ps _mm_set1_epi32(i32) _mm_and_si128 _mm_xor_si128
    _mm_add_epi32 _mm_sub_epi32 _mm_slli_epi32 30;
    crate::math::COMMON_RANGE_F32, |x, bound| _mm_movemask_ps(_mm_cmple_ps(x, bound)) == 0b1111
}

#[cfg(all(feature = "dispatch", not(target_feature = "fma")))]
register! {
    /// Four [`FusedF64`], for functions that are compiled with fused multiply-adds.
    FusedF64x4: __m256d of FusedF64 4, f64, once_rounded;
    _mm256_set1_pd _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_sqrt_pd _mm256_fmadd_pd;
    _mm256_castpd_si256 _mm256_castsi256_pd _mm256_set1_epi64x(i64) _mm256_and_si256 _mm256_xor_si256
    _mm256_add_epi64 _mm256_sub_epi64 _mm256_slli_epi64 62;
    crate::math::COMMON_RANGE_F64,
    |x, bound| _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(x, bound)) == 0b1111;
    coefficients _mm256_load_pd
}

#[cfg(all(feature = "dispatch", not(target_feature = "fma")))]
register! {
    /// Eight [`FusedF32`], for functions that are compiled with fused multiply-adds.
    FusedF32x8: __m256 of FusedF32 8, f32, once_rounded;
    _mm256_set1_ps _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_sqrt_ps _mm256_fmadd_ps;
    _mm256_castps_si256 _mm256_castsi256_ps _mm256_set1_epi32(i32) _mm256_and_si256 _mm256_xor_si256
    _mm256_add_epi32 _mm256_sub_epi32 _mm256_slli_epi32 30;
    crate::math::COMMON_RANGE_F32,
    |x, bound| _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(x, bound)) == 0xff;
    coefficients _mm256_load_ps
}
