//! The physics: one file per derived thing, all on the expression graph.
//!
//! Every derivation works in body frames with barycentric inertial parameters (mass, first moment, inertia
//! about the frame origin), because then all of them enter linearly and add up along the tree.
mod gait_formulas;
mod inertia;
mod kinematics;
mod model;
mod pinned;
mod reduced;
mod sensitivity;
mod standing;

pub mod articulated;
pub mod base_rows;
pub mod composite;
pub mod constrained;
pub mod constraint;
pub mod contact;
pub mod coriolis;
pub mod curve;
pub mod dependence;
pub mod derivatives;
pub mod drive;
pub mod effects;
pub mod frames;
pub mod impact;
pub mod joint_axes;
pub mod lie_derivatives;
pub mod momentum;
pub mod newton_euler;
pub mod regressor;
pub mod relabel;
pub mod shared_columns;
pub mod solve;
pub mod support;
pub mod unresisted;
pub mod virtual_constraints;
pub mod zero_dynamics;

pub use inertia::BodyInertia;
pub use kinematics::Motions;
pub use model::{InertiaMode, RobotModel};
