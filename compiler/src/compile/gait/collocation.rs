//! What an optimisation of a gait is put together from: at a node of a phase the equations of motion, the contacts and the virtual constraints,
//! and the change from each phase to the next, as functions with exact derivatives.
use super::in_the_plane;
use super::phased_in_process::{feet, standing};
use super::regularity::regularity;
use crate::compile::without_poles;
use crate::derive::constraint::Constraints;
use crate::derive::contact::contact_points;
use crate::derive::curve::bernstein;
use crate::derive::effects::{At, JointLaws};
use crate::derive::newton_euler::generalised_forces;
use crate::derive::relabel::Relabelling;
use crate::derive::virtual_constraints::controlled_of;
use crate::derive::{InertiaMode, Motions, RobotModel};
use crate::description::gait::{AnyGait, GaitOutput, hip_height};
use crate::description::model::{Contact, Phase, RobotDescription};
use crate::expression::{Graph, Input, Sym, replaced, slopes_along};
use crate::program::LocalFunction;
use crate::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::Effect;
use bipedc_effects::effect::formula::Formula;
use bipedc_runtime::Argument;
use bipedc_runtime::control::{MOST_FEET, StandingFoot};
use std::collections::BTreeMap;

/// What of a gait an optimisation keeps: what is controlled and over what, not what it is to be.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitForm {
    /// Size of gravity, m/s²; `None`: that of the description.
    pub gravity: Option<f64>,
    /// Formulas that other formulas name.
    pub quantities: BTreeMap<String, Formula>,
    /// Makes another body of the description.
    pub effects: Vec<Effect>,
    /// In order; after the last comes the first.
    pub phases: Vec<PhaseForm>,
}

/// The same of a phase.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseForm {
    /// Phase of the description.
    pub name: String,
    /// φ(q)
    pub variable: Formula,
    /// Of φ.
    pub unit: String,
    /// Outputs, whose `wanted` does not count.
    pub outputs: Vec<GaitOutput>,
    /// Bezier coefficients of each output.
    pub coefficients: usize,
}

impl GaitForm {
    /// Of a gait, with so many coefficients of each output's polynomial.
    pub fn new(gait: &AnyGait, coefficients: usize) -> Self {
        let phase = |name: &str, (variable, unit): (&Formula, &str), outputs: &[GaitOutput]| PhaseForm {
            name: name.to_owned(),
            variable: variable.clone(),
            unit: unit.to_owned(),
            outputs: outputs.to_vec(),
            coefficients,
        };
        match gait {
            AnyGait::OnePhase(gait) => Self {
                gravity: gait.gravity,
                quantities: gait.quantities.clone(),
                effects: gait.effects.clone(),
                phases: vec![phase(
                    &gait.phase.name,
                    (&gait.phase.variable, &gait.phase.unit),
                    &gait.phase.outputs,
                )],
            },
            AnyGait::Phased(gait) => Self {
                gravity: gait.gravity,
                quantities: gait.quantities.clone(),
                effects: gait.effects.clone(),
                phases: (gait.phases.iter())
                    .map(|of| phase(&of.name, (&of.variable, &of.unit), &of.outputs))
                    .collect(),
            },
        }
    }
}

/// How fast deviations of outputs from zero decay over the nodes, of the rate √(g/h) of a pendulum as high as the hips.
const STABLE: f64 = 4.0;

/// A kind of rows of a node, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NodeRow {
    /// What inverse dynamics needs less torques and forces of the ground, by row of v; N and N m. (4.6)
    Dynamics,
    /// Accelerations of what the ground holds, by force; m/s² or rad/s². (4.23)
    Contact,
    /// ÿ by output with a little of ẏ and y, so that these stay zero; y = h₀(q) − h_d(φ(q)). (6.27)
    OutputAcceleration,
    /// y.
    Output,
    /// ẏ.
    OutputRate,
    /// φ(q), then φ less its first and less its last value in the phase.
    Phase,
    /// φ̇.
    PhaseRate,
    /// Height of each contact point of the robot, m.
    Height,
    /// Its rate, m/s.
    HeightRate,
    /// x of each contact point, m.
    Place,
    /// By foot: a determinant that vanishes where its leg is straight; 0 where outputs settle the leg.
    Regularity,
}

/// One phase. Variables of a node: q, v, a, φ at the phase's first and at its last node, torques by joint, forces of the ground,
/// Bezier coefficients output after output.
#[derive(Debug, Clone)]
pub struct CollocationPhase {
    /// As the description calls it.
    pub name: String,
    /// All rows of a node.
    pub node: LocalFunction,
    /// Kinds of rows, with the first and how many.
    pub rows: Vec<(NodeRow, usize, usize)>,
    /// Names of the forces of the ground.
    pub forces: Vec<String>,
    /// Unit of φ.
    pub unit: String,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// Their units.
    pub output_units: Vec<String>,
    /// Coefficients of each.
    pub coefficients: usize,
    /// Feet that stand.
    pub feet: [Option<StandingFoot>; MOST_FEET],
    /// Contact points that stand, by index.
    pub standing: Vec<usize>,
}

/// The change to the next phase. Variables: q⁻, v⁻, q⁺, v⁺ and the impulses. Rows: q⁺ less what it has to be, the balance of momentum (without
/// an impact: v⁺ less what it has to be), velocities of what the impact holds, upward velocities of all contact points just after it (before a
/// relabelling).
#[derive(Debug, Clone)]
pub struct CollocationChange {
    /// All rows.
    pub function: LocalFunction,
    /// Names of the impulses.
    pub impulses: Vec<String>,
    /// Feet on which they act.
    pub feet: [Option<StandingFoot>; MOST_FEET],
    /// Whether left and right swap.
    pub relabel: bool,
    /// Points that come to the ground, and those that are let go, by index; before a relabelling.
    pub landing: Vec<usize>,
    /// Those that are let go.
    pub leaving: Vec<usize>,
}

/// All functions of a robot's step.
#[derive(Debug, Clone)]
pub struct Collocation {
    /// Phases.
    pub phases: Vec<CollocationPhase>,
    /// The change behind each.
    pub changes: Vec<CollocationChange>,
    /// The robot in the world of the gait.
    pub description: RobotDescription,
    /// Its tree.
    pub tree: Tree,
    /// How the legs swap: for each row of v the row that takes its place, and the sign.
    pub relabelling: Vec<(usize, f64)>,
    /// Mass of the robot, kg.
    pub mass: f64,
}

impl Collocation {
    /// Whether the height of a point counts in a phase: no point of its foot stands, and where the foot lands at the end, it stood in the phase before. A foot
    /// that is in the air for several phases is near the ground all through the last one.
    #[must_use]
    pub fn swings(&self, phase: usize, point: usize) -> bool {
        let count = self.phases.len();
        let before = (phase + count - 1) % count;
        let of_foot = |points: &[usize], foot: &str| points.iter().any(|&point| self.foot(point) == foot);
        let foot = self.foot(point);
        let lands = of_foot(&self.changes[phase].landing, foot);
        let other = if self.changes[before].relabel { self.other_foot(foot) } else { foot };
        let stood = of_foot(&self.phases[before].standing, other);
        !of_foot(&self.phases[phase].standing, foot) && (stood || !lands)
    }

    fn foot(&self, point: usize) -> &str {
        self.tree.points[point].name.split('/').next().unwrap_or("")
    }

    fn other_foot<'f>(&'f self, foot: &'f str) -> &'f str {
        let others = self.description.feet.iter().find(|other| other.name != foot);
        others.map_or(foot, |other| other.name.as_str())
    }
}

/// Derives them.
///
/// # Errors
/// A base that is not planar, formulas without a value, contacts that are not independent.
pub fn compile_collocation(
    description: &RobotDescription,
    form: &GaitForm,
) -> Result<Collocation, Diagnostic> {
    let (description, tree) = in_the_plane(description, (form.gravity, &form.effects))?;
    let (mut phases, mut changes) = (Vec::new(), Vec::new());
    for of in &form.phases {
        let phase = find(&description, &of.name)?;
        phases.push(node(&description, &tree, form, (of, phase))?);
        changes.push(change(&description, &tree, phase)?);
    }
    let relabelling = relabelling(&tree, &description)?;
    let mass = tree.bodies.iter().map(|body| body.inertia.mass).sum();
    Ok(Collocation { phases, changes, description, tree, relabelling, mass })
}

fn find<'d>(description: &'d RobotDescription, name: &str) -> Result<&'d Phase, Diagnostic> {
    let found = description.phases.iter().find(|phase| phase.name == name);
    found.ok_or_else(|| Diagnostic::error(format!("the robot has no phase `{name}`")))
}

/// R v as permutation with signs, read off its action on unit vectors.
fn relabelling(tree: &Tree, description: &RobotDescription) -> Result<Vec<(usize, f64)>, Diagnostic> {
    let relabel = Relabelling::new(tree, description)?;
    let graph = Graph::new();
    let model = RobotModel::new(&graph, tree, InertiaMode::Folded);
    let mut found = vec![(0, 1.0); tree.nv];
    for column in 0..tree.nv {
        let unit: Vec<Sym<'_>> =
            (0..tree.nv).map(|k| model.constant(if k == column { 1.0 } else { 0.0 })).collect();
        for (row, value) in relabel.velocity(&unit).iter().enumerate() {
            if let Some(sign) = value.constant_value().filter(|x| *x != 0.0) {
                found[row] = (column, sign);
            }
        }
    }
    Ok(found)
}

/// Derivative along the motion.
fn rate<'g>(model: &RobotModel<'g, '_>, of: &[Sym<'g>]) -> Vec<Sym<'g>> {
    slopes_along(of, |input| match input.argument {
        Argument::Q => Some(model.input(Argument::V, input.index as usize)),
        Argument::V => Some(model.input(Argument::A, input.index as usize)),
        _ => None,
    })
}

/// The first arguments, nv of each, then the parameters, all as parameters in this order.
fn all_local<'g>(model: &RobotModel<'g, '_>, first: &[Argument], rows: &[Sym<'g>]) -> Vec<Sym<'g>> {
    let nv = model.tree.nv;
    replaced(rows, |Input { argument, index }| {
        let block = match argument {
            Argument::Parameters => first.len(),
            _ => first.iter().position(|known| *known == argument)?,
        };
        Some(model.input(Argument::Parameters, block * nv + index as usize))
    })
}

fn node(
    description: &RobotDescription,
    tree: &Tree,
    form: &GaitForm,
    (of, phase): (&PhaseForm, &Phase),
) -> Result<CollocationPhase, Diagnostic> {
    let graph = Graph::new();
    let model = RobotModel::new(&graph, tree, InertiaMode::Folded);
    let held = Constraints::new(&model, &description.feet, &phase.contacts)?;
    let (nv, joints, forces) = (tree.nv, tree.joints.len(), held.len());
    let given = |index: usize| model.input(Argument::Parameters, index);
    let (torques, pushes, coefficients) = (2, 2 + joints, 2 + joints + forces);
    let loads = unbalanced(&model, description, &held, [torques, pushes])?;
    let acceleration = |row: usize| {
        let products = (0..nv).map(|k| held.jacobian[row][k] * model.input(Argument::A, k));
        products.fold(held.rate[row], |sum, x| sum + x)
    };
    let contact: Vec<Sym<'_>> = (0..forces).map(acceleration).collect();
    let controlled = controlled_of(&model, &form.quantities, (&of.variable, &of.outputs))?;
    let (variable, [first, last]) = (controlled[0], [given(0), given(1)]);
    let s = (variable - first) / (last - first);
    let output = |k: usize| {
        let own: Vec<Sym<'_>> =
            (0..of.coefficients).map(|c| given(coefficients + k * of.coefficients + c)).collect();
        controlled[1 + k] - bernstein(s, own.len(), |k, power, binomial| power * own[k] * binomial)
    };
    let outputs: Vec<Sym<'_>> = (0..of.outputs.len()).map(output).collect();
    let output_rates = rate(&model, &outputs);
    let gravity = description.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    let decay = STABLE * (gravity / hip_height(description)).sqrt();
    let points = contact_points(&model);
    let kinds = [
        (NodeRow::Dynamics, loads),
        (NodeRow::Contact, contact),
        (NodeRow::OutputAcceleration, held_accelerations(&model, decay, (&outputs, &output_rates))),
        (NodeRow::Output, outputs),
        (NodeRow::OutputRate, output_rates),
        (NodeRow::Phase, vec![variable, variable - first, variable - last]),
        (NodeRow::PhaseRate, rate(&model, &[variable])),
        (NodeRow::Height, points.normal.clone()),
        (NodeRow::HeightRate, rate(&model, &points.normal)),
        (NodeRow::Place, points.tangential.clone()),
        (
            NodeRow::Regularity,
            regularity(&model, description, [&points.tangential, &points.normal], &controlled[1..]),
        ),
    ];
    let (mut all, mut rows) = (Vec::new(), Vec::new());
    for (kind, of_kind) in kinds {
        rows.push((kind, all.len(), of_kind.len()));
        all.extend(of_kind);
    }
    let all = all_local(&model, &[Argument::Q, Argument::V, Argument::A], &all);
    let variables = 3 * nv + coefficients + of.outputs.len() * of.coefficients;
    let node = LocalFunction::new(&graph, variables, &all);
    without_poles(&graph, &format!("phase `{}` of the gait", of.name))?;
    Ok(CollocationPhase {
        name: of.name.clone(),
        node,
        rows,
        unit: of.unit.clone(),
        outputs: of.outputs.iter().map(|output| output.name.clone()).collect(),
        output_units: of.outputs.iter().map(|output| output.unit.clone()).collect(),
        coefficients: of.coefficients,
        feet: feet(description, phase, &held.names)?,
        forces: held.names,
        standing: on_the_ground(description, tree, &phase.contacts),
    })
}

/// What the motion needs less what the ground and the joints give, N and N m; torques and forces of the ground are parameters from these
/// places on.
fn unbalanced<'g>(
    model: &RobotModel<'g, '_>,
    description: &RobotDescription,
    held: &Constraints<'g>,
    [torques, pushes]: [usize; 2],
) -> Result<Vec<Sym<'g>>, Diagnostic> {
    let given = |index: usize| model.input(Argument::Parameters, index);
    let mut loads = generalised_forces(model, Motions::ALL, false);
    for (k, row) in held.jacobian.iter().enumerate() {
        for (load, &slope) in loads.iter_mut().zip(row) {
            *load = *load - slope * given(pushes + k);
        }
    }
    let laws = JointLaws::new(model.tree, description)?;
    if !laws.is_empty() {
        loads = laws.report(model, &At::new(model, true, true), &loads);
    }
    for (k, joint) in model.tree.joints.iter().enumerate() {
        loads[joint.v_index] = loads[joint.v_index] - given(torques + k);
    }
    Ok(loads)
}

/// ÿ + 2 ω ẏ + ω² y: what is left of outputs between nodes decays.
fn held_accelerations<'g>(
    model: &RobotModel<'g, '_>,
    decay: f64,
    (outputs, rates): (&[Sym<'g>], &[Sym<'g>]),
) -> Vec<Sym<'g>> {
    let accelerations = rate(model, rates);
    let held = |((&y, &rate), acceleration): ((&Sym<'g>, &Sym<'g>), Sym<'g>)| {
        acceleration + rate * (2.0 * decay) + y * (decay * decay)
    };
    outputs.iter().zip(rates).zip(accelerations).map(held).collect()
}

/// Contact points that contacts hold, by index.
fn on_the_ground(description: &RobotDescription, tree: &Tree, contacts: &[Contact]) -> Vec<usize> {
    let of_foot = |foot| {
        let names = standing(foot, contacts);
        names.into_iter().map(move |point| format!("{}/{point}", foot.name))
    };
    let names: Vec<String> = description.feet.iter().flat_map(of_foot).collect();
    (0..tree.points.len()).filter(|&k| names.contains(&tree.points[k].name)).collect()
}

fn change(
    description: &RobotDescription,
    tree: &Tree,
    phase: &Phase,
) -> Result<CollocationChange, Diagnostic> {
    let graph = Graph::new();
    let model = RobotModel::new(&graph, tree, InertiaMode::Folded);
    let nv = tree.nv;
    let relabel = Relabelling::new(tree, description)?;
    let legs = (&relabel, phase.relabel);
    let inputs = |argument| (0..nv).map(|k| model.input(argument, k)).collect::<Vec<_>>();
    let given =
        |first: usize| (first..first + nv).map(|k| model.input(Argument::Parameters, k)).collect::<Vec<_>>();
    let (q, v) = (inputs(Argument::Q), inputs(Argument::V));
    let [next_q, next_v] = [0, nv].map(given);
    let after = swapped(legs, next_v.clone(), true);
    let mut rows: Vec<Sym<'_>> = next_q.iter().zip(swapped(legs, q, false)).map(|(&a, b)| a - b).collect();
    let next = find(description, &phase.next)?;
    let held = if phase.impact.is_empty() { &next.contacts } else { &phase.impact };
    let mut impulses = Vec::new();
    let mut feet_hit = [None; MOST_FEET];
    if phase.impact.is_empty() {
        rows.extend(next_v.iter().zip(swapped(legs, v, true)).map(|(&a, b)| a - b));
    } else {
        let hit = Constraints::new(&model, &description.feet, &phase.impact)?;
        let jump: Vec<Sym<'_>> = after.iter().zip(&v).map(|(&a, &b)| a - b).collect();
        rows.extend(impulse_balance(&model, description, &hit, &jump)?);
        rows.extend(hit.jacobian.iter().map(|row| product(row, &after)));
        feet_hit = feet(description, phase, &hit.names)?;
        impulses = hit.names;
    }
    let points = contact_points(&model);
    for point in 0..tree.points.len() {
        let row: Vec<Sym<'_>> = points.normal_directions.iter().map(|row| row[point]).collect();
        rows.push(product(&row, &after));
    }
    let local = all_local(&model, &[Argument::Q, Argument::V], &rows);
    let (now, then) =
        (on_the_ground(description, tree, &phase.contacts), on_the_ground(description, tree, held));
    let function = LocalFunction::new(&graph, 4 * nv + impulses.len(), &local);
    without_poles(&graph, &format!("the end of phase `{}`", phase.name))?;
    Ok(CollocationChange {
        function,
        impulses,
        feet: feet_hit,
        relabel: phase.relabel,
        landing: match phase.impact.is_empty() {
            true => Vec::new(),
            false => then.iter().copied().filter(|point| !now.contains(point)).collect(),
        },
        leaving: now.iter().copied().filter(|point| !then.contains(point)).collect(),
    })
}

/// M (v₊ − v₋) less the impulses of the ground, which are parameters behind q₊ and v₊ (4.22), N s and N m s.
fn impulse_balance<'g>(
    model: &RobotModel<'g, '_>,
    description: &RobotDescription,
    hit: &Constraints<'g>,
    jump: &[Sym<'g>],
) -> Result<Vec<Sym<'g>>, Diagnostic> {
    let motions = Motions { velocity: false, acceleration: true, gravity: false };
    let moved = generalised_forces(model, motions, false);
    let mut balance = replaced(&moved, |input| match input.argument {
        Argument::A => Some(jump[input.index as usize]),
        _ => None,
    });
    let laws = JointLaws::new(model.tree, description)?;
    for (row, column, inertia) in laws.inertias(model) {
        balance[row] = balance[row] + inertia * jump[column];
    }
    for (k, row) in hit.jacobian.iter().enumerate() {
        let impulse = model.input(Argument::Parameters, 2 * model.tree.nv + k);
        for (sum, &slope) in balance.iter_mut().zip(row) {
            *sum = *sum - slope * impulse;
        }
    }
    Ok(balance)
}

/// What becomes of positions and velocities when the legs swap, if they do.
fn swapped<'g>((relabel, swaps): (&Relabelling, bool), x: Vec<Sym<'g>>, velocity: bool) -> Vec<Sym<'g>> {
    match (swaps, velocity) {
        (false, _) => x,
        (true, true) => relabel.velocity(&x),
        (true, false) => relabel.configuration(&x),
    }
}

fn product<'g>(row: &[Sym<'g>], x: &[Sym<'g>]) -> Sym<'g> {
    row.iter().zip(x).fold(x[0].zero(), |sum, (&a, &b)| sum + a * b)
}
