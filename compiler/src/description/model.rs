//! The checked description of a robot: plain data, names resolved by string, SI units.
use bipedc_effects::drive::Drive;
use bipedc_effects::effect::{Effect, Location};
pub use bipedc_effects::feet::{ContactPoint, Side};

/// A URDF and its `biped.toml`, read and checked; nothing in it refers to something undefined.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotDescription {
    /// Name of the robot: `robot/@name` of the URDF unless `biped.toml` gives another.
    pub name: String,
    /// All links in the order of the file.
    pub links: Vec<Link>,
    /// All joints in the order of the file; together with the links they form one tree.
    pub joints: Vec<Joint>,
    /// The URDF's root link.
    pub root_link: String,
    /// How the robot hangs in the world.
    pub base: Base,
    /// Gravitational acceleration in world axes, m/s².
    pub gravity: [f64; 3],
    /// Feet with their contact points.
    pub feet: Vec<Foot>,
    /// Mirror-symmetric pairs of joints.
    pub symmetric_joints: Vec<SymmetricPair>,
    /// Names of the joints with an actuator, in the order of the generalised torques.
    pub actuated_joints: Vec<String>,
    /// Names of the joints whose angle in logs is measured at the motor, before springs and play.
    pub motor_encoders: Vec<String>,
    /// Drives in the order of the file, each joint once.
    pub drives: Vec<JointDrive>,
    /// Contact phases in their order.
    pub phases: Vec<Phase>,
    /// What the rigid-body model lacks, in the order of the file.
    pub effects: Vec<Effect>,
    /// What to generate.
    pub generate: Generate,
}

/// Whether the joint of a place is one of these and slides.
pub(super) fn slides(joints: &[Joint], place: &Location) -> bool {
    let here = |joint: &&Joint| place.joint.as_ref() == Some(&joint.name);
    joints.iter().find(here).is_some_and(|joint| joint.kind == JointKind::Prismatic)
}

impl RobotDescription {
    /// Whether the joint of a place slides: its effects have m and N instead of rad and N m.
    pub fn slides(&self, place: &Location) -> bool {
        slides(&self.joints, place)
    }

    /// The rigid-body model alone: the same robot without its `[[effect]]`s.
    #[must_use]
    pub fn without_effects(mut self) -> Self {
        self.effects.clear();
        self
    }

    /// Position limits of the joints with these names, rad or m.
    pub fn stops<'n>(&self, joints: impl Iterator<Item = &'n str>) -> Vec<Option<[f64; 2]>> {
        let of_urdf = |name: &str| self.joints.iter().find(|joint| joint.name == name);
        joints.map(|name| of_urdf(name)?.position_limits.map(|(low, high)| [low, high])).collect()
    }

    /// Velocity limits of the joints with these names, rad/s or m/s.
    pub fn velocity_limits<'n>(&self, joints: impl Iterator<Item = &'n str>) -> Vec<Option<f64>> {
        let of_urdf = |name: &str| self.joints.iter().find(|joint| joint.name == name);
        joints.map(|name| of_urdf(name)?.velocity_limit).collect()
    }

    /// The drive of a joint, if it has one.
    pub fn drive(&self, joint: &str) -> Option<&Drive> {
        self.drives.iter().find(|driven| driven.joint == joint).map(|driven| &driven.drive)
    }
}

/// A rigid body of the URDF.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Name, unique among links.
    pub name: String,
    /// Mass, centre of mass, inertia; `None` where the URDF has none (counts as massless).
    pub inertial: Option<Inertial>,
}

/// Mass, centre of mass and inertia of one link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertial {
    /// kg
    pub mass: f64,
    /// Centre of mass and orientation of the inertia axes in the link frame.
    pub origin: Pose,
    /// `ixx, ixy, ixz, iyy, iyz, izz` about the centre of mass in the axes of `origin`, kg m².
    pub inertia: [f64; 6],
}

/// A placement as URDF writes it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// Translation, m.
    pub xyz: [f64; 3],
    /// Roll, pitch, yaw about fixed axes, rad: `R = Rz(yaw) Ry(pitch) Rx(roll)`.
    pub rpy: [f64; 3],
}

/// What a joint lets its child do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Rotation with limits.
    Revolute,
    /// Rotation without limits.
    Continuous,
    /// Translation along the axis.
    Prismatic,
    /// No motion.
    Fixed,
}

impl JointKind {
    /// Whether the joint has a coordinate.
    pub fn moves(self) -> bool {
        self != Self::Fixed
    }
}

/// A joint of the URDF.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name, unique among joints.
    pub name: String,
    /// Kind of motion.
    pub kind: JointKind,
    /// Parent link.
    pub parent: String,
    /// Child link.
    pub child: String,
    /// Pose of the joint (and child link) frame in the parent link frame at zero position.
    pub origin: Pose,
    /// Unit axis in the joint frame.
    pub axis: [f64; 3],
    /// Position limits (rad or m), if stated.
    pub position_limits: Option<(f64, f64)>,
    /// Velocity limit (rad/s or m/s), if stated and positive.
    pub velocity_limit: Option<f64>,
    /// Effort limit (N m or N), if stated and positive.
    pub effort_limit: Option<f64>,
}

/// How the robot hangs in the world.
#[derive(Debug, Clone, PartialEq)]
pub enum Base {
    /// Free in space. `root` is the floating link (or contact point `foot/point`); default the URDF's root.
    Floating {
        /// Link or contact point.
        root: String,
    },
    /// Moves in the x-z plane: x, z, pitch.
    Planar {
        /// Link or contact point.
        root: String,
    },
    /// Bolted to the world, upright at the origin.
    Fixed {
        /// The link that does not move.
        link: String,
    },
    /// One angle about a contact point (planar) or a foot's edge (3D).
    Pivot {
        /// `foot/point` or `foot/edge`.
        about: String,
    },
}

/// A foot and its contact points.
#[derive(Debug, Clone, PartialEq)]
pub struct Foot {
    /// Name in the description, such as `right_foot`.
    pub name: String,
    /// The URDF link that carries the points.
    pub link: String,
    /// Side of the body.
    pub side: Option<Side>,
    /// Points that may touch the ground.
    pub points: Vec<ContactPoint>,
    /// Edges about which the foot can tip; derived from the corners where not stated.
    pub edges: Vec<FootEdge>,
}

/// A line through two contact points.
#[derive(Debug, Clone, PartialEq)]
pub struct FootEdge {
    /// `front`, `rear`, `left`, `right`.
    pub name: String,
    /// Names of the two points; the axis runs from the second (right) to the first (left), so along +y for
    /// the front and rear edge.
    pub points: [String; 2],
}

/// Two joints that mirror each other at the x-z plane.
#[derive(Debug, Clone, PartialEq)]
pub struct SymmetricPair {
    /// Left joint.
    pub left: String,
    /// Right joint.
    pub right: String,
    /// +1: equal positions mirror each other (pitch); −1: opposite ones (roll, yaw).
    pub sign: f64,
}

/// A joint and what drives it.
#[derive(Debug, Clone, PartialEq)]
pub struct JointDrive {
    /// Name of the joint.
    pub joint: String,
    /// Its drive.
    pub drive: Drive,
}

/// Which part of a foot stands on the ground.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ContactPart {
    /// The whole sole: six rows (planar: three).
    Flat,
    /// A named edge: five rows (planar: two).
    Edge(String),
    /// A named point: three rows (planar: two).
    Point(String),
}

/// A contact that holds during a phase; written `right_foot`, `right_foot/front` or `right_foot/toe`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contact {
    /// Name of the foot.
    pub foot: String,
    /// Part of it.
    pub part: ContactPart,
}

/// One contact phase and the change to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct Phase {
    /// Name, an identifier.
    pub name: String,
    /// Contacts that hold.
    pub contacts: Vec<Contact>,
    /// The phase that follows.
    pub next: String,
    /// Contacts that hold just after the change (the rows of the impact); empty: the velocity does not jump.
    pub impact: Vec<Contact>,
    /// Left and right swap their roles at the change.
    pub relabel: bool,
}

/// What to generate.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Generate {
    /// Names of functions or groups; empty means everything.
    pub functions: Vec<String>,
    /// Further links and contact points of which functions of frames are generated.
    pub frames: Vec<String>,
    /// Base parameters stay run-time inputs instead of folded constants.
    pub runtime_parameters: bool,
}
