//! Links and joints as one tree.
use super::UrdfRobot;
use crate::description::geometry::Frame;
use crate::description::model::Link;
use crate::description::source::{Messages, Place, list_names, short, suggest};
use std::collections::{HashMap, HashSet};

/// The link that may be used as a root without being declared.
pub(crate) const WORLD: &str = "world";

/// Who hangs on whom; indices into the lists of links and joints.
#[derive(Debug, Clone)]
pub(crate) struct Tree {
    pub(crate) root: usize,
    /// The joint above each link and the link above that.
    pub(crate) above: Vec<Option<(usize, usize)>>,
    /// The joints below each link, in the order of the file, and their children.
    pub(crate) below: Vec<Vec<(usize, usize)>>,
    /// All links, parents first.
    pub(crate) order: Vec<usize>,
}

impl Tree {
    /// The frames of all links in the root's frame at zero position.
    pub(crate) fn frames(&self, robot: &UrdfRobot) -> Vec<Frame> {
        let mut frames = vec![Frame::IDENTITY; robot.links.len()];
        for &link in &self.order {
            if let Some((joint, parent)) = self.above[link] {
                frames[link] = frames[parent].compose(&Frame::of(&robot.joints[joint].origin));
            }
        }
        frames
    }
}

/// Checks names and connections; adds the undeclared root `world`. `None` if anything is wrong.
pub(super) fn check_tree(robot: &mut UrdfRobot, messages: &mut Messages<'_>) -> Option<Tree> {
    add_world(robot);
    let link_names = robot.links.iter().zip(&robot.link_places).map(|(l, p)| (l.name.as_str(), p.at));
    let unique_links = check_unique(link_names, "link", messages);
    let joint_names = robot.joints.iter().zip(&robot.joint_places).map(|(j, p)| (j.name.as_str(), p.at));
    let unique_joints = check_unique(joint_names, "joint", messages);
    let tree = connect(robot, unique_links, messages)?;
    unique_joints.then_some(tree)
}

fn add_world(robot: &mut UrdfRobot) {
    let declared = robot.links.iter().any(|link| link.name == WORLD);
    let is_parent = robot.joints.iter().any(|joint| joint.parent == WORLD);
    let is_child = robot.joints.iter().any(|joint| joint.child == WORLD);
    if !declared && is_parent && !is_child {
        robot.links.insert(0, Link { name: WORLD.into(), inertial: None });
        robot.shapes.insert(0, Vec::new());
        robot.link_places.insert(0, super::LinkPlaces { name: WORLD.into(), ..Default::default() });
    }
}

fn check_unique<'a>(
    names: impl Iterator<Item = (&'a str, Place)>,
    what: &str,
    messages: &mut Messages<'_>,
) -> bool {
    let mut seen = HashSet::new();
    let mut unique = true;
    for (name, place) in names {
        // Nameless ones were reported when they were read.
        if !name.is_empty() && !seen.insert(name) {
            unique = false;
            let message = format!("the {what} name `{}` is used twice", short(name));
            messages.error(place, message, format!("rename one of the two {what}s"));
        }
    }
    unique
}

/// Resolves the joints' links and looks for the one root.
fn connect(robot: &UrdfRobot, unique_links: bool, messages: &mut Messages<'_>) -> Option<Tree> {
    let count = robot.links.len();
    let index: HashMap<&str, usize> =
        robot.links.iter().enumerate().map(|(i, link)| (link.name.as_str(), i)).collect();
    let mut tree =
        Tree { root: 0, above: vec![None; count], below: vec![Vec::new(); count], order: Vec::new() };
    let mut sound = unique_links;
    for joint in 0..robot.joints.len() {
        let ends = [true, false].map(|parent| resolve(robot, joint, parent, &index, messages));
        let [Some(parent), Some(child)] = ends else {
            sound = false;
            continue;
        };
        if let Some((other, _)) = tree.above[child] {
            sound = false;
            let message = format!(
                "link `{}` is the child of two joints, `{}` and `{}`",
                short(&robot.links[child].name),
                short(&robot.joints[other].name),
                short(&robot.joints[joint].name)
            );
            let help = "closed chains are not supported: cut the loop, each link needs exactly one parent";
            messages.error(robot.joint_places[joint].at, message, help);
            continue;
        }
        tree.above[child] = Some((joint, parent));
        tree.below[parent].push((joint, child));
    }
    // Broken references and names used twice make links look like roots: one message per cause is enough.
    if !sound || !find_root(robot, &mut tree, messages) || !check_reached(robot, &mut tree, messages) {
        return None;
    }
    Some(tree)
}

fn resolve(
    robot: &UrdfRobot,
    joint: usize,
    parent: bool,
    index: &HashMap<&str, usize>,
    messages: &mut Messages<'_>,
) -> Option<usize> {
    let places = &robot.joint_places[joint];
    let end = if parent { "parent" } else { "child" };
    let name = short(&places.name);
    let Some((link, place)) = (if parent { &places.parent } else { &places.child }) else {
        messages.error(
            places.at,
            format!("joint `{name}` has no {end} link"),
            format!("add <{end} link=\"…\"/>"),
        );
        return None;
    };
    let found = index.get(link.as_str()).copied();
    if found.is_none() && !link.is_empty() {
        let names: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
        messages.error(
            *place,
            format!("joint `{name}`: {end} link `{}` does not exist", short(link)),
            suggest(link, names, "links in this file"),
        );
    }
    found
}

fn find_root(robot: &UrdfRobot, tree: &mut Tree, messages: &mut Messages<'_>) -> bool {
    let roots: Vec<usize> = (0..robot.links.len()).filter(|&link| tree.above[link].is_none()).collect();
    match roots[..] {
        [root] => tree.root = root,
        // Without any root there is a cycle, which `check_reached` names.
        [] => tree.root = 0,
        [_, second, ..] => {
            let names = list_names(roots.iter().map(|&root| robot.links[root].name.as_str()));
            messages.error(
                robot.link_places[second].at,
                format!("the links form {} separate trees; their roots are {names}", roots.len()),
                "connect them by joints (fixed ones if nothing moves), or remove the parts that do not belong",
            );
            return false;
        }
    }
    true
}

/// Orders the links, parents first; what the root does not lead to is on or below a cycle.
fn check_reached(robot: &UrdfRobot, tree: &mut Tree, messages: &mut Messages<'_>) -> bool {
    let mut reached = vec![false; robot.links.len()];
    if tree.above[tree.root].is_none() {
        let mut stack = vec![tree.root];
        while let Some(link) = stack.pop() {
            reached[link] = true;
            tree.order.push(link);
            stack.extend(tree.below[link].iter().rev().map(|&(_, child)| child));
        }
    }
    let Some(mut link) = reached.iter().position(|&reached| !reached) else { return true };
    let mut path = vec![link];
    while let Some((_, parent)) = tree.above[link] {
        if let Some(start) = path.iter().position(|&visited| visited == parent) {
            path.drain(..start);
            break;
        }
        path.push(parent);
        link = parent;
    }
    path.reverse();
    let mut names: Vec<String> =
        path.iter().take(8).map(|&link| format!("`{}`", short(&robot.links[link].name))).collect();
    names.push(if path.len() > 8 { "…".into() } else { names[0].clone() });
    let place = tree.above[path[0]].and_then(|(joint, _)| robot.joint_places[joint].at);
    messages.error(
        place,
        format!("the links form a cycle: {}", names.join(" → ")),
        "remove one of its joints; a robot's links must form a tree",
    );
    false
}
