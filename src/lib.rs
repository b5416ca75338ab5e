//! Robots ready to be compared, diagnosed, identified, simulated and filmed: compiler and analysis together.
pub mod absolute;
pub mod drawing;
pub mod feet;
pub mod film;
pub mod identification;
pub mod link_inertias;
pub mod regressor;
pub mod simulation;
pub mod standing;
pub mod torques;

pub use feet::feet;
pub use link_inertias::link_inertias;
pub use regressor::ProgramRegressor;
pub use torques::ProgramTorques;
