//! What a described robot lacks, by logs: which effects, where, how large, how sure.
mod behind;
mod filtered;
mod from_logs;
mod judged;
mod options;
mod raised;
mod stated;
mod text;

pub use from_logs::{diagnose, estimate};
pub use options::{Diagnosed, Inertial, Options};
pub use text::text;
