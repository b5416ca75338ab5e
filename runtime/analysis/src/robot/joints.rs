//! Joints and base: what the coordinates of a robot are called.

/// A joint of the model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Joint {
    /// As in the URDF.
    pub name: String,
    /// Whether it slides: m and N instead of rad and N m.
    pub prismatic: bool,
}

impl Joint {
    /// A revolute or continuous joint.
    pub fn revolute(name: impl Into<String>) -> Self {
        Self { name: name.into(), prismatic: false }
    }
    /// Of its effort.
    pub fn unit(&self) -> &'static str {
        if self.prismatic { "N" } else { "N m" }
    }
}

/// The coordinates before those of the joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BaseKind {
    /// None.
    Fixed,
    /// q: position, quaternion x y z w; v: linear, angular in the base's axes.
    Floating,
    /// q: x, z, pitch; v: their rates.
    Planar,
}

impl BaseKind {
    /// Number of coordinates in `q`.
    pub const fn nq(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Floating => 7,
            Self::Planar => 3,
        }
    }
    /// Number of coordinates in `v`.
    pub const fn nv(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Floating => 6,
            Self::Planar => 3,
        }
    }
}

/// The robot that is compared, without its dynamics.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JointLayout {
    /// In the order of `v` after the base.
    pub joints: Vec<Joint>,
    /// Before them.
    pub base: BaseKind,
}
