//! Joint torques of a log: what is measured, what the model predicts, what effects would change.
mod experiment;
mod laws;
mod limit;
mod noise;
mod places;
pub(crate) mod recording;
mod rigid;
mod ripple;
mod thinning;

pub use experiment::MotionExperiment;
pub(crate) use noise::white_noise;
pub use recording::Recording;
pub use thinning::HELD;
