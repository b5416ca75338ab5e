//! Feet, their contact points and the edges about which they can tip.
use super::table::{Entry, Section};
use super::{Known, check_identifier};
use crate::description::geometry::{Frame, Vector};
use crate::description::model::{ContactPoint, Foot, FootEdge, Side};
use crate::description::source::{Messages, Place, short, suggest};

pub(super) fn read_feet(top: &Section<'_, '_>, known: Known<'_>, messages: &mut Messages<'_>) -> Vec<Foot> {
    let Some(section) = top.section("feet", messages) else { return Vec::new() };
    let mut feet = Vec::new();
    for entry in section.entries() {
        let title = format!("[feet.{}]", short(entry.key));
        if let Some(section) = entry.section(title, messages) {
            feet.push(read_foot(&entry, &section, known, messages));
        }
    }
    feet
}

fn read_foot(
    entry: &Entry<'_, '_>,
    section: &Section<'_, '_>,
    known: Known<'_>,
    messages: &mut Messages<'_>,
) -> Foot {
    section.check_keys(&["link", "side", "points", "edges"], messages);
    let name = entry.key.to_string();
    check_identifier(&name, "foot", section.at, messages);
    let (link, place) = section.string("link", messages).unwrap_or_else(|| (name.clone(), section.at));
    known.check_link(&link, place, &section.title, messages);
    let side = read_side(section, &name, messages);
    let points =
        section.get("points").map(|entry| read_points(&entry, section, messages)).unwrap_or_default();
    if points.is_empty() {
        messages.error(
            section.at,
            format!("{} has no contact points", section.title),
            format!("add [feet.{}.points] with lines such as `toe = [0.15, 0.0, -0.05]`", short(&name)),
        );
    }
    let edges = match section.get("edges") {
        Some(entry) => read_edges(&entry, section, &points, messages),
        None => derive_edges(&points, &link_frame(known, &link)),
    };
    Foot { name, link, side, points, edges }
}

fn read_side(section: &Section<'_, '_>, foot: &str, messages: &mut Messages<'_>) -> Option<Side> {
    let Some((side, at)) = section.string("side", messages) else {
        return if section.has("side") { None } else { side_of_name(foot) };
    };
    match side.as_str() {
        "left" => return Some(Side::Left),
        "right" => return Some(Side::Right),
        _ => {}
    }
    let message =
        format!("`side` in {}: expected \"left\" or \"right\", found \"{}\"", section.title, short(&side));
    messages.error(at, message, suggest(&side, ["left", "right"], "sides"));
    None
}

/// Words for the left and the right side. Quadrupeds say front/rear/hind and left/right in two letters, in either order.
pub(crate) const SIDES: [(&str, &str); 14] = [
    ("left", "right"),
    ("l", "r"),
    ("lt", "rt"),
    ("lft", "rgt"),
    ("fl", "fr"),
    ("rl", "rr"),
    ("hl", "hr"),
    ("lf", "rf"),
    ("lh", "rh"),
    ("port", "starboard"),
    ("li", "re"),
    ("links", "rechts"),
    ("gauche", "droite"),
    ("sx", "dx"),
];

/// The side that a name tells: `left_foot`, `l_sole`, `foot_r`, `LFoot`, `LeftAnkle`.
pub(crate) fn side_of_name(name: &str) -> Option<Side> {
    let lower = name.to_ascii_lowercase();
    let words: Vec<&str> = lower.split(|c: char| !c.is_ascii_alphanumeric()).collect();
    let camel = |letter: char| {
        let mut letters = name.chars();
        letters.next() == Some(letter)
            && letters.next().is_some_and(|c| c.is_ascii_uppercase())
            && letters.next().is_some_and(|c| c.is_ascii_lowercase())
    };
    let any = |side: fn(&(&'static str, &'static str)) -> &'static str| {
        SIDES.iter().any(|pair| words.contains(&side(pair)))
    };
    let told = |left: bool, right: bool| match (left, right) {
        (true, false) => Some(Side::Left),
        (false, true) => Some(Side::Right),
        _ => None,
    };
    // Whole words count more than short ones, which may mean something else (`left_re_hip`: rear).
    told(lower.contains("left"), lower.contains("right"))
        .or_else(|| told(any(|pair| pair.0) || camel('L'), any(|pair| pair.1) || camel('R')))
}

fn read_points(
    entry: &Entry<'_, '_>,
    foot: &Section<'_, '_>,
    messages: &mut Messages<'_>,
) -> Vec<ContactPoint> {
    let title = foot.title.replace(']', ".points]");
    let Some(section) = entry.section(title, messages) else { return Vec::new() };
    let mut points: Vec<ContactPoint> = Vec::new();
    for entry in section.entries() {
        check_identifier(entry.key, "point", entry.at, messages);
        let Some(position) = entry.vector(messages) else { continue };
        if let Some(other) = points.iter().find(|point| point.position == position) {
            let message = format!("{} lies on the point `{}`", entry.name(), short(&other.name));
            messages.error(entry.at, message, "give each point a position of its own");
        }
        points.push(ContactPoint { name: entry.key.to_string(), position });
    }
    points
}

fn read_edges(
    entry: &Entry<'_, '_>,
    foot: &Section<'_, '_>,
    points: &[ContactPoint],
    messages: &mut Messages<'_>,
) -> Vec<FootEdge> {
    let title = foot.title.replace(']', ".edges]");
    let Some(section) = entry.section(title, messages) else { return Vec::new() };
    section.entries().iter().filter_map(|entry| read_edge(entry, points, messages)).collect()
}

fn read_edge(
    entry: &Entry<'_, '_>,
    points: &[ContactPoint],
    messages: &mut Messages<'_>,
) -> Option<FootEdge> {
    check_identifier(entry.key, "edge", entry.at, messages);
    if points.iter().any(|point| point.name == entry.key) {
        let message = format!("{} has the name of a point", entry.name());
        let help = "contacts are written foot/part: points and edges need different names";
        messages.error(entry.at, message, help);
    }
    let names = entry.strings(messages)?;
    let [(first, _), (second, _)] = &names[..] else {
        let message = format!("{}: expected two points, found {}", entry.name(), names.len());
        let help = "write the left point first: [\"front_left\", \"front_right\"]";
        messages.error(entry.at, message, help);
        return None;
    };
    if first == second {
        let message = format!("{}: both ends are `{}`", entry.name(), short(first));
        messages.error(entry.at, message, "name two points");
    }
    for (name, at) in &names {
        check_point(name, *at, entry, points, messages);
    }
    Some(FootEdge { name: entry.key.to_string(), points: [first.clone(), second.clone()] })
}

fn check_point(
    name: &str,
    at: Place,
    edge: &Entry<'_, '_>,
    points: &[ContactPoint],
    messages: &mut Messages<'_>,
) {
    if points.iter().all(|point| point.name != name) {
        let names: Vec<&str> = points.iter().map(|point| point.name.as_str()).collect();
        let message = format!("{}: the foot has no point `{}`", edge.name(), short(name));
        messages.error(at, message, suggest(name, names, "points of this foot"));
    }
}

fn link_frame(known: Known<'_>, link: &str) -> Frame {
    let frame = || {
        let robot = known.robot?;
        let index = robot.links.iter().position(|other| other.name == link)?;
        Some(robot.tree.as_ref()?.frames(robot)[index])
    };
    frame().unwrap_or(Frame::IDENTITY)
}

/// The four edges of a foot with four corners, told apart by where the corners are at zero posture.
fn derive_edges(points: &[ContactPoint], frame: &Frame) -> Vec<FootEdge> {
    let corners: Vec<(&str, Vector)> =
        points.iter().map(|point| (point.name.as_str(), frame.direction(point.position))).collect();
    if corners.len() != 4 {
        return Vec::new();
    }
    // The two corners furthest along an axis, the one further along the other axis first.
    let pair = |along: usize, sign: f64, first: usize| {
        let mut sorted = corners.clone();
        sorted.sort_by(|a, b| (sign * b.1[along]).total_cmp(&(sign * a.1[along])));
        let (mut a, mut b) = (sorted[0], sorted[1]);
        if a.1[first] < b.1[first] {
            std::mem::swap(&mut a, &mut b);
        }
        [a.0.to_string(), b.0.to_string()]
    };
    let (front, rear) = (pair(0, 1.0, 1), pair(0, -1.0, 1));
    let (left, right) = (pair(1, 1.0, 0), pair(1, -1.0, 0));
    // Corners that do not form a quadrangle seen from above have no such edges.
    let meets = |edge: &[String; 2], a: &String, b: &String| edge[0] == *a && edge[1] == *b;
    if !meets(&left, &front[0], &rear[0]) || !meets(&right, &front[1], &rear[1]) {
        return Vec::new();
    }
    let named = [("front", front), ("rear", rear), ("left", left), ("right", right)];
    let free = named.into_iter().filter(|(name, _)| points.iter().all(|point| point.name != *name));
    free.map(|(name, points)| FootEdge { name: name.into(), points }).collect()
}
