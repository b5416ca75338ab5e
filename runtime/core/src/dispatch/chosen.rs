//! Which level the processor has, and how data of a function become those of the faster one.
use super::Level;
use crate::Real;
use crate::lanes::{FusedF32, FusedF64};
use core::any::TypeId;
use core::sync::atomic::{AtomicU8, Ordering};

/// Whether the faster number of a type is one of the fused ones of `lanes`, which are laid out as the slower ones.
#[inline(always)]
pub(super) fn is_known<R: Real>() -> bool {
    let (own, faster) = (TypeId::of::<R>(), TypeId::of::<R::Faster>());
    let is = |slow: TypeId, fast: TypeId| faster == fast && (own == slow || own == fast);
    is(TypeId::of::<f64>(), TypeId::of::<FusedF64>()) || is(TypeId::of::<f32>(), TypeId::of::<FusedF32>())
}

/// The best level that processor and system have; asked for once.
#[inline]
pub(super) fn level() -> Level {
    const UNKNOWN: u8 = 0;
    static KNOWN: AtomicU8 = AtomicU8::new(UNKNOWN);
    match KNOWN.load(Ordering::Relaxed) {
        UNKNOWN => {
            let found = ask();
            KNOWN.store(1 + found as u8, Ordering::Relaxed);
            found
        }
        1 => Level::Target,
        _ => Level::V3,
    }
}

#[cold]
#[cfg(feature = "std")]
fn ask() -> Level {
    use std::arch::is_x86_feature_detected as has;
    if !(has!("avx2") && has!("fma")) { Level::Target } else { Level::V3 }
}

/// As the standard library does, which is not there: the processor's word, and that the system keeps wide registers.
#[cold]
#[cfg(not(feature = "std"))]
fn ask() -> Level {
    use core::arch::x86_64::{__cpuid, __cpuid_count, __get_cpuid_max, _xgetbv};
    /// FMA, OSXSAVE and AVX in leaf 1.
    const BASIC: u32 = 1 << 12 | 1 << 27 | 1 << 28;
    const AVX2: u32 = 1 << 5;
    /// Registers of 128 and 256 bits.
    const WIDE: u64 = 0b110;
    #[target_feature(enable = "xsave")]
    fn kept() -> u64 {
        // SAFETY: the processor says (OSXSAVE) that the system has enabled the instruction.
        #[allow(unused_unsafe)]
        unsafe {
            _xgetbv(0)
        }
    }
    // SAFETY: every x86-64 has the instruction; leaf 7 is asked for where it is there.
    #[allow(unused_unsafe)]
    let (basic, extended) = unsafe {
        let extended = if __get_cpuid_max(0).0 >= 7 { __cpuid_count(7, 0).ebx } else { 0 };
        (__cpuid(1).ecx, extended)
    };
    if basic & BASIC != BASIC || extended & AVX2 == 0 {
        return Level::Target;
    }
    // SAFETY: OSXSAVE is among what was found.
    let kept = unsafe { kept() };
    if kept & WIDE != WIDE { Level::Target } else { Level::V3 }
}

/// What a generated function is given, as the faster function takes it.
pub trait Recast {
    /// The same with faster numbers.
    type Faster;
    /// The same place in memory.
    fn recast(self) -> Self::Faster;
}

/// A reference to the same place.
macro_rules! same_place {
    ($pointer:expr) => {{
        // SAFETY: as was asserted, the faster numbers are transparent structs around the slower ones, or they themselves.
        unsafe { $pointer }
    }};
}

impl<'a, R: Real, const N: usize> Recast for &'a [R; N] {
    type Faster = &'a [R::Faster; N];
    #[inline(always)]
    fn recast(self) -> Self::Faster {
        assert!(is_known::<R>());
        same_place!(&*core::ptr::from_ref(self).cast())
    }
}

impl<'a, R: Real, const N: usize> Recast for &'a mut [R; N] {
    type Faster = &'a mut [R::Faster; N];
    #[inline(always)]
    fn recast(self) -> Self::Faster {
        assert!(is_known::<R>());
        same_place!(&mut *core::ptr::from_mut(self).cast())
    }
}

impl<'a, R: Real, const N: usize, const M: usize> Recast for &'a mut [[R; N]; M] {
    type Faster = &'a mut [[R::Faster; N]; M];
    #[inline(always)]
    fn recast(self) -> Self::Faster {
        assert!(is_known::<R>());
        same_place!(&mut *core::ptr::from_mut(self).cast())
    }
}

/// A result of the faster function, in the numbers of the caller.
#[inline(always)]
pub fn back<R: Real>(x: R::Faster) -> R {
    assert!(is_known::<R>());
    same_place!(*core::ptr::from_ref(&x).cast::<R>())
}
