//! Controllers that impose virtual constraints (thesis 6.1): outputs as formulas of the configuration, differentiated
//! along the motion, and a feedback that makes them vanish.
mod controller;
mod driven;
mod feedback;
mod program;
mod signals;
mod tracker;

pub use controller::{Controller, Outputs, PhaseOutputs};
pub use driven::Driven;
pub(crate) use driven::cannot_drive;
pub use feedback::Feedback;
pub(crate) use program::Step;
pub use program::{Jet, Program, Work};
pub use signals::{POINT_FUNCTIONS, Signal, signals};
