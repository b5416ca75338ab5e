//! Simulation of walking robots (thesis chapter 4).
//!
//! [`Stepper`] is the non-smooth time stepping of 4.3: rigid ground, Signorini's and Coulomb's laws, Newton's law of
//! impact, all contacts at once ([`Problem`], [`Solver`]), on any [`Model`](crate::Model) with a mass matrix, a bias and
//! contact points ([`Mechanics`]).
mod dense;
mod ground;
mod mechanics;
mod newton;
mod problem;
mod proximal;
mod stepper;

pub use ground::{Compliance, Ground, JointLaw};
pub use mechanics::{FUNCTIONS, Frame, Mechanics};
pub use problem::{Block, Cone, Law, Problem};
pub use proximal::{Solved, Solver, Tolerance};
pub use stepper::{Motion, Stepped, Stepper};
