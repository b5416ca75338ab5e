//! Controllers of simulated robots: servos at the joints, and virtual constraints (thesis 6.1): outputs as formulas of the
//! configuration, differentiated along the motion, and a feedback that makes them vanish.
mod joint_servos;
mod phased_controller;
mod program;
mod signals;
mod tracker;
mod virtual_constraints;

pub use joint_servos::JointServos;
pub use phased_controller::PhasedController;
pub(crate) use phased_controller::refused;
pub(crate) use program::Step;
pub use program::{Jet, Program, Work};
pub use signals::{POINT_FUNCTIONS, Signal, signals};
pub use virtual_constraints::{Outputs, PhaseOutputs, VirtualConstraints};

/// What makes an output vanish.
pub type Feedback = bipedc_runtime::control::Feedback<f64>;
