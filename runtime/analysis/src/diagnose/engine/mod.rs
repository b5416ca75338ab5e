//! The engine: from experiments to a [`Diagnosis`].
mod equations;
mod estimate;
mod judge;
mod refine;
mod run;
mod search;
mod words;

pub use estimate::{Stated, estimate};
pub use judge::alike::left_alike;
pub use judge::errors::{Errors, errors, left_by_kind, root_mean_squares};
pub use run::{Options, diagnose};
pub use words::text::summary;
