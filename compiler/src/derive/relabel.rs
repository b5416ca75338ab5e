//! Exchange of the left and the right leg after a step: the R of q⁺ = R(q⁻), q̇⁺ = R q̇ (missing in the
//! thesis' (4.19b) and (6.1)).
use super::contact::{is_planar, zero_rotations};
use crate::description::model::{JointKind, RobotDescription};
use crate::expression::Sym;
use crate::tree::{BaseKind, Body, JointMotion, Tree};
use bipedc_effects::diagnostic::Diagnostic;

/// `offset + Σ factor · x[index]`
#[derive(Debug, Clone, PartialEq)]
struct Sum {
    offset: f64,
    terms: Vec<(usize, f64)>,
}

impl Sum {
    fn of(index: usize, factor: f64) -> Self {
        Self { offset: 0.0, terms: vec![(index, factor)] }
    }
    fn apply<'g>(&self, x: &[Sym<'g>], offset: bool) -> Sym<'g> {
        let start = x[0].constant(if offset { self.offset } else { 0.0 });
        self.terms.iter().fold(start, |sum, &(index, factor)| sum + x[index] * factor)
    }
}

/// The robot seen in a mirror at its x-z plane, so that the leg that was left is the right one.
///
/// Paired joints exchange their values, with the pair's sign. Joints in the middle keep theirs (pitch) or
/// turn it around (roll, yaw). The base:
/// - floating: y of the position changes sign, the orientation x y z w becomes −x y −z w, and of the twist in
///   the root's axes the linear y, the angular x and z change sign. The root's x-z plane must be the robot's
///   plane of symmetry;
/// - planar: stays as it is;
/// - pivot (planar robots): the new pivot angle is the pitch of the other foot, a sum of joint angles, its
///   rate the sum of their rates; the world's origin moves to the new pivot;
/// - fixed: no coordinates; the other foot now stands where this one stood, level.
///
/// Everything is linear, so the rate map equals the position map less its constants. Applied twice it is the
/// identity.
#[derive(Debug, Clone, PartialEq)]
pub struct Relabelling {
    q: Vec<Sum>,
    v: Vec<Sum>,
}

impl Relabelling {
    /// From the description's pairs of joints.
    ///
    /// # Errors
    /// A free root that is not in the plane of symmetry, a pivot of a robot that is not planar, a middle joint
    /// whose axis is skew.
    pub fn new(tree: &Tree, description: &RobotDescription) -> Result<Self, Diagnostic> {
        let (nq0, nv0) = (tree.nq - tree.joints.len(), tree.base_nv());
        let joints: Vec<(usize, f64)> =
            (0..tree.joints.len()).map(|k| partner(tree, description, k)).collect::<Result<_, _>>()?;
        let base = match tree.base {
            BaseKind::Floating => floating(tree, description)?,
            BaseKind::Planar => {
                in_the_middle(tree, description)?;
                [0, 0].map(|_| (0..3).map(|k| Sum::of(k, 1.0)).collect())
            }
            BaseKind::Fixed => [Vec::new(), Vec::new()],
            BaseKind::Pivot => pivot(tree, description)?,
        };
        let [mut q, mut v] = base;
        q.extend(joints.iter().map(|&(k, sign)| Sum::of(nq0 + k, sign)));
        v.extend(joints.iter().map(|&(k, sign)| Sum::of(nv0 + k, sign)));
        Ok(Self { q, v })
    }

    /// R(q).
    pub fn configuration<'g>(&self, q: &[Sym<'g>]) -> Vec<Sym<'g>> {
        self.q.iter().map(|sum| sum.apply(q, true)).collect()
    }

    /// R v, for velocities and accelerations alike.
    pub fn velocity<'g>(&self, v: &[Sym<'g>]) -> Vec<Sym<'g>> {
        self.v.iter().map(|sum| sum.apply(v, false)).collect()
    }
}

/// The joint that takes this one's place, and the sign.
fn partner(tree: &Tree, description: &RobotDescription, joint: usize) -> Result<(usize, f64), Diagnostic> {
    let name = &tree.joints[joint].name;
    match other_side(description, name) {
        Some((other, sign)) => {
            let at = tree.joints.iter().position(|j| j.name == other).ok_or_else(|| {
                Diagnostic::error(format!("symmetry: `{other}`, the partner of `{name}`, does not move"))
            })?;
            Ok((at, sign))
        }
        None => Ok((joint, middle_sign(tree, name)?)),
    }
}

fn other_side<'a>(description: &'a RobotDescription, joint: &str) -> Option<(&'a str, f64)> {
    description.symmetric_joints.iter().find_map(|pair| {
        if pair.left == joint {
            Some((pair.right.as_str(), pair.sign))
        } else if pair.right == joint {
            Some((pair.left.as_str(), pair.sign))
        } else {
            None
        }
    })
}

/// A mirror keeps turns about y and slides in the x-z plane.
fn middle_sign(tree: &Tree, joint: &str) -> Result<f64, Diagnostic> {
    let tree = tree.structure();
    let rotations = zero_rotations(tree);
    let at = tree.bodies.iter().position(|body| body.joint == joint);
    let sideways = |axis: usize| at.map_or(0.0, |k| rotations[k][1][axis].abs());
    let (along_y, other) = match at.map(|k| tree.bodies[k].motion) {
        Some(JointMotion::Revolute { axis, .. }) => (sideways(axis), [1.0, -1.0]),
        Some(JointMotion::Prismatic { axis, .. }) => (sideways(axis), [-1.0, 1.0]),
        _ => (0.0, [1.0, 1.0]),
    };
    if along_y > 1.0 - 1e-9 {
        Ok(other[0])
    } else if along_y < 1e-9 {
        Ok(other[1])
    } else {
        Err(Diagnostic::error(format!(
            "joint `{joint}` has no mirror image: its axis is neither in the plane of symmetry nor across it"
        ))
        .help("name its partner under [symmetry]"))
    }
}

fn floating(tree: &Tree, description: &RobotDescription) -> Result<[Vec<Sum>; 2], Diagnostic> {
    in_the_middle(tree, description)?;
    let mirror = |signs: &[f64]| signs.iter().enumerate().map(|(k, &sign)| Sum::of(k, sign)).collect();
    Ok([mirror(&[1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0]), mirror(&[1.0, -1.0, 1.0, -1.0, 1.0, -1.0])])
}

/// The movable joint that carries the link in the URDF's own tree; fixed joints are passed.
fn carrier<'a>(description: &'a RobotDescription, link: &str) -> Option<&'a str> {
    let joint = description.joints.iter().find(|joint| joint.child == link)?;
    match joint.kind {
        JointKind::Fixed => carrier(description, &joint.parent),
        _ => Some(&joint.name),
    }
}

fn in_the_middle(tree: &Tree, description: &RobotDescription) -> Result<(), Diagnostic> {
    let root = tree.bodies.iter().find(|body| !body.is_virtual).map_or("", |body| &body.name);
    match carrier(description, root).and_then(|joint| other_side(description, joint)) {
        None => Ok(()),
        Some(_) => Err(Diagnostic::error(format!(
            "legs cannot be relabelled while the base stands at `{root}`, which belongs to one side"
        ))
        .help("choose a link in the plane of symmetry, such as the torso, or `kind = \"pivot\"`")),
    }
}

/// Turn of a body about the world's y axis per unit of its joint, when all axes are parallel to y.
fn pitch_sign(body: &Body, rotation: &[[f64; 3]; 3]) -> f64 {
    match body.motion {
        JointMotion::Revolute { axis, reversed } => {
            rotation[1][axis].signum() * if reversed { -1.0 } else { 1.0 }
        }
        _ => 0.0,
    }
}

fn pivot(tree: &Tree, description: &RobotDescription) -> Result<[Vec<Sum>; 2], Diagnostic> {
    if !is_planar(tree) {
        return Err(Diagnostic::error("legs of a pivoting robot can be relabelled only if it is planar")
            .help("in space the new pivot angle is no sum of joint angles: relabel on a floating base"));
    }
    let rotations = zero_rotations(tree);
    let other = other_foot(tree, description)?;
    let own = pitch_sign(&tree.bodies[0], &rotations[0]);
    let mut angle = Sum { offset: own * other.level, terms: Vec::new() };
    let mut rate = Sum { offset: 0.0, terms: Vec::new() };
    for index in tree.path_to_root(other.body) {
        let (body, sign) = (&tree.bodies[index], own * pitch_sign(&tree.bodies[index], &rotations[index]));
        if sign != 0.0 {
            angle.terms.push((body.q_index, sign));
            rate.terms.push((body.v_index, sign));
        }
    }
    Ok([vec![angle], vec![rate]])
}

/// Where the other foot hangs.
struct OtherFoot {
    body: usize,
    /// Its pitch less that of the pivoting foot when all joint positions are zero, rad.
    level: f64,
}

fn other_foot(tree: &Tree, description: &RobotDescription) -> Result<OtherFoot, Diagnostic> {
    let root = tree.bodies[0].name.as_str();
    let partner = description
        .joints
        .iter()
        .find(|joint| joint.child == root)
        .and_then(|joint| other_side(description, &joint.name))
        .and_then(|(name, _)| description.joints.iter().find(|joint| joint.name == name))
        .and_then(|joint| tree.frame(&joint.child));
    let unknown = || {
        Diagnostic::error(format!("the foot `{root}` has no partner on the other side"))
            .help("pair the joint above it under [symmetry]")
    };
    let frame = partner.ok_or_else(unknown)?;
    let body = frame.body.ok_or_else(unknown)?;
    let rotation = zero_rotations(tree)[body];
    let local = frame.placement.rotation.matrix();
    let entry = |c: usize| (0..3).map(|k| rotation[0][k] * local[k][c]).sum::<f64>();
    let level = entry(2).atan2(entry(0));
    Ok(OtherFoot { body, level: if level.abs() < 1e-12 { 0.0 } else { level } })
}
