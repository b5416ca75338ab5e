//! A first sequence of phases for a robot with two feet.
use super::feet::FootGuess;
use crate::description::model::Side;
use std::fmt::Write as _;

/// `known`: the robot walks in the plane and its legs mirror each other, so that the phases can stand as they are; else they are a comment.
pub(super) fn write_phases(feet: &[FootGuess], known: bool, out: &mut String) {
    let of = |side| feet.iter().filter(move |foot| foot.side == Some(side));
    let (mut left, mut right) = (of(Side::Left), of(Side::Right));
    let (Some(left), Some(right), 2) = (left.next(), right.next(), feet.len()) else { return };
    let has = |foot: &FootGuess, wanted: &str| foot.points.iter().any(|(name, _)| *name == wanted);
    let soles =
        [left, right].iter().all(|foot| foot.points.len() == 2 && has(foot, "heel") && has(foot, "toe"));
    let text = match known && soles {
        true => human_like(&left.name, &right.name),
        false => one_phase(&left.name, &right.name),
    };
    out.push('\n');
    for line in text.lines() {
        let _ = match known || line.starts_with('#') || line.is_empty() {
            true => writeln!(out, "{line}"),
            false => writeln!(out, "# {line}"),
        };
    }
}

fn one_phase(left: &str, right: &str) -> String {
    format!(
        "\
# Walking phases in their order; this one is a walk that swaps its legs at each touch-down.
[[phase]]
name = \"single_support\"
contacts = [\"{right}\"]
impact = [\"{left}\"]
relabel = true
"
    )
}

/// Table 4.1 of the thesis.
fn human_like(left: &str, right: &str) -> String {
    format!(
        "\
# The four phases of a human-like step in their order; the right leg stands. `contacts` holds during the phase, `impact` just after its
# end; without `impact` something is let go and nothing jumps.

# 1: the stance foot is flat. Ends when the ground no longer pushes on its heel.
[[phase]]
name = \"single_support\"
contacts = [\"{right}\"]
next = \"toe_support\"

# 2: the robot tips about the stance toe. Ends when the swing heel lands; the stance toe stays.
[[phase]]
name = \"toe_support\"
contacts = [\"{right}/toe\"]
impact = [\"{right}/toe\", \"{left}/heel\"]
next = \"touch_down\"

# 3: stance toe and swing heel. Ends when the swing toe lands; then left and right swap roles.
[[phase]]
name = \"touch_down\"
contacts = [\"{right}/toe\", \"{left}/heel\"]
impact = [\"{right}/toe\", \"{left}\"]
relabel = true
next = \"push_off\"

# 4: after the swap the front foot (right) is flat, the rear foot (left) pushes with its toe until it lifts off.
[[phase]]
name = \"push_off\"
contacts = [\"{right}\", \"{left}/toe\"]
next = \"single_support\"
"
    )
}
