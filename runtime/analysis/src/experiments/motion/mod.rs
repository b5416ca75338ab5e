//! Joint torques of a log: what is measured, what the model predicts, what effects would change.
mod columns;
mod detrend;
mod experiment;
mod hidden_link;
mod hidden_links;
mod hidden_play;
mod inertial;
mod laws;
mod limit;
mod motion_noise;
mod motor_side;
mod on_ground;
mod places;
mod rigid;
mod ripple;
mod sharp_signs;
mod signals;
mod starts;
mod sticking;
mod torques;
mod under_effects;
mod unseen;
mod within_steps;

pub use experiment::MotionExperiment;
pub(crate) use motor_side::Hidden;
pub(crate) use on_ground::OnGround;
pub(crate) use unseen::{depends_on_unseen, nothing_left};
