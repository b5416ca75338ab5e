//! A robot with a gait of several phases: the functions of its controller beside those of the model that a step needs.
use super::phased_surface::{ground_on_surface, rate_ratio, surface_equations};
use super::{configuration, function, in_the_plane, rates};
use crate::compile::{
    CompiledModel, Function, FunctionRequest, Quantity, compile, identifier, without_poles,
};
use crate::derive::constrained::{constrained_dynamics, constrained_dynamics_with_effects};
use crate::derive::constraint::Constraints;
use crate::derive::effects::JointLaws;
use crate::derive::lie_derivatives::{along_dynamics, response};
use crate::derive::virtual_constraints::{
    GaitArguments, PhaseConstraints, configuration_jacobian, phase_constraints, slopes_with_phase,
};
use crate::derive::zero_dynamics::power_along_surface;
use crate::derive::{InertiaMode, RobotModel};
use crate::description::gait::{PhasedGait, SupportPhase};
use crate::description::model::{Phase, RobotDescription};
use crate::expression::{Graph, Sym, replaced};
use crate::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::Argument;
use bipedc_runtime::control::MOST_JOINTS;

/// A robot and its gait of several phases as programs. Functions of each phase are `controlled_of_PHASE`, `wanted_of_PHASE`,
/// `phase_end_of_PHASE`, `feedforward_of_PHASE`, `lie_derivatives_of_PHASE`, `zero_dynamics_of_PHASE`,
/// `virtual_constraints_of_PHASE` with their slopes, `surface_equations_of_PHASE` with theirs, `rate_ratio_of_PHASE`; of all phases
/// `ground_on_surface`.
#[derive(Debug, Clone, PartialEq)]
pub struct CompiledPhases {
    /// With the functions of the model that a step needs; [`Argument::Parameters`] are those of the gait.
    pub model: CompiledModel,
    /// Places of the gait's arguments, the same in every phase.
    pub arguments: GaitArguments,
    /// The robot in the world of the gait.
    pub description: RobotDescription,
    /// Names of the forces of the ground by phase, `right_foot/force/x`, in the order of the rows of `lie_derivatives_of_PHASE` behind
    /// the outputs.
    pub forces: Vec<Vec<String>>,
}

/// Functions of the model that a step needs.
const OF_ROBOT: [&str; 7] = [
    "inverse_dynamics",
    "relabelled_configuration",
    "relabelled_velocity",
    "contact_distances",
    "contact_positions",
    "contact_normal_directions",
    "contact_tangential_directions",
];

/// Derives everything that a gait of several phases needs.
///
/// # Errors
/// A base that is not planar, formulas without a value, phases that the robot does not have.
pub fn compile_phases(
    description: &RobotDescription,
    gait: &PhasedGait,
) -> Result<CompiledPhases, Diagnostic> {
    let (description, tree) = in_the_plane(description, (gait.gravity, &gait.effects))?;
    if tree.joints.len() > MOST_JOINTS {
        let message = format!("gaits have at most {MOST_JOINTS} joints, the robot has {}", tree.joints.len());
        return Err(Diagnostic::error(message).help("a controller's work and memory are bounded"));
    }
    let phases = gait.phases.iter().map(|phase| known(&description, phase)).collect::<Result<Vec<_>, _>>()?;
    let mut model = compile(&description, &tree, &requests(&phases))?;
    let (mut forces, mut own) = (Vec::new(), Vec::new());
    for (index, phase) in phases.iter().enumerate() {
        let (functions, rows) = of_phase(&description, &tree, gait, (index, phase))?;
        own.extend(functions);
        forces.push(rows);
    }
    // Those of a kind stand together: they are a module of emitted code.
    let families: Vec<&'static str> = own.iter().map(|function: &Function| function.family).collect();
    own.sort_by_key(|function| families.iter().position(|family| *family == function.family));
    model.functions.extend(own);
    let graph = Graph::new();
    model.functions.push(ground_on_surface(&RobotModel::new(&graph, &tree, InertiaMode::Folded)));
    let arguments = GaitArguments::phased(gait);
    model.run_time_parameters = arguments.len();
    Ok(CompiledPhases { model, arguments, description, forces })
}

fn known<'d>(description: &'d RobotDescription, phase: &SupportPhase) -> Result<&'d Phase, Diagnostic> {
    let found = description.phases.iter().find(|other| other.name == phase.name);
    found.ok_or_else(|| Diagnostic::error(format!("the robot has no phase `{}`", phase.name)))
}

fn requests(phases: &[&Phase]) -> Vec<FunctionRequest> {
    let request = |family: &str, subject: Option<&str>| FunctionRequest {
        family: family.to_owned(),
        subject: subject.map(str::to_owned),
    };
    let mut found: Vec<FunctionRequest> = OF_ROBOT.iter().map(|family| request(family, None)).collect();
    found.extend(phases.iter().map(|phase| request("constrained_dynamics", Some(&phase.name))));
    let landing = phases.iter().filter(|phase| !phase.impact.is_empty());
    found.extend(landing.map(|phase| request("impact_map", Some(&phase.name))));
    found
}

/// The functions of a phase, and the names of its forces.
fn of_phase(
    description: &RobotDescription,
    tree: &Tree,
    gait: &PhasedGait,
    (index, phase): (usize, &Phase),
) -> Result<(Vec<Function>, Vec<String>), Diagnostic> {
    let graph = Graph::new();
    let model = RobotModel::new(&graph, tree, InertiaMode::Folded);
    let laws = JointLaws::new(tree, description)?;
    let held = Constraints::new(&model, &description.feet, &phase.contacts)?;
    let constraints = phase_constraints(&model, gait, index)?;
    let of = &gait.phases[index];
    let motion = match laws.is_empty() {
        true => constrained_dynamics(&model, &held),
        false => constrained_dynamics_with_effects(&model, &held, &laws),
    };
    let lie = along_dynamics(&model, (constraints.controlled[0], &constraints.outputs), &motion.acceleration);
    let names = Names { phase: of };
    let mut found = formulas(&model, &names, &constraints);
    let (outputs, units) = names.outputs();
    let rows = outputs.into_iter().chain(held.names.iter().cloned()).collect();
    let units = units.into_iter().chain(held.units.iter().map(|&unit| unit.to_owned())).collect();
    let zero = model.constant(0.0);
    let free = replaced(&motion.forces, |input| (input.argument == Argument::Tau).then_some(zero));
    let nothing = vec![zero; free.len()];
    let mut columns =
        vec![joined(lie.outputs, &nothing), joined(lie.rates, &nothing), joined(lie.drift, &free)];
    for (joint, decoupling) in tree.joints.iter().zip(lie.decoupling) {
        columns.push(joined(decoupling, &response(&model, &motion.forces, joint.v_index)));
    }
    let joints = tree.joints.iter().map(|joint| format!("one N m at {}", joint.name));
    let heads = ["value", "rate", "without torques"].map(str::to_owned).into_iter().chain(joints).collect();
    let head = (
        "lie_derivatives",
        "(6.27), (6.28)",
        "Outputs h(q) with h_p, their rates L_f h, their accelerations without torques L_f² h, and what one N m at each joint adds to \
         them, L_g L_f h; then, without value and rate, the forces of the ground without torques and what one N m adds to them.",
    );
    found.push(names.function(&graph, head, Quantity::matrix(rows, units, heads, columns)));
    found.push(zero_dynamics(&model, &names));
    found.extend(surface_equations(&model, &names, &constraints, (description, phase)));
    found.push(rate_ratio(&model, (gait, index), &names, (description, phase, &laws))?);
    without_poles(&graph, &format!("phase `{}` of the gait", of.name))?;
    Ok((found, held.names))
}

/// α, β, γ along the surface, then what one N m at each joint adds to the other side.
fn zero_dynamics(model: &RobotModel<'_, '_>, names: &Names<'_>) -> Function {
    let zero = power_along_surface(model);
    let unit = &names.phase.unit;
    let per = |top: &str, power: &str| match unit.as_str() {
        "rad" => top.to_owned(),
        unit => format!("{top} rad{power}/({unit}){power}"),
    };
    let inertia = per("kg m²", "²");
    let (mut rows, mut units) = (
        ["alpha", "beta", "gamma"].map(str::to_owned).to_vec(),
        vec![inertia.clone(), per("kg m²", "³"), per("N m", "")],
    );
    let mut values = vec![zero.alpha, zero.beta, zero.gamma];
    for joint in &model.tree.joints {
        rows.push(format!("one N m at {}", joint.name));
        units.push(per("N m", ""));
        values.push(model.input(Argument::V, joint.v_index));
    }
    let head = (
        "zero_dynamics",
        "(6.31), Table 6.3 along n = T′",
        "α φ̈ + β φ̇² + γ = Σ ζ u at q = T(φ), v = T′(φ), a = T″(φ), with ½ α φ̇² the kinetic energy; then ζ of one N m at each joint. Effects in \
         joints are not in it.",
    );
    names.function(model.graph, head, Quantity::named(rows, units, values))
}

pub(super) fn joined<'g>(mut head: Vec<Sym<'g>>, tail: &[Sym<'g>]) -> Vec<Sym<'g>> {
    head.extend_from_slice(tail);
    head
}

/// Names of what belongs to a phase.
pub(super) struct Names<'a> {
    pub phase: &'a SupportPhase,
}

impl Names<'_> {
    /// Names and units of the outputs.
    pub(super) fn outputs(&self) -> (Vec<String>, Vec<String>) {
        self.phase.outputs.iter().map(|output| (output.name.clone(), output.unit.clone())).unzip()
    }

    /// As `family_of_PHASE`.
    pub(super) fn function(&self, graph: &Graph, head: super::Head, quantity: Quantity<'_>) -> Function {
        let mut found = function(graph, head, quantity);
        found.name = format!("{}_of_{}", found.family, identifier(&self.phase.name));
        found.subject = Some(self.phase.name.clone());
        found
    }
}

/// What the formulas of a phase say.
const OF_FORMULAS: [super::Head; 4] = [
    ("controlled", "(6.27)", "The phase variable φ(q), then h₀(q); with their rates."),
    ("wanted", "(6.27)", "h_d(φ, p) without h_p; with its slopes along φ."),
    ("phase_end", "(6.27)", "φ where h_p has vanished, of the gait parameters."),
    ("feedforward", "(6.25)", "Torques at φ that those of the controller are a least change of."),
];

/// Slopes of the outputs, for the surface on which they vanish.
const OF_OUTPUTS: [super::Head; 4] = [
    ("virtual_constraints", "(6.27)", "h(q, p) with h_p, then φ(q) − φ, for an argument φ."),
    ("virtual_constraints_jacobian", "(6.30)", "Slopes of the virtual constraints with respect to q."),
    (
        "virtual_constraints_slope",
        "(6.30)",
        "Slopes of the virtual constraints with respect to φ at constant q.",
    ),
    (
        "virtual_constraints_curvature",
        "(6.30)",
        "Second slopes of the virtual constraints where q changes with v and φ with 1.",
    ),
];

fn formulas<'g>(
    model: &RobotModel<'g, '_>,
    names: &Names<'_>,
    constraints: &PhaseConstraints<'g>,
) -> Vec<Function> {
    let (outputs, units) = names.outputs();
    let before = |first: &str, of: &[String]| {
        std::iter::once(first.to_owned()).chain(of.iter().cloned()).collect::<Vec<_>>()
    };
    let pair = |second: &str| vec!["value".to_owned(), second.to_owned()];
    let unit = &names.phase.unit;
    let controlled = vec![constraints.controlled.clone(), rates(model, &constraints.controlled)];
    let wanted = vec![constraints.wanted.clone(), slopes_with_phase(model, &constraints.wanted, false)];
    let (joints, torques) =
        model.tree.joints.iter().map(|joint| (joint.name.clone(), "N m".to_owned())).unzip();
    let of_formulas = [
        Quantity::matrix(before("phase", &outputs), before(unit, &units), pair("rate"), controlled),
        Quantity::matrix(outputs.clone(), units.clone(), pair("slope"), wanted),
        Quantity::scalar("end", "1", constraints.end),
        Quantity::named(joints, torques, constraints.feedforward.clone()),
    ];
    let residual = residual(model, constraints);
    let moving = slopes_with_phase(model, &residual, true);
    let (rows, units) = (after(&outputs, "phase"), after(&units, unit));
    let vector = |values: Vec<Sym<'g>>| Quantity::named(rows.clone(), units.clone(), values);
    let columns = configuration_jacobian(model.tree, &residual);
    let of_outputs = [
        vector(residual.clone()),
        Quantity::matrix(rows.clone(), units.clone(), configuration(model.tree).0, columns),
        vector(slopes_with_phase(model, &residual, false)),
        vector(slopes_with_phase(model, &moving, true)),
    ];
    let all = OF_FORMULAS.into_iter().chain(OF_OUTPUTS).zip(of_formulas.into_iter().chain(of_outputs));
    all.map(|(head, of)| names.function(model.graph, head, of)).collect()
}

fn after(of: &[String], last: &str) -> Vec<String> {
    of.iter().cloned().chain([last.to_owned()]).collect()
}

/// The outputs, then φ(q) − φ.
fn residual<'g>(model: &RobotModel<'g, '_>, constraints: &PhaseConstraints<'g>) -> Vec<Sym<'g>> {
    let phase = model.input(Argument::Parameters, 0);
    joined(constraints.outputs.clone(), &[constraints.controlled[0] - phase])
}
