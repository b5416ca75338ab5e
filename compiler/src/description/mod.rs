//! What the user wrote: the URDF and `biped.toml`, read and checked.
pub mod model;
