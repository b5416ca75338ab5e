//! What a model predicts against what was logged.
//!
//! [`compare`] reads a log once, in blocks, and judges all candidate cut-offs on the way: positions are filtered
//! and differentiated ([`crate::signal`]), the model's inverse dynamics is evaluated at every sample, and the
//! logged effort minus the predicted one goes into one channel per joint. Efforts are not filtered.
//!
//! Memory is that of a block: at least 16384 samples, and four times the filter's overlap. Filtered positions of a
//! log in several blocks differ from those of the whole log at once by less than 4e-12 of the signal's range
//! ([`crate::signal::TRUNCATION`]); logs shorter than a block are one block.
mod experiment;
mod free_run;
mod motion_noise;
mod report;
mod run;
mod statistics;

pub use experiment::{Reading, channels_of};
pub use free_run::{FEWEST_SAMPLES, FreeChannel, FreeRun, MOST_WINDOWS, free_run};
pub use report::{Channel, Comparison, Cutoff, KindError};
pub use run::{compare, compare_file};
pub use statistics::geometric_mean;
