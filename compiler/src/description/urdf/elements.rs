//! Reads the elements of a URDF: what is understood goes on in a normalised text, everything else is reported.
//!
//! The normalised text holds only what we need and only what was checked, so that the typed URDF crate, which
//! knows no positions, cannot fail on it or take it differently.
use super::attributes::{check_attributes, find, number, text, vector};
use super::shapes::write_collisions;
use crate::description::source::{Messages, Place, short};
use bipedc_effects::spelling::did_you_mean;
use roxmltree::Node;
use std::fmt::Write as _;

/// What the file says, as text for the typed crate and as places for messages.
#[derive(Debug, Default)]
pub(super) struct Elements {
    pub(super) robot_name: String,
    pub(super) links: Vec<LinkPlaces>,
    pub(super) joints: Vec<JointPlaces>,
    /// A URDF in which links and joints are called by their number: names may hold anything XML allows.
    pub(super) normalised: String,
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
    elements.normalised.push_str("<robot name=\"robot\" version=\"1.1\">\n");
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
    elements.normalised.push_str("</robot>\n");
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
    let mut places = LinkPlaces { name, at: Some(node.range().start), ..LinkPlaces::default() };
    let _ = write!(elements.normalised, "<link name=\"{}\">", elements.links.len());
    let children = children(node, &owner, IN_LINK, messages);
    if let Some(inertial) = find(&children, "inertial") {
        let errors = messages.errors();
        read_inertial(inertial, &owner, &mut places, &mut elements.normalised, messages);
        places.faulty = messages.errors() > errors;
    }
    write_collisions(&children, &owner, &mut elements.normalised, messages);
    elements.normalised.push_str("</link>\n");
    elements.links.push(places);
}

fn read_inertial(
    node: Node<'_, '_>,
    owner: &str,
    places: &mut LinkPlaces,
    out: &mut String,
    messages: &mut Messages<'_>,
) {
    let children = children(node, owner, IN_INERTIAL, messages);
    places.inertial = Some(node.range().start);
    let mass = find(&children, "mass");
    let inertia = find(&children, "inertia");
    places.mass = mass.map(|node| node.range().start);
    places.inertia = inertia.map(|node| node.range().start);
    out.push_str("<inertial>");
    write_origin(find(&children, "origin"), owner, out, messages);
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
    let _ = write!(out, "<mass value=\"{}\"/>", value.unwrap_or("0"));
    write_inertia(inertia, owner, places.inertial, out, messages);
    out.push_str("</inertial>");
}

fn write_inertia(
    node: Option<Node<'_, '_>>,
    owner: &str,
    inertial: Place,
    out: &mut String,
    messages: &mut Messages<'_>,
) {
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
    out.push_str("<inertia");
    for name in NAMES {
        let value = node.and_then(|node| number(node, name, owner, messages));
        let _ = write!(out, " {name}=\"{}\"", value.unwrap_or("0"));
    }
    out.push_str("/>");
}

/// Writes an `<origin>`; what is missing is zero, as everywhere in URDF.
pub(super) fn write_origin(
    node: Option<Node<'_, '_>>,
    owner: &str,
    out: &mut String,
    messages: &mut Messages<'_>,
) {
    let Some(node) = node else {
        out.push_str("<origin xyz=\"0 0 0\" rpy=\"0 0 0\"/>");
        return;
    };
    check_attributes(node, &["xyz", "rpy", "quat_xyzw"], messages);
    let xyz = vector(node, "xyz", 3, owner, messages).unwrap_or("0 0 0");
    let _ = write!(out, "<origin xyz=\"{xyz}\"");
    let _ = match (node.attribute("rpy"), vector(node, "quat_xyzw", 4, owner, messages)) {
        (None, Some(quaternion)) => write!(out, " quat_xyzw=\"{quaternion}\"/>"),
        _ => write!(out, " rpy=\"{}\"/>", vector(node, "rpy", 3, owner, messages).unwrap_or("0 0 0")),
    };
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
        name,
    };
    write_joint(&children, &owner, elements, messages);
    elements.joints.push(places);
}

fn write_joint(children: &[Node<'_, '_>], owner: &str, elements: &mut Elements, messages: &mut Messages<'_>) {
    let out = &mut elements.normalised;
    // The kind is decided from the places, where "prismatik" can be reported; here any will do.
    let _ = write!(out, "<joint name=\"{}\" type=\"continuous\">", elements.joints.len());
    write_origin(find(children, "origin"), owner, out, messages);
    out.push_str("<parent link=\"p\"/><child link=\"c\"/>");
    if let Some(axis) = find(children, "axis") {
        check_attributes(axis, &["xyz"], messages);
        let xyz = vector(axis, "xyz", 3, owner, messages).unwrap_or("1 0 0");
        let _ = write!(out, "<axis xyz=\"{xyz}\"/>");
    }
    if let Some(limit) = find(children, "limit") {
        const KNOWN: [&str; 7] =
            ["lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"];
        check_attributes(limit, &KNOWN, messages);
        out.push_str("<limit");
        for name in &KNOWN[..4] {
            let value = number(limit, name, owner, messages);
            let _ = write!(out, " {name}=\"{}\"", value.unwrap_or("0"));
        }
        out.push_str("/>");
    }
    out.push_str("</joint>\n");
}
