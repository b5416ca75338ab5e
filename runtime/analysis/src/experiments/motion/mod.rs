//! Joint torques of a log: what is measured, what the model predicts, what effects would change.
mod detrend;
mod experiment;
mod hidden_link;
mod hidden_play;
mod laws;
mod limit;
mod motor_side;
mod places;
mod rigid;
mod ripple;
mod sticking;
mod torques;

pub use experiment::MotionExperiment;
