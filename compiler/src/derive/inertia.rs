//! Inertias of the bodies as expressions, and the regrouping that makes most of them vanish.
use super::model::rotate;
use crate::expression::{Expr, Graph, Matrix3, Sym, Vector3};
use crate::tree::{Inertia, JointMotion, Placement, Rotation, Tree};
use bipedc_runtime::Argument;

/// Mass, first moment and inertia about the frame origin, as expressions.
#[derive(Debug, Clone, Copy)]
pub struct BodyInertia<'g> {
    /// kg
    pub mass: Sym<'g>,
    /// Mass times centre of mass, kg m.
    pub first_moment: Vector3<'g>,
    /// Symmetric, about the frame's origin, kg m².
    pub second_moment: Matrix3<'g>,
}

impl<'g> BodyInertia<'g> {
    /// Both together, in one frame.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first_moment: self.first_moment + other.first_moment,
            second_moment: self.second_moment + other.second_moment,
        }
    }

    /// Turned about a coordinate axis: 19 operations where the full product takes 30.
    pub fn turned(&self, axis: usize, s: Sym<'g>, c: Sym<'g>) -> Self {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let l = self.second_moment;
        let (luu, lvv, luv) = (l[(u, u)], l[(v, v)], l[(u, v)]);
        let (ss, sc) = (s * s, s * c);
        let difference = luu - lvv;
        let exchange = ss * difference + sc * luv * 2.0;
        let (lku, lkv) = (l[(axis, u)], l[(axis, v)]);
        let (ku, kv) = (c * lku - s * lkv, s * lku + c * lkv);
        let uv = luv - ss * luv * 2.0 + sc * difference;
        let mut turned = l;
        turned[(u, u)] = luu - exchange;
        turned[(v, v)] = lvv + exchange;
        for (r, k, x) in [(u, v, uv), (axis, u, ku), (axis, v, kv)] {
            turned[(r, k)] = x;
            turned[(k, r)] = x;
        }
        Self { mass: self.mass, first_moment: rotate(axis, s, c, self.first_moment), second_moment: turned }
    }

    /// Turned by a constant rotation.
    pub fn turned_constant(&self, graph: &'g Graph, rotation: &Rotation) -> Self {
        rotation.0.iter().rev().fold(*self, |body, &(axis, angle)| {
            let angle = Sym::new(graph, graph.constant(angle));
            body.turned(axis, angle.sin(), angle.cos())
        })
    }

    /// Seen from a frame with the same axes in which the present origin stands at `p`.
    pub fn shifted(&self, p: Vector3<'g>) -> Self {
        if p.is_zero() {
            return *self;
        }
        let (m, l) = (self.mass, self.first_moment);
        let moved = l + p.scale(m);
        // -(p (m p + l)ᵀ + l pᵀ) + trace · 1
        let outer = |r: usize, c: usize| p[r] * moved[c] + l[r] * p[c];
        let diagonal = [0, 1, 2].map(|k| outer(k, k));
        let mut second = self.second_moment;
        for r in 0..3 {
            second[(r, r)] = second[(r, r)] + (diagonal[(r + 1) % 3] + diagonal[(r + 2) % 3]);
            for c in r + 1..3 {
                let x = second[(r, c)] - outer(r, c);
                second[(r, c)] = x;
                second[(c, r)] = x;
            }
        }
        Self { mass: m, first_moment: moved, second_moment: second }
    }

    /// Force and moment about the frame's origin, per unit of the body's motion, of the linear momentum
    /// `m u + w × l` and the angular momentum `l × u + L w`.
    pub fn momentum(&self, u: Vector3<'g>, w: Vector3<'g>) -> (Vector3<'g>, Vector3<'g>) {
        let linear = u.scale(self.mass) + w.cross(self.first_moment);
        let angular = self.first_moment.cross(u) + self.second_moment * w;
        (linear, angular)
    }
}

/// Constants.
pub fn folded<'g>(graph: &'g Graph, inertias: &[Inertia]) -> Vec<BodyInertia<'g>> {
    let constant = |x| Sym::new(graph, graph.constant(x));
    inertias
        .iter()
        .map(|i| BodyInertia {
            mass: constant(i.mass),
            first_moment: Vector3(i.first_moment.map(constant)),
            second_moment: Matrix3(i.second_moment.map(|row| row.map(constant))),
        })
        .collect()
}

/// Ten parameters per body, stated in the frame of its main link and moved to the body frame here.
pub fn symbolic<'g>(graph: &'g Graph, tree: &Tree) -> Vec<BodyInertia<'g>> {
    parametric(graph, tree, |k| graph.input(Argument::Parameters, k))
}

/// The base parameters alone: `leading` names the standard parameters that stand for their groups, all
/// others are 0. Whatever depends on the base parameters only is unchanged by that (5.2).
pub fn reduced<'g>(graph: &'g Graph, tree: &Tree, leading: &[usize]) -> Vec<BodyInertia<'g>> {
    parametric(graph, tree, |k| match leading.iter().position(|&l| l == k) {
        Some(place) => graph.input(Argument::Parameters, place),
        None => Expr::ZERO,
    })
}

fn parametric<'g>(graph: &'g Graph, tree: &Tree, parameter: impl Fn(usize) -> Expr) -> Vec<BodyInertia<'g>> {
    let zero = folded(graph, &[Inertia::default()])[0];
    let body = |index: usize| stated(graph, tree, index, |k| Sym::new(graph, parameter(10 * index + k)));
    (0..tree.bodies.len()).map(|i| if tree.bodies[i].is_virtual { zero } else { body(i) }).collect()
}

/// A body of the ten parameters `p` in the frame of its main link, moved to the body frame.
fn stated<'g>(graph: &'g Graph, tree: &Tree, index: usize, p: impl Fn(usize) -> Sym<'g>) -> BodyInertia<'g> {
    let [xx, xy, xz, yy, yz, zz] = [4, 5, 6, 7, 8, 9].map(&p);
    let in_link = BodyInertia {
        mass: p(0),
        first_moment: Vector3([p(1), p(2), p(3)]),
        second_moment: Matrix3([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]),
    };
    let Placement { rotation, translation } = &tree.bodies[index].main_link;
    in_link.turned_constant(graph, rotation).shifted(Vector3::constant(graph, *translation))
}

/// A body of which one parameter is 1 and the others are 0.
pub fn unit<'g>(graph: &'g Graph, tree: &Tree, index: usize, parameter: usize) -> BodyInertia<'g> {
    let one = |k| if k == parameter { Expr::ONE } else { Expr::ZERO };
    stated(graph, tree, index, |k| Sym::new(graph, one(k)))
}

/// Moves everything that a joint cannot tell from its parent's inertia to the parent, from the leaves to
/// the root: mass, the first moment along the axis, and one of the two transverse moments.
///
/// What moves is a mass distribution on the joint axis, so every quantity of the whole robot (torques,
/// momentum, energy, centre of mass) stays the same. Dust of the subtraction is cleaned, relative to what
/// was there.
pub fn regroup(tree: &Tree) -> Vec<Inertia> {
    let mut inertias: Vec<Inertia> = tree.bodies.iter().map(|body| body.inertia).collect();
    let mut before = inertias.clone();
    for index in (0..tree.bodies.len()).rev() {
        let body = &tree.bodies[index];
        let own = inertias[index];
        before[index] = own;
        let Some(parent) = body.parent else { continue };
        let moved = movable_part(body.motion, &own);
        inertias[index] = own.less(&moved);
        inertias[parent] = inertias[parent].plus(&moved.transformed(&body.placement));
    }
    inertias.iter().zip(&before).map(|(kept, before)| clean(kept, before)).collect()
}

fn movable_part(motion: JointMotion, own: &Inertia) -> Inertia {
    let mut moved = Inertia::default();
    match motion {
        JointMotion::Free => {}
        // A slide keeps the orientation: all of the moments of inertia act like the parent's.
        JointMotion::Prismatic { .. } => moved.second_moment = own.second_moment,
        JointMotion::Revolute { axis, .. } => {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            moved.mass = own.mass;
            moved.first_moment[axis] = own.first_moment[axis];
            moved.second_moment[u][u] = own.second_moment[v][v];
            moved.second_moment[v][v] = own.second_moment[v][v];
        }
    }
    moved
}

/// Sums that should cancel leave 1e-17 of what was there `before` behind, which would cost operations.
fn clean(inertia: &Inertia, before: &Inertia) -> Inertia {
    let small = |x: f64, scale: f64| if x.abs() <= 1e-14 * scale { 0.0 } else { x };
    let l = inertia.first_moment;
    let i = inertia.second_moment;
    let first = l.iter().fold(inertia.mass, |m, x| m.max(x.abs()));
    let second = before.second_moment.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    Inertia {
        mass: inertia.mass,
        first_moment: l.map(|x| small(x, first)),
        second_moment: i.map(|row| row.map(|x| small(x, second))),
    }
}

impl<'g> BodyInertia<'g> {
    /// Seen from the parent: turned and shifted by the joint and its placement.
    pub fn in_parent(&self, model: &super::RobotModel<'g, '_>, body: usize) -> Self {
        let b = &model.tree.bodies[body];
        let turned = match b.motion {
            JointMotion::Revolute { axis, .. } => {
                let (s, c) = model.sin_cos(body);
                self.turned(axis, s, c)
            }
            _ => *self,
        };
        turned.turned_constant(model.graph, &b.placement.rotation).shifted(model.offset(body))
    }
}
