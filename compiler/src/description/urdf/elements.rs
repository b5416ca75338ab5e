//! Reads the elements of a URDF into the types of `urdf-rs`, with their places; everything else is reported.
//!
//! The reader of `urdf-rs` knows no positions and refuses files that every robotics tool loads (a second `<origin>`
//! in the published KUKA LWR, undeclared name spaces), so its types are filled here.
use super::attributes::{check_attributes, find, number, text, vector};
use super::rewrite::JointDynamics;
use super::shapes::read_collisions;
use crate::description::geometry::quaternion_to_rpy;
use crate::description::source::{Messages, Place, short};
use bipedc_effects::magnitude::refusal;
use bipedc_effects::spelling::did_you_mean;
use roxmltree::Node;
use urdf_rs::{Axis, Inertia, Inertial, JointLimit, JointType, LinkName, Mass, Pose, Vec3};

/// What the file says, with places for messages: each link and joint beside its own.
#[derive(Debug, Default)]
pub(super) struct Elements {
    pub(super) robot_name: String,
    pub(super) links: Vec<(LinkPlaces, urdf_rs::Link)>,
    pub(super) joints: Vec<(JointPlaces, urdf_rs::Joint)>,
}

/// Name and places of a link.
#[derive(Debug, Clone, Default)]
pub(crate) struct LinkPlaces {
    pub(crate) name: String,
    pub(crate) at: Place,
    pub(crate) inertial: Place,
    pub(crate) mass: Place,
    pub(crate) inertia: Place,
    /// Whether its inertial could not be read: mass and inertia then mean nothing.
    pub(crate) faulty: bool,
}

/// Names and places of a joint.
#[derive(Debug, Clone, Default)]
pub(crate) struct JointPlaces {
    pub(crate) name: String,
    pub(crate) at: Place,
    pub(crate) kind: String,
    pub(crate) parent: Option<(String, Place)>,
    pub(crate) child: Option<(String, Place)>,
    pub(crate) origin: Place,
    pub(crate) axis: Place,
    pub(crate) limit: Place,
    pub(crate) has_range: bool,
    pub(crate) mimic: Place,
    pub(crate) dynamics_at: Place,
    /// No part of the rigid body: for those who offer it as effects.
    pub(crate) dynamics: JointDynamics,
}

/// Elements that URDF and its usual extensions have directly in `<robot>`.
const IN_ROBOT: &[&str] = &["link", "joint", "material", "transmission", "gazebo", "sensor"];
const IN_LINK: &[&str] = &["inertial", "visual", "collision"];
const IN_INERTIAL: &[&str] = &["origin", "mass", "inertia"];
const IN_JOINT: &[&str] =
    &["origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller"];

/// Links and joints beyond this number are refused: no robot has them, and every later stage stays bounded.
const COUNT_LIMIT: usize = 10_000;

/// Reads all links and joints below `<robot>`.
pub(super) fn read_elements(robot: Node<'_, '_>, messages: &mut Messages<'_>) -> Option<Elements> {
    let robot_name = robot.attribute("name").unwrap_or_default().trim().to_string();
    let mut elements = Elements { robot_name, ..Elements::default() };
    let own_children = robot.children().filter(|node| node.is_element());
    if own_children.clone().filter(|node| ["link", "joint"].contains(&node.tag_name().name())).count()
        > COUNT_LIMIT
    {
        messages.error(
            Some(robot.range().start),
            format!("more than {COUNT_LIMIT} links and joints"),
            "is this one robot?",
        );
        return None;
    }
    for node in own_children {
        // Joints of a <transmission> and of extensions in other name spaces are not joints of the robot.
        if node.tag_name().namespace() != robot.tag_name().namespace() {
            continue;
        }
        match node.tag_name().name() {
            "link" => read_link(node, &mut elements, messages),
            "joint" => read_joint(node, &mut elements, messages),
            name if IN_ROBOT.contains(&name) => {}
            name => report_misspelt(node, name, IN_ROBOT, messages),
        }
    }
    Some(elements)
}

fn report_misspelt(node: Node<'_, '_>, name: &str, known: &'static [&'static str], messages: &mut Messages) {
    if let Some(meant) = did_you_mean(name, known.iter().copied()) {
        messages.warning(
            Some(node.range().start),
            format!("<{}> is not an element of <{}>; it is ignored", short(name), parent_name(node)),
            format!("did you mean <{meant}>?"),
        );
    }
}

fn parent_name<'a>(node: Node<'a, '_>) -> &'a str {
    node.parent_element().map_or("robot", |parent| parent.tag_name().name())
}

/// The first child of each known name; others are reported when misspelt, repetitions always.
fn children<'a, 'i>(
    node: Node<'a, 'i>,
    owner: &str,
    known: &'static [&'static str],
    messages: &mut Messages<'_>,
) -> Vec<Node<'a, 'i>> {
    let mut result: Vec<Node<'a, 'i>> = Vec::new();
    for child in node.children().filter(Node::is_element) {
        let name = child.tag_name().name();
        if child.tag_name().namespace() != node.tag_name().namespace() {
            continue;
        }
        if !known.contains(&name) {
            report_misspelt(child, name, known, messages);
        } else if ["visual", "collision"].contains(&name)
            || !result.iter().any(|other| other.tag_name().name() == name)
        {
            result.push(child);
        } else {
            messages.warning(
                Some(child.range().start),
                format!("{owner} has a second <{name}>; the first one counts"),
                "remove one of the two",
            );
        }
    }
    result
}

/// A name that can stand in messages, generated code and logs; reports why not.
fn read_name(node: Node<'_, '_>, what: &str, messages: &mut Messages<'_>) -> String {
    let name = node.attribute("name").unwrap_or_default().trim();
    if name.is_empty() {
        messages.error(
            Some(node.range().start),
            format!("a {what} without a name"),
            format!("write <{what} name=\"…\">"),
        );
    } else if name.chars().any(char::is_control) {
        messages.error(
            Some(node.range().start),
            format!("the name of {what} `{}` holds a control character", short(name)),
            "use letters, digits and `_`",
        );
    }
    name.to_string()
}

fn read_link(node: Node<'_, '_>, elements: &mut Elements, messages: &mut Messages<'_>) {
    let name = read_name(node, "link", messages);
    check_attributes(node, &["name", "type"], messages);
    let owner = format!("link `{}`", short(&name));
    let mut places = LinkPlaces { name: name.clone(), at: Some(node.range().start), ..LinkPlaces::default() };
    let children = children(node, &owner, IN_LINK, messages);
    let mut inertial = Inertial::default();
    if let Some(element) = find(&children, "inertial") {
        let errors = messages.errors();
        inertial = read_inertial(element, &owner, &mut places, messages);
        places.faulty = messages.errors() > errors;
    }
    let collision = read_collisions(&children, &owner, messages);
    elements.links.push((places, urdf_rs::Link { name, inertial, visual: Vec::new(), collision }));
}

fn read_inertial(
    node: Node<'_, '_>,
    owner: &str,
    places: &mut LinkPlaces,
    messages: &mut Messages<'_>,
) -> Inertial {
    let children = children(node, owner, IN_INERTIAL, messages);
    places.inertial = Some(node.range().start);
    let mass = find(&children, "mass");
    let inertia = find(&children, "inertia");
    places.mass = mass.map(|node| node.range().start);
    places.inertia = inertia.map(|node| node.range().start);
    let origin = read_origin(find(&children, "origin"), owner, messages);
    let value = mass.and_then(|node| {
        check_attributes(node, &["value"], messages);
        number(node, "value", owner, messages)
    });
    if value.is_none() && mass.is_none_or(|node| node.attribute("value").is_none()) {
        messages.warning(
            places.inertial,
            format!("{owner}: <inertial> without <mass value=\"…\"/> counts as massless"),
            "write <mass value=\"…\"/> in kg",
        );
    }
    let inertia = read_inertia(inertia, owner, places.inertial, messages);
    Inertial { origin, mass: Mass { value: value.unwrap_or(0.0) }, inertia }
}

fn read_inertia(
    node: Option<Node<'_, '_>>,
    owner: &str,
    inertial: Place,
    messages: &mut Messages<'_>,
) -> Inertia {
    const NAMES: [&str; 6] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
    let missing: Vec<&str> =
        NAMES.into_iter().filter(|name| node.and_then(|node| node.attribute(*name)).is_none()).collect();
    if !missing.is_empty() {
        messages.warning(
            node.map_or(inertial, |node| Some(node.range().start)),
            format!("{owner}: the inertia lacks {}; what is missing counts as zero", missing.join(", ")),
            "write all six of ixx, ixy, ixz, iyy, iyz, izz in kg m²",
        );
    }
    if let Some(node) = node {
        check_attributes(node, &NAMES, messages);
    }
    let [ixx, ixy, ixz, iyy, iyz, izz] =
        NAMES.map(|name| node.and_then(|node| number(node, name, owner, messages)).unwrap_or(0.0));
    Inertia { ixx, ixy, ixz, iyy, iyz, izz }
}

/// Reads an `<origin>`; what is missing is zero, as everywhere in URDF.
pub(super) fn read_origin(node: Option<Node<'_, '_>>, owner: &str, messages: &mut Messages<'_>) -> Pose {
    let Some(node) = node else { return Pose::default() };
    check_attributes(node, &["xyz", "rpy", "quat_xyzw"], messages);
    let xyz = vector(node, "xyz", owner, messages).unwrap_or_default();
    let rpy = if node.has_attribute("rpy") {
        vector(node, "rpy", owner, messages)
    } else {
        vector(node, "quat_xyzw", owner, messages).and_then(|quaternion| {
            let rpy = quaternion_to_rpy(quaternion);
            if rpy.is_none() {
                messages.error(
                    Some(node.range().start),
                    format!("{owner}: origin/quat_xyzw is zero, which is no rotation"),
                    "write a unit quaternion x y z w, such as 0 0 0 1",
                );
            }
            rpy
        })
    };
    Pose { xyz: Vec3(xyz), rpy: Vec3(rpy.unwrap_or_default()) }
}

fn read_joint(node: Node<'_, '_>, elements: &mut Elements, messages: &mut Messages<'_>) {
    let name = read_name(node, "joint", messages);
    check_attributes(node, &["name", "type"], messages);
    let owner = format!("joint `{}`", short(&name));
    let children = children(node, &owner, IN_JOINT, messages);
    let place = |name| find(&children, name).map(|node| node.range().start);
    let mut link_of = |element: &str| {
        let node = find(&children, element)?;
        check_attributes(node, &["link"], messages);
        // A missing name was reported here; the empty one stands for it.
        let name = text(node, "link", &owner, messages).unwrap_or_default();
        Some((name.to_string(), Some(node.range().start)))
    };
    let (parent, child) = (link_of("parent"), link_of("child"));
    let typed = typed_joint(&name, &children, &owner, messages);
    let limit = find(&children, "limit");
    let places = JointPlaces {
        at: Some(node.range().start),
        kind: node.attribute("type").unwrap_or_default().trim().to_string(),
        parent,
        child,
        origin: place("origin"),
        axis: place("axis"),
        limit: place("limit"),
        has_range: limit.is_some_and(|node| node.has_attribute("lower") || node.has_attribute("upper")),
        mimic: place("mimic"),
        dynamics_at: place("dynamics"),
        dynamics: stated_dynamics(find(&children, "dynamics")),
        name,
    };
    elements.joints.push((places, typed));
}

/// Damping and friction as far as they are positive numbers: nothing depends on them, so nothing is said about others.
fn stated_dynamics(node: Option<Node<'_, '_>>) -> JointDynamics {
    let stated = |name: &str| {
        let value: f64 = node?.attribute(name)?.trim().parse().ok()?;
        (value > 0.0 && refusal(value).is_none()).then_some(value)
    };
    JointDynamics { damping: stated("damping"), friction: stated("friction") }
}

/// Origin, axis and limits. Kind and links are decided from the places, where "prismatik" can be reported.
fn typed_joint(
    name: &str,
    children: &[Node<'_, '_>],
    owner: &str,
    messages: &mut Messages<'_>,
) -> urdf_rs::Joint {
    let origin = read_origin(find(children, "origin"), owner, messages);
    let mut axis = Axis::default();
    if let Some(element) = find(children, "axis") {
        check_attributes(element, &["xyz"], messages);
        axis.xyz = vector(element, "xyz", owner, messages).map_or(axis.xyz, Vec3);
    }
    let mut limit = JointLimit::default();
    if let Some(element) = find(children, "limit") {
        const KNOWN: [&str; 7] =
            ["lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"];
        check_attributes(element, &KNOWN, messages);
        let mut of = |name| number(element, name, owner, messages).unwrap_or(0.0);
        limit = JointLimit {
            lower: of("lower"),
            upper: of("upper"),
            effort: of("effort"),
            velocity: of("velocity"),
            ..limit
        };
    }
    urdf_rs::Joint {
        name: name.to_string(),
        joint_type: JointType::Continuous,
        origin,
        parent: LinkName::default(),
        child: LinkName::default(),
        axis,
        limit,
        calibration: None,
        dynamics: None,
        mimic: None,
        safety_controller: None,
    }
}
