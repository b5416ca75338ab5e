//! Smooth positions, velocities and accelerations from sampled ones.
//!
//! Positions are filtered forwards and backwards with a fourth-order Butterworth low-pass ([`Butterworth`]), so
//! that they are smooth and not late, then joined by a quintic spline ([`Spline`]) whose derivatives are velocity
//! and acceleration. Where samples are not evenly spaced, positions are first interpolated on an even grid
//! ([`resample`]); the spline is evaluated at the logged times again, so efforts are never interpolated.
mod butterworth;
mod orientation;
mod resample;
mod spline;

pub use butterworth::{Butterworth, FilterError, TRUNCATION};
pub(crate) use orientation::cross;
pub use orientation::{Rotation, align_signs, rotate_to_base, rotation};
pub use resample::{Grid, resample};
pub use spline::Spline;
