//! The engine: from experiments to a [`Diagnosis`].
mod alternatives;
mod answer;
mod bank;
mod candidates;
mod doubtful;
mod fit;
mod floor;
mod form;
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
pub(crate) use form::effect_columns;
pub use words::summary;
