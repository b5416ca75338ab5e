//! The kinematic tree: bodies with one joint each, parents before children, fixed joints lumped, rooted at
//! any link or contact point.
mod build;
mod effects;
mod inertia;
mod placement;
mod rates;
mod right_angles;
mod standing;
mod twins;

pub use bipedc_effects::base::BaseKind;
pub use effects::as_built;
pub use inertia::Inertia;
pub(crate) use placement::NEARLY_RIGHT;
pub use placement::{Placement, Rotation, matrix_vector};
pub(crate) use standing::{Standing, Trunk};
pub use twins::Twins;

/// How a body moves relative to its parent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointMotion {
    /// Six degrees of freedom: position and unit quaternion (x y z w); twist in the body's axes.
    Free,
    /// Rotation about a coordinate axis (0 = x, 1 = y, 2 = z) of the body frame.
    Revolute {
        /// Coordinate axis.
        axis: usize,
        /// The joint's positive direction is against the coordinate axis.
        reversed: bool,
    },
    /// Translation along a coordinate axis.
    Prismatic {
        /// Coordinate axis.
        axis: usize,
        /// The joint's positive direction is against the coordinate axis.
        reversed: bool,
    },
}

impl JointMotion {
    /// Number of velocity components.
    pub fn nv(self) -> usize {
        if self == Self::Free { 6 } else { 1 }
    }
    /// Number of configuration components.
    pub fn nq(self) -> usize {
        if self == Self::Free { 7 } else { 1 }
    }
}

/// One rigid body: a link and everything fixed to it.
///
/// Its frame is chosen so that its joint axis is a coordinate axis; link frames sit in it by constant
/// placements.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Name of the main link (the one nearest to the URDF's root), or of the virtual base body.
    pub name: String,
    /// Index of the parent body; `None` hangs in the world.
    pub parent: Option<usize>,
    /// Name of the joint that moves it.
    pub joint: String,
    /// Degrees of freedom.
    pub motion: JointMotion,
    /// Frame at zero joint position in the parent's frame.
    pub placement: Placement,
    /// First element in `q`.
    pub q_index: usize,
    /// First element in `v`.
    pub v_index: usize,
    /// Mass, first moment and inertia in the body frame, all lumped links together.
    pub inertia: Inertia,
    /// Frame of the main link in the body frame: inertial parameters are stated in it.
    pub main_link: Placement,
    /// A virtual body of a planar base: massless and without a link.
    pub is_virtual: bool,
}

/// A frame fixed to a body (or to the world).
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Link name, or `foot/point`.
    pub name: String,
    /// The body; `None` is the world.
    pub body: Option<usize>,
    /// In the body's frame.
    pub placement: Placement,
}

/// A joint of the robot as the user knows it.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeJoint {
    /// URDF name.
    pub name: String,
    /// Index into `v`.
    pub v_index: usize,
    /// Translation instead of rotation.
    pub prismatic: bool,
    /// Has an actuator.
    pub actuated: bool,
}

/// A robot as the derivations see it.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    /// Robot name.
    pub name: String,
    /// Kind of base.
    pub base: BaseKind,
    /// Parents first.
    pub bodies: Vec<Body>,
    /// All links.
    pub links: Vec<Frame>,
    /// All contact points, `foot/point`, axes of their link.
    pub points: Vec<Frame>,
    /// Joints in the order of the URDF: also their order in `q` and `v` after the base.
    pub joints: Vec<TreeJoint>,
    /// Gravitational acceleration in world axes, m/s².
    pub gravity: [f64; 3],
    /// Length of `q`.
    pub nq: usize,
    /// Length of `v`.
    pub nv: usize,
    /// Angles of the description within 1e-4 rad of a multiple of π/2 but not on it (axes: of a coordinate axis), which
    /// [`Tree::structure`] takes as right: (where, rad).
    pub nearly_right_angles: Vec<(String, f64)>,
    /// The same robot with right angles, where that is another one.
    right_angled: Option<Box<Tree>>,
}

impl Tree {
    /// Number of base coordinates in `v`.
    pub fn base_nv(&self) -> usize {
        self.base.nv()
    }

    /// A link or contact point by name.
    pub fn frame(&self, name: &str) -> Option<&Frame> {
        self.links.iter().chain(&self.points).find(|frame| frame.name == name)
    }

    /// Names of the rows of `v`, with units of the corresponding force: `base/linear/x`, …, then joints.
    pub fn row_names(&self) -> Vec<String> {
        let base: &[&str] = match self.base {
            BaseKind::Floating => &[
                "base/linear/x",
                "base/linear/y",
                "base/linear/z",
                "base/angular/x",
                "base/angular/y",
                "base/angular/z",
            ],
            BaseKind::Planar => &["base/x", "base/z", "base/pitch"],
            BaseKind::Fixed => &[],
            BaseKind::Pivot => &["base/pivot"],
        };
        base.iter().map(|s| (*s).to_owned()).chain(self.joints.iter().map(|j| j.name.clone())).collect()
    }

    /// Names of the elements of `q`: `base/x`, …, then joints.
    pub fn coordinate_names(&self) -> Vec<String> {
        let base: &[&str] = match self.base {
            BaseKind::Floating => &["base/x", "base/y", "base/z", "base/qx", "base/qy", "base/qz", "base/qw"],
            BaseKind::Planar => &["base/x", "base/z", "base/pitch"],
            BaseKind::Fixed => &[],
            BaseKind::Pivot => &["base/pivot"],
        };
        base.iter().map(|s| (*s).to_owned()).chain(self.joints.iter().map(|j| j.name.clone())).collect()
    }

    /// Whether the row of `v` is a translation.
    pub fn row_is_linear(&self, row: usize) -> bool {
        match (self.base, row) {
            (BaseKind::Floating, 0..3) | (BaseKind::Planar, 0..2) => true,
            (BaseKind::Floating, 3..6) | (BaseKind::Planar, 2) | (BaseKind::Pivot, 0) => false,
            _ => self.joints[row - self.base_nv()].prismatic,
        }
    }

    /// Total mass of everything that moves, kg.
    pub fn total_mass(&self) -> f64 {
        self.bodies.iter().map(|body| body.inertia.mass).sum()
    }

    /// Indices of the bodies from `body` up to its root, `body` first.
    pub fn path_to_root(&self, body: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(body), |&b| self.bodies[b].parent)
    }
}
