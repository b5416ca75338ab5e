//! How the generalised forces answer to changes of single coordinates: the common recursion behind
//! derivatives and the Coriolis matrix.
//!
//! Singh, Russell and Wensing, "Efficient analytical derivatives of rigid-body dynamics using spatial vector
//! algebra" (2022), rewritten for barycentric parameters. Turning a joint changes the motion of all that
//! hangs on it like a change of the base of that subtree: by an acceleration, an angular acceleration and
//! an angular velocity. The sums Σ m, Σ m r, Σ m r rᵀ, Σ m v, Σ m v rᵀ of the subtree answer to it; a force
//! on the way to the root is carried by three vectors, all in the axes before each joint.
mod absolute;
pub(super) mod articulated;
pub(super) mod axes;
mod carried;
mod motion;
pub(super) mod pinned;
mod second;
mod subtree;

use super::RobotModel;
use crate::expression::{Sym, Vector3};
use crate::tree::JointMotion;
pub(super) use axes::Axes;
use bipedc_runtime::Argument;
use motion::Link;
pub(super) use subtree::Wrench;
use subtree::{Change, Moments, Subtree};

/// Motions and subtree sums of one robot under given accelerations.
pub(super) struct Sensitivity<'m, 'g, 't> {
    pub(super) model: &'m RobotModel<'g, 't>,
    axes: Vec<Axes<'g>>,
    /// Of single bodies, in their own axes.
    moments: Vec<Moments<'g>>,
    links: Vec<Link<'g>>,
    /// Of single bodies: in their own axes where children hang on those, else in the joint axes.
    single: Vec<Wrench<'g>>,
    /// Without the children that have absolute angles, in joint axes.
    cores: Vec<Sums<'g>>,
    /// In joint axes.
    subtrees: Vec<Subtree<'g>>,
    /// In joint axes.
    wrenches: Vec<Wrench<'g>>,
    factor: f64,
    external: Option<External<'g>>,
}

/// A wrench that acts on a body from outside, about its origin.
#[derive(Clone, Copy)]
pub(super) struct External<'g> {
    pub body: usize,
    /// In its own axes.
    pub own: Wrench<'g>,
    /// In its joint axes.
    pub joint: Wrench<'g>,
}

/// Sums over a subtree and the wrench that it needs.
type Sums<'g> = (Subtree<'g>, Wrench<'g>);

fn less<'g>(wrench: Wrench<'g>, other: Option<Wrench<'g>>) -> Wrench<'g> {
    other.map_or(wrench, |other| (wrench.0 - other.0, wrench.1 - other.1))
}

/// What the children of a body add to its sums.
#[derive(Clone, Default)]
struct Carried<'g> {
    /// In its own axes.
    own: Option<Sums<'g>>,
    /// In its joint axes, turning with it.
    beside: Option<Sums<'g>>,
    /// In its joint axes, with an absolute angle of their own.
    parallel: Option<Sums<'g>>,
}

fn add<'g>(sum: &mut Sums<'g>, other: Option<&Sums<'g>>) {
    if let Some((subtree, wrench)) = other {
        sum.0 = sum.0.plus(subtree);
        sum.1 = (sum.1.0 + wrench.0, sum.1.1 + wrench.1);
    }
}

/// Which changes a matrix is asked for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Column {
    /// Of the configuration, in its tangent space.
    Position,
    /// Of the velocity.
    Velocity,
    /// Rate of the unit velocity: `J̇` instead of the derivative of `J̇ v`.
    UnitRate,
}

impl<'m, 'g, 't> Sensitivity<'m, 'g, 't> {
    /// Prepares the sums. `factor` is 2 for derivatives (both velocities of a Coriolis term change) and 1 for
    /// [`Column::UnitRate`].
    pub fn new(model: &'m RobotModel<'g, 't>, accelerations: &[Sym<'g>], gravity: bool, factor: f64) -> Self {
        Self::pushed(model, accelerations, gravity, factor, |_| None)
    }

    /// The same while a body is pushed from outside: [`Self::forces`] and wrenches are what is needed besides.
    pub fn pushed(
        model: &'m RobotModel<'g, 't>,
        accelerations: &[Sym<'g>],
        gravity: bool,
        factor: f64,
        push: impl Fn(&[Axes<'g>]) -> Option<External<'g>>,
    ) -> Self {
        let axes = axes::choose(model);
        let links = motion::forward(model, &axes, accelerations, gravity);
        let moments = subtree::moments(model);
        let external = push(&axes);
        let (single, cores, subtrees, wrenches) = Default::default();
        let mut this =
            Self { model, axes, moments, links, single, cores, subtrees, wrenches, factor, external };
        this.sum();
        this
    }

    /// What pushes a body: in its own axes, and in its joint axes.
    fn external(&self, body: usize) -> Option<&External<'g>> {
        self.external.as_ref().filter(|external| external.body == body)
    }

    /// Sums from the leaves to the root. Bodies that carry something in their own axes are summed there
    /// and turned once; the others are turned alone.
    fn sum(&mut self) {
        let bodies = &self.model.tree.bodies;
        let mut carried = vec![Carried::default(); bodies.len()];
        for index in (0..bodies.len()).rev() {
            let _work = self.model.work(index, "sums of what it carries");
            let (single, mut all) = self.body(index, carried[index].own.as_ref());
            add(&mut all, carried[index].beside.as_ref());
            self.single.push(single);
            self.cores.push(all);
            add(&mut all, carried[index].parallel.as_ref());
            if let Some(parent) = bodies[index].parent {
                let moved = self.in_hub(index, &all);
                let place = match (self.axes[index].joined, self.absolute_parent(index)) {
                    (false, _) => &mut carried[parent].own,
                    (true, None) => &mut carried[parent].beside,
                    (true, Some(_)) => &mut carried[parent].parallel,
                };
                match place {
                    Some(sum) => add(sum, Some(&moved)),
                    None => *place = Some(moved),
                }
            }
            self.subtrees.push(all.0);
            self.wrenches.push(all.1);
        }
        self.single.reverse();
        self.cores.reverse();
        self.subtrees.reverse();
        self.wrenches.reverse();
    }

    /// A body's own wrench, and in the joint axes its sums with what it carries in its own axes.
    fn body(&self, index: usize, carried: Option<&Sums<'g>>) -> (Wrench<'g>, Sums<'g>) {
        let (turned, link, moments) = (self.axes[index], &self.links[index], &self.moments[index]);
        if let Some((subtree, wrench)) = carried {
            let single = less(subtree::rigid_wrench(moments, &link.own), self.external(index).map(|e| e.own));
            let sum = subtree.plus(&Subtree::rigid(*moments, link.own.w, self.factor));
            let wrench = (turned.out(single.0 + wrench.0), turned.out(single.1 + wrench.1));
            return (single, (sum.turned(turned.turn), wrench));
        }
        let moments = moments.turned(turned.turn);
        let single =
            less(subtree::rigid_wrench(&moments, &link.joint), self.external(index).map(|e| e.joint));
        (single, (Subtree::rigid(moments, link.joint.w, self.factor), single))
    }

    /// Sums of a body about its parent's origin.
    fn in_hub(
        &self,
        index: usize,
        (subtree, wrench): &(Subtree<'g>, Wrench<'g>),
    ) -> (Subtree<'g>, Wrench<'g>) {
        let link = &self.links[index];
        let velocity = link.arm_velocity.scale(self.model.constant(self.factor));
        let mut moved = *subtree;
        if !self.axes[index].joined {
            moved =
                moved.turned_constant(self.model.graph, &self.model.tree.bodies[index].placement.rotation);
        }
        let (force, moment) = (self.placed(index, wrench.0), self.placed(index, wrench.1));
        (moved.shifted(link.arm, velocity), (force, moment + link.arm.cross(force)))
    }

    /// From the joint axes of a body to the axes of its parent in which its arm is given.
    fn placed(&self, index: usize, x: Vector3<'g>) -> Vector3<'g> {
        if self.axes[index].joined {
            return x;
        }
        self.model.placed(&self.model.tree.bodies[index].placement, x)
    }

    /// From the axes of the arm to the parent's joint axes.
    fn outward(&self, index: usize, parent: usize, x: Vector3<'g>) -> Vector3<'g> {
        if self.axes[index].joined { x } else { self.axes[parent].out(x) }
    }

    fn lift(&self, index: usize, parent: usize, (force, moment): Wrench<'g>) -> Wrench<'g> {
        let (force, moment) = (self.placed(index, force), self.placed(index, moment));
        let moment = moment + self.links[index].arm.cross(force);
        (self.outward(index, parent, force), self.outward(index, parent, moment))
    }

    fn lift_functional(&self, index: usize, parent: usize, row: [Vector3<'g>; 3]) -> [Vector3<'g>; 3] {
        let link = &self.links[index];
        let velocity = link.arm_velocity.scale(self.model.constant(self.factor));
        let [force, moment, spin] = row.map(|x| self.placed(index, x));
        let moved = [force, moment + link.arm.cross(force), spin + velocity.cross(force)];
        moved.map(|x| self.outward(index, parent, x))
    }

    /// Rows of `v` that belong to the body and what the wrench does on them.
    fn projections(&self, index: usize, (force, moment): Wrench<'g>) -> Vec<(usize, Sym<'g>)> {
        let body = &self.model.tree.bodies[index];
        let signed = |x| self.model.signed(index, x);
        match body.motion {
            JointMotion::Free => {
                force.0.into_iter().chain(moment.0).enumerate().map(|(k, x)| (body.v_index + k, x)).collect()
            }
            JointMotion::Revolute { axis, .. } => vec![(body.v_index, signed(moment[axis]))],
            JointMotion::Prismatic { axis, .. } => vec![(body.v_index, signed(force[axis]))],
        }
    }

    /// Generalised forces that the motion needs.
    pub fn forces(&self) -> Vec<Sym<'g>> {
        let mut out = vec![self.model.constant(0.0); self.model.tree.nv];
        for index in 0..self.links.len() {
            for (row, x) in self.projections(index, self.wrenches[index]) {
                out[row] = x;
            }
        }
        out
    }

    fn still(&self) -> Change<'g> {
        let zero = self.model.zero3();
        Change { acceleration: zero, angular: zero, spin: zero, carried: (zero, zero) }
    }

    /// Unit accelerations of the body's degrees of freedom.
    fn units(&self, index: usize) -> Vec<Change<'g>> {
        let axes = [0, 1, 2].map(|k| self.model.along(k, self.model.constant(1.0)));
        let linear = |acceleration| Change { acceleration, ..self.still() };
        let angular = |angular| Change { angular, ..self.still() };
        match self.model.tree.bodies[index].motion {
            JointMotion::Free => axes.map(linear).into_iter().chain(axes.map(angular)).collect(),
            JointMotion::Revolute { .. } => vec![angular(self.model.joint_axis(index))],
            JointMotion::Prismatic { .. } => vec![linear(self.model.joint_axis(index))],
        }
    }

    /// Mass matrix, all entries.
    pub fn mass_matrix(&self) -> Vec<Vec<Sym<'g>>> {
        let nv = self.model.tree.nv;
        let mut d = vec![vec![self.model.constant(0.0); nv]; nv];
        for index in 0..self.links.len() {
            let _work = self.model.work(index, "mass matrix");
            for (k, change) in self.units(index).iter().enumerate() {
                let column = self.model.tree.bodies[index].v_index + k;
                self.walk(index, self.subtrees[index].response(change), |_, row, x| {
                    d[row][column] = x;
                    d[column][row] = x;
                });
            }
        }
        d
    }

    /// Calls `entry` with body, row and force for all rows between `index` and the root.
    fn walk(&self, index: usize, wrench: Wrench<'g>, mut entry: impl FnMut(usize, usize, Sym<'g>)) {
        let (mut at, mut wrench) = (index, wrench);
        loop {
            for (row, x) in self.projections(at, wrench) {
                entry(at, row, x);
            }
            let Some(parent) = self.model.tree.bodies[at].parent else { return };
            wrench = self.lift(at, parent, wrench);
            at = parent;
        }
    }

    /// Derivatives of the generalised forces (rows) by the coordinates (columns).
    pub fn matrix(&self, column: Column) -> Vec<Vec<Sym<'g>>> {
        let tree = self.model.tree;
        let changes: Vec<Vec<Change<'g>>> =
            (0..tree.bodies.len()).map(|index| self.changes(index, column)).collect();
        let mut out = vec![vec![self.model.constant(0.0); tree.nv]; tree.nv];
        for (index, body) in tree.bodies.iter().enumerate() {
            let _work = self.model.work(index, "answer of the forces to its motion");
            for (k, change) in changes[index].iter().enumerate() {
                let wrench = self.subtrees[index].response(change);
                self.walk(index, wrench, |_, row, x| out[row][body.v_index + k] = x);
            }
            if body.motion == JointMotion::Free {
                continue;
            }
            let mut row = self.subtrees[index].functional(body.motion, self.model.joint_axis(index));
            let mut at = index;
            while let Some(parent) = tree.bodies[at].parent {
                row = self.lift_functional(at, parent, row);
                for (k, c) in changes[parent].iter().enumerate() {
                    let x = row[0].dot(c.acceleration) + row[1].dot(c.angular) + row[2].dot(c.spin);
                    out[body.v_index][tree.bodies[parent].v_index + k] = x;
                }
                at = parent;
            }
        }
        out
    }

    /// One change per degree of freedom of the body.
    fn changes(&self, index: usize, column: Column) -> Vec<Change<'g>> {
        let model = self.model;
        let _work = model.work(index, "change of its motion");
        if model.tree.bodies[index].motion == JointMotion::Free {
            return self.free_changes(index, column);
        }
        let (axis, motion) = (model.joint_axis(index), &self.links[index].joint);
        let mut change = self.still();
        let (force, moment) = self.wrenches[index];
        let across = motion.w.cross(axis);
        let revolute = matches!(model.tree.bodies[index].motion, JointMotion::Revolute { .. });
        match (column, revolute) {
            (Column::Position, true) => {
                change.acceleration = motion.a.cross(axis);
                change.angular = motion.u * axis;
                change.spin = across;
                change.carried = (axis.cross(force), axis.cross(moment));
            }
            (Column::Position, false) => {
                change.acceleration = motion.u * axis;
                change.carried.1 = axis.cross(force);
            }
            (_, true) => {
                change.angular = across.scale(model.constant(self.factor));
                change.spin = axis;
            }
            (_, false) => change.acceleration = across.scale(model.constant(self.factor)),
        }
        vec![change]
    }

    /// A free root: displacements and twist in its own axes.
    fn free_changes(&self, index: usize, column: Column) -> Vec<Change<'g>> {
        let model = self.model;
        let still = self.still();
        let first = model.tree.bodies[index].v_index;
        let w = self.links[index].joint.w;
        let v = model.input3(Argument::V, first);
        let up = -model.down(index, model.gravity());
        let axes = [0, 1, 2].map(|k| model.along(k, model.constant(1.0)));
        let linear = axes.map(|e| match column {
            Column::Position => still,
            _ => Change { acceleration: w.cross(e), ..still },
        });
        let angular = axes.map(|e| match column {
            Column::Position => Change { acceleration: up.cross(e), ..still },
            Column::Velocity => Change { acceleration: e.cross(v), angular: w.cross(e), spin: e, ..still },
            Column::UnitRate => Change { angular: w.cross(e), spin: e, ..still },
        });
        linear.into_iter().chain(angular).collect()
    }

    /// Columns of `D⁻¹` [`Self::matrix`] that need no solving: turning a free root changes gravity only, and its
    /// linear velocity enters by ω × v only; both are accelerations of the root.
    pub fn known_accelerations(&self, column: Column) -> Vec<(usize, Vec<Sym<'g>>)> {
        let mut out = Vec::new();
        for (index, body) in self.model.tree.bodies.iter().enumerate() {
            if body.motion != JointMotion::Free {
                continue;
            }
            let first = if column == Column::Position { 3 } else { 0 };
            let changes = self.free_changes(index, column);
            for (k, change) in changes.iter().enumerate().skip(first).take(3) {
                let mut known = vec![self.model.constant(0.0); self.model.tree.nv];
                known[body.v_index..body.v_index + 3].copy_from_slice(&change.acceleration.0);
                out.push((body.v_index + k, known));
            }
        }
        out
    }
}
