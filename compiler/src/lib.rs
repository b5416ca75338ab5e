//! From a URDF and a description file to optimised straight-line programs and Rust code.
//!
//! The stages, each with a type of its own:
//! [`description`] → tree → expression → derive → optimise → program →
//! emit (Rust tokens) or evaluate (in process).
pub mod build;
pub mod compile;
pub mod derive;
pub mod description;
pub mod emit;
pub mod exact;
pub mod expression;
pub mod front;
pub mod program;
pub mod robot;
mod self_check;
pub mod states;
pub mod tree;

pub use robot::Robot;
pub use self_check::self_check;
