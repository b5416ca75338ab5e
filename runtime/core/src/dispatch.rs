//! Levels of x86-64 in one program: generated functions of `f64` and `f32` take the fused multiply-adds and the registers of
//! x86-64-v3 where the processor has them, though the crate is compiled for every x86-64.
//!
//! Not those of x86-64-v4: compilers then write registers of 512 bits, and while one of them is at work Intel's processors close
//! one of the two ports of scalar arithmetic (on an Intel Xeon functions of one state took 1.1 to 2 times as long).
//!
//! With the feature `dispatch`, and only where the target itself is without fused multiply-add: compiled with `-C target-cpu=native`
//! or `x86-64-v3`, or for another processor, there is nothing to choose. Results have then the bits of code that is
//! compiled for x86-64-v3 (one rounding in `a * b + c`); [`fused`] tells which they are. Lanes compute as the target does.
use crate::Real;

#[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
mod chosen;
#[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
pub use chosen::{Recast, back};

/// What generated functions are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// What the whole crate is compiled for.
    Target,
    /// AVX2 and fused multiply-add.
    V3,
}

/// Whether generated functions of `f64` and `f32` round once in `a * b + c`: as the target does, or as the processor can.
#[inline(always)]
pub fn fused() -> bool {
    crate::math::FUSED || level::<f64>() > Level::Target
}

/// The level at which functions of this number run here.
#[inline(always)]
pub fn level<R: Real>() -> Level {
    #[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
    if chosen::is_known::<R>() {
        return chosen::level();
    }
    Level::Target
}

/// A generated function, compiled at all levels where there are several.
///
/// Parameters are references to arrays of `R`. `storing set` stands for a last one, `mut set: impl FnMut(usize, R)`, which stores
/// results.
#[cfg(not(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma"))))]
#[macro_export]
macro_rules! dispatched {
    (
        $(#[$meta:meta])*
        $visibility:vis fn $name:ident<R: Real>($($argument:ident: $type:ty),* $(,)?) $(storing $set:ident)? $body:block
    ) => {
        $(#[$meta])*
        $visibility fn $name<R: $crate::Real>(
            $($argument: $type,)* $(mut $set: impl FnMut(usize, R))?
        ) $body
    };
}

/// A generated function, compiled at all levels.
///
/// Parameters are references to arrays of `R`. `storing set` stands for a last one, `mut set: impl FnMut(usize, R)`, which stores
/// results.
#[cfg(all(feature = "dispatch", target_arch = "x86_64", not(target_feature = "fma")))]
#[macro_export]
macro_rules! dispatched {
    (
        $(#[$meta:meta])*
        $visibility:vis fn $name:ident<R: Real>($($argument:ident: $type:ty),* $(,)?) $(storing $set:ident)? $body:block
    ) => {
        $(#[$meta])*
        $visibility fn $name<R: $crate::Real>(
            $($argument: $type,)* $(mut $set: impl FnMut(usize, R))?
        ) {
            #[inline(always)]
            fn statements<R: $crate::Real>(
                $($argument: $type,)* $(mut $set: impl FnMut(usize, R))?
            ) $body

            #[target_feature(enable = "avx2,fma")]
            fn at_v3<R: $crate::Real>(
                $($argument: $type,)* $(mut $set: impl FnMut(usize, R))?
            ) {
                statements::<R>($($argument,)* $($set)?);
            }

            match $crate::dispatch::level::<R>() {
                // SAFETY: the processor has what the function is compiled for.
                $crate::dispatch::Level::V3 => unsafe {
                    at_v3::<R::Faster>(
                        $($crate::dispatch::Recast::recast($argument),)*
                        $(move |k, x| $set(k, $crate::dispatch::back(x)))?
                    )
                },
                // Faster numbers are asked for where the processor has them alone; elsewhere they have no results.
                $crate::dispatch::Level::Target if R::IS_FASTER => {}
                $crate::dispatch::Level::Target => statements::<R>($($argument,)* $($set)?),
            }
        }
    };
}
