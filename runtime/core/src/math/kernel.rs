//! The branch-free path of sine and cosine, written once for scalars and lanes.
//!
//! x = n π/2 + y with |y| ≤ π/4; polynomials for sin y and cos y; n mod 4 swaps and negates them. The
//! nearest integer n comes from adding 1.5 · 2⁵² (2²³ in `f32`), which also leaves n in the low bits.

use crate::Real;

/// A scalar or lane type with what the kernel needs beyond arithmetic.
pub(crate) trait Kernel: Real {
    /// `f64` or `f32`.
    type Element: Element;
    /// Whether every lane is in the common range; false for NaN.
    fn within(self) -> bool;
    /// Sine and cosine from those of the reduced angle; `turns` has the quadrant in its lowest two bits.
    fn rotate(turns: Self, sine: Self, cosine: Self) -> (Self, Self);
    /// Sine and cosine when a lane is out of that range, each lane on its own; scalars are out of it themselves.
    fn lane_by_lane(self) -> (Self, Self);
    /// The `k`-th of [`Element::COEFFICIENTS`].
    #[inline(always)]
    fn coefficient(k: usize) -> Self {
        Self::constant(Self::Element::COEFFICIENTS[k])
    }
}

/// The constants of a precision.
pub(crate) trait Element: Kernel {
    /// Adding it rounds to an integer and leaves that integer in the low bits.
    const SHIFT: f64;
    /// π/2 in parts, to be subtracted n times one after the other.
    const PARTS: &'static [f64];
    /// The same where products are not rounded.
    const FUSED_PARTS: &'static [f64];
    /// Of the polynomials, from the highest power on: those of the sine, then those of the cosine.
    const COEFFICIENTS: &'static [f64];
    /// Sine and cosine of |y| ≤ π/4.
    fn polynomials<V: Kernel>(y: V) -> (V, V);
}

/// Sine and cosine in the common range.
#[inline(always)]
pub(crate) fn common<V: Kernel>(x: V) -> (V, V) {
    let shift = V::constant(V::Element::SHIFT);
    let turns = V::fused(x, V::constant(core::f64::consts::FRAC_2_PI), shift);
    let n = turns - shift;
    let mut y = x;
    for part in V::Element::PARTS {
        y = V::fused(n, V::constant(-part), y);
    }
    let (sine, cosine) = V::Element::polynomials(y);
    V::rotate(turns, sine, cosine)
}

/// Sine and cosine of any argument.
#[inline(always)]
pub(crate) fn any<V: Kernel>(x: V) -> (V, V) {
    if x.within() { common(x) } else { x.lane_by_lane() }
}

impl Element for f64 {
    const SHIFT: f64 = 6_755_399_441_055_744.0;

    // Fused: the first difference is exact, and so is each later one that cancels, because n times a part
    // is never rounded. Otherwise parts of at most 33 bits keep the products exact for
    // n < 2^20; the second part ends at 2^-53, so that its difference is exact too and only one of them rounds.
    const FUSED_PARTS: &'static [f64] =
        &[core::f64::consts::FRAC_PI_2, 6.123233995736766e-17, -1.4973849048591698e-33];
    const PARTS: &'static [f64] = if super::FUSED {
        Self::FUSED_PARTS
    } else {
        &[1.5707963267341256, 6.077094383272197e-11, 6.12323399538461e-17, 3.5215598651832e-27]
    };

    // The minimax coefficients of fdlibm.
    const COEFFICIENTS: &'static [f64] = &[
        1.589_690_995_211_55e-10,
        -2.505_076_025_340_686_3e-8,
        2.755_731_370_707_006_8e-6,
        -1.984_126_982_985_795e-4,
        8.333_333_333_322_49e-3,
        -1.666_666_666_666_663_2e-1,
        -1.135_964_755_778_819_5e-11,
        2.087_572_321_298_175e-9,
        -2.755_731_435_139_066_3e-7,
        2.480_158_728_947_673e-5,
        -1.388_888_888_887_411e-3,
        4.166_666_666_666_66e-2,
        -0.5,
        1.0,
    ];

    /// Pairs are summed apart to shorten the chain of dependent steps.
    #[inline(always)]
    fn polynomials<V: Kernel>(y: V) -> (V, V) {
        let k = V::coefficient;
        let z = y * y;
        let zz = z * z;
        let s = V::fused(k(0), z, k(1));
        let s = V::fused(s, zz, V::fused(k(2), z, k(3)));
        let s = V::fused(s, zz, V::fused(k(4), z, k(5)));
        let c = V::fused(k(6), z, k(7));
        let c = V::fused(c, zz, V::fused(k(8), z, k(9)));
        let c = V::fused(c, zz, V::fused(k(10), z, k(11)));
        let c = V::fused(c, z, k(12));
        (V::fused(s, y * z, y), V::fused(c, z, k(13)))
    }
}

impl Element for f32 {
    const SHIFT: f64 = 12_582_912.0;

    // As for `f64`; without fusing, 14 bits are exact for n < 2^10, and the second part ends at 2^-24.
    const FUSED_PARTS: &'static [f64] = &[1.5707963705062866, -4.371138828673793e-8, -1.7151245100058819e-15];
    const PARTS: &'static [f64] = if super::FUSED {
        Self::FUSED_PARTS
    } else {
        &[1.5706787109375, 0.0001175999641418457, 1.5892510418780148e-08, 7.443547731314504e-13]
    };

    // Those of Cephes.
    const COEFFICIENTS: &'static [f64] = &[
        -1.951_529_589_1e-4,
        8.332_160_873_6e-3,
        -1.666_665_461_1e-1,
        2.443_315_711_809_948e-5,
        -1.388_731_625_493_765e-3,
        4.166_664_568_298_827e-2,
        -0.5,
        1.0,
    ];

    #[inline(always)]
    fn polynomials<V: Kernel>(y: V) -> (V, V) {
        let k = V::coefficient;
        let z = y * y;
        let s = V::fused(k(0), z, k(1));
        let s = V::fused(s, z, k(2));
        let c = V::fused(k(3), z, k(4));
        let c = V::fused(c, z, k(5));
        let c = V::fused(c, z, k(6));
        (V::fused(s, y * z, y), V::fused(c, z, k(7)))
    }
}

macro_rules! scalar_kernel {
    ($scalar:ident, $bits:ident, $limit:path, $large:path) => {
        impl Kernel for $scalar {
            type Element = Self;
            #[inline(always)]
            fn within(self) -> bool {
                self.abs() <= $limit
            }
            #[inline(always)]
            fn rotate(turns: Self, sine: Self, cosine: Self) -> (Self, Self) {
                const TOP: u32 = $bits::BITS - 2;
                let (turns, s, c) = (turns.to_bits(), sine.to_bits(), cosine.to_bits());
                let swap = (s ^ c) & (turns & 1).wrapping_neg();
                let sine = s ^ swap ^ ((turns & 2) << TOP);
                let cosine = c ^ swap ^ ((turns.wrapping_add(1) & 2) << TOP);
                (Self::from_bits(sine), Self::from_bits(cosine))
            }
            #[inline(always)]
            fn lane_by_lane(self) -> (Self, Self) {
                $large(self)
            }
        }
    };
}

scalar_kernel!(f64, u64, super::COMMON_RANGE_F64, super::large::sin_cos_f64);
scalar_kernel!(f32, u32, super::COMMON_RANGE_F32, super::large::sin_cos_f32);
