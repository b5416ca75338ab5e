//! Left and right joints: paired by name, else by place, with the sign from their axes.
use super::quoted;
use crate::description::geometry::{Frame, norm, subtract};
use crate::description::model::Side;
use crate::description::settings::{SIDES, mirror_sign, side_of_name};
use crate::description::urdf::{Tree, UrdfRobot};
use std::collections::HashMap;
use std::fmt::Write as _;

/// Joints further than this from the mirror image of their partner are remarked on, m.
const ORIGIN_TOLERANCE: f64 = 1e-3;

/// Writes the pairs; returns the names of the joints that have a partner. Where all joints pitch (`planar`), those whose names tell nothing are paired by
/// where they are.
pub(super) fn write_symmetry(
    (robot, tree, frames): (&UrdfRobot, &Tree, &[Frame]),
    planar: bool,
    out: &mut String,
) -> Vec<String> {
    let moving: HashMap<&str, usize> = tree
        .below
        .iter()
        .flatten()
        .filter(|(joint, _)| robot.joints[*joint].kind.moves())
        .map(|&(joint, child)| (robot.joints[joint].name.as_str(), child))
        .collect();
    let mut lines = String::new();
    let mut paired = Vec::new();
    for joint in robot.joints.iter().filter(|joint| side_of_name(&joint.name) == Some(Side::Left)) {
        let left = joint.name.as_str();
        let partner = mirrored_names(left).into_iter().find(|name| moving.contains_key(name.as_str()));
        let (Some(&left_link), Some(right)) = (moving.get(left), partner) else { continue };
        let (a, b) = (frames[left_link].position, frames[moving[right.as_str()]].position);
        let pair = format!("{{ left = {}, right = {}", quoted(left), quoted(&right));
        let sign = mirror_sign(robot, frames, left, &right);
        let _ = match sign {
            Some(sign) if norm(subtract(b, [a[0], -a[1], a[2]])) < ORIGIN_TOLERANCE => {
                writeln!(lines, "  {pair}, sign = {sign} }},")
            }
            Some(sign) => {
                writeln!(lines, "  {pair}, sign = {sign} }}, # the joints' places are not mirror images")
            }
            None => writeln!(lines, "  # {pair} }}: the axes are not mirror images"),
        };
        if sign.is_some() {
            paired.extend([left.to_owned(), right]);
        }
    }
    if planar {
        by_place((robot, tree, frames), &mut paired, &mut lines);
    }
    if lines.is_empty() {
        out.push_str("\n# No joints with left and right names were found.\n");
    } else {
        out.push_str("\n# Joints that mirror each other. sign = 1: equal angles (pitch), -1: opposite ones (roll, yaw).\n");
        let _ = write!(out, "[symmetry]\njoints = [\n{lines}]\n");
    }
    paired
}

/// Pairs of joints without names of sides: on one link or on two that are paired already, at places that mirror each other, with equal masses behind
/// them, and no third one like them. The left one is that of the larger y; in one plane the first.
fn by_place(
    (robot, tree, frames): (&UrdfRobot, &Tree, &[Frame]),
    paired: &mut Vec<String>,
    lines: &mut String,
) {
    let mut partner: HashMap<usize, (usize, bool)> = HashMap::new();
    let moving: Vec<(usize, usize)> = tree
        .order
        .iter()
        .filter_map(|&link| Some((tree.above[link]?.0, link)))
        .filter(|&(joint, _)| robot.joints[joint].kind.moves())
        .collect();
    // What names have paired may carry joints whose names tell nothing.
    for pair in paired.chunks_exact(2) {
        let link = |name: &str| {
            moving.iter().find(|(joint, _)| robot.joints[*joint].name == name).map(|found| found.1)
        };
        if let (Some(left), Some(right)) = (link(&pair[0]), link(&pair[1])) {
            partner.extend([(left, (right, true)), (right, (left, false))]);
        }
    }
    let mass = |link: usize| robot.links[link].inertial.map_or(0.0, |inertial| inertial.mass);
    let above = |link: usize| tree.above[link].map(|(_, parent)| parent);
    let alike = |(j, a): (usize, usize), (k, b): (usize, usize), partner: &HashMap<usize, (usize, bool)>| {
        let [p, q] = [a, b].map(|link| frames[link].position);
        let apart = [[p[0], -p[1], p[2]], p].map(|place| norm(subtract(q, place)));
        let parents = (above(a), above(b));
        let legs = parents.0 == parents.1
            || parents.0.and_then(|a| partner.get(&a)).map(|found| Some(found.0)) == Some(parents.1);
        let masses = (mass(a) - mass(b)).abs() < 1e-6 * mass(a).max(1e-9);
        let names = [j, k].map(|joint| robot.joints[joint].name.as_str());
        let sign = mirror_sign(robot, frames, names[0], names[1]);
        (a != b && legs && masses && apart[0].min(apart[1]) < ORIGIN_TOLERANCE).then_some(sign).flatten()
    };
    for &(joint, link) in &moving {
        let name = &robot.joints[joint].name;
        if paired.contains(name) {
            continue;
        }
        let others = moving.iter().filter(|(other, _)| !paired.contains(&robot.joints[*other].name));
        let found: Vec<(usize, usize, f64)> = others
            .filter_map(|&(k, other)| Some((k, other, alike((joint, link), (k, other), &partner)?)))
            .collect();
        let [(k, other, sign)] = found[..] else { continue };
        let y = frames[link].position[1];
        let inherited = above(link).and_then(|parent| partner.get(&parent)).map(|found| found.1);
        let first = inherited.unwrap_or(y > -1e-6);
        partner.insert(link, (other, first));
        partner.insert(other, (link, !first));
        let names = [name.clone(), robot.joints[k].name.clone()];
        let [left, right] = if first { [0, 1] } else { [1, 0] }.map(|k: usize| quoted(&names[k]));
        let _ = writeln!(lines, "  {{ left = {left}, right = {right}, sign = {sign} }}, # by their places");
        paired.extend(names);
    }
}

/// What the right joint may be called if the left one is called this.
fn mirrored_names(left: &str) -> Vec<String> {
    let mut names: Vec<String> = [("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT")]
        .into_iter()
        .filter(|(from, _)| left.contains(from))
        .map(|(from, to)| left.replace(from, to))
        .collect();
    if let Some(rest) = left.strip_prefix('L') {
        names.push(format!("R{rest}"));
    }
    let words: Vec<&str> = left.split_inclusive(|c: char| !c.is_ascii_alphanumeric()).collect();
    names.push(words.into_iter().map(mirrored_word).collect());
    names.retain(|name| name != left);
    names
}

/// A word with the separator behind it, swapped if it tells a side.
fn mirrored_word(word: &str) -> String {
    let core = word.trim_end_matches(|c: char| !c.is_ascii_alphanumeric());
    let lower = core.to_ascii_lowercase();
    let Some((_, to)) = SIDES.iter().find(|(from, _)| *from == lower) else { return word.into() };
    let upper = core.chars().all(|c| c.is_ascii_uppercase());
    let to = if upper { to.to_ascii_uppercase() } else { (*to).to_string() };
    to + &word[core.len()..]
}
