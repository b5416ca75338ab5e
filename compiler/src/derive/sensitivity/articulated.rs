//! Articulated-body inertias in the joint axes.
use super::Sensitivity;
use super::second::turn_matrix;
use super::subtree::{Moments, Wrench};
use crate::derive::RobotModel;
use crate::expression::{Matrix3, Sym, Vector3};
use crate::tree::{JointMotion, Rotation};

/// Force `A a + Bᵀ α` and moment `B a + C α` that an acceleration needs; about a body's origin.
#[derive(Clone, Copy)]
struct Articulated<'g> {
    a: Matrix3<'g>,
    b: Matrix3<'g>,
    c: Matrix3<'g>,
}

/// What is left of a body's joint after its elimination.
#[derive(Clone, Copy)]
pub(super) struct Pivot<'g> {
    /// One over what resists the joint.
    pub inverse: Sym<'g>,
    /// Force and moment per acceleration of it.
    pub force: Vector3<'g>,
    pub moment: Vector3<'g>,
}

impl<'g> Pivot<'g> {
    /// A wrench of the body as it goes past the free joint, which lacks so much force.
    pub fn pass(&self, rest: Sym<'g>, (force, moment): Wrench<'g>) -> Wrench<'g> {
        let share = rest * self.inverse;
        (force + self.force.scale(share), moment + self.moment.scale(share))
    }
}

impl<'g> Articulated<'g> {
    fn rigid(m: &Moments<'g>) -> Self {
        let mut a = m.first.skew().map(Sym::zero);
        for k in 0..3 {
            a[(k, k)] = m.mass;
        }
        Self { a, b: m.first.skew(), c: m.second.complement() }
    }

    /// Element of the 6 × 6 matrix, forces and linear accelerations first.
    fn entry(&self, r: usize, c: usize) -> Sym<'g> {
        match (r < 3, c < 3) {
            (true, true) => self.a[(r, c)],
            (false, true) => self.b[(r - 3, c)],
            (true, false) => self.b[(c - 3, r)],
            (false, false) => self.c[(r - 3, c - 3)],
        }
    }

    fn plus(&self, other: &Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }

    fn turned(&self, turn: (usize, Sym<'g>, Sym<'g>)) -> Self {
        Self { a: turn_matrix(turn, &self.a), b: turn_matrix(turn, &self.b), c: turn_matrix(turn, &self.c) }
    }

    fn turned_constant(&self, model: &RobotModel<'g, '_>, rotation: &Rotation) -> Self {
        rotation.0.iter().rev().fold(*self, |body, &(axis, angle)| {
            let angle = model.constant(angle);
            body.turned((axis, angle.sin(), angle.cos()))
        })
    }

    /// About an origin from which the present one is at `p`.
    fn shifted(&self, p: Vector3<'g>) -> Self {
        if p.is_zero() {
            return *self;
        }
        let cross = p.skew();
        let b = self.b + cross * self.a;
        let c = self.c - self.b * cross + cross * b.transpose();
        let mut symmetric = c;
        for r in 0..3 {
            for k in 0..r {
                symmetric[(r, k)] = c[(k, r)];
            }
        }
        Self { a: self.a, b, c: symmetric }
    }

    /// Frees the joint.
    fn released(&self, motion: JointMotion) -> (Self, Pivot<'g>) {
        let (force, moment, d) = match motion {
            JointMotion::Revolute { axis, .. } => {
                (self.b.row(axis), self.c.column(axis), self.c[(axis, axis)])
            }
            JointMotion::Prismatic { axis, .. } => {
                (self.a.row(axis), self.b.column(axis), self.a[(axis, axis)])
            }
            JointMotion::Free => unreachable!("a free root is solved as a whole"),
        };
        let inverse = d.constant(1.0) / d;
        let (f, n) = (force.scale(inverse), moment.scale(inverse));
        let rank_one =
            |x: Vector3<'g>, y: Vector3<'g>| Matrix3([0, 1, 2].map(|r| [0, 1, 2].map(|c| x[r] * y[c])));
        let symmetric = |x: Vector3<'g>, y: Vector3<'g>| {
            let m = rank_one(x, y);
            Matrix3([0, 1, 2].map(|r: usize| [0, 1, 2].map(|c: usize| m[(r.min(c), r.max(c))])))
        };
        let mut out = Self {
            a: self.a - symmetric(f, force),
            b: self.b - rank_one(moment, f),
            c: self.c - symmetric(n, moment),
        };
        let zero = d.zero();
        // Along the joint nothing resists any more.
        for k in 0..3 {
            match motion {
                JointMotion::Revolute { axis, .. } => {
                    out.b[(axis, k)] = zero;
                    out.c[(axis, k)] = zero;
                    out.c[(k, axis)] = zero;
                }
                JointMotion::Prismatic { axis, .. } => {
                    out.b[(k, axis)] = zero;
                    out.a[(axis, k)] = zero;
                    out.a[(k, axis)] = zero;
                }
                JointMotion::Free => {}
            }
        }
        (out, Pivot { inverse, force, moment })
    }
}

/// Inertia and wrench of a subtree whose joints are free.
type Freed<'g> = (Articulated<'g>, Wrench<'g>);

fn add<'g>(sum: &mut Option<Freed<'g>>, (inertia, wrench): Freed<'g>) {
    *sum = Some(match sum {
        Some((i, w)) => (i.plus(&inertia), (w.0 + wrench.0, w.1 + wrench.1)),
        None => (inertia, wrench),
    });
}

/// Accelerations under generalised forces, in the order of `v`; `robot` without joint accelerations.
pub(in crate::derive) fn solve<'g>(robot: &Sensitivity<'_, 'g, '_>, forces: &[Sym<'g>]) -> Vec<Sym<'g>> {
    solve_held(robot, forces, 0).0
}

/// The same while the first `held` of the base's rows keep their accelerations; and the forces that this takes there.
pub(in crate::derive) fn solve_held<'g>(
    robot: &Sensitivity<'_, 'g, '_>,
    forces: &[Sym<'g>],
    held: usize,
) -> (Vec<Sym<'g>>, Vec<Sym<'g>>) {
    let freed = Freeing::new(robot, forces, held);
    let accelerations = freed.accelerate(robot);
    let reaction = |row: usize| match &freed.root {
        Some(root) => {
            (held..6).fold(-freed.rests[row], |sum, c| sum + root.inertia.entry(row, c) * accelerations[c])
        }
        None => -freed.rests[row],
    };
    let reactions = (0..held).map(reaction).collect();
    (accelerations, reactions)
}

/// All joints freed, from the leaves to the root.
pub(super) struct Freeing<'g> {
    /// By body, where its joint was freed.
    pub pivots: Vec<Option<Pivot<'g>>>,
    /// What the forces lack, in the order of `v` and with the joints' signs; a free root's are solved by half.
    pub rests: Vec<Sym<'g>>,
    /// The root, if it is free.
    pub root: Option<Root<'g>>,
}

impl<'g> Freeing<'g> {
    /// Frees all joints but the first `held` rows of `v`.
    pub fn new(robot: &Sensitivity<'_, 'g, '_>, forces: &[Sym<'g>], held: usize) -> Self {
        let model = robot.model;
        let bodies = &model.tree.bodies;
        // Sums of what the children add, in the own axes and in the joint axes.
        let (mut own, mut joined) = (vec![None; bodies.len()], vec![None; bodies.len()]);
        let mut out = Self { pivots: vec![None; bodies.len()], rests: forces.to_vec(), root: None };
        for index in (0..bodies.len()).rev() {
            let _work = model.work(index, "articulated inertia");
            let mut sum = Some(body(robot, index, own[index].as_ref()));
            if let Some(carried) = joined[index] {
                add(&mut sum, carried);
            }
            let (inertia, wrench) = sum.expect("it was put in above");
            for (row, x) in robot.projections(index, wrench) {
                out.rests[row] = out.rests[row] - x;
            }
            let row = bodies[index].v_index;
            if bodies[index].motion == JointMotion::Free {
                let root = Root::new(inertia, row, held);
                root.half_solve(&mut out.rests[row..row + 6]);
                out.root = Some(root);
                continue;
            }
            let (mut handed, mut wrench) = (inertia, wrench);
            if row >= held {
                let (released, pivot) = inertia.released(bodies[index].motion);
                out.pivots[index] = Some(pivot);
                out.rests[row] = model.signed(index, out.rests[row]);
                (handed, wrench) = (released, pivot.pass(out.rests[row], wrench));
            }
            let Some(parent) = bodies[index].parent else { continue };
            let slot = if robot.axes[index].joined { &mut joined[parent] } else { &mut own[parent] };
            add(slot, in_hub(robot, index, handed, wrench));
        }
        out
    }

    /// Accelerations in the order of `v`, from the root to the leaves.
    pub fn accelerate(&self, robot: &Sensitivity<'_, 'g, '_>) -> Vec<Sym<'g>> {
        let model = robot.model;
        let mut out = self.rests.clone();
        let mut motions: Vec<Wrench<'g>> = Vec::new();
        for (index, body) in model.tree.bodies.iter().enumerate() {
            let _work = model.work(index, "acceleration");
            let Some(pivot) = &self.pivots[index] else {
                motions.push(match &self.root {
                    Some(root) if body.motion == JointMotion::Free => root.accelerate(&mut out),
                    _ => {
                        out[body.v_index] = model.constant(0.0);
                        (model.zero3(), model.zero3())
                    }
                });
                continue;
            };
            let (mut linear, mut angular) = match body.parent {
                None => (model.zero3(), model.zero3()),
                Some(p) => robot.to_joint(index, p, motions[p]),
            };
            let rest = self.rests[body.v_index];
            let x = (rest - pivot.force.dot(linear) - pivot.moment.dot(angular)) * pivot.inverse;
            out[body.v_index] = model.signed(index, x);
            match body.motion {
                JointMotion::Revolute { axis, .. } => angular[axis] = angular[axis] + x,
                JointMotion::Prismatic { axis, .. } => linear[axis] = linear[axis] + x,
                JointMotion::Free => {}
            }
            motions.push((linear, angular));
        }
        out
    }
}

/// A body with what it carries in its own axes, in its joint axes.
fn body<'g>(robot: &Sensitivity<'_, 'g, '_>, index: usize, carried: Option<&Freed<'g>>) -> Freed<'g> {
    let (axes, moments, single) = (robot.axes[index], &robot.moments[index], robot.single[index]);
    let Some((carried, wrench)) = carried else {
        return (Articulated::rigid(&moments.turned(axes.turn)), single);
    };
    let sum = Articulated::rigid(moments).plus(carried);
    let wrench = (axes.out(single.0 + wrench.0), axes.out(single.1 + wrench.1));
    (axes.turn.map_or(sum, |turn| sum.turned(turn)), wrench)
}

/// About the parent's origin, in the axes of the arm.
fn in_hub<'g>(
    robot: &Sensitivity<'_, 'g, '_>,
    index: usize,
    inertia: Articulated<'g>,
    wrench: Wrench<'g>,
) -> Freed<'g> {
    let rotation = &robot.model.tree.bodies[index].placement.rotation;
    let joined = robot.axes[index].joined;
    let turned = if joined { inertia } else { inertia.turned_constant(robot.model, rotation) };
    let arm = robot.links[index].arm;
    let (force, moment) = (robot.placed(index, wrench.0), robot.placed(index, wrench.1));
    (turned.shifted(arm), (force, moment + arm.cross(force)))
}

/// A free root's equations, factored: all but the first rows, whose accelerations are 0.
pub(super) struct Root<'g> {
    inertia: Articulated<'g>,
    /// Its first row of `v`.
    pub first: usize,
    held: usize,
    /// Below the diagonal: what is left of the inertia when the rows after are gone.
    lower: Vec<Vec<Sym<'g>>>,
    /// By row, one over the diagonal.
    pub inverse: [Sym<'g>; 6],
}

impl<'g> Root<'g> {
    fn new(inertia: Articulated<'g>, first: usize, held: usize) -> Self {
        let mut h: Vec<Vec<Sym<'g>>> =
            (0..6).map(|r| (0..6).map(|c| inertia.entry(r, c)).collect()).collect();
        let mut inverse = [inertia.a[(0, 0)].zero(); 6];
        for k in (held..6).rev() {
            let one = h[k][k].constant(1.0) / h[k][k];
            inverse[k] = one;
            for i in (held..k).rev() {
                let factor = h[k][i] * one;
                let pivot = h[k].clone();
                for (x, &y) in h[i].iter_mut().zip(&pivot).take(i + 1) {
                    *x = *x - factor * y;
                }
            }
        }
        Self { inertia, first, held, lower: h, inverse }
    }

    /// L⁻ᵀ x
    pub fn half_solve(&self, x: &mut [Sym<'g>]) {
        for k in (self.held..6).rev() {
            for i in (self.held..k).rev() {
                x[i] = x[i] - self.lower[k][i] * self.inverse[k] * x[k];
            }
        }
    }

    /// The rest of the solution, in place of what was solved by half: linear and angular acceleration.
    fn accelerate(&self, rests: &mut [Sym<'g>]) -> Wrench<'g> {
        let x = &mut rests[self.first..self.first + 6];
        x[..self.held].fill(self.inertia.a[(0, 0)].zero());
        for k in self.held..6 {
            for i in self.held..k {
                x[k] = x[k] - self.lower[k][i] * x[i];
            }
            x[k] = x[k] * self.inverse[k];
        }
        (Vector3([x[0], x[1], x[2]]), Vector3([x[3], x[4], x[5]]))
    }
}
