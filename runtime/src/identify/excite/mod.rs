//! Motions that tell much: joint trajectories designed for identification (thesis 5.3, equations 5.16 to 5.18).
//!
//! A [`Machine`] says what moves within which limits, a [`Basis`] which trajectories there are, a [`Regression`] what a
//! motion tells; [`design`] looks for the motion that tells most and keeps every limit.
mod basis;
mod information;
mod limits;
mod machine;
mod search;
#[cfg(test)]
mod tests;

pub use basis::{Basis, Family};
pub use information::{Criterion, Quality, Regression};
pub use limits::{Peaks, peaks};
pub use machine::{Limits, Machine, Motion};
pub use search::{Designed, Request, design};
