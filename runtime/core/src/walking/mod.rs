//! Walking on flat feet: what a robot does with its legs while one or both stand (thesis 6.3).
pub mod ground_forces;
mod ground_program;
pub mod space;
