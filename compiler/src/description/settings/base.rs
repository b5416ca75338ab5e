//! How the robot hangs in the world, and whether it can move that way.
use super::Known;
use super::table::Section;
use crate::description::geometry::{Vector, norm};
use crate::description::model::{Base, Foot, JointKind};
use crate::description::source::{Messages, Place, short, suggest};
use crate::description::urdf::{WORLD, bodies};

const KINDS: [&str; 4] = ["floating", "planar", "fixed", "pivot"];
/// The key that goes with each kind.
const KEYS: [&str; 4] = ["root", "root", "link", "about"];

/// Sine of the angle by which an axis may miss the plane's normal, from rounding in the URDF.
const OUT_OF_PLANE: f64 = 1e-6;

pub(super) fn read_base(
    top: &Section<'_, '_>,
    known: Known<'_>,
    feet: &[Foot],
    messages: &mut Messages<'_>,
) -> Base {
    let root = root_name(known);
    let default = if root == WORLD {
        Base::Fixed { link: root.clone() }
    } else {
        Base::Floating { root: root.clone() }
    };
    let Some(section) = top.section("base", messages) else { return default };
    let stated = section.string("kind", messages);
    let kind = match (&stated, &default) {
        (Some((kind, _)), _) => kind.as_str(),
        (None, Base::Fixed { .. }) => "fixed",
        (None, _) => "floating",
    };
    let Some((_, key)) = KINDS.into_iter().zip(KEYS).find(|(name, _)| *name == kind) else {
        let at = stated.as_ref().and_then(|(_, at)| *at);
        let message = format!("`kind` in [base]: unknown base \"{}\"", short(kind));
        messages.error(at, message, suggest(kind, KINDS, "bases"));
        section.check_keys(&["kind", "root", "link", "about"], messages);
        return default;
    };
    section.check_keys(&["kind", key], messages);
    let value = section.string(key, messages).unwrap_or((root, section.at));
    if kind == "pivot" && !section.has(key) {
        let help = "write about = \"foot/point\" (planar robots) or \"foot/edge\"";
        messages.error(section.at, "[base]: kind \"pivot\" needs `about`", help);
        return default;
    }
    checked_base(kind, value, known, feet, messages)
}

/// The base of this kind, its link, point or edge checked.
fn checked_base(
    kind: &str,
    (value, at): (String, Place),
    known: Known<'_>,
    feet: &[Foot],
    messages: &mut Messages<'_>,
) -> Base {
    match kind {
        "fixed" => {
            known.check_link(&value, at, "[base]", messages);
            Base::Fixed { link: value }
        }
        "pivot" => {
            check_pivot(&value, at, feet, messages);
            Base::Pivot { about: value }
        }
        _ => {
            check_root(&value, at, known, feet, messages);
            if kind == "planar" { Base::Planar { root: value } } else { Base::Floating { root: value } }
        }
    }
}

fn root_name(known: Known<'_>) -> String {
    let tree = known.robot.and_then(|robot| Some((robot, robot.tree.as_ref()?)));
    tree.map_or_else(String::new, |(robot, tree)| robot.links[tree.root].name.clone())
}

/// A link, or a contact point written `foot/point`.
fn check_root(value: &str, at: Place, known: Known<'_>, feet: &[Foot], messages: &mut Messages<'_>) {
    let Some((foot, part)) = value.split_once('/') else {
        // An unreadable tree has no root; that was reported with the URDF.
        if known.robot.is_none_or(|robot| robot.tree.is_some()) {
            known.check_link(value, at, "[base]", messages);
        }
        return;
    };
    // Link names may contain a slash; a link of that name is meant first.
    if known.robot.is_some_and(|robot| robot.links.iter().any(|link| link.name == value)) {
        return;
    }
    if let Some(foot) = find_foot(foot, at, "[base]", feet, messages)
        && foot.points.iter().all(|point| point.name != part)
    {
        let names: Vec<&str> = foot.points.iter().map(|point| point.name.as_str()).collect();
        let message = format!("[base]: foot `{}` has no point `{}`", foot.name, short(part));
        messages.error(at, message, suggest(part, names, "its points"));
    }
}

fn check_pivot(about: &str, at: Place, feet: &[Foot], messages: &mut Messages<'_>) {
    let Some((foot, part)) = about.split_once('/') else {
        let message = format!("[base]: `about = \"{}\"` is not of the form \"foot/part\"", short(about));
        messages.error(at, message, "write about = \"right_foot/toe\" or \"right_foot/front\"");
        return;
    };
    let Some(foot) = find_foot(foot, at, "[base]", feet, messages) else { return };
    let parts: Vec<&str> = parts(foot);
    if !parts.contains(&part) {
        let message = format!("[base]: foot `{}` has no point or edge `{}`", foot.name, short(part));
        messages.error(at, message, suggest(part, parts, "its parts"));
    }
}

/// Names of all points and edges.
pub(super) fn parts(foot: &Foot) -> Vec<&str> {
    let points = foot.points.iter().map(|point| point.name.as_str());
    points.chain(foot.edges.iter().map(|edge| edge.name.as_str())).collect()
}

/// The foot of this name; reports if there is none.
pub(super) fn find_foot<'f>(
    name: &str,
    at: Place,
    what: &str,
    feet: &'f [Foot],
    messages: &mut Messages<'_>,
) -> Option<&'f Foot> {
    let found = feet.iter().find(|foot| foot.name == name);
    if found.is_none() {
        let names: Vec<&str> = feet.iter().map(|foot| foot.name.as_str()).collect();
        let message = format!("{what}: there is no foot `{}`", short(name));
        messages.error(at, message, suggest(name, names, "feet under [feet]"));
    }
    found
}

/// Checks that a planar robot stays in its plane and that a free base has mass.
pub(super) fn check_motion(
    top: &Section<'_, '_>,
    known: Known<'_>,
    base: &Base,
    gravity: Vector,
    messages: &mut Messages<'_>,
) {
    let gravity_at = top.get("gravity").and_then(|entry| entry.at);
    if gravity[2] > 0.0 {
        let message = format!("gravity points up: its z component is {} m/s²", gravity[2]);
        messages.warning(gravity_at, message, "write gravity = [0.0, 0.0, -9.81]");
    }
    let base_at = top.get("base").and_then(|entry| entry.at);
    match base {
        Base::Planar { .. } => {
            if gravity[1] != 0.0 {
                let message = "a planar robot cannot have gravity along y".to_string();
                messages.error(gravity_at, message, "write gravity = [0.0, 0.0, -9.81]");
            }
            check_plane(known, base_at, messages);
        }
        Base::Floating { .. } => check_base_mass(known, base_at, messages),
        _ => {}
    }
}

fn check_plane(known: Known<'_>, at: Place, messages: &mut Messages<'_>) {
    let Some((robot, tree)) = known.robot.and_then(|robot| Some((robot, robot.tree.as_ref()?))) else {
        return;
    };
    let frames = tree.frames(robot);
    for &(joint, child) in tree.below.iter().flatten() {
        let joint = &robot.joints[joint];
        let [x, y, z] = frames[child].direction(joint.axis);
        let leaves = match joint.kind {
            JointKind::Fixed => false,
            JointKind::Prismatic => y.abs() > OUT_OF_PLANE,
            _ => norm([x, 0.0, z]) > OUT_OF_PLANE,
        };
        if leaves {
            messages.error(
                at,
                format!(
                    "[base]: the robot is planar, but joint `{}` leaves the x-z plane",
                    short(&joint.name)
                ),
                "use kind = \"floating\", or fix the joint in the URDF",
            );
        }
    }
}

fn check_base_mass(known: Known<'_>, at: Place, messages: &mut Messages<'_>) {
    let Some((robot, tree)) = known.robot.and_then(|robot| Some((robot, robot.tree.as_ref()?))) else {
        return;
    };
    if bodies::bodies(robot, tree).first().is_some_and(|root| root.moments.mass == 0.0) {
        messages.warning(
            at,
            format!("the base floats, but its link `{}` has no mass", short(&robot.links[tree.root].name)),
            "add <inertial> to it in the URDF, or write kind = \"fixed\" under [base]",
        );
    }
}
