//! A first `biped.toml` for a URDF, with every guess written out so that it can be corrected.
mod base_joints;
mod feet;
mod friction;
mod pairs;
mod phases;
mod points;

use super::geometry::Frame;
use super::model::{JointKind, Side};
use super::settings::DEFAULT_URDF;
use super::source::{Messages, finish};
use super::urdf::{Tree, UrdfRobot, WORLD, read_urdf};
use base_joints::{BaseJoints, base_joints, carries_all};
use bipedc_effects::diagnostic::Diagnostics;
use feet::FootGuess;
pub use feet::{BACKWARD, NO_SHAPE};
use std::fmt::Write as _;
use std::path::Path;

/// The text of a first `biped.toml` for this URDF. Nothing is written to disk.
///
/// # Errors
/// Everything about the URDF that has no meaning, all at once.
pub fn init(urdf: &Path) -> Result<String, Diagnostics> {
    init_text(&super::load_text(urdf)?, urdf)
}

/// The text of a first `biped.toml` for the text of a URDF; the name serves messages and the key `urdf`.
///
/// # Errors
/// Everything about the URDF that has no meaning, all at once.
pub fn init_text(urdf_text: &str, urdf_name: &Path) -> Result<String, Diagnostics> {
    let mut messages = Messages::new(urdf_text, urdf_name);
    let mut robot = read_urdf(urdf_text, &mut messages);
    finish(messages.into_list())?;
    let followers = robot.as_mut().map(hold_followers).unwrap_or_default();
    let file = urdf_name.file_name().map_or_else(|| DEFAULT_URDF.into(), |name| name.to_string_lossy());
    let described =
        robot.as_ref().and_then(|robot| Some(describe(robot, robot.tree.as_ref()?, &file, &followers)));
    // Without errors there is a robot with a tree; an empty description would be right as well.
    Ok(described.unwrap_or_default())
}

/// Joints that move as others do, which are fixed here: fingers of grippers in most URDFs.
fn hold_followers(robot: &mut UrdfRobot) -> Vec<String> {
    let followers: Vec<String> = robot.followers().into_iter().map(|(name, _)| name).collect();
    let held = robot.joints.iter_mut().filter(|joint| followers.contains(&joint.name));
    held.for_each(|joint| joint.kind = JointKind::Fixed);
    followers
}

fn describe(robot: &UrdfRobot, tree: &Tree, file: &str, followers: &[String]) -> String {
    let frames = tree.frames(robot);
    let planar = is_planar(robot, tree, &frames);
    let feet = feet::guess_feet(robot, tree, &frames, planar);
    let mut out = String::from(
        "# A first description, guessed from the URDF: check every line. Keys that are left out have defaults.\n\n",
    );
    if file != DEFAULT_URDF && !file.chars().any(char::is_control) {
        let _ = writeln!(out, "urdf = {}", quoted(file));
    }
    out.push_str("gravity = [0.0, 0.0, -9.81]     # m/s²\n");
    let base = base_joints((robot, tree, &frames)).filter(|_| planar && !feet.is_empty());
    match &base {
        Some(base) => write_base_joints(base, &mut out),
        None => write_base(robot, tree, planar, &feet, &mut out),
    }
    write_locked(base.as_ref().map_or(&[], |base| &base.joints), followers, &mut out);
    write_feet(&feet, &mut out);
    let paired = pairs::write_symmetry((robot, tree, &frames), planar, &mut out);
    write_actuation(robot, base.as_ref().map_or(&[], |base| &base.joints), &mut out);
    friction::write_friction(robot, &mut out);
    let legs = feet.iter().all(|foot| legs_are_paired(robot, tree, &foot.link, &paired));
    let free = base.is_some() || robot.links[tree.root].name != WORLD;
    phases::write_phases(&feet, planar && legs && free, &mut out);
    out
}

/// A text as TOML writes it; names with control characters were refused with the URDF.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Whether the joint that carries a foot has a partner, and those above it up to the root, but for a trunk that both legs share.
fn legs_are_paired(robot: &UrdfRobot, tree: &Tree, foot: &str, paired: &[String]) -> bool {
    let mut link = robot.links.iter().position(|link| link.name == foot);
    let mut known = Vec::new();
    while let Some((joint, parent)) = link.and_then(|link| tree.above[link]) {
        if robot.joints[joint].kind.moves() {
            known.push(paired.contains(&robot.joints[joint].name));
        }
        link = Some(parent);
    }
    // From the foot upwards: paired ones, then those of the trunk.
    known.first() == Some(&true) && known.windows(2).all(|pair| pair[0] || !pair[1])
}

/// The base coordinates take the place of joints that move the whole robot.
fn write_base_joints(base: &BaseJoints<'_>, out: &mut String) {
    let _ = write!(
        out,
        "\n[base]\nkind = \"planar\"                 # all axes are pitch axes, slides in the plane: x, z, pitch. Else \"floating\" or \"fixed\" (with `link`)\nroot = {}\n",
        quoted(base.carried)
    );
}

/// Joints of the URDF that are no joints of the robot: those of its base, and those that follow others.
fn write_locked<N: AsRef<str>>(base: &[N], followers: &[String], out: &mut String) {
    if base.is_empty() && followers.is_empty() {
        return;
    }
    out.push('\n');
    if !base.is_empty() {
        out.push_str("# Joints of the URDF that move the whole robot about the world: what the base coordinates are for.\n");
    }
    if !followers.is_empty() {
        out.push_str("# Joints that <mimic> others are held at zero; a table instead of a list holds them elsewhere: { NAME = ANGLE }.\n");
    }
    let base = base.iter().map(AsRef::as_ref);
    let locked: Vec<String> = base.chain(followers.iter().map(String::as_str)).map(quoted).collect();
    let _ = writeln!(out, "[joints]\nlocked = [{}]", locked.join(", "));
}

fn write_base(robot: &UrdfRobot, tree: &Tree, planar: bool, feet: &[FootGuess], out: &mut String) {
    let root = &robot.links[tree.root].name;
    let name = quoted(root);
    out.push_str("\n[base]\n");
    let _ = if root == WORLD {
        writeln!(out, "kind = \"fixed\"                  # the URDF's root link is the world\nlink = {name}")
    } else if feet.is_empty() {
        writeln!(
            out,
            "kind = \"fixed\"                  # no feet found: bolted to the world. Else \"floating\" or \"planar\", with `root`\nlink = {name}"
        )
    } else if planar {
        writeln!(
            out,
            "kind = \"planar\"                 # all axes are pitch axes, slides in the plane: x, z, pitch. Else \"floating\" or \"fixed\" (with `link`)\nroot = {name}"
        )
    } else {
        writeln!(
            out,
            "kind = \"floating\"               # free in space; \"fixed\" (with `link` instead of `root`) if bolted to a stand\nroot = {name}"
        )
    };
}

/// Whether every moving joint turns about the y axis of the root or slides across it, and one turns.
fn is_planar(robot: &UrdfRobot, tree: &Tree, frames: &[Frame]) -> bool {
    let moving = || tree.below.iter().flatten().filter(|(joint, _)| robot.joints[*joint].kind.moves());
    let slides = |joint: usize| robot.joints[joint].kind == JointKind::Prismatic;
    moving().any(|&(joint, _)| !slides(joint))
        && moving().all(|&(joint, child)| {
            let [x, y, z] = frames[child].direction(robot.joints[joint].axis);
            if slides(joint) { y.abs() < 1e-9 } else { x.hypot(z) < 1e-9 }
        })
}

fn write_feet(feet: &[FootGuess], out: &mut String) {
    if feet.is_empty() {
        out.push_str(
            "\n# No feet were recognised. A foot looks like this:\n# [feet.right_foot]\n# link = \"…\"                    # the link that touches the ground\n# side = \"right\"\n# points.toe = [0.15, 0.0, -0.05]  # m, in the frame of that link\n",
        );
    }
    for foot in feet {
        let _ = writeln!(out, "\n# {}", foot.reason);
        let _ = writeln!(out, "[feet.{}]\nlink = {}", foot.name, quoted(&foot.link));
        match foot.side {
            Some(Side::Left) => out.push_str("side = \"left\"\n"),
            Some(Side::Right) => out.push_str("side = \"right\"\n"),
            None => {}
        }
        for (name, [x, y, z]) in &foot.points {
            let _ = writeln!(out, "points.{name} = [{x:?}, {y:?}, {z:?}]");
        }
    }
}

fn write_actuation(robot: &UrdfRobot, of_base: &[&str], out: &mut String) {
    let moving = robot.joints.iter().filter(|joint| joint.kind.moves());
    // Planar robots often carry their base joints in the URDF.
    let (base, driven): (Vec<_>, Vec<_>) = moving.partition(|joint| {
        let name = joint.name.to_ascii_lowercase();
        let named = ["base", "root", "floating"].iter().any(|word| name.starts_with(word));
        of_base.contains(&joint.name.as_str()) || named && carries_all(robot, &joint.child)
    });
    out.push_str("\n# Joints with an actuator, in the order of the generalised torques.\n");
    for joint in base {
        let _ = writeln!(out, "# Not {}: it looks like a joint of the base.", joint.name);
    }
    out.push_str("[actuation]\njoints = [\n");
    for joint in driven {
        let _ = writeln!(out, "  {},", quoted(&joint.name));
    }
    out.push_str("]\n");
}
