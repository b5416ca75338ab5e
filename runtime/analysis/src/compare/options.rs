//! What to compare and how.

/// Cut-offs that are tried if none is given, Hz.
pub const CANDIDATES: [f64; 6] = [10.0, 16.0, 25.0, 40.0, 60.0, 90.0];

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
pub struct Subject {
    /// In the order of `v` after the base.
    pub joints: Vec<Joint>,
    /// Before them.
    pub base: BaseKind,
}

/// Where velocities come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VelocitySource {
    /// Filtered positions, differentiated: logged velocities are often late and noisy.
    #[default]
    Positions,
    /// Logged velocities, filtered; accelerations are their derivative. Joints without a velocity column fall
    /// back to positions, with a warning.
    Logged,
}

/// How to compare.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Cut-off of the filter, Hz; `None`: the one of `candidates` with the smallest total error.
    pub cutoff_hz: Option<f64>,
    /// Tried if `cutoff_hz` is not given, Hz.
    pub candidates: Vec<f64>,
    /// Left out of the error at both ends of the log and on both sides of gaps, s.
    pub trim_s: f64,
    /// Samples before this time (of the log's own clock, s) do not count.
    pub from_s: Option<f64>,
    /// Samples after this time do not count.
    pub to_s: Option<f64>,
    /// For the joints.
    pub velocity: VelocitySource,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            cutoff_hz: None,
            candidates: CANDIDATES.to_vec(),
            trim_s: 0.5,
            from_s: None,
            to_s: None,
            velocity: VelocitySource::Positions,
        }
    }
}
