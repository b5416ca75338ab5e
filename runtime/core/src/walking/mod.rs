//! Walking on flat feet: what a robot does with its legs while one or both stand (thesis 6.3).
mod error_state;
pub mod estimator;
mod estimator_feet;
mod ground_foot;
pub mod ground_forces;
mod ground_program;
mod quaternion;
mod readings;
mod sensed;
pub mod space;
