//! Which legs a robot has, where their soles are, and how it stands.
use bipedc_compiler::description::model::{Foot, Joint, RobotDescription};
use bipedc_compiler::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::feet::Side;
use nalgebra::{Matrix3, Vector3};

/// A sole in the frame of its link.
#[derive(Debug, Clone, PartialEq)]
pub struct SoleFrame {
    /// Its middle, m.
    pub center: Vector3<f64>,
    /// Its axes forward, left, up.
    pub axes: Matrix3<f64>,
    /// Corners in its axes about its middle, m.
    pub corners: Vec<[f64; 3]>,
}

/// A joint with its limits.
#[derive(Debug, Clone, PartialEq)]
pub struct Limited {
    /// As in the description.
    pub name: String,
    /// Place in `v`.
    pub column: usize,
    /// Least and largest position, rad.
    pub position: [f64; 2],
    /// rad/s
    pub velocity: f64,
    /// N m
    pub effort: f64,
    /// It slides: m for rad.
    pub prismatic: bool,
    /// The leg that it is in: 0 right, 1 left.
    pub leg: Option<usize>,
}

impl Limited {
    /// rad, rad/s, N m, or those of a joint that slides.
    pub fn units(&self) -> [&'static str; 3] {
        if self.prismatic { ["m", "m/s", "N"] } else { ["rad", "rad/s", "N m"] }
    }
}

/// The feet of a robot that walks: right, left.
///
/// # Errors
/// Not one foot on each side with three contact points.
pub fn feet(description: &RobotDescription) -> Result<[&Foot; 2], Diagnostic> {
    let help = "walking wants one foot with `side` on either side and at least three `points` each; say so in biped.toml";
    let of = |side: Side, name: &str| {
        let mut found = description.feet.iter().filter(|foot| foot.side == Some(side));
        match (found.next(), found.next()) {
            (Some(foot), None) if foot.points.len() >= 3 => Ok(foot),
            (Some(foot), None) => Err(Diagnostic::error(format!(
                "the foot `{}` has only {} contact points",
                foot.name,
                foot.points.len()
            ))
            .help(help)),
            (None, _) => Err(Diagnostic::error(format!("the robot has no {name} foot")).help(help)),
            _ => Err(Diagnostic::error(format!("the robot has several {name} feet")).help(help)),
        }
    };
    Ok([of(Side::Right, "right")?, of(Side::Left, "left")?])
}

/// All joints in the order of `v`, with the leg that they belong to: those between the root and one foot alone.
pub fn joints(description: &RobotDescription, tree: &Tree, root: &str, feet: [&Foot; 2]) -> Vec<Limited> {
    let chains = feet.map(|foot| chain(description, &foot.link, root));
    let of_urdf = |name: &str| description.joints.iter().find(|joint| joint.name == name);
    tree.joints
        .iter()
        .map(|joint| {
            let urdf = of_urdf(&joint.name);
            let within: Vec<usize> = (0..2).filter(|k| chains[*k].contains(&joint.name)).collect();
            let limits = urdf.and_then(|j| j.position_limits).map_or([-1e9, 1e9], |(low, high)| [low, high]);
            let or_none = |x: Option<f64>| x.filter(|x| *x > 0.0).unwrap_or(f64::INFINITY);
            Limited {
                name: joint.name.clone(),
                column: joint.v_index,
                position: limits,
                velocity: or_none(urdf.and_then(|j| j.velocity_limit)),
                effort: or_none(urdf.and_then(|j| j.effort_limit)),
                prismatic: joint.prismatic,
                leg: if within.len() == 1 { within.first().copied() } else { None },
            }
        })
        .collect()
}

/// Names of the moving joints on the way between two links, from the root on.
pub fn chain(description: &RobotDescription, link: &str, root: &str) -> Vec<String> {
    let up = |from: &str| {
        let (mut link, mut way) = (from.to_owned(), Vec::new());
        while let Some(joint) = description.joints.iter().find(|joint| joint.child == link) {
            way.push(joint);
            link.clone_from(&joint.parent);
        }
        way
    };
    let (down, other) = (up(link), up(root));
    let shared = |joint: &&Joint, list: &[&Joint]| list.iter().any(|j| j.name == joint.name);
    let moving = |joint: &&&Joint| joint.kind.moves();
    let first = other.iter().filter(|joint| !shared(joint, &down));
    let second = down.iter().rev().filter(|joint| !shared(joint, &other));
    first.chain(second).filter(moving).map(|joint| joint.name.clone()).collect()
}
