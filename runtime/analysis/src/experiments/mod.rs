//! Logs as experiments: rows (measured minus modelled), and how any list of effects would change them.
pub mod contact_log;
pub(crate) mod corners;
pub mod data_checks;
mod experiment;
pub(crate) mod form;
pub mod impacts;
pub(crate) mod jumps;
pub(crate) mod memo;
mod motion;
pub(crate) mod moving;
pub(crate) mod noise;
pub mod plotted;
pub mod postures;
pub(crate) mod signals;

pub use experiment::{Channel, Experiment, Inertial, Row};
pub use motion::MotionExperiment;
pub(crate) use motion::{depends_on_unseen, nothing_left};
