//! Films of simulations: shapes from the URDF, poses of all bodies, what acts on them, energies.
mod hull;
pub(crate) mod meshes;
mod parts;
mod poses;
mod record;
mod touching;

pub use parts::{parts, side_of_bodies};
pub use poses::poses;
pub use record::Recorder;
pub use touching::touching_points;
