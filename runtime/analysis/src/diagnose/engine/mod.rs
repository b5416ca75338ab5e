//! The engine: from experiments to a [`Diagnosis`].
mod alternatives;
mod block_equations;
mod candidates;
mod corners;
mod corrections;
mod exchange;
mod fit;
mod noise_floor;
mod parallel;
mod parsimony;
mod refinement;
mod regression;
mod resolution;
mod run;
mod search;
mod significance;
mod smoother;
mod text;
mod unexplained;

pub use run::{Errors, Options, diagnose, errors, estimate};
pub use text::summary;
