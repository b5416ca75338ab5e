//! What is told of a foot everywhere alike: its side of the body, and where it may touch the ground.

/// Left or right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// y > 0
    Left,
    /// y < 0
    Right,
}

/// A point fixed to a foot's link that may touch the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPoint {
    /// Name within the foot: `heel`, `toe`, `front_left`, …
    pub name: String,
    /// Position in the link frame, m.
    pub position: [f64; 3],
}
