//! A robot with a gait: the functions of its zero dynamics and of its controller beside those of the model that a step needs.
mod collocation;
mod controller;
mod controllers_in_process;
mod in_process;
mod phased;
mod phased_in_process;
mod phased_surface;
mod regularity;

pub use collocation::{
    Collocation, CollocationChange, CollocationPhase, GaitForm, NodeRow, PhaseForm, compile_collocation,
};
pub use controllers_in_process::{PhasedProgramController, ProgramController};
pub use in_process::GaitPrograms;
pub use phased::{CompiledPhases, compile_phases};
pub use phased_in_process::PhasePrograms;

use super::{CompiledModel, Function, FunctionRequest, Quantity, compile, without_poles};
use crate::derive::virtual_constraints::{
    GaitArguments, VirtualConstraints, configuration_jacobian, slopes_with_phase, surface,
    virtual_constraints,
};
use crate::derive::zero_dynamics::zero_dynamics;
use crate::derive::{InertiaMode, RobotModel};
use crate::description::gait::{Gait, NOT_PLANAR};
use crate::description::model::{Contact, ContactPart, RobotDescription};
use crate::expression::{Expr, Graph, Sym};
use crate::program::{Operations, Order, lower};
use crate::tree::{BaseKind, Tree};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Acts, Effect};
use bipedc_runtime::Argument;

/// A robot and its gait as programs. Functions of the gait are `virtual_constraints`, `virtual_constraints_jacobian`,
/// `virtual_constraints_slope`, `virtual_constraints_curvature`, `controlled`, `wanted`, `guard`, `zero_dynamics`,
/// `lie_derivatives` and, where it has a closed form, `surface` and `step_end`.
#[derive(Debug, Clone, PartialEq)]
pub struct CompiledGait {
    /// With the functions of the model that a step needs; [`Argument::Parameters`] are those of the gait.
    pub model: CompiledModel,
    /// Places of the gait's arguments.
    pub arguments: GaitArguments,
    /// The robot in the world of the gait.
    pub description: RobotDescription,
    /// The contact point that stands, and the one that lands; by index.
    pub points: [usize; 2],
}

/// Functions of the model that a step needs.
const OF_ROBOT: [&str; 5] = [
    "inverse_dynamics",
    "relabelled_configuration",
    "relabelled_velocity",
    "contact_distances",
    "contact_normal_directions",
];

/// Derives everything that a gait needs.
///
/// # Errors
/// A base that is not planar, outputs that do not fix the joints, formulas without a value.
pub fn compile_gait(description: &RobotDescription, gait: &Gait) -> Result<CompiledGait, Diagnostic> {
    let (description, tree) = in_the_plane(description, (gait.gravity, &gait.effects))?;
    let Some(phase) = description.phases.iter().find(|phase| phase.name == gait.phase.name) else {
        return Err(Diagnostic::error(format!("the robot has no phase `{}`", gait.phase.name)));
    };
    let points = [point(&description, &tree, &phase.contacts)?, point(&description, &tree, &phase.impact)?];
    let request = |family: &str, subject: Option<&str>| FunctionRequest {
        family: family.to_owned(),
        subject: subject.map(str::to_owned),
    };
    let mut requests: Vec<FunctionRequest> = OF_ROBOT.iter().map(|family| request(family, None)).collect();
    requests.extend(["impact_map", "constrained_dynamics"].map(|family| request(family, Some(&phase.name))));
    let mut model = compile(&description, &tree, &requests)?;
    model.functions.extend(functions(&tree, gait, points[0])?);
    model.functions.push(controller::lie_derivatives(&description, &tree, gait, points[0])?);
    let arguments = GaitArguments::new(gait);
    model.run_time_parameters = arguments.len();
    Ok(CompiledGait { model, arguments, description, points })
}

/// The robot as the gait means it, and its tree.
///
/// # Errors
/// A base that is not planar.
fn in_the_plane(
    description: &RobotDescription,
    world: (Option<f64>, &[Effect]),
) -> Result<(RobotDescription, Tree), Diagnostic> {
    let description = in_its_world(description, world);
    let tree = Tree::new(&description, &description.base)?;
    if tree.base != BaseKind::Planar {
        return Err(Diagnostic::error(NOT_PLANAR[0]).help(NOT_PLANAR[1]));
    }
    Ok((description, tree))
}

/// The robot as the gait means it: under its gravity, with the effects that make another body of it. What only sensors or the
/// log know, and what is between motor and link, is no part of it.
fn in_its_world(
    description: &RobotDescription,
    (gravity, effects): (Option<f64>, &[Effect]),
) -> RobotDescription {
    let mut description = description.clone();
    if let Some(size) = gravity {
        description.gravity = [0.0, 0.0, -size];
    }
    description.effects.extend_from_slice(effects);
    description.effects.retain(|effect| match effect.kind.law.acts() {
        Acts::Body => true,
        Acts::Torque => effect.kind.simulation.is_smooth(),
        _ => false,
    });
    // A gait is about this robot, with its numbers.
    description.generate.runtime_parameters = false;
    description
}

/// The one contact point of these contacts.
fn point(description: &RobotDescription, tree: &Tree, contacts: &[Contact]) -> Result<usize, Diagnostic> {
    let name = |contact: &Contact| {
        let foot = description.feet.iter().find(|foot| foot.name == contact.foot)?;
        let point = match (&contact.part, foot.points.as_slice()) {
            (ContactPart::Point(point), _) => point,
            (ContactPart::Flat, [only]) => &only.name,
            _ => return None,
        };
        Some(format!("{}/{point}", foot.name))
    };
    let found = match contacts {
        [contact] => name(contact).and_then(|name| tree.points.iter().position(|point| point.name == name)),
        _ => None,
    };
    found.ok_or_else(|| Diagnostic::error("a gait's step stands and lands on one contact point of one foot"))
}

/// The functions of the gait itself.
fn functions(tree: &Tree, gait: &Gait, stance: usize) -> Result<Vec<Function>, Diagnostic> {
    let graph = Graph::new();
    let model = RobotModel::new(&graph, tree, InertiaMode::Folded);
    let constraints = virtual_constraints(&model, gait, stance)?;
    let mut found = of_constraints(&model, gait, &constraints);
    found.extend(of_outputs(&model, gait, &constraints));
    let zero = zero_dynamics(&model, &constraints.foot);
    let unit = if gait.phase.unit == "rad" { String::new() } else { format!(" rad/({})", gait.phase.unit) };
    let units = vec![format!("kg m²{unit}"), format!("kg m²{unit}"), "N m".to_owned()];
    let rows = ["alpha", "beta", "gamma"].map(str::to_owned).to_vec();
    found.push(function(
        &graph,
        ("zero_dynamics", "(6.6), Table 6.3, corrected", "α, β and γ at q = T(φ), v = T′(φ), a = T″(φ)."),
        Quantity::named(rows, units, vec![zero.alpha, zero.beta, zero.gamma]),
    ));
    if let Some(columns) = surface(&model, &constraints, (gait.phase.variable_at, &gait.phase.outputs))? {
        let names = ["T", "T'", "T''"].map(str::to_owned).to_vec();
        let (rows, units) = configuration(tree);
        found.push(function(
            &graph,
            (
                "surface",
                "(6.5)",
                "The configuration where the outputs vanish, with its slope and curvature along φ.",
            ),
            Quantity::matrix(rows, units, names, columns.to_vec()),
        ));
        found.push(controller::step_end(&model, gait, constraints.guard, &columns[0]));
    }
    without_poles(&graph, "the gait")?;
    Ok(found)
}

/// Name, equation and summary of a function.
type Head = (&'static str, &'static str, &'static str);

/// What vanishes on the constraint surface, and its slopes.
const OF_CONSTRAINTS: [Head; 4] = [
    (
        "virtual_constraints",
        "(6.2)",
        "The foot that stands, h(q, p), φ(q) − φ: zero on the constraint surface.",
    ),
    ("virtual_constraints_jacobian", "(6.2)", "Slopes of the virtual constraints with respect to q."),
    (
        "virtual_constraints_slope",
        "(6.5)",
        "Slopes of the virtual constraints with respect to φ at constant q.",
    ),
    (
        "virtual_constraints_curvature",
        "(6.5)",
        "Second slopes of the virtual constraints where q changes with v and φ with 1.",
    ),
];

/// The formulas themselves.
const OF_FORMULAS: [Head; 3] = [
    ("controlled", "(6.2)", "The phase variable φ(q), then h₀(q); with their rates."),
    ("wanted", "(6.2)", "h_d(φ, p) without h_p; with its slopes along φ."),
    ("guard", "(6.1)", "Zero where the step ends."),
];

fn of_constraints<'g>(
    model: &RobotModel<'g, '_>,
    gait: &Gait,
    constraints: &VirtualConstraints<'g>,
) -> Vec<Function> {
    let residual = &constraints.residual;
    let moving = slopes_with_phase(model, residual, true);
    let (rows, units) = constraint_rows(gait);
    let vector = |values: Vec<Sym<'g>>| Quantity::named(rows.clone(), units.clone(), values);
    let columns = configuration_jacobian(model.tree, residual);
    let quantities = [
        vector(residual.clone()),
        Quantity::matrix(rows.clone(), units.clone(), configuration(model.tree).0, columns),
        vector(slopes_with_phase(model, residual, false)),
        vector(slopes_with_phase(model, &moving, true)),
    ];
    OF_CONSTRAINTS.into_iter().zip(quantities).map(|(head, of)| function(model.graph, head, of)).collect()
}

/// The rates of functions of q at the velocity v.
fn rates<'g>(model: &RobotModel<'g, '_>, values: &[Sym<'g>]) -> Vec<Sym<'g>> {
    let columns = configuration_jacobian(model.tree, values);
    let sum = |row: usize| {
        let products =
            columns.iter().enumerate().map(|(k, column)| column[row] * model.input(Argument::V, k));
        products.fold(model.constant(0.0), |sum, x| sum + x)
    };
    (0..values.len()).map(sum).collect()
}

fn of_outputs<'g>(
    model: &RobotModel<'g, '_>,
    gait: &Gait,
    constraints: &VirtualConstraints<'g>,
) -> Vec<Function> {
    let outputs = gait.phase.outputs.iter();
    let (names, units): (Vec<String>, Vec<String>) =
        outputs.map(|output| (output.name.clone(), output.unit.clone())).unzip();
    let after = |first: &str, of: &[String]| {
        std::iter::once(first.to_owned()).chain(of.iter().cloned()).collect::<Vec<_>>()
    };
    let pair = |second: &str| vec!["value".to_owned(), second.to_owned()];
    let controlled = vec![constraints.controlled.clone(), rates(model, &constraints.controlled)];
    let wanted = vec![constraints.wanted.clone(), slopes_with_phase(model, &constraints.wanted, false)];
    let quantities = [
        Quantity::matrix(after("phase", &names), after(&gait.phase.unit, &units), pair("rate"), controlled),
        Quantity::matrix(names, units, pair("slope"), wanted),
        Quantity::scalar("guard", "1", constraints.guard),
    ];
    OF_FORMULAS.into_iter().zip(quantities).map(|(head, of)| function(model.graph, head, of)).collect()
}

/// Names and units of q on a planar base.
fn configuration(tree: &Tree) -> (Vec<String>, Vec<String>) {
    let base = [("base/x", "m"), ("base/z", "m"), ("base/pitch", "rad")];
    let joints = tree.joints.iter().map(|j| (j.name.as_str(), if j.prismatic { "m" } else { "rad" }));
    base.into_iter().chain(joints).map(|(name, unit)| (name.to_owned(), unit.to_owned())).unzip()
}

fn constraint_rows(gait: &Gait) -> (Vec<String>, Vec<String>) {
    let foot = [("foot/x", "m"), ("foot/z", "m")];
    let outputs = gait.phase.outputs.iter().map(|output| (output.name.as_str(), output.unit.as_str()));
    let all = foot.into_iter().chain(outputs).chain([("phase", gait.phase.unit.as_str())]);
    all.map(|(name, unit)| (name.to_owned(), unit.to_owned())).unzip()
}

fn function(graph: &Graph, (name, source, summary): Head, quantity: Quantity<'_>) -> Function {
    let outputs: Vec<Expr> = quantity.columns.iter().flatten().map(|x| x.expr).collect();
    let program = lower(graph, &outputs, Order::DepthFirst);
    Function {
        name: name.to_owned(),
        family: name,
        subject: None,
        summary,
        source,
        rows: quantity.row_names,
        columns: quantity.column_names,
        row_units: quantity.row_units,
        packed: false,
        by_pairs: false,
        operations: Operations::of(&program),
        program,
        notes: Vec::new(),
    }
}
