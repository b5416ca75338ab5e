//! Motions that tell much: joint trajectories designed for identification (thesis 5.3, equations 5.16 to 5.18).
//!
//! [`postures`] designs static postures instead (5.4.1, equations 5.24 and 5.25).
//!
//! A [`Machine`] says what moves within which limits, a [`Basis`] which trajectories there are, a [`Regression`] what a
//! motion tells; [`design`] looks for the motion that tells most and keeps every limit.
mod basis;
mod clearance;
mod information;
mod limits;
mod machine;
pub mod postures;
mod search;
pub mod separate;
mod spectrum;
#[cfg(test)]
mod tests;

pub use basis::{Basis, Family};
pub use clearance::{CLEARANCE_FUNCTIONS, Clearance};
pub use information::{MotionQuality, Regression};
pub use limits::{Peaks, peaks};
pub use machine::{Limits, Machine};
pub use search::{Designed, Early, Request, design};
pub use spectrum::{Criterion, Quality, Scaling};
