//! Walks on flat feet: footsteps, phases with cosine profiles, the pendulum below the centre of mass, inverse kinematics, forces of
//! the ground (thesis 6.3.1). Knows no robot: Jacobians and zero moment points are handed in.
mod footsteps;
mod forces;
mod inverse_kinematics;
mod pendulum;
mod polygon;
mod profile;
mod schedule;
mod settings;
#[cfg(test)]
mod tests;

pub use footsteps::{Advance, Footstep, Sequence, read_footsteps};
pub use forces::{Wrench, corner_forces, distribute};
pub use inverse_kinematics::{Solved, bounded_least_squares, straight_direction, turn_error, turn_matrix};
pub use pendulum::{Rest, pendulum};
pub use polygon::{Point, distance, hull, margin};
pub use profile::{Moved, cosine, moved};
pub use schedule::{Instant, Kind, Phase, Schedule, Sole, Stance, Timing};
pub use settings::{Settings, Stated, read_settings};

/// Names of both legs, in the order of every pair here.
pub const LEGS: [&str; 2] = ["right", "left"];
