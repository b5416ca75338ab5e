//! What runs on the robot: what generated models need at run time.
//!
//! The crate is `no_std` (but with the feature `std`), never allocates and never panics on finite input. With the feature
//! `dispatch` generated functions use what the processor has beyond the target, see [`mod@dispatch`].
#![cfg_attr(not(feature = "std"), no_std)]

pub mod control;
pub mod dispatch;
pub mod format;
pub mod lanes;
pub mod math;
pub mod model;
pub mod real;
pub mod sparsity;
pub mod walking;

#[cfg(feature = "source")]
pub mod in_process;
#[cfg(feature = "source")]
pub mod source;

pub use format::{FORMAT, require_format};
pub use model::{Argument, Arguments, CallError, Model, Signature, State};
pub use real::{Real, Scalar};
pub use sparsity::Sparsity;

pub use nalgebra;
