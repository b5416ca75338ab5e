//! Walking on flat feet: what a robot does with its legs while one or both stand (thesis 6.3).
mod error_state;
pub mod estimator;
pub mod ground_forces;
mod ground_program;
mod readings;
pub mod space;
