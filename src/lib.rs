//! Robots ready to be compared, diagnosed, identified, simulated and filmed: compiler and analysis together.
pub mod absolute;
pub mod anatomy;
pub mod drawing;
pub mod feet;
pub mod film;
pub mod identification;
pub mod regressor;
pub mod simulation;
pub mod standing;
pub mod torques;

pub use anatomy::anatomy;
pub use feet::feet;
pub use regressor::ProgramRegressor;
pub use torques::ProgramTorques;
