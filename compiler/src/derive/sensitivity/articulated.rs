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

/// What is left of a body's joint after its elimination: `1/d`, and force and moment per acceleration of it.
type Pivot<'g> = (Sym<'g>, Vector3<'g>, Vector3<'g>);

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
        (out, (inverse, force, moment))
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
    let model = robot.model;
    let bodies = &model.tree.bodies;
    // Sums of what the children add, in the own axes and in the joint axes.
    let (mut own, mut joined) = (vec![None; bodies.len()], vec![None; bodies.len()]);
    let mut inertias = Vec::new();
    let mut pivots: Vec<Option<Pivot<'g>>> = vec![None; bodies.len()];
    let mut rests = forces.to_vec();
    for index in (0..bodies.len()).rev() {
        let _work = model.work(index, "articulated inertia");
        let mut sum = Some(body(robot, index, own[index].as_ref()));
        if let Some(carried) = joined[index] {
            add(&mut sum, carried);
        }
        let (inertia, wrench) = sum.expect("it was put in above");
        inertias.push(inertia);
        for (row, x) in robot.projections(index, wrench) {
            rests[row] = rests[row] - x;
        }
        if bodies[index].motion == JointMotion::Free {
            continue;
        }
        let row = bodies[index].v_index;
        let (mut handed, mut wrench) = (inertia, wrench);
        if row >= held {
            let (released, pivot) = inertia.released(bodies[index].motion);
            pivots[index] = Some(pivot);
            rests[row] = model.signed(index, rests[row]);
            let share = rests[row] * pivot.0;
            (handed, wrench) = (released, (wrench.0 + pivot.1.scale(share), wrench.1 + pivot.2.scale(share)));
        }
        let Some(parent) = bodies[index].parent else { continue };
        let slot = if robot.axes[index].joined { &mut joined[parent] } else { &mut own[parent] };
        add(slot, in_hub(robot, index, handed, wrench));
    }
    inertias.reverse();
    let accelerations = accelerate(robot, &inertias, &pivots, (&rests, held));
    let reaction = |row: usize| match bodies[0].motion {
        JointMotion::Free => {
            (held..6).fold(-rests[row], |sum, c| sum + inertias[0].entry(row, c) * accelerations[c])
        }
        _ => -rests[row],
    };
    let reactions = (0..held).map(reaction).collect();
    (accelerations, reactions)
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

/// From the root to the leaves.
fn accelerate<'g>(
    robot: &Sensitivity<'_, 'g, '_>,
    inertias: &[Articulated<'g>],
    pivots: &[Option<Pivot<'g>>],
    (rests, held): (&[Sym<'g>], usize),
) -> Vec<Sym<'g>> {
    let model = robot.model;
    let bodies = &model.tree.bodies;
    let mut out = rests.to_vec();
    let mut motions: Vec<Wrench<'g>> = Vec::new();
    for (index, body) in bodies.iter().enumerate() {
        let _work = model.work(index, "acceleration");
        let Some((inverse, force, moment)) = pivots[index] else {
            motions.push(match body.motion {
                JointMotion::Free => free_root(&inertias[index], (body.v_index, held), &mut out),
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
        let x = (rests[body.v_index] - force.dot(linear) - moment.dot(angular)) * inverse;
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

/// Solves the equations of a free root but for the first `held` ones, whose accelerations are 0.
fn free_root<'g>(
    inertia: &Articulated<'g>,
    (first, held): (usize, usize),
    rests: &mut [Sym<'g>],
) -> Wrench<'g> {
    let mut h: Vec<Vec<Sym<'g>>> = (0..6).map(|r| (0..6).map(|c| inertia.entry(r, c)).collect()).collect();
    let mut x: Vec<Sym<'g>> = rests[first..first + 6].to_vec();
    x[..held].fill(inertia.a[(0, 0)].zero());
    let mut inverse = [x[5].zero(); 6];
    for k in (held..6).rev() {
        let one = h[k][k].constant(1.0) / h[k][k];
        inverse[k] = one;
        for i in (held..k).rev() {
            let factor = h[k][i] * one;
            let pivot = h[k].clone();
            for (x, &y) in h[i].iter_mut().zip(&pivot).take(i + 1) {
                *x = *x - factor * y;
            }
            x[i] = x[i] - factor * x[k];
        }
    }
    for k in held..6 {
        for i in held..k {
            x[k] = x[k] - h[k][i] * x[i];
        }
        x[k] = x[k] * inverse[k];
    }
    rests[first..first + 6].copy_from_slice(&x);
    (Vector3([x[0], x[1], x[2]]), Vector3([x[3], x[4], x[5]]))
}
