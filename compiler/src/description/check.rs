//! What `bipedc check` prints: the tree, masses, centre of mass, and what is physically odd.
use super::geometry::{Frame, Moments, Vector};
use super::model::{Base, JointKind, RobotDescription};
use super::source::Messages;
use super::urdf::bodies::{bodies, body_name, oddities};
use super::urdf::{Tree, UrdfRobot};
use serde::Serialize;
use std::fmt;
use std::path::Path;

/// Deeper links are not indented further: a chain of thousands of links would print megabytes of blanks.
const DEEPEST_INDENT: usize = 40;

/// An overview of a robot at zero posture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckReport {
    /// Name of the robot.
    pub robot: String,
    /// How it hangs in the world, in words.
    pub base: String,
    /// Joints that move.
    pub moving_joints: usize,
    /// All links, parents first, depth first.
    pub links: Vec<LinkReport>,
    /// kg
    pub total_mass: f64,
    /// Centre of mass of the whole robot in the frame of the base link at zero posture, m.
    pub center_of_mass: [f64; 3],
    /// Its height above `height_above`, m.
    pub center_of_mass_height: f64,
    /// What the height is measured from: the lowest contact point, or the base link where there is none.
    pub height_above: String,
    /// Whatever no real robot has, in sentences; empty is good.
    pub inconsistencies: Vec<String>,
}

/// One link of the tree.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LinkReport {
    /// Name of the link.
    pub name: String,
    /// 0 for the root.
    pub depth: usize,
    /// The joint above it.
    pub joint: Option<String>,
    /// Kind of that joint and its axis in words: `revolute y`, `fixed`.
    pub motion: String,
    /// kg; `None` where the URDF has no inertial.
    pub mass: Option<f64>,
}

/// An overview of a description that was read without errors; of its bodies as the links state them. With the effects on
/// them: of [`as_built`](crate::tree::as_built).
pub fn check_report(robot: &RobotDescription) -> CheckReport {
    // The description was checked when it was read: these messages stay empty.
    let mut messages = Messages::new("", Path::new(""));
    let urdf = UrdfRobot::from_description(robot, &mut messages);
    let tree = urdf.tree.as_ref();
    let frames =
        tree.map_or_else(|| vec![Frame::IDENTITY; urdf.links.len()], |tree| base_frames(robot, &urdf, tree));
    let sum =
        urdf.links.iter().zip(&frames).filter_map(|(link, frame)| Some(Moments::of(&link.inertial?, frame)));
    let sum = sum.fold(Moments::ZERO, |sum, moments| sum.add(&moments));
    let (ground, height_above) = ground(robot, &frames);
    CheckReport {
        robot: robot.name.clone(),
        base: base_in_words(&robot.base),
        moving_joints: robot.joints.iter().filter(|joint| joint.kind.moves()).count(),
        links: tree.map_or_else(Vec::new, |tree| link_reports(&urdf, tree)),
        total_mass: sum.mass,
        center_of_mass: sum.center_of_mass(),
        center_of_mass_height: sum.center_of_mass()[2] - ground,
        height_above,
        inconsistencies: tree.map_or_else(Vec::new, |tree| inconsistencies(&urdf, tree)),
    }
}

/// Frames of all links in the frame of the base link at zero posture.
fn base_frames(robot: &RobotDescription, urdf: &UrdfRobot, tree: &Tree) -> Vec<Frame> {
    let frames = tree.frames(urdf);
    let name = match &robot.base {
        Base::Floating { root } | Base::Planar { root } => root,
        Base::Fixed { link } => link,
        Base::Pivot { about } => about,
    };
    let by_foot = || {
        let foot = name.split_once('/').map(|(foot, _)| foot)?;
        Some(robot.feet.iter().find(|other| other.name == foot)?.link.as_str())
    };
    let link = urdf.links.iter().position(|link| link.name == *name).or_else(|| {
        let link = by_foot()?;
        urdf.links.iter().position(|other| other.name == link)
    });
    let to_base = link.map_or(Frame::IDENTITY, |link| frames[link].inverse());
    frames.iter().map(|frame| to_base.compose(frame)).collect()
}

/// Height of the lowest contact point, and what that is called.
fn ground(robot: &RobotDescription, frames: &[Frame]) -> (f64, String) {
    let mut lowest: Option<(f64, String)> = None;
    for foot in &robot.feet {
        let Some(link) = robot.links.iter().position(|link| link.name == foot.link) else { continue };
        for point in &foot.points {
            let height = frames[link].point(point.position)[2];
            if lowest.as_ref().is_none_or(|(other, _)| height < *other) {
                lowest = Some((height, format!("contact point {}/{}", foot.name, point.name)));
            }
        }
    }
    lowest.unwrap_or_else(|| (0.0, "the origin of the base link".into()))
}

fn base_in_words(base: &Base) -> String {
    match base {
        Base::Floating { root } => format!("floating at `{root}`"),
        Base::Planar { root } => format!("planar at `{root}`"),
        Base::Fixed { link } => format!("fixed at `{link}`"),
        Base::Pivot { about } => format!("pivot about `{about}`"),
    }
}

fn link_reports(urdf: &UrdfRobot, tree: &Tree) -> Vec<LinkReport> {
    let mut depths = vec![0; urdf.links.len()];
    let report = |&link: &usize| {
        let above = tree.above[link];
        if let Some((_, parent)) = above {
            depths[link] = depths[parent] + 1;
        }
        let joint = above.map(|(joint, _)| &urdf.joints[joint]);
        LinkReport {
            name: urdf.links[link].name.clone(),
            depth: depths[link],
            joint: joint.map(|joint| joint.name.clone()),
            motion: joint.map_or_else(String::new, |joint| motion(joint.kind, joint.axis)),
            mass: urdf.links[link].inertial.map(|inertial| inertial.mass),
        }
    };
    tree.order.iter().map(report).collect()
}

fn motion(kind: JointKind, axis: Vector) -> String {
    let name = match kind {
        JointKind::Revolute => "revolute",
        JointKind::Continuous => "continuous",
        JointKind::Prismatic => "prismatic",
        JointKind::Fixed => return "fixed".into(),
    };
    let letter = ["x", "y", "z"].into_iter().zip(axis).find(|(_, component)| component.abs() == 1.0);
    match letter {
        Some((letter, component)) => format!("{name} {}{letter}", if component < 0.0 { "-" } else { "" }),
        None => format!("{name} [{:.4}, {:.4}, {:.4}]", axis[0], axis[1], axis[2]),
    }
}

fn inconsistencies(urdf: &UrdfRobot, tree: &Tree) -> Vec<String> {
    let bodies = bodies(urdf, tree);
    let total = bodies.iter().map(|body| body.moments.mass).sum();
    // Massless bodies that carry others are harmless, and those that do not were refused.
    let massive = bodies.iter().filter(|body| body.moments.mass > 0.0);
    massive
        .flat_map(|body| oddities(body, &body_name(urdf, body), total))
        .map(|(sentence, _)| sentence)
        .collect()
}

impl fmt::Display for CheckReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (links, moving) = (self.links.len(), self.moving_joints);
        writeln!(f, "robot `{}`: {links} links, {moving} moving joints, base {}", self.robot, self.base)?;
        writeln!(f)?;
        for link in &self.links {
            let indent = "  ".repeat(link.depth.min(DEEPEST_INDENT));
            write!(f, "{indent}{}", link.name)?;
            if let Some(mass) = link.mass {
                write!(f, "  {mass} kg")?;
            }
            match &link.joint {
                Some(joint) => writeln!(f, "  ({joint}: {})", link.motion)?,
                None => writeln!(f)?,
            }
        }
        let [x, y, z] = self.center_of_mass;
        writeln!(f)?;
        writeln!(f, "total mass {:.6} kg", self.total_mass)?;
        writeln!(f, "centre of mass {x:.6}, {y:.6}, {z:.6} m in the base link, zero posture")?;
        writeln!(f, "height {:.6} m above {}", self.center_of_mass_height, self.height_above)?;
        if self.inconsistencies.is_empty() {
            return writeln!(f, "physically consistent");
        }
        writeln!(f, "physically inconsistent:")?;
        self.inconsistencies.iter().try_for_each(|sentence| writeln!(f, "  {sentence}"))
    }
}
