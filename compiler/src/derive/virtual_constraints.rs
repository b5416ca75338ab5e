//! Virtual constraints of a gait (6.2) with the pinned foot: what q has to satisfy at a phase φ, and where it can be solved
//! on the graph the map q = T(φ, p) (6.5).
use super::dependence::dependent_row;
use super::frames::{frame_pose, world_poses};
use super::gait_formulas::{placed, reader};
use super::model::RobotModel;
use crate::description::gait::{FilePlace, Gait, GaitOutput, GaitPhase, JointNames, PhasedGait};
use crate::expression::{Input, Sym, replaced, slopes_along};
use crate::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::formula::Formula;
use bipedc_runtime::Argument;
use std::collections::BTreeMap;

/// Places in the arguments of a gait ([`Argument::Parameters`]): φ, φ₊, φ₋, the gait parameters, then of each output the
/// value and the slope of h_p at φ₊.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GaitArguments {
    parameters: usize,
    outputs: usize,
}

impl GaitArguments {
    /// φ.
    pub const PHASE: Input = Input { argument: Argument::Parameters, index: 0 };
    /// Where φ₋ stands.
    pub const PHASE_END: usize = 2;

    /// Of a gait.
    pub fn new(gait: &Gait) -> Self {
        Self { parameters: gait.parameters.len(), outputs: gait.phase.outputs.len() }
    }
    /// Of a gait of several phases: room for the outputs of that which has most.
    pub fn phased(gait: &PhasedGait) -> Self {
        let outputs = gait.phases.iter().map(|phase| phase.outputs.len()).max().unwrap_or(0);
        Self { parameters: gait.parameters.len(), outputs }
    }
    /// How many there are.
    pub fn len(self) -> usize {
        3 + self.parameters + 2 * self.outputs
    }
    /// Never: φ is always there.
    pub fn is_empty(self) -> bool {
        false
    }
    /// Where a gait parameter stands.
    pub fn parameter(self, index: usize) -> usize {
        3 + index
    }
    /// Where value (0) and slope (1) of an output's h_p stand.
    pub fn matching(self, output: usize, order: usize) -> usize {
        3 + self.parameters + 2 * output + order
    }
}

/// Everything that a gait's formulas say, as expressions of q and of the gait's arguments.
#[derive(Debug, Clone)]
pub struct VirtualConstraints<'g> {
    /// What vanishes where q is on the constraint surface: x and z of the foot that stands, h by output, φ(q) − φ; as many as q.
    pub residual: Vec<Sym<'g>>,
    /// φ(q), then h₀(q) by output.
    pub controlled: Vec<Sym<'g>>,
    /// h_d by output, without h_p.
    pub wanted: Vec<Sym<'g>>,
    /// Zero at the end of the step.
    pub guard: Sym<'g>,
    /// x and z of the foot that stands, m.
    pub foot: [Sym<'g>; 2],
}

/// h₀ − h_d − h_p by output, as a function of q, φ and the arguments.
fn residuals<'g>(
    model: &RobotModel<'g, '_>,
    arguments: GaitArguments,
    (controlled, wanted): (&[Sym<'g>], &[Sym<'g>]),
) -> Vec<Sym<'g>> {
    let argument = |index: usize| model.input(Argument::Parameters, index);
    let ends = [0, 1, 2].map(argument);
    let residual = |(index, (&h0, &hd)): (usize, (&Sym<'g>, &Sym<'g>))| {
        let [value, slope] = [0, 1].map(|order| argument(arguments.matching(index, order)));
        h0 - hd - matching(ends, value, slope)
    };
    controlled.iter().zip(wanted).enumerate().map(residual).collect()
}

/// The constraints of a gait on `model`, whose base is planar; `stance` is the index of the contact point that stands.
///
/// # Errors
/// Formulas without a value, such as a division by zero.
pub fn virtual_constraints<'g>(
    model: &RobotModel<'g, '_>,
    gait: &Gait,
    stance: usize,
) -> Result<VirtualConstraints<'g>, Diagnostic> {
    let arguments = GaitArguments::new(gait);
    let phase = model.input(Argument::Parameters, 0);
    let points = contact_places(model);
    let reader = reader(model, &points, (&gait.parameters, &gait.quantities), arguments);
    let GaitPhase { variable, variable_at, outputs, guard, .. } = &gait.phase;
    let variable = reader.variable(variable, *variable_at)?;
    let controlled = reader.controlled(outputs)?;
    let wanted = reader.wanted(outputs, phase)?;
    let mut residual = points[stance].to_vec();
    residual.extend(residuals(model, arguments, (&controlled, &wanted)));
    residual.push(variable - phase);
    let guard = reader.of("the guard", &guard.formula)?;
    let controlled = std::iter::once(variable).chain(controlled).collect();
    Ok(VirtualConstraints { residual, controlled, wanted, guard, foot: points[stance] })
}

/// What the formulas of one phase of a gait say, as expressions of q and of the gait's arguments.
#[derive(Debug, Clone)]
pub struct PhaseConstraints<'g> {
    /// φ(q), then h₀(q) by output.
    pub controlled: Vec<Sym<'g>>,
    /// h_d by output, without h_p.
    pub wanted: Vec<Sym<'g>>,
    /// h by output: with h_p, φ being an argument.
    pub outputs: Vec<Sym<'g>>,
    /// φ where h_p has vanished, of the gait parameters.
    pub end: Sym<'g>,
    /// Torques by joint that the outputs' own are a least change of, at φ; N m.
    pub feedforward: Vec<Sym<'g>>,
}

/// Of a phase of a gait on `model`, whose base is planar.
///
/// # Errors
/// Formulas without a value, such as a division by zero.
pub fn phase_constraints<'g>(
    model: &RobotModel<'g, '_>,
    gait: &PhasedGait,
    index: usize,
) -> Result<PhaseConstraints<'g>, Diagnostic> {
    let arguments = GaitArguments::phased(gait);
    let phase = model.input(Argument::Parameters, 0);
    let points = contact_places(model);
    let reader = reader(model, &points, (&gait.parameters, &gait.quantities), arguments);
    let of = &gait.phases[index];
    let variable = reader.variable(&of.variable, of.variable_at)?;
    let controlled = reader.controlled(&of.outputs)?;
    let wanted = reader.wanted(&of.outputs, phase)?;
    let outputs = residuals(model, arguments, (&controlled, &wanted));
    let end = reader.of("the end of the phase", &of.end)?;
    let controlled = std::iter::once(variable).chain(controlled).collect();
    let feedforward = reader.feedforward(model, of.feedforward.as_ref(), phase)?;
    Ok(PhaseConstraints { controlled, wanted, outputs, end, feedforward })
}

/// φ(q), then h₀(q) by output: formulas of the configuration and of quantities alone.
///
/// # Errors
/// Formulas without a value.
pub fn controlled_of<'g>(
    model: &RobotModel<'g, '_>,
    quantities: &BTreeMap<String, Formula>,
    (variable, outputs): (&Formula, &[GaitOutput]),
) -> Result<Vec<Sym<'g>>, Diagnostic> {
    let reader = reader(
        model,
        &contact_places(model),
        (&[], quantities),
        GaitArguments { parameters: 0, outputs: outputs.len() },
    );
    let variable = reader.of("the phase variable", variable)?;
    Ok(std::iter::once(variable).chain(reader.controlled(outputs)?).collect())
}

/// h_p: the cubic that has this value and slope at φ₊ and vanishes with its slope at φ₋ (below 6.2).
fn matching<'g>([phase, start, end]: [Sym<'g>; 3], value: Sym<'g>, slope: Sym<'g>) -> Sym<'g> {
    let length = end - start;
    let s = (phase - start) / length;
    let rest = s.constant(1.0) - s;
    (value * (s * 2.0 + 1.0) + slope * length * s) * (rest * rest)
}

/// x and z of all contact points, m.
pub fn contact_places<'g>(model: &RobotModel<'g, '_>) -> Vec<[Sym<'g>; 2]> {
    let poses = world_poses(model);
    let place = |point| {
        let position = frame_pose(model, &poses, point).position;
        [position[0], position[2]]
    };
    model.tree.points.iter().map(place).collect()
}

pub(super) fn configuration_names<'g>(
    model: &RobotModel<'g, '_>,
    points: &[[Sym<'g>; 2]],
) -> BTreeMap<String, Sym<'g>> {
    let base = ["base_x", "base_z", "base_pitch"];
    let position = |index: usize| model.input(Argument::Q, index);
    let mut names: BTreeMap<String, Sym<'g>> =
        base.into_iter().map(str::to_owned).zip((0..3).map(position)).collect();
    // On a planar base q and v have the same places.
    let contacts = model.tree.points.iter().map(|point| point.name.replace('/', "_"));
    let joints = JointNames::new(model.tree.joints.iter().map(|joint| joint.name.as_str()), contacts);
    let words: Vec<(&str, String)> =
        joints.each().map(|(joint, name)| (joint, name.to_owned())).chain(joints.plainer()).collect();
    for (joint, name) in words {
        let found = model.tree.joints.iter().find(|other| other.name == joint);
        names.extend(found.map(|joint| (name, position(joint.v_index))));
    }
    for (point, place) in model.tree.points.iter().zip(points) {
        for (axis, &value) in ["x", "z"].into_iter().zip(place) {
            names.insert(format!("{}_{axis}", point.name.replace('/', "_")), value);
        }
    }
    names
}

/// The Jacobian of expressions with respect to q, column after column.
pub fn configuration_jacobian<'g>(tree: &Tree, of: &[Sym<'g>]) -> Vec<Vec<Sym<'g>>> {
    let Some(first) = of.first() else { return Vec::new() };
    let (one, zero) = (first.constant(1.0), first.zero());
    let column = |index: usize| {
        slopes_along(of, |input| match input.argument {
            Argument::Q => Some(if input.index as usize == index { one } else { zero }),
            _ => None,
        })
    };
    (0..tree.nq).map(column).collect()
}

/// How expressions change with φ, or with q along v while φ grows by one.
pub fn slopes_with_phase<'g>(
    model: &RobotModel<'g, '_>,
    of: &[Sym<'g>],
    along_velocity: bool,
) -> Vec<Sym<'g>> {
    let one = model.constant(1.0);
    slopes_along(of, |input| match input {
        Input { argument: Argument::Parameters, index: 0 } => Some(one),
        Input { argument: Argument::Q, index } if along_velocity => {
            Some(model.input(Argument::V, index as usize))
        }
        _ => None,
    })
}

/// T, T′ and T″ as expressions of the gait's arguments, if φ and the controlled quantities are affine in pitch and joints and
/// do not speak of where the robot is; `None`: T is to be found by iteration.
///
/// # Errors
/// The outputs and the phase variable do not fix the joints.
pub fn surface<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &VirtualConstraints<'g>,
    (variable_at, outputs): (FilePlace, &[GaitOutput]),
) -> Result<Option<[Vec<Sym<'g>>; 3]>, Diagnostic> {
    let n = model.tree.nq - 2;
    let columns = configuration_jacobian(model.tree, &constraints.controlled);
    let slope = |row: usize, column: usize| columns[column][row].constant_value();
    let moves_with_base = (0..=1).any(|column| (0..n).any(|row| slope(row, column) != Some(0.0)));
    let matrix: Option<Vec<Vec<f64>>> =
        (0..n).map(|row| (0..n).map(|column| slope(row, column + 2)).collect()).collect();
    let Some(matrix) = matrix.filter(|_| !moves_with_base) else { return Ok(None) };
    // What is affine has its constant part at q = 0.
    let zero = model.constant(0.0);
    let at_zero = |input: Input| (input.argument == Argument::Q).then_some(zero);
    let right: Vec<Sym<'g>> = replaced(&constraints.residual[2..], at_zero).into_iter().map(|h| -h).collect();
    // In the order of the residual: outputs first, then the phase variable.
    let rows = (1..n).chain([0]).map(|row| matrix[row].clone()).collect();
    // Of φ and the outputs, the first that says what those before it say.
    let inverse = inverse(rows).ok_or_else(|| not_fixed(dependent_row(&matrix), (variable_at, outputs)))?;
    let angles: Vec<Sym<'g>> = inverse
        .iter()
        .map(|row| row.iter().zip(&right).fold(zero, |sum, (&factor, &x)| sum + x * factor))
        .collect();
    let turned = |input: Input| match (input.argument, input.index as usize) {
        (Argument::Q, 0 | 1) => Some(zero),
        (Argument::Q, index) => Some(angles[index - 2]),
        _ => None,
    };
    // The base is where it puts the foot at the origin.
    let base = replaced(&constraints.foot, turned).into_iter().map(|x| -x);
    let position: Vec<Sym<'g>> = base.chain(angles.iter().copied()).collect();
    let slope = slopes_with_phase(model, &position, false);
    let curvature = slopes_with_phase(model, &slope, false);
    Ok(Some([position, slope, curvature]))
}

/// Of φ and the outputs, the `dependent` one says the same as those before it; none was found: at φ, as all of them together are meant.
fn not_fixed(dependent: Option<usize>, (variable_at, outputs): (FilePlace, &[GaitOutput])) -> Diagnostic {
    let help = "each [[phase.output]] controls something that the others and the phase variable leave open";
    let output = dependent.and_then(|row| outputs.get(row.checked_sub(1)?));
    match (dependent, output) {
        (Some(0), _) => {
            let message = "the phase variable stays the same whatever the joints do";
            placed(Diagnostic::error(message), variable_at)
                .help("choose one that grows along the step, such as the angle of the leg that stands")
        }
        (_, Some(GaitOutput { name, at, .. })) => {
            let message = format!(
                "the output `{name}` says nothing new beside the outputs before it and the phase variable: the joints are not fixed"
            );
            placed(Diagnostic::error(message), *at).help(help)
        }
        _ => {
            let message =
                "the outputs and the phase variable do not fix the joints: some of them say the same";
            placed(Diagnostic::error(message), variable_at).help(help)
        }
    }
}

/// Pivots below this are rounding, where the largest element of each row is 1.
const SINGULAR: f64 = 1e-10;

/// The inverse of a matrix by rows (Gauss–Jordan with row exchanges), if it has one.
pub(super) fn inverse(mut a: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    let n = a.len();
    for (k, row) in a.iter_mut().enumerate() {
        row.extend((0..n).map(|column| f64::from(u8::from(column == k))));
        // Outputs may have any scale.
        let largest = row[..n].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        row.iter_mut().for_each(|x| *x /= largest);
    }
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))?;
        // An output that nothing moves has no scale: its row is no number, and neither is the pivot.
        if !a[pivot][k].is_finite() || a[pivot][k].abs() <= SINGULAR {
            return None;
        }
        a.swap(k, pivot);
        let scale = a[k][k];
        a[k].iter_mut().for_each(|x| *x /= scale);
        let row = a[k].clone();
        for (_, other) in a.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = other[k];
            other.iter_mut().zip(&row).for_each(|(x, y)| *x -= factor * y);
        }
    }
    Some(a.into_iter().map(|row| row[n..].to_vec()).collect())
}
