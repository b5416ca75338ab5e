//! Event-driven simulation with phases in a fixed order (thesis 4.4): an error-controlled integration of each phase, the
//! instant at which it ends, the impact, the exchange of the legs, and the assumptions under which all this holds.
mod assumptions;
mod begin;
mod fastest;
mod follow;
mod integrate;
mod mirror;
mod phased;
mod points;
mod precision;
mod project;
mod robot;
mod run;
mod spec;
mod support;
mod watch;

pub use assumptions::Assumptions;
pub use fastest::Fastest;
pub use integrate::{
    Change, Effort, End, Passage, Phased, Start, Violation, Walk, Watcher, walk, walk_watched,
};
pub(crate) use mirror::Mirror;
pub use precision::{Order, Precision};
pub use project::Projected;
pub use robot::PhasedRobot;
pub use run::{FootImpulse, PhaseChange, WalkEnd, WalkSummary, Walking, columns};
pub use spec::{Ending, Landing, LandingGuard, PhaseSpec};
pub use support::{Row, RowKind};
