//! Joints and base: what the coordinates of a robot are called.
use bipedc_effects::base::BaseKind;

/// A joint of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// As in the URDF.
    pub name: String,
    /// Whether it slides: m and N instead of rad and N m.
    pub prismatic: bool,
    /// Its stops, rad or m: lower, upper; `None`: not known, or none.
    pub limits: Option<[f64; 2]>,
}

impl Joint {
    /// A revolute or continuous joint.
    pub fn revolute(name: impl Into<String>) -> Self {
        Self { name: name.into(), prismatic: false, limits: None }
    }
    /// Of its effort.
    pub fn unit(&self) -> &'static str {
        if self.prismatic { "N" } else { "N m" }
    }
}

/// The robot that is compared, without its dynamics.
#[derive(Debug, Clone, PartialEq)]
pub struct JointLayout {
    /// In the order of `v` after the base.
    pub joints: Vec<Joint>,
    /// Before them.
    pub base: BaseKind,
}
