//! The URDF: XML with positions, one tree of links and joints, physically meaningful numbers.
mod attributes;
pub(crate) mod bodies;
mod elements;
mod joints;
mod rewrite;
mod shapes;
mod tree;
mod xml;

use super::model::{Inertial, Joint, Link, Pose, RobotDescription};
use super::source::Messages;
pub(crate) use elements::{JointPlaces, LinkPlaces};
pub(crate) use joints::{Follower, refuse_followers};
pub use rewrite::{JointDynamics, rewritten, with_inertials};
pub(crate) use tree::{Tree, WORLD};

/// A URDF as far as it could be read, with the places of its parts for later messages.
#[derive(Debug, Default)]
pub(crate) struct UrdfRobot {
    pub(crate) name: String,
    pub(crate) links: Vec<Link>,
    pub(crate) joints: Vec<Joint>,
    /// Collision shapes of each link.
    pub(crate) shapes: Vec<Vec<Shape>>,
    /// Whether the shapes are missing because nobody kept them: sizes of bodies then mean nothing.
    pub(crate) shapes_unknown: bool,
    pub(crate) link_places: Vec<LinkPlaces>,
    pub(crate) joint_places: Vec<JointPlaces>,
    /// Joints that move in the URDF and are held by the description; fixed among `joints`.
    pub(crate) locked: Vec<String>,
    /// `None` while anything about the tree is wrong.
    pub(crate) tree: Option<Tree>,
}

/// A collision shape with measures.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    pub(crate) origin: Pose,
    pub(crate) geometry: urdf_rs::Geometry,
}

/// Reads and checks a URDF; `None` if not even its elements could be read.
pub(crate) fn read_urdf(text: &str, messages: &mut Messages<'_>) -> Option<UrdfRobot> {
    let text = xml::prepare(text, messages)?;
    let document = match xml::parse_xml(&text) {
        Ok(document) => document,
        Err(error) => {
            xml::report_broken(&error, messages);
            return None;
        }
    };
    let root = document.root_element();
    if !xml::check_no_xacro(root, messages) {
        return None;
    }
    if root.tag_name().name() != "robot" {
        messages.error(
            Some(root.range().start),
            format!("the file holds <{}>, expected <robot>", super::source::short(root.tag_name().name())),
            "give a URDF; SDF and MJCF files must be converted first",
        );
        return None;
    }
    let elements = elements::read_elements(root, messages)?;
    let mut robot = convert(elements, messages);
    if robot.links.is_empty() {
        messages.error(Some(root.range().start), "the robot has no links", "add <link name=\"…\"> elements");
        return Some(robot);
    }
    robot.tree = tree::check_tree(&mut robot, messages);
    bodies::check_links(&robot, messages);
    Some(robot)
}

impl UrdfRobot {
    /// Joints that move as others do.
    pub(crate) fn followers(&self) -> Vec<Follower> {
        let joints = self.joints.iter().zip(&self.joint_places);
        let moving = joints.filter(|(joint, place)| joint.kind.moves() && place.mimic.is_some());
        moving.map(|(joint, place)| (joint.name.clone(), place.mimic)).collect()
    }

    /// Back from a description, without places and shapes.
    pub(crate) fn from_description(description: &RobotDescription, messages: &mut Messages<'_>) -> Self {
        let joint_places = description.joints.iter().map(|joint| JointPlaces {
            name: joint.name.clone(),
            parent: Some((joint.parent.clone(), None)),
            child: Some((joint.child.clone(), None)),
            ..JointPlaces::default()
        });
        let mut robot = Self {
            name: description.name.clone(),
            links: description.links.clone(),
            joints: description.joints.clone(),
            shapes: vec![Vec::new(); description.links.len()],
            shapes_unknown: true,
            link_places: vec![LinkPlaces::default(); description.links.len()],
            joint_places: joint_places.collect(),
            locked: Vec::new(),
            tree: None,
        };
        robot.tree = tree::check_tree(&mut robot, messages);
        robot
    }
}

fn convert(elements: elements::Elements, messages: &mut Messages<'_>) -> UrdfRobot {
    let mut robot = UrdfRobot { name: elements.robot_name, ..UrdfRobot::default() };
    for (places, link) in elements.links {
        let inertial = places.inertial.map(|_| convert_inertial(&link.inertial));
        robot.links.push(Link { name: places.name.clone(), inertial });
        let shapes = link.collision.into_iter();
        robot.shapes.push(
            shapes.map(|shape| Shape { origin: pose(&shape.origin), geometry: shape.geometry }).collect(),
        );
        robot.link_places.push(places);
    }
    for (places, joint) in elements.joints {
        let joint = joints::convert_joint(&places, &joint, messages);
        robot.joints.push(joint);
        robot.joint_places.push(places);
    }
    robot
}

fn convert_inertial(inertial: &urdf_rs::Inertial) -> Inertial {
    let i = &inertial.inertia;
    Inertial {
        mass: inertial.mass.value,
        origin: pose(&inertial.origin),
        inertia: [i.ixx, i.ixy, i.ixz, i.iyy, i.iyz, i.izz],
    }
}

fn pose(pose: &urdf_rs::Pose) -> Pose {
    Pose { xyz: pose.xyz.0, rpy: pose.rpy.0 }
}
