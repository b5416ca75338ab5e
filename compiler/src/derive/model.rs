//! A tree with its symbols: what all derivations start from.
use super::inertia::{self, BodyInertia};
use crate::expression::{Graph, Matrix3, Purpose, Sym, Vector3, Work};
use crate::tree::{JointMotion, Placement, Rotation, Tree};
use bipedc_runtime::Argument;

/// Where the inertial parameters come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InertiaMode {
    /// Numbers of the description, regrouped along the joint axes so that most of them vanish.
    Folded,
    /// Numbers as they stand, without regrouping.
    Plain,
    /// Ten run-time parameters per body ([`Argument::Parameters`], in the frame of the body's main link).
    Symbolic,
}

/// A tree, a graph and the inertias in it.
#[derive(Clone)]
pub struct RobotModel<'g, 't> {
    /// Where expressions live.
    pub graph: &'g Graph,
    /// The robot.
    pub tree: &'t Tree,
    /// By body.
    pub inertias: Vec<BodyInertia<'g>>,
    /// By element of `q`: what the logged position is too large by.
    pub offsets: Vec<f64>,
    /// How the inertias came in; `None` for [`Self::with_base_parameters`].
    pub mode: Option<InertiaMode>,
    /// What takes the place of the arguments.
    pub(super) given: Option<Given<'g>>,
}

/// A state in the place of [`Argument::Q`] and [`Argument::V`], and gravity in the axes in which the root has its place.
#[derive(Debug, Clone)]
pub(super) struct Given<'g> {
    /// Positions; a free root's are not read: it lies in the axes of gravity.
    pub q: Vec<Sym<'g>>,
    pub v: Vec<Sym<'g>>,
    pub gravity: Vector3<'g>,
}

impl<'g, 't> RobotModel<'g, 't> {
    /// Prepares the derivations.
    pub fn new(graph: &'g Graph, tree: &'t Tree, mode: InertiaMode) -> Self {
        let inertias = match mode {
            InertiaMode::Folded => inertia::folded(graph, &inertia::regroup(tree)),
            InertiaMode::Plain => {
                inertia::folded(graph, &tree.bodies.iter().map(|b| b.inertia).collect::<Vec<_>>())
            }
            InertiaMode::Symbolic => inertia::symbolic(graph, tree),
        };
        Self { graph, tree, inertias, offsets: Vec::new(), mode: Some(mode), given: None }
    }

    /// With base parameters as run-time inputs ([`Argument::Parameters`]); `leading` are their places among
    /// the ten standard parameters of every body.
    pub fn with_base_parameters(graph: &'g Graph, tree: &'t Tree, leading: &[usize]) -> Self {
        let inertias = inertia::reduced(graph, tree, leading);
        Self { graph, tree, inertias, offsets: Vec::new(), mode: None, given: None }
    }

    /// While the guard lives, what is derived is a quantity of this body: generated code says so.
    pub fn work(&self, body: usize, quantity: &'static str) -> Work<'g> {
        self.graph.work(Purpose { body: Some(body), quantity })
    }

    /// The same for a quantity of the whole robot.
    pub fn work_on_all(&self, quantity: &'static str) -> Work<'g> {
        self.graph.work(Purpose { body: None, quantity })
    }

    /// A constant.
    pub fn constant(&self, value: f64) -> Sym<'g> {
        Sym::new(self.graph, self.graph.constant(value))
    }
    /// An element of an argument; positions are the true ones, without the offsets of encoders.
    pub fn input(&self, argument: Argument, index: usize) -> Sym<'g> {
        match (&self.given, argument) {
            (Some(given), Argument::Q) => return given.q[index],
            (Some(given), Argument::V) => return given.v[index],
            _ => {}
        }
        let given = Sym::new(self.graph, self.graph.input(argument, index));
        let offset = if argument == Argument::Q { self.offsets.get(index).copied() } else { None };
        given - offset.unwrap_or(0.0)
    }
    /// Three consecutive elements of an argument.
    pub fn input3(&self, argument: Argument, first: usize) -> Vector3<'g> {
        Vector3([0, 1, 2].map(|i| self.input(argument, first + i)))
    }
    /// The zero vector.
    pub fn zero3(&self) -> Vector3<'g> {
        Vector3::zero(self.graph)
    }
    /// A unit vector along a coordinate axis, times `value`.
    pub fn along(&self, axis: usize, value: Sym<'g>) -> Vector3<'g> {
        let mut v = self.zero3();
        v[axis] = value;
        v
    }

    /// Value of a joint variable in the direction of the body's coordinate axis: `±x`.
    pub fn signed(&self, body: usize, x: Sym<'g>) -> Sym<'g> {
        match self.tree.bodies[body].motion {
            JointMotion::Revolute { reversed: true, .. } | JointMotion::Prismatic { reversed: true, .. } => {
                -x
            }
            _ => x,
        }
    }

    /// A vector of the body's frame in the parent's axes (for a free root: world axes).
    pub fn up(&self, body: usize, x: Vector3<'g>) -> Vector3<'g> {
        let b = &self.tree.bodies[body];
        let moved = match b.motion {
            JointMotion::Revolute { axis, .. } => {
                let (s, c) = self.sin_cos(body);
                rotate(axis, s, c, x)
            }
            JointMotion::Prismatic { .. } => x,
            JointMotion::Free => return self.base_rotation(body) * x,
        };
        rotate_constant(self.graph, &b.placement.rotation, moved)
    }

    /// A vector of the parent's frame in the body's axes.
    pub fn down(&self, body: usize, x: Vector3<'g>) -> Vector3<'g> {
        let b = &self.tree.bodies[body];
        if b.motion == JointMotion::Free {
            return self.base_rotation(body).transpose() * x;
        }
        let placed = rotate_constant(self.graph, &b.placement.rotation.inverse(), x);
        match b.motion {
            JointMotion::Revolute { axis, .. } => {
                let (s, c) = self.sin_cos(body);
                rotate(axis, -s, c, placed)
            }
            _ => placed,
        }
    }

    /// Sine and cosine of the body's turn about its coordinate axis.
    pub fn sin_cos(&self, body: usize) -> (Sym<'g>, Sym<'g>) {
        let angle = self.signed(body, self.input(Argument::Q, self.tree.bodies[body].q_index));
        (angle.sin(), angle.cos())
    }

    /// Origin of the body's frame in the parent's frame (for a free root: in the world).
    pub fn offset(&self, body: usize) -> Vector3<'g> {
        let b = &self.tree.bodies[body];
        let fixed = Vector3::constant(self.graph, b.placement.translation);
        match b.motion {
            JointMotion::Revolute { .. } => fixed,
            JointMotion::Free => self.input3(Argument::Q, b.q_index),
            JointMotion::Prismatic { axis, .. } => {
                let travel = self.signed(body, self.input(Argument::Q, b.q_index));
                fixed + rotate_constant(self.graph, &b.placement.rotation, self.along(axis, travel))
            }
        }
    }

    /// Rotation of a free root, from its unit quaternion (x y z w).
    pub fn base_rotation(&self, body: usize) -> Matrix3<'g> {
        if self.given.is_some() {
            return Matrix3::identity(self.graph);
        }
        let first = self.tree.bodies[body].q_index + 3;
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| self.input(Argument::Q, first + i));
        let (x2, y2, z2) = (x * 2.0, y * 2.0, z * 2.0);
        let one = self.constant(1.0);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz) = (x * y2, x * z2, y * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        Matrix3([
            [one - (yy + zz), xy - wz, xz + wy],
            [xy + wz, one - (xx + zz), yz - wx],
            [xz - wy, yz + wx, one - (xx + yy)],
        ])
    }

    /// A constant placement's rotation applied to a vector.
    pub fn placed(&self, placement: &Placement, x: Vector3<'g>) -> Vector3<'g> {
        rotate_constant(self.graph, &placement.rotation, x)
    }

    /// A vector in the axes of a constant placement.
    pub fn placed_back(&self, placement: &Placement, x: Vector3<'g>) -> Vector3<'g> {
        rotate_constant(self.graph, &placement.rotation.inverse(), x)
    }

    /// The direction of a joint in its body's axes.
    pub fn joint_axis(&self, body: usize) -> Vector3<'g> {
        match self.tree.bodies[body].motion {
            JointMotion::Revolute { axis, .. } | JointMotion::Prismatic { axis, .. } => {
                self.along(axis, self.signed(body, self.constant(1.0)))
            }
            JointMotion::Free => self.zero3(),
        }
    }

    /// Total mass of all bodies, kg.
    pub fn total_mass(&self) -> Sym<'g> {
        self.inertias.iter().fold(self.constant(0.0), |sum, body| sum + body.mass)
    }

    /// The same robot with every inertia divided by its mass.
    pub fn of_unit_mass(&self) -> Self {
        let per_mass = self.constant(1.0) / self.total_mass();
        let scaled = |body: &BodyInertia<'g>| BodyInertia {
            mass: body.mass * per_mass,
            first_moment: body.first_moment.scale(per_mass),
            second_moment: Matrix3(body.second_moment.0.map(|row| row.map(|x| x * per_mass))),
        };
        Self { inertias: self.inertias.iter().map(scaled).collect(), ..self.clone() }
    }

    /// Gravitational acceleration in world axes.
    pub fn gravity(&self) -> Vector3<'g> {
        match &self.given {
            Some(given) => given.gravity,
            None => Vector3::constant(self.graph, self.tree.gravity),
        }
    }
}

/// `R_axis(angle) x`
pub fn rotate<'g>(axis: usize, s: Sym<'g>, c: Sym<'g>, x: Vector3<'g>) -> Vector3<'g> {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut y = x;
    y[u] = c * x[u] - s * x[v];
    y[v] = s * x[u] + c * x[v];
    y
}

/// Whether a turn is by a multiple of π/2, so that it exchanges coordinates and costs nothing.
///
/// The sine alone does not tell: near π/2 it rounds to 1 over 1e-8 rad, where the cosine does not vanish.
pub fn is_right_angle((_, s, c): (usize, Sym<'_>, Sym<'_>)) -> bool {
    s.is_zero() || c.is_zero()
}

/// A constant rotation applied to a vector: elementary turns while there are few, else the matrix.
pub fn rotate_constant<'g>(graph: &'g Graph, rotation: &Rotation, x: Vector3<'g>) -> Vector3<'g> {
    let elementary = |(axis, angle): (usize, f64)| {
        let angle = Sym::new(graph, graph.constant(angle));
        (axis, angle.sin(), angle.cos())
    };
    let turn = |x, &step: &(usize, f64)| {
        let (axis, s, c) = elementary(step);
        rotate(axis, s, c, x)
    };
    let odd = rotation.0.iter().filter(|&&step| !is_right_angle(elementary(step))).count();
    if odd <= 2 {
        return rotation.0.iter().rev().fold(x, turn);
    }
    let columns = [0, 1, 2].map(|k| {
        let mut e = Vector3::zero(graph);
        e[k] = Sym::new(graph, crate::expression::Expr::ONE);
        rotation.0.iter().rev().fold(e, turn)
    });
    Matrix3::from_columns(columns) * x
}
