//! A robot with its sides exchanged: what walks while phases that name legs by their roles call the left leg the right one.
//!
//! A mirrored robot stays what it is. One with a payload at a foot, friction in one knee or other masses on the left than on the
//! right becomes another one with every step: its left leg stands as the right one of this robot.
use bipedc_compiler::Robot;
use bipedc_compiler::description::model::{Inertial, Joint, JointKind, Pose, RobotDescription};
use bipedc_compiler::tree::{Inertia, Rotation, as_built};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Acts, BoundLaw, Effect, VARIABLES};
use nalgebra::{Matrix3, Vector3};

/// Masses, places (m) and inertias that differ by less, as a part of the largest, are the same.
const SAME: f64 = 1e-9;
/// Places of mirrored frames differ by less, m.
const NEAR: f64 = 1e-6;

/// The robot with its sides exchanged; `None`: it is the same, or no phase exchanges them.
///
/// # Errors
/// A link or an effect without a mirror image.
pub(super) fn exchanged(robot: &Robot) -> Result<Option<Robot>, Diagnostic> {
    if !robot.description.phases.iter().any(|phase| phase.relabel) {
        return Ok(None);
    }
    let mut built = as_built(&robot.description).into_owned();
    built.effects.retain(|effect| !matches!(effect.kind.law.acts(), Acts::Body | Acts::Gravity));
    let sides = Sides::new(&built);
    let mut other = built.clone();
    for (link, name) in
        sides.links.iter().enumerate().filter(|(link, _)| built.links[*link].inertial.is_some())
    {
        let Some(partner) = *name else {
            let message = format!("link `{}` has no mirror image", built.links[link].name);
            return Err(Diagnostic::error(message)
                .help("pair the joint above it under [symmetry], or write method = \"time_stepping\""));
        };
        other.links[partner].inertial =
            built.links[link].inertial.map(|own| sides.mirrored(&own, [link, partner]));
    }
    other.effects = built.effects.iter().map(|effect| sides.effect(effect)).collect::<Result<_, _>>()?;
    for driven in &mut other.drives {
        driven.joint = sides.joint(&driven.joint).0;
    }
    let same =
        alike(&built, &other) && same_effects(&built.effects, &other.effects) && same_drives(&built, &other);
    Ok((!same).then(|| Robot { description: other, ..robot.clone() }))
}

/// Which link and joint is in the place of which, seen in a mirror at the x-z plane.
struct Sides<'a> {
    description: &'a RobotDescription,
    /// By link: the one in its place.
    links: Vec<Option<usize>>,
    /// By link, at zero posture in the axes of the root link.
    frames: Vec<(Matrix3<f64>, Vector3<f64>)>,
}

impl<'a> Sides<'a> {
    fn new(description: &'a RobotDescription) -> Self {
        let count = description.links.len();
        let mut sides = Self {
            description,
            links: vec![None; count],
            frames: vec![(Matrix3::identity(), Vector3::zeros()); count],
        };
        let at = |name: &str| description.links.iter().position(|link| link.name == name);
        let Some(root) = at(&description.root_link) else { return sides };
        // Parents first: frames, then partners, which look at the frames of both sides.
        let (mut order, mut open) = (Vec::new(), vec![root]);
        while let Some(parent) = open.pop() {
            let below =
                description.joints.iter().filter(|joint| joint.parent == description.links[parent].name);
            for (joint, child) in below.filter_map(|joint| Some((joint, at(&joint.child)?))) {
                sides.frames[child] = placed(sides.frames[parent], joint);
                order.push((joint, parent, child));
                open.push(child);
            }
        }
        sides.links[root] = Some(root);
        for (joint, parent, child) in order {
            let partner = sides.below(joint, parent, child);
            sides.links[child] = partner.and_then(|joint| at(&joint.child));
        }
        sides
    }

    /// The joint in the place of this one.
    fn below(&self, joint: &'a Joint, parent: usize, child: usize) -> Option<&'a Joint> {
        let mut joints = self.description.joints.iter();
        let (partner, _) = self.joint(&joint.name);
        if partner != joint.name {
            return joints.find(|other| other.name == partner);
        }
        if joint.kind.moves() {
            return Some(joint);
        }
        // Fixed links have no pair of their own: the one that hangs at the mirrored place.
        let parent = &self.description.links[self.links[parent]?].name;
        let wanted = mirrored(self.frames[child].1);
        let place = |other: &Joint| {
            let child = self.description.links.iter().position(|link| link.name == other.child);
            child.is_some_and(|child| (self.frames[child].1 - wanted).norm() < NEAR)
        };
        joints.find(|other| other.kind == JointKind::Fixed && other.parent == *parent && place(other))
    }

    /// The joint in the place of this one, and whether it turns the other way there.
    fn joint(&self, name: &str) -> (String, bool) {
        for pair in &self.description.symmetric_joints {
            for (one, other) in [(&pair.left, &pair.right), (&pair.right, &pair.left)] {
                if one == name {
                    return (other.clone(), pair.sign < 0.0);
                }
            }
        }
        (name.to_owned(), self.turns_over(name))
    }

    /// Whether a joint in the middle turns the other way: all but turns about y and slides in the plane.
    fn turns_over(&self, name: &str) -> bool {
        let Some(joint) = self.description.joints.iter().find(|joint| joint.name == name) else {
            return false;
        };
        let child = self.description.links.iter().position(|link| link.name == joint.child);
        let across = child.map_or(1.0, |child| (self.frames[child].0 * Vector3::from(joint.axis)).y.abs());
        (across < 0.5) != (joint.kind == JointKind::Prismatic)
    }

    /// What a link's mass is in the frame of the other one, seen in the mirror.
    fn mirrored(&self, own: &Inertial, [from, to]: [usize; 2]) -> Inertial {
        let ((turn, place), (other, there)) = (self.frames[from], self.frames[to]);
        let over = other.transpose() * Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0)) * turn;
        let center = mirrored(place + turn * Vector3::from(own.origin.xyz));
        let inertia = over * about_center(own) * over.transpose();
        Inertial {
            mass: own.mass,
            origin: Pose { xyz: (other.transpose() * (center - there)).into(), rpy: [0.0; 3] },
            inertia: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|at| inertia[at]),
        }
    }

    /// The same at the other side.
    fn effect(&self, effect: &Effect) -> Result<Effect, Diagnostic> {
        let mut other = effect.clone();
        let mut over = Vec::new();
        for joint in [&mut other.location.joint, &mut other.location.other_joint].into_iter().flatten() {
            let (name, turned) = self.joint(joint);
            *joint = name;
            over.push(turned);
        }
        let one_turns = over.iter().filter(|turned| **turned).count() == 1;
        let turns = over.contains(&true) && (one_turns && over.len() > 1 || !is_odd(effect));
        if turns {
            let message =
                format!("{effect} has no mirror image: the joint on the other side turns the other way");
            return Err(Diagnostic::error(message).help("write method = \"time_stepping\""));
        }
        Ok(other)
    }
}

/// A joint's child at zero posture.
fn placed((turn, place): (Matrix3<f64>, Vector3<f64>), joint: &Joint) -> (Matrix3<f64>, Vector3<f64>) {
    let own = Rotation::from_rpy(joint.origin.rpy).matrix();
    let own = Matrix3::from_fn(|row, column| own[row][column]);
    (turn * own, place + turn * Vector3::from(joint.origin.xyz))
}

fn mirrored(place: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(place.x, -place.y, place.z)
}

/// Inertia about the centre of mass in the link's axes, kg m².
fn about_center(own: &Inertial) -> Matrix3<f64> {
    let at_center = Inertial { origin: Pose { xyz: [0.0; 3], ..own.origin }, ..*own };
    let moment = Inertia::from_inertial(&at_center).second_moment;
    Matrix3::from_fn(|row, column| moment[row][column])
}

/// Whether the opposite motion needs the opposite torque.
fn is_odd(effect: &Effect) -> bool {
    let Some(Ok(mut law)) = effect.law_text().map(|text| BoundLaw::new(text, &VARIABLES, effect)) else {
        return false;
    };
    let mut at = |sign: f64, k: usize| {
        let motion = std::array::from_fn::<f64, { VARIABLES.len() }, _>(|i| {
            sign * (0.7 + (1.9 * (i + 5 * k) as f64).sin())
        });
        law.at(&motion, &mut Vec::new())
    };
    (0..8).all(|k| (at(1.0, k) + at(-1.0, k)).abs() <= SAME * at(1.0, k).abs())
}

/// Whether all links have the same masses.
fn alike(one: &RobotDescription, other: &RobotDescription) -> bool {
    one.links.iter().zip(&other.links).all(|(one, other)| match (&one.inertial, &other.inertial) {
        (None, None) => true,
        (Some(one), Some(other)) => {
            let (a, b) = (about_center(one), about_center(other));
            let apart = Vector3::from(one.origin.xyz) - Vector3::from(other.origin.xyz);
            (one.mass - other.mass).abs() <= SAME * one.mass
                && apart.amax() <= SAME
                && (a - b).amax() <= SAME * a.amax()
        }
        _ => false,
    })
}

fn same_effects(one: &[Effect], other: &[Effect]) -> bool {
    one.iter().all(|effect| other.contains(effect))
}

fn same_drives(one: &RobotDescription, other: &RobotDescription) -> bool {
    one.drives.iter().all(|drive| other.drives.contains(drive))
}
