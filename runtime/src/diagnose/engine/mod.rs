//! The engine: from experiments to a [`Diagnosis`].
mod answer;
mod bank;
mod fit;
mod form;
mod polish;
mod search;
mod setting;
mod smoother;
mod words;

pub use answer::{Options, diagnose, errors, estimate};
pub use words::summary;
