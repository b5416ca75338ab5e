//! Random states of a robot in any arithmetic.
use super::arithmetic::{Angle, Arithmetic};
use super::evaluate::Assignment;
use super::flat::{Turning, level};
use crate::expression::{Input, exact_sin_cos};
use crate::tree::{BaseKind, Frame, JointMotion, Tree};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::random::Random;
use bipedc_runtime::Argument;

/// The states in which a model is observed.
#[derive(Debug, Clone)]
pub struct StateSpace<'t> {
    /// The robot.
    pub tree: &'t Tree,
    /// The base stays upright at the origin, at rest: its link stands on the ground or is bolted to it.
    pub pinned: bool,
    /// Links that stay parallel to the ground (their z axis vertical) throughout the motion.
    pub flat: Vec<String>,
}

/// Sine and cosine of a constant angle, exact on multiples of π/2 as in an exact graph.
pub fn constant_angle<A: Arithmetic>(a: &A, angle: f64) -> Option<Angle<A::Value>> {
    let unit = |x: f64| match x {
        1.0 => a.one(),
        -1.0 => a.neg(a.one()),
        _ => a.zero(),
    };
    let (s, c) = exact_sin_cos(angle);
    if s == 0.0 || c == 0.0 { Some((unit(s), unit(c))) } else { a.constant_angle(angle) }
}

impl<'t> StateSpace<'t> {
    /// Any state.
    pub fn free(tree: &'t Tree) -> Self {
        Self { tree, pinned: false, flat: Vec::new() }
    }

    /// Any motion of the joints, the root standing still.
    pub fn pinned(tree: &'t Tree) -> Self {
        Self { tree, pinned: true, flat: Vec::new() }
    }

    /// The same with these links parallel to the ground.
    pub fn with_flat(mut self, links: Vec<String>) -> Self {
        self.flat = links;
        self
    }

    /// Whether the states can be drawn.
    ///
    /// # Errors
    /// A link to keep flat that does not exist, does not move, or cannot be levelled.
    pub fn check(&self) -> Result<(), Diagnostic> {
        for name in &self.flat {
            let Some(frame) = self.tree.frame(name) else {
                return Err(Diagnostic::error(format!(
                    "`{name}` cannot be kept flat: there is no such link"
                )));
            };
            let turning = |body: usize| matches!(self.tree.bodies[body].motion, JointMotion::Revolute { .. });
            let path: Vec<usize> = frame.body.into_iter().flat_map(|b| self.tree.path_to_root(b)).collect();
            let joints = path.iter().filter(|&&b| !self.is_base(b) && turning(b)).count();
            let why = if joints == 0 {
                "no joint turns it"
            } else if !self.pinned && self.tree.base == BaseKind::Floating {
                "the base floats; pin it to the ground"
            } else {
                continue;
            };
            return Err(Diagnostic::error(format!("`{name}` cannot be kept parallel to the ground: {why}")));
        }
        Ok(())
    }

    /// A state with values for all `inputs`; `None` if this draw has no solution and another is to be made.
    pub fn sample<A: Arithmetic>(
        &self,
        a: &A,
        inputs: impl Iterator<Item = Input>,
        random: &mut Random,
    ) -> Option<Assignment<A::Value>> {
        let mut draw = Draw::new(a, self, random)?;
        for frame in self.flat.iter().map(|name| self.tree.frame(name)) {
            level(a, self.tree, frame?, &mut draw.turning())?;
        }
        let mut state = draw.assignment(a, self, random)?;
        for input in inputs {
            state.values.entry(input).or_insert_with(|| a.random(random));
        }
        Some(state)
    }

    /// Whether the body's coordinates belong to the base.
    fn is_base(&self, body: usize) -> bool {
        self.tree.bodies[body].v_index < self.tree.base_nv()
    }

    /// Link frames that are candidates for [`Self::flat`]: those of `links` that some joint moves.
    pub fn movable<'n>(&self, links: impl Iterator<Item = &'n str>) -> Vec<String> {
        let moves = |frame: &Frame| frame.body.is_some_and(|body| !self.is_base(body));
        links.filter(|name| self.tree.frame(name).is_some_and(moves)).map(str::to_owned).collect()
    }
}

/// Positions, rates and accelerations of all joints, by body.
struct Draw<V> {
    angles: Vec<Angle<V>>,
    positions: Vec<V>,
    rates: Vec<V>,
    accelerations: Vec<V>,
}

impl<V: Copy> Draw<V> {
    fn new<A: Arithmetic<Value = V>>(a: &A, space: &StateSpace<'_>, random: &mut Random) -> Option<Self> {
        let mut draw =
            Self { angles: Vec::new(), positions: Vec::new(), rates: Vec::new(), accelerations: Vec::new() };
        for body in 0..space.tree.bodies.len() {
            let still = space.pinned && space.is_base(body);
            let angle = a.random_angle(random)?;
            let numbers = [0, 1, 2].map(|_| if still { a.zero() } else { a.random(random) });
            draw.angles.push(if still { (a.zero(), a.one()) } else { angle });
            draw.positions.push(numbers[0]);
            draw.rates.push(numbers[1]);
            draw.accelerations.push(numbers[2]);
        }
        Some(draw)
    }

    fn turning(&mut self) -> Turning<'_, V> {
        Turning { angles: &mut self.angles, rates: &mut self.rates, accelerations: &mut self.accelerations }
    }

    fn assignment<A: Arithmetic<Value = V>>(
        &self,
        a: &A,
        space: &StateSpace<'_>,
        random: &mut Random,
    ) -> Option<Assignment<V>> {
        let mut out = Assignment::default();
        for (index, body) in space.tree.bodies.iter().enumerate() {
            let (q, v) = (input(Argument::Q, body.q_index), body.v_index);
            match body.motion {
                JointMotion::Free => {
                    free_body(a, space, body.q_index, v, random, &mut out)?;
                    continue;
                }
                JointMotion::Revolute { .. } => {
                    out.angles.insert(q, self.angles[index]);
                    out.values.insert(q, a.angle_number(self.angles[index], random));
                }
                JointMotion::Prismatic { .. } => {
                    out.values.insert(q, self.positions[index]);
                }
            }
            out.values.insert(input(Argument::V, v), self.rates[index]);
            out.values.insert(input(Argument::A, v), self.accelerations[index]);
        }
        Some(out)
    }
}

fn input(argument: Argument, index: usize) -> Input {
    Input { argument, index: index as u32 }
}

/// Position, unit quaternion, twist and its derivative of a floating root.
fn free_body<A: Arithmetic>(
    a: &A,
    space: &StateSpace<'_>,
    q: usize,
    v: usize,
    random: &mut Random,
    out: &mut Assignment<A::Value>,
) -> Option<()> {
    let mut number = || if space.pinned { a.zero() } else { a.random(random) };
    for k in 0..3 {
        out.values.insert(input(Argument::Q, q + k), number());
    }
    for k in 0..6 {
        out.values.insert(input(Argument::V, v + k), number());
        out.values.insert(input(Argument::A, v + k), number());
    }
    // Stereographic projection onto the unit sphere; from 0 it gives the unit quaternion.
    let t = [number(), number(), number()];
    let square = a.dot(t, t);
    let sum = a.add(a.one(), square);
    for (k, &x) in t.iter().enumerate() {
        out.values.insert(input(Argument::Q, q + 3 + k), a.div(a.add(x, x), sum)?);
    }
    out.values.insert(input(Argument::Q, q + 6), a.div(a.sub(a.one(), square), sum)?);
    Some(())
}
