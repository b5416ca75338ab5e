//! The physically possible estimate ([`crate::physical`]): its program for a design, and how much CAD counts in it.
mod choose;
mod problem;

pub use crate::physical::{
    Body, Bound, Bounds, Certificate, Consistency, Inertia, Links, Physical, Problem, check,
};
pub use choose::{Choice, TriedWeight, WEIGHTS, choose};
pub use problem::problem;
