//! Which links are feet: by name, else the lowest ends of the kinematic chains.
use super::points::contact_points;
use crate::description::geometry::{Frame, Vector};
use crate::description::model::Side;
use crate::description::settings::side_of_name;
use crate::description::urdf::bodies::{Body, bodies};
use crate::description::urdf::{Tree, UrdfRobot};

/// Parts of names that only feet have, the best first.
const WORDS: [&str; 5] = ["sole", "foot", "toe", "heel", "ankle"];

/// How far above the lowest chain's end another may end and still be a foot, relative to the robot's height.
const SAME_LEVEL: f64 = 0.05;

/// How far below the root link feet must be, relative to the robot's height.
const BELOW_ROOT: f64 = 0.2;

/// A foot and why it was taken for one.
#[derive(Debug)]
pub(super) struct FootGuess {
    pub(super) name: String,
    pub(super) link: String,
    pub(super) side: Option<Side>,
    pub(super) points: Vec<(&'static str, Vector)>,
    pub(super) reason: String,
}

/// `pitch`: all joints of the robot pitch.
pub(super) fn guess_feet(robot: &UrdfRobot, tree: &Tree, frames: &[Frame], pitch: bool) -> Vec<FootGuess> {
    let bodies = bodies(robot, tree);
    let ends: Vec<&Body> = bodies.iter().filter(|body| body.joint.is_some() && !body.has_children).collect();
    let mut found: Vec<(usize, &Body, &str)> =
        ends.iter().filter_map(|body| Some((foot_by_name(robot, body)?, *body, "its name"))).collect();
    if found.is_empty() {
        let lowest = lowest_ends(robot, &ends, frames);
        found = lowest
            .into_iter()
            .map(|body| (body.links[0], body, "its place, its chain ends lowest"))
            .collect();
    }
    let mut guesses: Vec<FootGuess> = found
        .into_iter()
        .map(|(link, body, reason)| guess((robot, frames, pitch), link, body, reason))
        .collect();
    if let [a, b] = &mut guesses[..]
        && pitch
        && a.side.is_none()
        && b.side.is_none()
    {
        (a.side, b.side) = (Some(Side::Left), Some(Side::Right));
        for foot in [a, b] {
            foot.reason += " Nothing tells its side: taken for the one or the other, which in the plane makes no difference.";
        }
    }
    name_feet(&mut guesses);
    guesses
}

/// The link of a body whose name tells of a foot; one with collision shapes if there is any.
fn foot_by_name(robot: &UrdfRobot, body: &Body) -> Option<usize> {
    let rank = |link: usize| {
        // Wheels are no heels.
        let name = robot.links[link].name.to_ascii_lowercase().replace("wheel", "");
        let word = WORDS.iter().position(|word| name.contains(word))?;
        // Skin patches and sensor frames have longer names than the foot that carries them.
        Some((robot.shapes[link].is_empty(), word, name.len(), link))
    };
    body.links.iter().filter_map(|&link| rank(link)).min().map(|(_, _, _, link)| link)
}

/// Ends of chains at the level of the lowest one, if there are at least two and well below the root: legs, not
/// the tools of arms on a pedestal.
fn lowest_ends<'b>(robot: &UrdfRobot, ends: &[&'b Body], frames: &[Frame]) -> Vec<&'b Body> {
    let heights: Vec<f64> = ends.iter().map(|body| lowest_point(robot, body, frames)).collect();
    let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = frames.iter().map(|frame| frame.position[2]).fold(f64::NEG_INFINITY, f64::max);
    let margin = SAME_LEVEL * (highest - lowest);
    let level = ends.iter().zip(&heights).filter(|(_, height)| **height <= lowest + margin);
    let level: Vec<&Body> = level.map(|(body, _)| *body).collect();
    let below_root = lowest < -BELOW_ROOT * (highest - lowest);
    if level.len() < 2 || !below_root { Vec::new() } else { level }
}

fn lowest_point(robot: &UrdfRobot, body: &Body, frames: &[Frame]) -> f64 {
    let points = contact_points(robot, frames, (body.links[0], &body.links), false);
    let heights = points.iter().map(|(_, point)| frames[body.links[0]].point(*point)[2]);
    let masses = body.links.iter().filter_map(|&link| {
        let inertial = robot.links[link].inertial?;
        Some(frames[link].point(inertial.origin.xyz)[2])
    });
    heights.chain(masses).fold(f64::INFINITY, f64::min)
}

/// What a first description says of a foot whose longer side is behind its joint.
pub const BACKWARD: &str = "which is longer: does the robot face −x?";

/// A side of a foot that is so much longer than the other, measured from the joint that carries the foot, is its front.
const LONGER: f64 = 1.25;

/// Which end was taken for the heel, and why; nothing of a foot without ends.
fn direction(ankle: f64, points: impl Iterator<Item = f64> + Clone) -> String {
    let front = points.clone().fold(f64::NEG_INFINITY, f64::max) - ankle;
    let rear = ankle - points.fold(f64::INFINITY, f64::min);
    if front + rear <= 1e-3 {
        return String::new();
    }
    let ends = format!(
        " Its front is the end towards +x, where robots walk to: {:.0} mm before the joint that carries it; its rear, {:.0} mm behind that",
        1e3 * front,
        1e3 * rear
    );
    if rear > LONGER * front.max(0.0) { format!("{ends}, {BACKWARD}") } else { format!("{ends}.") }
}

/// What a first description says of a foot whose points are a guess.
pub const NO_SHAPE: &str = "it has no collision shape: put the corners of its sole here";

fn guess(
    (robot, frames, pitch): (&UrdfRobot, &[Frame], bool),
    link: usize,
    body: &Body,
    reason: &str,
) -> FootGuess {
    let name = &robot.links[link].name;
    let points = contact_points(robot, frames, (link, &body.links), pitch);
    let y = frames[link].position[1];
    let side_by_place = (y.abs() > 1e-3).then_some(if y > 0.0 { Side::Left } else { Side::Right });
    let shapes = body.links.iter().any(|&link| !robot.shapes[link].is_empty());
    let ankle = frames[body.links[0]].position[0];
    let towards = direction(ankle, points.iter().map(|(_, point)| frames[link].point(*point)[0]));
    let origin = if shapes { "the points are the lowest of its collision shapes" } else { NO_SHAPE };
    FootGuess {
        name: identifier(name),
        link: name.clone(),
        side: side_of_name(name).or(side_by_place),
        points,
        reason: format!(
            "Taken for a foot because of {reason}; {origin} (m, in the frame of the link).{towards}"
        ),
    }
}

/// `left_foot` and `right_foot` where that is unambiguous, else names made of the links'.
fn name_feet(feet: &mut [FootGuess]) {
    let sides: Vec<Option<Side>> = feet.iter().map(|foot| foot.side).collect();
    for (index, foot) in feet.iter_mut().enumerate() {
        let alone = sides.iter().filter(|side| **side == foot.side).count() == 1;
        match foot.side {
            Some(Side::Left) if alone => foot.name = "left_foot".into(),
            Some(Side::Right) if alone => foot.name = "right_foot".into(),
            _ => {}
        }
        // Different links may give the same identifier, such as `a-b` and `a_b`.
        if !alone {
            foot.name = format!("{}_{}", foot.name, index + 1);
        }
    }
}

fn identifier(name: &str) -> String {
    let word: String = name
        .chars()
        .take(60)
        .map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' })
        .collect();
    if word.starts_with(|c: char| c.is_ascii_alphabetic()) { word } else { format!("foot_{word}") }
}
