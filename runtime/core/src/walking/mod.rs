//! Walking on flat feet: what a robot does with its legs while one or both stand (thesis 6.3).
mod controller;
pub mod divergent;
mod motion;
pub mod robot;
mod sharing;
pub mod space;
pub mod steps;
pub mod support;
pub mod swing;

pub use controller::{Gains, Walked, WalkingController};
pub use motion::{Motion, Wish};
