//! How a robot hangs in the world: the coordinates before those of its joints.

/// The coordinates before those of the joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BaseKind {
    /// q: position, quaternion x y z w; v: linear, angular in the root's axes.
    Floating,
    /// q: x, z, pitch; v: their rates.
    Planar,
    /// None.
    Fixed,
    /// One angle, about a contact point or joint: for derivations alone, no log tells it and no simulation lets it go.
    Pivot,
}

impl BaseKind {
    /// Number of coordinates in `q`.
    pub const fn nq(self) -> usize {
        self.rest().len()
    }
    /// Number of coordinates in `v`.
    pub const fn nv(self) -> usize {
        match self {
            Self::Floating => 6,
            Self::Planar => 3,
            Self::Fixed => 0,
            Self::Pivot => 1,
        }
    }
    /// Its `q` at the origin, upright.
    pub const fn rest(self) -> &'static [f64] {
        match self {
            Self::Floating => &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            Self::Planar => &[0.0; 3],
            Self::Fixed => &[],
            Self::Pivot => &[0.0],
        }
    }
    /// World axes that it moves along and turns about, as measurements have them: 0 = x, 1 = y, 2 = z.
    pub const fn axes(self) -> (&'static [usize], &'static [usize]) {
        match self {
            Self::Floating => (&[0, 1, 2], &[0, 1, 2]),
            Self::Planar => (&[0, 2], &[1]),
            Self::Fixed | Self::Pivot => (&[], &[]),
        }
    }
}
