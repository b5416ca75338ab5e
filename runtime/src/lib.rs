//! What generated robot models need at run time, and offline tools that work on any model.
//!
//! Without the feature `std` the crate is `no_std`, never allocates and never panics on finite input.
#![cfg_attr(not(feature = "std"), no_std)]

pub mod lanes;
pub mod math;
pub mod model;
pub mod real;

#[cfg(feature = "std")]
pub mod compare;
#[cfg(feature = "std")]
pub mod diagnose;
#[cfg(feature = "std")]
pub mod diagnostic;
#[cfg(feature = "std")]
pub mod effect;
#[cfg(feature = "std")]
pub mod files;
#[cfg(feature = "std")]
pub mod identify;
#[cfg(feature = "std")]
pub mod input;
#[cfg(feature = "std")]
pub mod log;
#[cfg(feature = "std")]
pub mod magnitude;
#[cfg(feature = "std")]
pub mod report;
#[cfg(feature = "std")]
pub mod signal;
#[cfg(feature = "std")]
pub mod simulate;
#[cfg(feature = "std")]
pub mod source;

pub use model::{Argument, Arguments, CallError, Model, Signature, State};
pub use real::Real;

pub use nalgebra;
