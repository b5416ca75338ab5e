//! The engine: from experiments to a [`Diagnosis`].
mod alternatives;
mod answer;
mod bank;
mod doubtful;
mod fit;
mod form;
mod polish;
mod remainder;
mod search;
mod setting;
mod simplest;
mod smoother;
mod words;

pub use answer::{Options, diagnose, errors, estimate};
pub(crate) use form::effect_columns;
pub use words::summary;
