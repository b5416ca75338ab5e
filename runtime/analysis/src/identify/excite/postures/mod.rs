//! Static postures that tell much: both feet flat on the ground, centre of pressure inside the support (thesis 5.4.1).
//!
//! Unknown are the placements of the swing foot (x, y, yaw) and the joints of every posture; that its sole lies flat at
//! its placement is a condition of six equations per posture, so what is searched is a surface in the space of joints.
//! [`StanceModel`] knows where bodies are and how that changes with the joints (analytically), `surface` the directions in
//! which a posture may move and the way back onto the surface, `ground` the conditions with their slack, `start` the
//! thesis' search for feasible postures, and [`design_postures`] minimises the condition number within.
mod descent;
mod ground;
mod problem;
mod search;
mod standing;
mod start;
mod surface;
#[cfg(test)]
mod tests;

pub use ground::Tolerance;
pub use search::{DesignedPostures, Planned, PostureRequest, Run, design_postures};
pub use standing::{Bodies, JointPlace, Place, SolePlace, StanceModel, StandingParts};
