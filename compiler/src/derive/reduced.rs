//! A free robot with a flat foot, in the coordinates of its joints alone: the base follows the foot.
//!
//! With J_b v = V + A q̇ the twist of the standing foot, taken at the base's origin and in its axes, the base's
//! columns are the identity: V̇ = −A q̈ − w eliminates the base, and what is left is the mass matrix of the
//! robot rooted at that foot, with that tree's sparsity. The base rows then give the foot's wrench.
use super::composite::mass_matrix;
use super::constrained::{ConstraintSolves, Demand, dot, movable_rows};
use super::constraint::Constraints;
use super::kinematics::{Motions, forward};
use super::model::RobotModel;
use super::solve::{Factor, Topology};
use super::support::{Support, SupportKind};
use crate::expression::{Matrix3, Sym, Vector3};
use crate::tree::{BaseKind, JointMotion};
use bipedc_runtime::Argument;

/// The six components of a twist or wrench, linear first.
type Six<'g> = [Sym<'g>; 6];

/// The standing foot as the base sees it.
struct Stance<'g> {
    body: usize,
    /// Rotation of the foot in base axes.
    rotation: Matrix3<'g>,
    /// Origin of the foot's body in base axes, from the base's origin.
    origin: Vector3<'g>,
    /// By degree of freedom: the joint's twist at the base's origin in base axes; `None` off the foot's leg.
    twists: Vec<Option<Six<'g>>>,
}

/// Index of the support that eliminates the base: the first flat foot of a free robot.
pub(super) fn flat_support(model: &RobotModel<'_, '_>, constraints: &Constraints<'_>) -> Option<usize> {
    if model.tree.base != BaseKind::Floating {
        return None;
    }
    let flat = |s: &Support| matches!(s.kind, SupportKind::Flat { .. });
    constraints.supports.iter().position(flat)
}

impl<'g> Stance<'g> {
    fn new(model: &RobotModel<'g, '_>, body: usize) -> Self {
        let tree = model.tree;
        let mut path: Vec<usize> = tree.path_to_root(body).collect();
        path.pop();
        let mut out = Self {
            body,
            rotation: Matrix3::identity(model.graph),
            origin: model.zero3(),
            twists: vec![None; tree.nv],
        };
        for &index in path.iter().rev() {
            out.origin = out.origin + out.rotation * model.offset(index);
            out.rotation = Matrix3(out.rotation.0.map(|row| model.down(index, Vector3(row)).0));
            let axis = out.rotation * model.joint_axis(index);
            let (linear, angular) = match tree.bodies[index].motion {
                JointMotion::Prismatic { .. } => (axis, model.zero3()),
                _ => (out.origin.cross(axis), axis),
            };
            out.twists[tree.bodies[index].v_index] = Some(six(linear, angular));
        }
        out
    }

    /// The rates of the support's rows, as J_b combines the rows: p̈ + ω̇ × r at v̇ = 0, with r from the
    /// support's point p to the base's origin, and ω̇, in base axes.
    ///
    /// The foot's point at the base's origin accelerates by ω × (ω × r) besides: nothing while the foot stands,
    /// but Wᵀ v̇ + w = 0 is to hold in states that miss Wᵀ v = 0 too.
    fn rate(&self, model: &RobotModel<'g, '_>, support: &Support) -> Six<'g> {
        let foot = forward(model, Motions::NO_ACCELERATION)[self.body];
        let point = Vector3::constant(model.graph, support.point);
        let arm = self.rotation.transpose() * -self.origin - point;
        let turning = foot.angular_acceleration;
        // The recursion is the bias' own and carries gravity as an acceleration of the world.
        let linear = foot.acceleration + foot.u * point + turning.cross(arm);
        six(self.rotation * linear + model.down(0, model.gravity()), self.rotation * turning)
    }

    /// J_b v.
    fn velocity(&self, model: &RobotModel<'g, '_>) -> Six<'g> {
        let v = |k: usize| model.input(Argument::V, k);
        [0, 1, 2, 3, 4, 5].map(|i| {
            let joints = self.twists.iter().enumerate().filter_map(|(k, a)| a.map(|a| a[i] * v(k)));
            joints.fold(v(i), |sum, x| sum + x)
        })
    }

    /// A wrench at the base's origin, base axes, as the rows of the foot's support: about its point, in the
    /// foot's axes.
    fn at_point(&self, model: &RobotModel<'g, '_>, support: &Support, wrench: Six<'g>) -> Vec<Sym<'g>> {
        let point = self.origin + self.rotation * Vector3::constant(model.graph, support.point);
        let force = Vector3([wrench[0], wrench[1], wrench[2]]);
        let moment = Vector3([wrench[3], wrench[4], wrench[5]]) - point.cross(force);
        let world = model.base_rotation(0);
        [world * force, world * moment].iter().flat_map(|x| x.0).collect()
    }
}

fn six<'g>(linear: Vector3<'g>, angular: Vector3<'g>) -> Six<'g> {
    [linear[0], linear[1], linear[2], angular[0], angular[1], angular[2]]
}

/// D with the base eliminated.
struct Reduced<'g> {
    stance: Stance<'g>,
    /// D of the base.
    base: Vec<Six<'g>>,
    /// By degree of freedom, base rows: G_k = D_bk − D_bb A_k on the foot's leg, D_bk elsewhere.
    coupling: Vec<Six<'g>>,
    factor: Factor<'g>,
}

impl<'g> Reduced<'g> {
    fn new(model: &RobotModel<'g, '_>, body: usize, rotors: &[Sym<'g>]) -> Self {
        let d = mass_matrix(model);
        let nv = model.tree.nv;
        let stance = Stance::new(model, body);
        let base: Vec<Six<'g>> = (0..6).map(|r| [0, 1, 2, 3, 4, 5].map(|c| d[r][c])).collect();
        let coupling: Vec<Six<'g>> = (0..nv)
            .map(|k| {
                [0, 1, 2, 3, 4, 5].map(|r| match stance.twists[k] {
                    Some(a) => d[r][k] - dot(&base[r], &a),
                    None => d[r][k],
                })
            })
            .collect();
        let mut reduced = d;
        let above = ancestors(model);
        for k in 6..nv {
            for l in 6..nv {
                // Where the leg's joint k carries l, D_kl = A_k · D_bl: the terms of D cancel. Elsewhere D_kl = 0.
                reduced[k][l] = match (stance.twists[k], stance.twists[l]) {
                    (None, None) => reduced[k][l],
                    (Some(a), None) if !above[l].contains(&k) => -dot(&a, &coupling[l]),
                    (None, Some(a)) if !above[k].contains(&l) => -dot(&a, &coupling[k]),
                    (Some(_), None) | (None, Some(_)) => model.constant(0.0),
                    (Some(a), Some(b)) => {
                        let k_is_nearer = depth(model, k) <= depth(model, l);
                        -if k_is_nearer { dot(&b, &coupling[k]) } else { dot(&a, &coupling[l]) }
                    }
                };
            }
            reduced[k][k] = reduced[k][k] + rotors.get(k).copied().unwrap_or(model.constant(0.0));
        }
        let factor = Factor::with_topology(model, Topology::standing_on(model.tree, body), &reduced);
        Self { stance, base, coupling, factor }
    }

    /// Nᵀ (f + D_b w): what drives the joints when the base has the acceleration −w besides.
    fn driving(&self, f: &[Sym<'g>], w: &Six<'g>) -> Vec<Sym<'g>> {
        let row = |k: usize| {
            let driven = f[k] + dot(&self.coupling[k], w);
            self.stance.twists[k].map_or(driven, |a| driven - dot(&a, &f[..6]))
        };
        (0..f.len()).map(|k| if k < 6 { f[k].zero() } else { row(k) }).collect()
    }
}

/// By degree of freedom: those of the bodies above.
fn ancestors(model: &RobotModel<'_, '_>) -> Vec<Vec<usize>> {
    let bodies = &model.tree.bodies;
    let mut out = vec![Vec::new(); model.tree.nv];
    for (index, body) in bodies.iter().enumerate() {
        out[body.v_index] = model.tree.path_to_root(index).skip(1).map(|k| bodies[k].v_index).collect();
    }
    out
}

/// Number of bodies above the one that this degree of freedom moves.
fn depth(model: &RobotModel<'_, '_>, row: usize) -> usize {
    let body = model.tree.bodies.iter().position(|body| body.v_index == row).unwrap_or(0);
    model.tree.path_to_root(body).count()
}

/// As [`super::constrained::respond`], by eliminating the base.
pub(super) fn respond<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    rotors: &[Sym<'g>],
    f: &[Sym<'g>],
    (flat, demand): (usize, Demand),
) -> (Vec<Sym<'g>>, Vec<Sym<'g>>) {
    let support = &constraints.supports[flat];
    let system = Reduced::new(model, support.body, rotors);
    let w = match demand {
        Demand::Rates => system.stance.rate(model, support),
        Demand::Velocity => system.stance.velocity(model),
    };
    let others: Vec<_> = constraints.blocks.iter().filter(|block| block.support != flat).collect();
    let rows: Vec<&Vec<Sym<'g>>> = others.iter().flat_map(|block| &block.jacobian).collect();
    let movable = movable_rows(model, constraints, |model, constraints| {
        on_joints(&Stance::new(model, constraints.supports[flat].body), constraints, flat)
    });
    let on_joints = on_joints(&system.stance, constraints, flat);
    let held = ConstraintSolves::new(&system.factor, on_joints, movable);
    let rates = others.iter().flat_map(|block| block.demanded(model, demand));
    let rates = rates.zip(&rows).map(|(rate, row)| rate - dot(&row[..6], &w)).collect();
    let (mut motion, forces) = held.solve(&system.factor, &system.driving(f, &w), rates);
    // Of a robot without joints the factor has no rows.
    motion.resize(f.len(), model.constant(0.0));
    let mut wrench = Vec::new();
    for i in 0..6 {
        let joints = |of: &dyn Fn(usize) -> Sym<'g>| {
            (6..f.len()).map(|k| of(k) * motion[k]).fold(f[i].zero(), |sum, x| sum + x)
        };
        let driven = joints(&|k| system.coupling[k][i]);
        let others = rows.iter().zip(&forces).fold(f[i].zero(), |sum, (row, &x)| sum + row[i] * x);
        wrench.push(driven - (f[i] + dot(&system.base[i], &w)) - others);
        motion[i] = -(joints(&|k| system.stance.twists[k].map_or(f[i].zero(), |a| a[i])) + w[i]);
    }
    let wrench: Six<'g> = [0, 1, 2, 3, 4, 5].map(|i| wrench[i]);
    let standing = system.stance.at_point(model, support, wrench);
    (motion, published(constraints, flat, &standing, &forces))
}

/// The other feet's rows on the joints alone, the base following the flat foot.
fn on_joints<'g>(stance: &Stance<'g>, constraints: &Constraints<'g>, flat: usize) -> Vec<Vec<Sym<'g>>> {
    let others = constraints.blocks.iter().filter(|block| block.support != flat);
    let reduce =
        |row: &Vec<Sym<'g>>, k: usize| stance.twists[k].map_or(row[k], |a| row[k] - dot(&a, &row[..6]));
    let row = |row: &Vec<Sym<'g>>| {
        (0..row.len()).map(|k| if k < 6 { row[k].zero() } else { reduce(row, k) }).collect()
    };
    others.flat_map(|block| &block.jacobian).map(row).collect()
}

/// λ in the order of the rows: the flat foot's in between the others'.
fn published<'g>(
    constraints: &Constraints<'g>,
    flat: usize,
    standing: &[Sym<'g>],
    others: &[Sym<'g>],
) -> Vec<Sym<'g>> {
    let (mut standing, mut others, mut out) = (standing, others, Vec::new());
    for block in &constraints.blocks {
        let n = block.rate.len();
        let from = if block.support == flat { &mut standing } else { &mut others };
        let (these, rest) = from.split_at(n);
        *from = rest;
        out.extend(if block.support == flat { these.to_vec() } else { block.publish(these) });
    }
    out
}
