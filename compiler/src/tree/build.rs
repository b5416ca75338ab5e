//! From a description to a tree rooted where the base says.
use super::placement::NEARLY_RIGHT;
use super::{BaseKind, Body, Frame, Inertia, JointMotion, Placement, Rotation, Tree, TreeJoint};
use crate::description::model::{Base, Foot, Joint, JointKind, Pose, RobotDescription};
use bipedc_effects::diagnostic::Diagnostic;
use std::collections::{HashMap, HashSet, VecDeque};

type Result<T> = std::result::Result<T, Diagnostic>;

fn placement(pose: &Pose) -> Placement {
    Placement { rotation: Rotation::from_rpy(pose.rpy), translation: pose.xyz }
}

/// The frame turned so that the joint axis is a coordinate axis: (turn, axis, against the axis).
fn aligned(axis: [f64; 3]) -> (Rotation, usize, bool) {
    for k in 0..3 {
        let others = axis[(k + 1) % 3].hypot(axis[(k + 2) % 3]);
        if others < 1e-12 {
            return (Rotation::default(), k, axis[k] < 0.0);
        }
        // The same coordinate axis as in the structure, so that frames differ by as little as the digits do.
        if others < NEARLY_RIGHT {
            let against = axis[k] < 0.0;
            return (Rotation::near(k, axis.map(|x| if against { -x } else { x })), k, against);
        }
    }
    (Rotation::z_onto(axis), 2, false)
}

/// What the chosen base means for the tree.
struct Root {
    link: String,
    /// Frame of the root body in the root link.
    in_link: Placement,
    kind: BaseKind,
    pivot_axis: [f64; 3],
}

struct Builder<'a> {
    description: &'a RobotDescription,
    bodies: Vec<Body>,
    links: HashMap<&'a str, (Option<usize>, Placement)>,
    v_index: HashMap<&'a str, usize>,
    base: (usize, usize),
}

impl Tree {
    /// The tree of `description` on `base` (usually `description.base`).
    ///
    /// # Errors
    /// A base that names no link, contact point or edge of the robot.
    pub fn new(description: &RobotDescription, base: &Base) -> Result<Self> {
        let description = &super::effects::as_built(description);
        Self::as_written(description, base)?.with_structure(description, base)
    }

    /// The tree of the description's digits.
    pub(super) fn as_written(description: &RobotDescription, base: &Base) -> Result<Self> {
        let root = find_root(description, base)?;
        let movable: Vec<&Joint> =
            description.joints.iter().filter(|joint| joint.kind != JointKind::Fixed).collect();
        let (nq0, nv0) = (root.kind.nq(), root.kind.nv());
        let mut builder = Builder {
            description,
            bodies: Vec::new(),
            links: HashMap::new(),
            v_index: movable.iter().enumerate().map(|(i, joint)| (joint.name.as_str(), i)).collect(),
            base: (nq0, nv0),
        };
        builder.place_root(&root);
        builder.spread(&root.link);
        builder.lump();
        Ok(builder.finish(&root, &movable, (nq0 + movable.len(), nv0 + movable.len())))
    }
}

fn find_root(description: &RobotDescription, base: &Base) -> Result<Root> {
    let root = |name: &str, kind, pivot_axis| -> Result<Root> {
        let (link, in_link) = find_frame(description, name)?;
        Ok(Root { link, in_link, kind, pivot_axis })
    };
    match base {
        Base::Floating { root: name } => root(name, BaseKind::Floating, [0.0; 3]),
        Base::Planar { root: name } => root(name, BaseKind::Planar, [0.0; 3]),
        Base::Fixed { link } => root(link, BaseKind::Fixed, [0.0; 3]),
        Base::Pivot { about } => match find_edge(description, about) {
            Some((link, origin, axis)) => {
                Ok(Root { link, in_link: Placement::shift(origin), kind: BaseKind::Pivot, pivot_axis: axis })
            }
            None => root(about, BaseKind::Pivot, [0.0, 1.0, 0.0]),
        },
    }
}

/// Link and placement of a link, contact point `foot/point`, or foot.
fn find_frame(description: &RobotDescription, name: &str) -> Result<(String, Placement)> {
    if description.links.iter().any(|link| link.name == name) {
        return Ok((name.to_owned(), Placement::default()));
    }
    for foot in &description.feet {
        if foot.name == name {
            return Ok((foot.link.clone(), Placement::default()));
        }
        if let Some(point) = foot.points.iter().find(|point| is_part(foot, &point.name, name)) {
            return Ok((foot.link.clone(), Placement::shift(point.position)));
        }
    }
    let points =
        description.feet.iter().flat_map(|f| f.points.iter().map(|p| format!("{}/{}", f.name, p.name)));
    let known: Vec<String> = description.links.iter().map(|l| l.name.clone()).chain(points).collect();
    Err(Diagnostic::error(format!(
        "`{name}` is neither a link nor a contact point of `{}`",
        description.name
    ))
    .help(format!("known are: {}", known.join(", "))))
}

fn is_part(foot: &Foot, part: &str, name: &str) -> bool {
    name.strip_prefix(&foot.name).and_then(|rest| rest.strip_prefix('/')) == Some(part)
}

/// Link, a point on the edge and its unit direction, in the link frame.
fn find_edge(description: &RobotDescription, name: &str) -> Option<(String, [f64; 3], [f64; 3])> {
    for foot in &description.feet {
        let Some(edge) = foot.edges.iter().find(|edge| is_part(foot, &edge.name, name)) else { continue };
        let point = |k: usize| foot.points.iter().find(|p| p.name == edge.points[k]).map(|p| p.position);
        let (left, right) = (point(0)?, point(1)?);
        let d = [0, 1, 2].map(|i| left[i] - right[i]);
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        let middle = [0, 1, 2].map(|i| 0.5 * (left[i] + right[i]));
        return (length > 0.0).then(|| (foot.link.clone(), middle, d.map(|x| x / length)));
    }
    None
}

impl<'a> Builder<'a> {
    fn push(
        &mut self,
        name: &str,
        parent: Option<usize>,
        joint: &str,
        motion: JointMotion,
        at: Placement,
    ) -> usize {
        self.bodies.push(Body {
            name: name.to_owned(),
            parent,
            joint: joint.to_owned(),
            motion,
            placement: at,
            q_index: 0,
            v_index: 0,
            inertia: Inertia::default(),
            main_link: Placement::default(),
            is_virtual: false,
        });
        self.bodies.len() - 1
    }

    fn place_root(&mut self, root: &Root) {
        let link = self.link_key(&root.link);
        let inverse = root.in_link.inverse();
        let here = Placement::default;
        let (body, in_body) = match root.kind {
            BaseKind::Fixed => (None, inverse),
            BaseKind::Floating => (Some(self.push(link, None, "base", JointMotion::Free, here())), inverse),
            BaseKind::Planar => {
                let along = |axis| JointMotion::Prismatic { axis, reversed: false };
                let x = self.push("base/x", None, "base/x", along(0), here());
                let z = self.push("base/z", Some(x), "base/z", along(2), here());
                self.bodies[x].is_virtual = true;
                self.bodies[z].is_virtual = true;
                self.bodies[z].q_index = 1;
                let pitch = JointMotion::Revolute { axis: 1, reversed: false };
                let body = self.push(link, Some(z), "base/pitch", pitch, here());
                self.bodies[body].q_index = 2;
                (Some(body), inverse)
            }
            BaseKind::Pivot => {
                let (turn, axis, reversed) = aligned(root.pivot_axis);
                let at = Placement { rotation: turn, translation: [0.0; 3] };
                let back = at.inverse().then(&inverse);
                (
                    Some(self.push(link, None, "base/pivot", JointMotion::Revolute { axis, reversed }, at)),
                    back,
                )
            }
        };
        for body in &mut self.bodies {
            body.v_index = body.q_index;
        }
        self.links.insert(link, (body, in_body));
    }

    fn link_key(&self, name: &str) -> &'a str {
        self.description.links.iter().map(|l| l.name.as_str()).find(|l| *l == name).unwrap_or("")
    }

    /// Breadth first over the joints, in both directions: parents come before their children.
    fn spread(&mut self, root: &str) {
        let mut queue = VecDeque::from([self.link_key(root)]);
        let mut used: HashSet<&str> = HashSet::new();
        while let Some(link) = queue.pop_front() {
            let description = self.description;
            for joint in &description.joints {
                let forward = joint.parent == link;
                if (forward || joint.child == link) && used.insert(&joint.name) {
                    let other = if forward { &joint.child } else { &joint.parent };
                    self.attach(joint, link, other, forward);
                    queue.push_back(other);
                }
            }
        }
    }

    fn attach(&mut self, joint: &'a Joint, near: &str, far: &'a str, forward: bool) {
        let (body, near_in_body) = self.links[near].clone();
        let origin = placement(&joint.origin);
        if joint.kind == JointKind::Fixed {
            let step = if forward { origin } else { origin.inverse() };
            self.links.insert(far, (body, near_in_body.then(&step)));
            return;
        }
        let (turn, axis, against) = aligned(joint.axis);
        let turn = Placement { rotation: turn, translation: [0.0; 3] };
        // Backwards the far link is the joint's parent: it moves by the opposite amount, about the same axis.
        let (at, far_in_body) = if forward {
            (near_in_body.then(&origin).then(&turn), turn.inverse())
        } else {
            (near_in_body.then(&turn), origin.then(&turn).inverse())
        };
        let reversed = against == forward;
        let motion = match joint.kind {
            JointKind::Prismatic => JointMotion::Prismatic { axis, reversed },
            _ => JointMotion::Revolute { axis, reversed },
        };
        let index = self.push(far, body, &joint.name, motion, at);
        self.bodies[index].q_index = self.base.0 + self.v_index[joint.name.as_str()];
        self.bodies[index].v_index = self.base.1 + self.v_index[joint.name.as_str()];
        self.links.insert(far, (Some(index), far_in_body));
    }

    /// Adds every link's inertia to its body and finds the main links.
    fn lump(&mut self) {
        let rigid: HashSet<&str> = self
            .description
            .joints
            .iter()
            .filter(|joint| joint.kind == JointKind::Fixed)
            .map(|joint| joint.child.as_str())
            .collect();
        for link in &self.description.links {
            let Some((Some(body), at)) = self.links.get(link.name.as_str()) else { continue };
            let body = &mut self.bodies[*body];
            if let Some(inertial) = &link.inertial {
                body.inertia = body.inertia.plus(&Inertia::from_inertial(inertial).transformed(at));
            }
            // Of the links of one body exactly one hangs on no fixed joint: the nearest to the URDF's root.
            if !rigid.contains(link.name.as_str()) {
                body.name.clone_from(&link.name);
                body.main_link = at.clone();
            }
        }
    }

    fn finish(self, root: &Root, movable: &[&Joint], (nq, nv): (usize, usize)) -> Tree {
        let description = self.description;
        let frame = |name: String, link: &str, offset: [f64; 3]| {
            let (body, at) = &self.links[link];
            Frame { name, body: *body, placement: at.then(&Placement::shift(offset)) }
        };
        let points = description.feet.iter().flat_map(|foot| {
            foot.points.iter().map(|p| frame(format!("{}/{}", foot.name, p.name), &foot.link, p.position))
        });
        Tree {
            name: description.name.clone(),
            base: root.kind,
            links: description.links.iter().map(|l| frame(l.name.clone(), &l.name, [0.0; 3])).collect(),
            points: points.collect(),
            joints: movable
                .iter()
                .map(|joint| TreeJoint {
                    name: joint.name.clone(),
                    v_index: self.base.1 + self.v_index[joint.name.as_str()],
                    prismatic: joint.kind == JointKind::Prismatic,
                    actuated: description.actuated_joints.contains(&joint.name),
                })
                .collect(),
            gravity: description.gravity,
            nq,
            nv,
            nearly_right_angles: Vec::new(),
            right_angled: None,
            bodies: self.bodies,
        }
    }
}
