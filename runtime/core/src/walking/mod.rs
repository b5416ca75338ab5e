//! Walking on flat feet: what a robot does with its legs while one or both stand (thesis 6.3).
mod adjustment;
mod controller;
pub mod divergent;
mod error_state;
pub mod estimator;
mod estimator_feet;
mod gains;
mod ground_foot;
pub mod ground_forces;
mod ground_program;
mod motion;
mod on_board;
mod quaternion;
mod readings;
pub mod robot;
mod sensed;
pub mod space;
pub mod steps;
pub mod support;
pub mod swing;

pub use controller::{Walked, WalkingController};
pub use gains::Gains;
pub use motion::{Motion, Wish};
pub use on_board::{Legs, OnBoardWalker, Stepped};
