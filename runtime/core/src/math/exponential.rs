//! Exponential function and hyperbolic tangent of scalars, without branches, so that loops over lanes become
//! vector instructions.
//!
//! e^x = 2ⁿ eʳ with n = round(x / ln 2) and |r| ≤ ln 2 / 2; eʳ − 1 by its Taylor polynomial, whose first left-out
//! term is below a tenth of the last place. tanh x = m / (m + 2) with m = e²ˣ − 1 = 2ⁿ (eʳ − 1) + (2ⁿ − 1), which
//! keeps the relative accuracy of small arguments.

macro_rules! scalar_functions {
    (
        $scalar:ident $bits:ident $signed:ident: $exp:ident $tanh:ident $reduce:ident $power:ident $fused:ident;
        $shift:literal $mantissa:literal $bias:literal $ln2_high:expr, $ln2_low:literal;
        $lowest:literal $highest:literal $saturated:literal; $($coefficient:expr),*
    ) => {
        /// 2ⁿ for a normal result.
        #[inline(always)]
        fn $power(n: i32) -> $scalar {
            $scalar::from_bits((n.wrapping_add($bias) as $bits) << $mantissa)
        }

        /// n and eʳ − 1 of a finite argument whose n fits into the mantissa.
        #[inline(always)]
        fn $reduce(x: $scalar) -> (i32, $scalar) {
            use super::scalar::$fused as fused;
            // Adding it rounds to an integer, which then stands in the low bits.
            let turns = fused(x, core::$scalar::consts::LOG2_E, $shift);
            let n = turns - $shift;
            // The product is exact: the constant ends in as many zeros as n has bits.
            let r = fused(n, -$ln2_low, fused(n, -$ln2_high, x));
            let mut sum: $scalar = 0.0;
            for coefficient in [$($coefficient),*] {
                sum = fused(sum, r, coefficient);
            }
            let count = turns.to_bits().wrapping_sub(($shift as $scalar).to_bits()) as $signed as i32;
            (count, fused(sum, r * r, r))
        }

        /// `e^x`: 0 and infinity where the result is out of range, NaN of NaN.
        #[inline(always)]
        pub(crate) fn $exp(x: $scalar) -> $scalar {
            let x = if x > $highest { $highest } else { x };
            let x = if x < $lowest { $lowest } else { x };
            let (n, m) = $reduce(x);
            // In two steps: 2ⁿ itself may be out of range where the result is not.
            let half = n >> 1;
            (m + 1.0) * $power(half) * $power(n.wrapping_sub(half))
        }

        /// `tanh x`, NaN of NaN.
        #[inline(always)]
        pub(crate) fn $tanh(x: $scalar) -> $scalar {
            let double = x.abs() + x.abs();
            let double = if double > $saturated { $saturated } else { double };
            let (n, m) = $reduce(double);
            let power = $power(n);
            let less_one = super::scalar::$fused(power, m, power - 1.0);
            (less_one / (less_one + 2.0)).copysign(x)
        }
    };
}

scalar_functions!(
    f64 u64 i64: exp_f64 tanh_f64 reduce_f64 power_f64 fused_f64;
    6_755_399_441_055_744.0 52 1023 6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10;
    -746.0 710.0 44.0;
    1.0 / 6_227_020_800.0, 1.0 / 479_001_600.0, 1.0 / 39_916_800.0, 1.0 / 3_628_800.0, 1.0 / 362_880.0,
    1.0 / 40_320.0, 1.0 / 5_040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5
);
scalar_functions!(
    f32 u32 i32: exp_f32 tanh_f32 reduce_f32 power_f32 fused_f32;
    12_582_912.0 23 127 355.0 / 512.0, -2.121_944_4e-4;
    -104.0 89.0 20.0;
    1.0 / 40_320.0, 1.0 / 5_040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5
);
#[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
scalar_functions!(
    f64 u64 i64: fused_exp_f64 fused_tanh_f64 fused_reduce_f64 fused_power_f64 instruction_f64;
    6_755_399_441_055_744.0 52 1023 6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10;
    -746.0 710.0 44.0;
    1.0 / 6_227_020_800.0, 1.0 / 479_001_600.0, 1.0 / 39_916_800.0, 1.0 / 3_628_800.0, 1.0 / 362_880.0,
    1.0 / 40_320.0, 1.0 / 5_040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5
);
#[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
scalar_functions!(
    f32 u32 i32: fused_exp_f32 fused_tanh_f32 fused_reduce_f32 fused_power_f32 instruction_f32;
    12_582_912.0 23 127 355.0 / 512.0, -2.121_944_4e-4;
    -104.0 89.0 20.0;
    1.0 / 40_320.0, 1.0 / 5_040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5
);
