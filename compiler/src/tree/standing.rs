//! A free robot as its standing foot sees it: the same joints, rooted at the foot instead of the base.
use super::{BaseKind, Body, Inertia, JointMotion, Placement, Rotation, Tree, TreeJoint, matrix_vector};

/// Direction cosines below this are rounding.
const IN_PLANE: f64 = 1e-12;

/// How the root of a free robot moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Trunk {
    /// By a free joint.
    Floating(usize),
    /// By slides along x and z and a turn about y, without rotations between them and without mass on the slides.
    Planar(usize),
}

/// A tree rooted at a foot, and what it has of the tree that it was made from.
#[derive(Debug, Clone)]
pub(crate) struct Standing {
    /// Floating or planar like the other one. Its root's frame lies at the foot's point; a planar one's has the axes of
    /// the world while all angles are zero.
    pub tree: Tree,
    /// By row of `v` of this tree: the row of the same joint in the other one; `None` for the base.
    pub rows: Vec<Option<usize>>,
    /// The same by element of `q`.
    pub coordinates: Vec<Option<usize>>,
    /// The body that was the other tree's trunk.
    pub trunk: usize,
    /// Frame of the other tree's trunk in that body.
    pub trunk_frame: Placement,
    /// Bodies of this tree from its root to the trunk.
    pub leg: Vec<usize>,
    /// Joints between trunk and foot in the other tree, the highest first.
    pub turns: Vec<Turn>,
}

/// How a joint between trunk and foot turns the foot of a planar robot.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turn {
    /// Its row of `v` in the other tree.
    pub row: usize,
    /// Its element of `q` there.
    pub coordinate: usize,
    /// With which its angle counts about the world's y axis while all angles are zero; 0 for slides.
    pub sign: f64,
}

impl Tree {
    /// The body that carries everything and can move freely, if there is one.
    pub(crate) fn trunk(&self) -> Option<Trunk> {
        if self.base == BaseKind::Floating {
            return Some(Trunk::Floating(0));
        }
        let [x, z, turn, ..] = self.bodies.as_slice() else { return None };
        let slides = |body: &Body, parent, axis| {
            let straight = body.placement.rotation.is_identity() && body.parent == parent;
            let along = matches!(body.motion, JointMotion::Prismatic { axis: a, .. } if a == axis);
            straight && along && body.inertia == Inertia::default()
        };
        let turns = matches!(turn.motion, JointMotion::Revolute { axis: 1, .. });
        let straight = turn.placement.rotation.is_identity() && turn.parent == Some(1);
        let alone = self.bodies[3..].iter().all(|body| body.parent.is_some_and(|p| p >= 2));
        let either =
            slides(x, None, 0) && slides(z, Some(0), 2) || slides(x, None, 2) && slides(z, Some(0), 0);
        (either && turns && straight && alone).then_some(Trunk::Planar(2))
    }

    /// The tree rooted at `point` (m, body axes) of the body `foot`, which hangs on the trunk.
    pub(crate) fn standing_on(&self, foot: usize, point: [f64; 3]) -> Option<Standing> {
        let trunk = self.trunk()?;
        let (Trunk::Floating(top) | Trunk::Planar(top)) = trunk;
        let path: Vec<usize> = self.path_to_root(foot).take_while(|&b| b >= top).collect();
        if path.last() != Some(&top) {
            return None;
        }
        let (turns, foot_rotation) = self.turns(&path, matches!(trunk, Trunk::Planar(_)))?;
        // Frames of the bodies of this path, in what were their frames.
        let mut frames = vec![Placement::shift(point)];
        if let Trunk::Planar(_) = trunk {
            frames[0].rotation = foot_rotation.inverse();
        }
        frames.extend(path.iter().take(path.len() - 1).map(|&b| self.bodies[b].placement.clone()));
        let mut builder = Builder::new(self, trunk);
        for (k, (&body, frame)) in path.iter().zip(&frames).enumerate() {
            let below = k.checked_sub(1).map(|k| (path[k], &frames[k]));
            builder.turn_over(body, frame, below);
        }
        for body in (top + 1..self.bodies.len()).filter(|b| !path.contains(b)) {
            builder.carry_over(
                body,
                path.iter().position(|p| Some(*p) == self.bodies[body].parent).map(|k| &frames[k]),
            );
        }
        let leg: Vec<usize> = path.iter().map(|&body| builder.places[body]).collect();
        let frame = frames.last().map(Placement::inverse)?;
        Some(builder.finish(frame, leg, turns))
    }

    /// Of the joints of a path from a foot to the trunk, the trunk's excepted, the highest first; and the foot's constant rotation in
    /// the trunk's axes. `None` where a joint of a planar robot leads out of the plane, be it by the last digits of its axis: then the
    /// foot does not turn about y alone.
    fn turns(&self, path: &[usize], planar: bool) -> Option<(Vec<Turn>, Rotation)> {
        let mut rotation = Rotation::default();
        let mut turns = Vec::new();
        for &index in path.iter().rev().skip(1) {
            let body = &self.bodies[index];
            rotation = rotation.then(&body.placement.rotation);
            let mut along = [0.0; 3];
            if let JointMotion::Revolute { axis, reversed } | JointMotion::Prismatic { axis, reversed } =
                body.motion
            {
                along[axis] = if reversed { -1.0 } else { 1.0 };
            }
            let [x, y, z] = matrix_vector(&rotation.matrix(), along);
            let is_turn = matches!(body.motion, JointMotion::Revolute { .. });
            let off = if is_turn { x.hypot(z) } else { y.abs() };
            if planar && off > IN_PLANE {
                return None;
            }
            let sign = if is_turn { y.round() } else { 0.0 };
            turns.push(Turn { row: body.v_index, coordinate: body.q_index, sign });
        }
        Some((turns, rotation))
    }
}

struct Builder<'t> {
    old: &'t Tree,
    bodies: Vec<Body>,
    joints: Vec<TreeJoint>,
    rows: Vec<Option<usize>>,
    coordinates: Vec<Option<usize>>,
    /// By body of the old tree: where it went.
    places: Vec<usize>,
}

impl<'t> Builder<'t> {
    /// With what carries the root of a planar tree.
    fn new(old: &'t Tree, trunk: Trunk) -> Self {
        let mut this = Self {
            old,
            bodies: Vec::new(),
            joints: Vec::new(),
            rows: Vec::new(),
            coordinates: Vec::new(),
            places: vec![0; old.bodies.len()],
        };
        if let Trunk::Planar(_) = trunk {
            for (axis, name) in [(0, "base/x"), (2, "base/z")] {
                let motion = JointMotion::Prismatic { axis, reversed: false };
                this.push(Body { is_virtual: true, ..this.body(name, motion) }, None);
            }
        }
        this
    }

    /// A body without mass that hangs on the last one.
    fn body(&self, joint: &str, motion: JointMotion) -> Body {
        Body {
            name: joint.to_owned(),
            parent: self.bodies.len().checked_sub(1),
            joint: joint.to_owned(),
            motion,
            placement: Placement::default(),
            q_index: 0,
            v_index: 0,
            inertia: Inertia::default(),
            main_link: Placement::default(),
            is_virtual: false,
        }
    }

    /// Adds a body; `like` is the one whose joint moves it in the old tree.
    fn push(&mut self, mut body: Body, like: Option<&Body>) {
        (body.q_index, body.v_index) = (self.coordinates.len(), self.rows.len());
        if let Some(like) = like {
            let known = self.old.joints.iter().find(|joint| joint.v_index == like.v_index);
            self.joints.extend(known.map(|joint| TreeJoint { v_index: body.v_index, ..joint.clone() }));
        }
        self.coordinates.extend((0..body.motion.nq()).map(|k| like.map(|like| like.q_index + k)));
        self.rows.extend((0..body.motion.nv()).map(|k| like.map(|like| like.v_index + k)));
        self.bodies.push(body);
    }

    /// A body between foot and trunk, whose new frame stands at `frame` in its old one: it hangs on the body `below` now, by that
    /// one's joint turned about.
    fn turn_over(&mut self, index: usize, frame: &Placement, below: Option<(usize, &Placement)>) {
        let own = &self.old.bodies[index];
        let back = frame.inverse();
        let mut body = match below {
            None if self.old.base == BaseKind::Floating => self.body("base", JointMotion::Free),
            None => self.body("base/pitch", JointMotion::Revolute { axis: 1, reversed: false }),
            Some((child, at)) => {
                let joint = &self.old.bodies[child];
                let motion = match joint.motion {
                    JointMotion::Revolute { axis, reversed } => {
                        JointMotion::Revolute { axis, reversed: !reversed }
                    }
                    JointMotion::Prismatic { axis, reversed } => {
                        JointMotion::Prismatic { axis, reversed: !reversed }
                    }
                    JointMotion::Free => JointMotion::Free,
                };
                Body { placement: at.inverse(), ..self.body(&joint.joint, motion) }
            }
        };
        body.name.clone_from(&own.name);
        body.inertia = own.inertia.transformed(&back);
        body.main_link = back.then(&own.main_link);
        self.places[index] = self.bodies.len();
        self.push(body, below.map(|(child, _)| &self.old.bodies[child]));
    }

    /// A body off that path; `frame` is the new frame of its parent in the old one, where that lies on the path.
    fn carry_over(&mut self, index: usize, frame: Option<&Placement>) {
        let own = &self.old.bodies[index];
        let placement =
            frame.map_or_else(|| own.placement.clone(), |frame| frame.inverse().then(&own.placement));
        let parent = own.parent.map(|parent| self.places[parent]);
        self.places[index] = self.bodies.len();
        self.push(Body { parent, placement, ..own.clone() }, Some(own));
    }

    fn finish(self, trunk_frame: Placement, leg: Vec<usize>, turns: Vec<Turn>) -> Standing {
        let old = self.old;
        let floating = old.base == BaseKind::Floating;
        let tree = Tree {
            name: old.name.clone(),
            base: if floating { BaseKind::Floating } else { BaseKind::Planar },
            bodies: self.bodies,
            links: Vec::new(),
            points: Vec::new(),
            joints: self.joints,
            gravity: old.gravity,
            nq: self.coordinates.len(),
            nv: self.rows.len(),
            nearly_right_angles: Vec::new(),
            right_angled: None,
        };
        let trunk = leg.last().copied().unwrap_or(0);
        Standing { tree, rows: self.rows, coordinates: self.coordinates, trunk, trunk_frame, leg, turns }
    }
}
