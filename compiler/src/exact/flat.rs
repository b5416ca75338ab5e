//! Postures and motions in which a foot stays parallel to the ground.
//!
//! Joint angles with rational sines do not satisfy the condition, and the rational families that do are too
//! special. So all joints but the last two are drawn freely and those two are solved for, with a square root
//! in the field.
use super::arithmetic::{Angle, Arithmetic};
use crate::tree::{Frame, JointMotion, Rotation, Tree};

type V3<A> = [<A as Arithmetic>::Value; 3];

/// One turning joint on the way from the world to a foot.
struct Step<'t> {
    /// Body that it moves.
    body: usize,
    /// Constant turn before it.
    before: &'t [Rotation],
    axis: usize,
    reversed: bool,
}

/// The state of all bodies as far as it matters here.
pub struct Turning<'s, V> {
    /// Angle of each body's joint in its direction, for turning joints.
    pub angles: &'s mut [Angle<V>],
    /// Rate of each.
    pub rates: &'s mut [V],
    /// Acceleration of each.
    pub accelerations: &'s mut [V],
}

/// Adjusts the joints next to a foot so that its z axis is vertical and stays so.
///
/// The base, if it moves, must not turn freely. `None`: no such angles in this field, or none at all.
pub fn level<A: Arithmetic>(
    a: &A,
    tree: &Tree,
    foot: &Frame,
    state: &mut Turning<'_, A::Value>,
) -> Option<()> {
    let rotations = constant_rotations(tree, foot);
    let steps = steps(tree, foot, &rotations);
    let chosen = solve_angles(a, &steps, rotations.last()?, state)?;
    solve_rates(a, &steps, &chosen, state)
}

/// The bodies on the way to the foot, the one nearest to the world first.
fn path(tree: &Tree, foot: &Frame) -> Vec<usize> {
    let mut path: Vec<usize> = foot.body.into_iter().flat_map(|body| tree.path_to_root(body)).collect();
    path.reverse();
    path
}

/// Constant rotations between consecutive turning joints; the last one leads to the foot's link frame.
fn constant_rotations(tree: &Tree, foot: &Frame) -> Vec<Vec<Rotation>> {
    let mut out = vec![Vec::new()];
    for body in path(tree, foot) {
        let last = out.len() - 1;
        out[last].push(tree.bodies[body].placement.rotation.clone());
        if matches!(tree.bodies[body].motion, JointMotion::Revolute { .. }) {
            out.push(Vec::new());
        }
    }
    let last = out.len() - 1;
    out[last].push(foot.placement.rotation.clone());
    out
}

fn steps<'t>(tree: &Tree, foot: &Frame, rotations: &'t [Vec<Rotation>]) -> Vec<Step<'t>> {
    let turning = path(tree, foot).into_iter().filter_map(|body| match tree.bodies[body].motion {
        JointMotion::Revolute { axis, reversed } => Some((body, axis, reversed)),
        _ => None,
    });
    let step =
        |((body, axis, reversed), before): (_, &'t Vec<Rotation>)| Step { body, before, axis, reversed };
    turning.zip(rotations).map(step).collect()
}

/// `R_axis(angle) x`
fn turn<A: Arithmetic>(a: &A, axis: usize, (s, c): Angle<A::Value>, x: V3<A>) -> V3<A> {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut y = x;
    y[u] = a.sub(a.mul(c, x[u]), a.mul(s, x[v]));
    y[v] = a.add(a.mul(s, x[u]), a.mul(c, x[v]));
    y
}

/// Constant rotations applied to a vector.
fn turn_constant<A: Arithmetic>(a: &A, rotations: &[Rotation], x: V3<A>, back: bool) -> Option<V3<A>> {
    let mut elementary: Vec<(usize, f64)> = rotations.iter().flat_map(|r| r.0.iter().copied()).collect();
    if !back {
        elementary.reverse();
    }
    let mut y = x;
    for (axis, angle) in elementary {
        let (s, c) = super::states::constant_angle(a, angle)?;
        y = turn(a, axis, if back { (a.neg(s), c) } else { (s, c) }, y);
    }
    Some(y)
}

impl Step<'_> {
    /// The angle about the positive coordinate axis.
    fn angle<A: Arithmetic>(&self, a: &A, state: &Turning<'_, A::Value>) -> Angle<A::Value> {
        let (s, c) = state.angles[self.body];
        if self.reversed { (a.neg(s), c) } else { (s, c) }
    }
    fn set_angle<A: Arithmetic>(&self, a: &A, (s, c): Angle<A::Value>, state: &mut Turning<'_, A::Value>) {
        state.angles[self.body] = if self.reversed { (a.neg(s), c) } else { (s, c) };
    }
    /// From the frame after the joint to the frame before the constant turn.
    fn up<A: Arithmetic>(&self, a: &A, state: &Turning<'_, A::Value>, x: V3<A>) -> Option<V3<A>> {
        turn_constant(a, self.before, turn(a, self.axis, self.angle(a, state), x), false)
    }
}

/// World vertical, seen from just before the turn of joint `index`.
fn vertical_before<A: Arithmetic>(
    a: &A,
    steps: &[Step<'_>],
    index: usize,
    state: &Turning<'_, A::Value>,
) -> Option<V3<A>> {
    let mut z = [a.zero(), a.zero(), a.one()];
    for (k, step) in steps[..=index].iter().enumerate() {
        z = turn_constant(a, step.before, z, true)?;
        if k < index {
            let (s, c) = step.angle(a, state);
            z = turn(a, step.axis, (a.neg(s), c), z);
        }
    }
    Some(z)
}

/// Chooses one or two joints next to the foot and their angles; returns their indices among the steps.
fn solve_angles<A: Arithmetic>(
    a: &A,
    steps: &[Step<'_>],
    to_foot: &[Rotation],
    state: &mut Turning<'_, A::Value>,
) -> Option<Vec<usize>> {
    let last = steps.len().checked_sub(1)?;
    let normal = turn_constant(a, to_foot, [a.zero(), a.zero(), a.one()], false)?;
    let vertical = vertical_before(a, steps, last, state)?;
    let axis = steps[last].axis;
    // A planar robot: the foot's normal and the vertical make the same angle with the axis.
    if a.is_zero(a.sub(vertical[axis], normal[axis])) {
        steps[last].set_angle(a, between(a, axis, normal, vertical)?, state);
        return Some(vec![last]);
    }
    let first = last.checked_sub(1)?;
    let wanted = vertical_before(a, steps, first, state)?[steps[first].axis];
    let angle = two_joints(a, &steps[first], &steps[last], normal, wanted)?;
    steps[last].set_angle(a, angle, state);
    let carried = steps[last].up(a, state, normal)?;
    let vertical = vertical_before(a, steps, first, state)?;
    steps[first].set_angle(a, between(a, steps[first].axis, carried, vertical)?, state);
    Some(vec![first, last])
}

/// The angle about `axis` that turns `x` onto `y`; both have equal length and component along the axis.
fn between<A: Arithmetic>(a: &A, axis: usize, x: V3<A>, y: V3<A>) -> Option<Angle<A::Value>> {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let square = a.add(a.mul(x[u], x[u]), a.mul(x[v], x[v]));
    let sine = a.sub(a.mul(x[u], y[v]), a.mul(x[v], y[u]));
    let cosine = a.add(a.mul(x[u], y[u]), a.mul(x[v], y[v]));
    Some((a.div(sine, square)?, a.div(cosine, square)?))
}

/// The angle of the last joint at which the normal has the component `wanted` along the axis before it.
fn two_joints<A: Arithmetic>(
    a: &A,
    first: &Step<'_>,
    last: &Step<'_>,
    normal: V3<A>,
    wanted: A::Value,
) -> Option<Angle<A::Value>> {
    let mut axis = [a.zero(); 3];
    axis[first.axis] = a.one();
    let axis = turn_constant(a, last.before, axis, true)?;
    let (u, v) = ((last.axis + 1) % 3, (last.axis + 2) % 3);
    // alpha sin + beta cos = gamma
    let alpha = a.sub(a.mul(axis[v], normal[u]), a.mul(axis[u], normal[v]));
    let beta = a.add(a.mul(axis[u], normal[u]), a.mul(axis[v], normal[v]));
    let gamma = a.sub(wanted, a.mul(axis[last.axis], normal[last.axis]));
    let square = a.add(a.mul(alpha, alpha), a.mul(beta, beta));
    let root = a.sqrt(a.sub(square, a.mul(gamma, gamma)))?;
    let sine = a.sub(a.mul(alpha, gamma), a.mul(beta, root));
    let cosine = a.add(a.mul(beta, gamma), a.mul(alpha, root));
    Some((a.div(sine, square)?, a.div(cosine, square)?))
}

/// Rates and accelerations of the chosen joints that keep the foot from tilting.
fn solve_rates<A: Arithmetic>(
    a: &A,
    steps: &[Step<'_>],
    chosen: &[usize],
    state: &mut Turning<'_, A::Value>,
) -> Option<()> {
    let axes = world_axes(a, steps, state)?;
    let scaled = |x: V3<A>, factor| x.map(|e| a.mul(e, factor));
    let plus = |x: V3<A>, y: V3<A>| [0, 1, 2].map(|i| a.add(x[i], y[i]));
    let mut spin = [a.zero(); 3];
    for (k, step) in steps.iter().enumerate().filter(|(k, _)| !chosen.contains(k)) {
        spin = plus(spin, scaled(axes[k], state.rates[step.body]));
    }
    for (&k, rate) in chosen.iter().zip(cancel(a, &axes, chosen, spin)?) {
        state.rates[steps[k].body] = rate;
    }
    let mut spin = [a.zero(); 3];
    let mut change = [a.zero(); 3];
    for (k, step) in steps.iter().enumerate() {
        let turning = scaled(axes[k], state.rates[step.body]);
        change = plus(change, a.cross(spin, turning));
        spin = plus(spin, turning);
        if !chosen.contains(&k) {
            change = plus(change, scaled(axes[k], state.accelerations[step.body]));
        }
    }
    for (&k, acceleration) in chosen.iter().zip(cancel(a, &axes, chosen, change)?) {
        state.accelerations[steps[k].body] = acceleration;
    }
    Some(())
}

/// Joint directions in world axes.
fn world_axes<A: Arithmetic>(a: &A, steps: &[Step<'_>], state: &Turning<'_, A::Value>) -> Option<Vec<V3<A>>> {
    let axis_of = |index: usize| {
        let step: &Step<'_> = &steps[index];
        let mut axis = [a.zero(); 3];
        axis[step.axis] = if step.reversed { a.neg(a.one()) } else { a.one() };
        steps[..=index].iter().rev().try_fold(axis, |x, step| step.up(a, state, x))
    };
    (0..steps.len()).map(axis_of).collect()
}

/// Factors of the chosen axes that cancel the horizontal part of `rest`.
fn cancel<A: Arithmetic>(a: &A, axes: &[V3<A>], chosen: &[usize], rest: V3<A>) -> Option<Vec<A::Value>> {
    let determinant = |x: V3<A>, y: V3<A>| a.sub(a.mul(x[0], y[1]), a.mul(x[1], y[0]));
    if let &[one] = chosen {
        let k = usize::from(a.is_zero(axes[one][0]));
        let factor = a.neg(a.div(rest[k], axes[one][k])?);
        let left = a.add(rest[1 - k], a.mul(axes[one][1 - k], factor));
        return a.is_zero(left).then(|| vec![factor]);
    }
    let (x, y) = (axes[*chosen.first()?], axes[*chosen.last()?]);
    let d = determinant(x, y);
    Some(vec![a.neg(a.div(determinant(rest, y), d)?), a.neg(a.div(determinant(x, rest), d)?)])
}
