//! Rows of velocity constraints J v = 0 of standing feet, and their rates J̇ v.
use super::constrained::{Demand, dot};
use super::kinematics::{BodyMotion, Motions, forward};
use super::model::RobotModel;
use super::support::{Support, SupportKind, supports};
use crate::description::model::{Contact, Foot};
use crate::expression::{Matrix3, Sym, Vector3};
use crate::tree::JointMotion;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::Argument;

/// Constraint rows of a phase: J v = 0 with J = Wᵀ (4.23c), m rows, in the order of [`Constraints::names`].
///
/// Per foot, in world axes at the support's point (see [`Support::point`]): `foot/force/x`, `/y`, `/z` (N,
/// z positive pushes the robot up), then `foot/moment/x`, `/y`, `/z` (N m). In the plane: `force/x`,
/// `force/z`, `moment/y`. An edge has instead of the moments two about axes fixed in the foot:
/// `moment/across` (along the sole, perpendicular to the edge) and `moment/normal` (perpendicular to both;
/// vertical while the foot stands flat). They stay perpendicular to the edge while the foot tips, which
/// world axes do not. A root that pivots and is held: `moment/pivot`, about the pivot axis.
///
/// λ is conjugate to the rows: what the ground does to the robot.
#[derive(Debug, Clone)]
pub struct Constraints<'g> {
    /// Names of the rows and of their λ.
    pub names: Vec<String>,
    /// Units of λ: `N` or `N m`.
    pub units: Vec<&'static str>,
    /// J = Wᵀ, m × nv: row by row; m or rad per unit of `v`.
    pub jacobian: Vec<Vec<Sym<'g>>>,
    /// w = J̇ v (4.23, with the factor q̇ that Table 4.1 lacks), m/s² or rad/s².
    pub rate: Vec<Sym<'g>>,
    /// The same rows in axes of the feet, block by block: they are sparser.
    pub(super) blocks: Vec<Block<'g>>,
    /// The feet behind the rows.
    pub(super) supports: Vec<Support>,
}

/// Rows of one kind of one foot, in body axes.
#[derive(Debug, Clone)]
pub(super) struct Block<'g> {
    /// Which of the supports.
    pub support: usize,
    /// Jacobian in body axes, row by row.
    pub jacobian: Vec<Vec<Sym<'g>>>,
    /// Rates in body axes.
    pub rate: Vec<Sym<'g>>,
    /// The same rates from the recursion that carries gravity: shared with the bias.
    pub rate_with_gravity: Vec<Sym<'g>>,
    /// `world row = turn · body row`, orthonormal; `None`: equal.
    turn: Option<Vec<Vec<Sym<'g>>>>,
}

impl<'g> Block<'g> {
    /// J̇ v or J v in body axes.
    pub fn demanded(&self, model: &RobotModel<'g, '_>, demand: Demand) -> Vec<Sym<'g>> {
        match demand {
            Demand::Rates => self.rate_with_gravity.clone(),
            Demand::Velocity => {
                let v: Vec<Sym<'g>> = (0..model.tree.nv).map(|k| model.input(Argument::V, k)).collect();
                self.jacobian.iter().map(|row| dot(row, &v)).collect()
            }
        }
    }

    /// From the foot's axes to the published rows: forces, rates or columns of J alike.
    pub fn publish(&self, rows: &[Sym<'g>]) -> Vec<Sym<'g>> {
        let Some(turn) = &self.turn else { return rows.to_vec() };
        let zero = rows[0].zero();
        let dot = |t: &Vec<Sym<'g>>| t.iter().zip(rows).fold(zero, |sum, (&a, &b)| sum + a * b);
        turn.iter().map(dot).collect()
    }
}

/// A foot's point seen from its own body: columns of the Jacobian in body axes and the body's rotation.
pub(super) struct BodyJacobian<'g> {
    /// By degree of freedom: linear and angular velocity in body axes.
    pub columns: Vec<(Vector3<'g>, Vector3<'g>)>,
    /// Columns are the body's axes in the world.
    pub rotation: Matrix3<'g>,
}

impl<'g> BodyJacobian<'g> {
    /// Of the point `at` (body axes) of `body`, walking to the root: near joints cost almost nothing.
    pub fn new(model: &RobotModel<'g, '_>, body: usize, at: [f64; 3]) -> Self {
        let zero = model.zero3();
        let mut columns = vec![(zero, zero); model.tree.nv];
        // Axes of the present body in axes of the first, and the point relative to its origin.
        let mut turn = Matrix3::identity(model.graph);
        let mut arm = Vector3::constant(model.graph, at);
        for index in model.tree.path_to_root(body) {
            let moved = &model.tree.bodies[index];
            let one = model.signed(index, model.constant(1.0));
            match moved.motion {
                JointMotion::Free => {
                    for k in 0..3 {
                        let axis = turn.column(k);
                        columns[moved.v_index + k] = (axis, zero);
                        columns[moved.v_index + 3 + k] = (axis.cross(arm), axis);
                    }
                }
                JointMotion::Revolute { axis, .. } => {
                    let axis = turn.column(axis).scale(one);
                    columns[moved.v_index] = (axis.cross(arm), axis);
                }
                JointMotion::Prismatic { axis, .. } => {
                    columns[moved.v_index] = (turn.column(axis).scale(one), zero);
                }
            }
            turn = Matrix3(turn.0.map(|row| model.up(index, Vector3(row)).0));
            arm = arm + turn * model.offset(index);
        }
        Self { columns, rotation: turn.transpose() }
    }
}

/// Rows of one kind of one foot, before they become expressions.
struct Group {
    linear: bool,
    /// Directions in body axes.
    basis: Vec<[f64; 3]>,
    /// World axes of the published rows; `None`: the directions themselves.
    world: Option<Vec<usize>>,
    names: &'static [&'static str],
}

fn groups(kind: &SupportKind) -> Vec<Group> {
    let linear = |basis: &Vec<[f64; 3]>| match basis.len() {
        2 => Group {
            linear: true,
            basis: basis.clone(),
            world: Some(vec![0, 2]),
            names: &["force/x", "force/z"],
        },
        _ => Group {
            linear: true,
            basis: basis.clone(),
            world: Some(vec![0, 1, 2]),
            names: &["force/x", "force/y", "force/z"],
        },
    };
    let angular = |basis: Vec<[f64; 3]>, world, names| Group { linear: false, basis, world, names };
    match kind {
        SupportKind::Point { linear: basis } => vec![linear(basis)],
        SupportKind::Edge { across, normal } => {
            let axes = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let turns = angular(vec![*across, *normal], None, &["moment/across", "moment/normal"]);
            vec![linear(&axes), turns]
        }
        SupportKind::Flat { linear: basis, angular: turns } if turns.len() == 1 => {
            vec![linear(basis), angular(turns.clone(), None, &["moment/y"])]
        }
        SupportKind::Flat { linear: basis, angular: turns } => {
            let names = &["moment/x", "moment/y", "moment/z"];
            vec![linear(basis), angular(turns.clone(), Some(vec![0, 1, 2]), names)]
        }
        SupportKind::Pivot => Vec::new(),
    }
}

impl<'g> Constraints<'g> {
    /// Rows of `contacts` (see [`supports`] for what they mean and which rows fall away).
    ///
    /// # Errors
    /// As [`supports`].
    pub fn new(model: &RobotModel<'g, '_>, feet: &[Foot], contacts: &[Contact]) -> Result<Self, Diagnostic> {
        let list = supports(model.tree, feet, contacts)?;
        Ok(Self::of_supports(model, &list))
    }

    /// Rows of supports found before.
    pub fn of_supports(model: &RobotModel<'g, '_>, list: &[Support]) -> Self {
        let mut out = Self {
            names: Vec::new(),
            units: Vec::new(),
            jacobian: Vec::new(),
            rate: Vec::new(),
            blocks: Vec::new(),
            supports: list.to_vec(),
        };
        let motions = |gravity| forward(model, Motions { velocity: true, acceleration: false, gravity });
        let (plain, heavy) = (motions(false), motions(true));
        for (number, support) in list.iter().enumerate() {
            if support.kind == SupportKind::Pivot {
                out.push(model, &support.foot, &["moment/pivot"], "N m", pivot(model, number));
                continue;
            }
            let seen = BodyJacobian::new(model, support.body, support.point);
            let at = Vector3::constant(model.graph, support.point);
            // The recursion with gravity holds a - g; the point's own acceleration is that plus g.
            let g = seen.rotation.transpose() * model.gravity();
            let motion = &plain[support.body];
            let shared = &heavy[support.body];
            let rates = [point_rate(motion, at), point_rate(shared, at) + g];
            for group in groups(&support.kind) {
                let block = block(model, (number, &group), &seen, rates, motion.angular_acceleration);
                let unit = if group.linear { "N" } else { "N m" };
                out.push(model, &support.foot, group.names, unit, block);
            }
        }
        out
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rate.len()
    }

    /// Whether nothing is constrained.
    pub fn is_empty(&self) -> bool {
        self.rate.is_empty()
    }

    /// λ in the published rows from λ in axes of the feet.
    pub(super) fn publish(&self, forces: &[Sym<'g>]) -> Vec<Sym<'g>> {
        let mut first = 0;
        let mut out = Vec::new();
        for block in &self.blocks {
            let next = first + block.rate.len();
            out.extend(block.publish(&forces[first..next]));
            first = next;
        }
        out
    }

    fn push(
        &mut self,
        model: &RobotModel<'g, '_>,
        foot: &str,
        names: &[&str],
        unit: &'static str,
        block: Block<'g>,
    ) {
        self.names.extend(names.iter().map(|name| format!("{foot}/{name}")));
        self.units.extend(names.iter().map(|_| unit));
        self.rate.extend(block.publish(&block.rate));
        let mut rows = vec![Vec::new(); block.rate.len()];
        for k in 0..model.tree.nv {
            let column: Vec<Sym<'g>> = block.jacobian.iter().map(|row| row[k]).collect();
            for (row, x) in rows.iter_mut().zip(block.publish(&column)) {
                row.push(x);
            }
        }
        self.jacobian.extend(rows);
        self.blocks.push(block);
    }
}

/// Acceleration of a point at v̇ = 0, in body axes.
fn point_rate<'g>(motion: &BodyMotion<'g>, at: Vector3<'g>) -> Vector3<'g> {
    motion.acceleration + motion.u * at
}

fn block<'g>(
    model: &RobotModel<'g, '_>,
    (support, group): (usize, &Group),
    seen: &BodyJacobian<'g>,
    [rate, with_gravity]: [Vector3<'g>; 2],
    angular_rate: Vector3<'g>,
) -> Block<'g> {
    let basis: Vec<Vector3<'g>> = group.basis.iter().map(|&u| Vector3::constant(model.graph, u)).collect();
    let row = |u: &Vector3<'g>| {
        let part = |(linear, angular): &(Vector3<'g>, Vector3<'g>)| {
            u.dot(if group.linear { *linear } else { *angular })
        };
        seen.columns.iter().map(part).collect()
    };
    let along = |x: Vector3<'g>| basis.iter().map(|u| u.dot(x)).collect::<Vec<_>>();
    let (rate, rate_with_gravity) = if group.linear {
        (along(rate), along(with_gravity))
    } else {
        (along(angular_rate), along(angular_rate))
    };
    let turned: Vec<Vector3<'g>> = basis.iter().map(|&u| seen.rotation * u).collect();
    let turn = group
        .world
        .as_ref()
        .map(|axes| axes.iter().map(|&axis| turned.iter().map(|t| t[axis]).collect()).collect());
    Block { support, jacobian: basis.iter().map(row).collect(), rate, rate_with_gravity, turn }
}

/// The pivot's angle is held: one row that is a unit vector.
fn pivot<'g>(model: &RobotModel<'g, '_>, support: usize) -> Block<'g> {
    let mut row = vec![model.constant(0.0); model.tree.nv];
    row[model.tree.bodies[0].v_index] = model.constant(1.0);
    let zero = vec![model.constant(0.0)];
    Block { support, jacobian: vec![row], rate: zero.clone(), rate_with_gravity: zero, turn: None }
}
