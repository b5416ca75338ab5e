//! The engine: from experiments to a [`Diagnosis`].
mod alike;
mod alternatives;
mod amended;
#[cfg(test)]
mod at_corners;
mod behind_motors;
mod block_equations;
mod candidates;
mod conclusion;
mod corrected;
mod corrections;
mod errors;
mod estimates;
mod exchange;
mod fit;
mod friction_first;
mod late;
mod linearised;
mod noise_floor;
mod parsimony;
mod refinement;
mod regression;
mod resolution;
mod rival;
mod run;
mod search;
mod significance;
mod smoother;
mod text;
mod uncertainty;
mod unexplained;

pub use alike::left_alike;
pub use errors::{Errors, errors, root_mean_squares};
pub use run::{Options, diagnose, estimate};
pub use text::summary;
