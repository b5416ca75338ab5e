//! The engine: from experiments to a [`Diagnosis`].
mod alternatives;
mod answer;
mod bank;
mod candidates;
mod doubtful;
mod fit;
mod floor;
mod parallel;
mod polish;
mod refine;
mod remainder;
mod search;
mod setting;
mod simplest;
mod smoother;
mod words;

pub use answer::{Options, diagnose, errors, estimate};
pub use words::summary;
