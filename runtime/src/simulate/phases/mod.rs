//! Event-driven simulation with phases in a fixed order (thesis 4.4): an error-controlled integration of each phase, the
//! instant at which it ends, the impact, the exchange of the legs, and the assumptions under which all this holds.
mod integrate;
mod robot;
mod support;

pub use integrate::{Change, End, Phased, Precision, Start, Violation, Walk, walk};
pub use robot::{Assumptions, Ending, PhaseSpec, PhasedRobot, Torque};
pub use support::{Row, RowKind};
