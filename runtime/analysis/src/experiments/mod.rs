//! Logs as experiments: rows (measured minus modelled), and how any list of effects would change them.
pub mod contact_log;
pub mod data_checks;
mod experiment;
pub(crate) mod form;
pub mod impacts;
mod motion;
pub(crate) mod moving;
pub(crate) mod noise;
pub mod plotted;
pub mod postures;

pub use experiment::{Channel, Experiment, Inertial, Row};
pub use motion::MotionExperiment;
