//! Left and right joints: paired by name, with the sign from their axes.
use super::quoted;
use crate::description::geometry::{Frame, norm, subtract};
use crate::description::model::Side;
use crate::description::settings::{mirror_sign, side_of_name};
use crate::description::urdf::{Tree, UrdfRobot};
use std::collections::HashMap;
use std::fmt::Write as _;

/// Joints further than this from the mirror image of their partner are remarked on, m.
const ORIGIN_TOLERANCE: f64 = 1e-3;

/// What the words for the left side become in the mirror.
const SWAPS: [(&str, &str); 7] =
    [("left", "right"), ("l", "r"), ("fl", "fr"), ("rl", "rr"), ("hl", "hr"), ("lf", "rf"), ("lh", "rh")];

pub(super) fn write_symmetry(robot: &UrdfRobot, tree: &Tree, frames: &[Frame], out: &mut String) {
    let moving: HashMap<&str, usize> = tree
        .below
        .iter()
        .flatten()
        .filter(|(joint, _)| robot.joints[*joint].kind.moves())
        .map(|&(joint, child)| (robot.joints[joint].name.as_str(), child))
        .collect();
    let mut lines = String::new();
    for joint in robot.joints.iter().filter(|joint| side_of_name(&joint.name) == Some(Side::Left)) {
        let left = joint.name.as_str();
        let partner = mirrored_names(left).into_iter().find(|name| moving.contains_key(name.as_str()));
        let (Some(&left_link), Some(right)) = (moving.get(left), partner) else { continue };
        let (a, b) = (frames[left_link].position, frames[moving[right.as_str()]].position);
        let pair = format!("{{ left = {}, right = {}", quoted(left), quoted(&right));
        let _ = match mirror_sign(robot, frames, left, &right) {
            Some(sign) if norm(subtract(b, [a[0], -a[1], a[2]])) < ORIGIN_TOLERANCE => {
                writeln!(lines, "  {pair}, sign = {sign} }},")
            }
            Some(sign) => {
                writeln!(lines, "  {pair}, sign = {sign} }}, # the joints' places are not mirror images")
            }
            None => writeln!(lines, "  # {pair} }}: the axes are not mirror images"),
        };
    }
    if lines.is_empty() {
        out.push_str("\n# No joints with left and right names were found.\n");
    } else {
        out.push_str("\n# Joints that mirror each other, by name. sign = 1: equal angles (pitch), -1: opposite ones (roll, yaw).\n");
        let _ = write!(out, "[symmetry]\njoints = [\n{lines}]\n");
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
    let Some((_, to)) = SWAPS.iter().find(|(from, _)| *from == lower) else { return word.into() };
    let upper = core.chars().all(|c| c.is_ascii_uppercase());
    let to = if upper { to.to_ascii_uppercase() } else { (*to).to_string() };
    to + &word[core.len()..]
}
