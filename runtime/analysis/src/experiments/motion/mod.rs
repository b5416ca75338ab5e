//! Joint torques of a log: what is measured, what the model predicts, what effects would change.
mod detrend;
mod experiment;
mod laws;
mod limit;
mod places;
mod rigid;
mod ripple;
mod sticking;

pub use experiment::MotionExperiment;
