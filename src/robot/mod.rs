//! A described robot as the analysis knows it: its joints, feet and link inertias, its inverse dynamics and regressor.
pub mod feet;
pub mod joint_layout;
pub mod link_inertias;
pub mod regressor;
pub mod torques;

pub use feet::feet;
pub use joint_layout::{joint_layout, joint_layout_with_stops};
pub use link_inertias::link_inertias;
pub use regressor::ProgramRegressor;
pub use torques::ProgramTorques;
