//! What a file of measurements holds for a robot.
use crate::log::{Kind, Log};
use crate::robot::{BaseKind, JointLayout};

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// Joint torques of a robot whose base rests.
    Efforts,
    /// Motion of the base and forces below the feet.
    Contacts,
    /// Static postures on force plates.
    Postures,
    /// Velocities before and after impacts.
    Impacts,
}

impl Content {
    /// What samples run over.
    pub fn abscissa(self) -> &'static str {
        match self {
            Self::Efforts | Self::Contacts => "time",
            Self::Postures => "posture",
            Self::Impacts => "impact",
        }
    }
}

impl Log {
    /// What the file holds for this robot.
    pub fn content(&self, layout: &JointLayout) -> Content {
        let has = |part: &str| self.columns().any(|column| column.contains(part));
        let moves = layout.base != BaseKind::Fixed && has("base/position");
        match self.kind() {
            Kind::Posture => Content::Postures,
            Kind::Impact => Content::Impacts,
            Kind::Time if moves && has("/force/") => Content::Contacts,
            Kind::Time => Content::Efforts,
        }
    }
}
