//! The pipeline: from a tree and a request list to optimised programs.
mod catalogue;
mod families;
mod gait;
mod in_process;
mod names;
mod notes;
mod quantity;
mod readable;
mod requests;
mod solvable;

pub use catalogue::{Entry, Scope, catalogue, entry, entry_and_subject};
pub use families::regressors::parameter_names;
pub use gait::{
    Collocation, CollocationChange, CollocationPhase, CompiledGait, CompiledPhases, GaitForm, GaitPrograms,
    NodeRow, PhaseForm, PhasePrograms, PhasedProgramController, ProgramController, compile_collocation,
    compile_gait, compile_phases,
};
pub use in_process::ProgramModel;
pub use names::{crate_name, distinct, identifier};
pub use quantity::Quantity;
pub use readable::{Readable, readable};
pub use requests::requested_functions;
pub use solvable::{Solvable, inertia_help, no_inertia};

use families::regressors;
use names::distinct_functions;

use crate::derive::effects::JointLaws;
use crate::derive::{InertiaMode, RobotModel};
use crate::description::model::RobotDescription;
use crate::expression::{Expr, Graph};
use crate::program::{Operand, Operations, Program, lower};
use crate::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::Argument;

/// A derived function, ready to be emitted or run.
#[derive(Debug, Clone, PartialEq)]
pub struct Function {
    /// Identifier, such as `position_of_left_foot`.
    pub name: String,
    /// The catalogue entry it belongs to.
    pub family: &'static str,
    /// The link, contact point or phase it is about.
    pub subject: Option<String>,
    /// What it is, for doc comments.
    pub summary: &'static str,
    /// Source equation.
    pub source: &'static str,
    /// Names of the rows.
    pub rows: Vec<String>,
    /// Names of the columns; one for a vector.
    pub columns: Vec<String>,
    /// Unit of each row (of its first column's kind for matrices).
    pub row_units: Vec<String>,
    /// Most entries are zero in every state: code computes and stores the others alone, with a dense matrix on top.
    pub packed: bool,
    /// Emitted code has the order of `program::schedule_pairs`: measured best where several processors are meant.
    pub by_pairs: bool,
    /// What it computes.
    pub program: Program,
    /// How much work that is.
    pub operations: Operations,
    /// What it does with the description's effects; empty without any.
    pub notes: Vec<String>,
}

impl Function {
    /// Whether it has no rows or no columns.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty() || self.columns.is_empty()
    }
}

/// A robot with its functions.
#[derive(Debug, Clone, PartialEq)]
pub struct CompiledModel {
    /// Name of the robot.
    pub name: String,
    /// The tree it was derived from.
    pub tree: Tree,
    /// In the order of the catalogue.
    pub functions: Vec<Function>,
    /// Number of parameters that functions take at run time: base parameters, unless they are folded, or what a gait takes.
    pub run_time_parameters: usize,
}

impl CompiledModel {
    /// Length of an argument.
    pub fn argument_length(&self, argument: Argument) -> usize {
        let tree = &self.tree;
        match argument {
            Argument::Q => tree.nq,
            Argument::V | Argument::A | Argument::Tau => tree.nv,
            Argument::Forces => 3 * tree.points.len(),
            Argument::Parameters => self.run_time_parameters,
            Argument::MotorQ | Argument::MotorV | Argument::MotorA => tree.joints.len(),
        }
    }
}

/// Everything a derivation may ask for.
pub struct Context<'g, 't> {
    /// The description the tree came from.
    pub description: &'t RobotDescription,
    /// Inertias as regrouped constants, or as base parameters if the description wants them at run time.
    pub folded: RobotModel<'g, 't>,
    /// Inertias as run-time parameters.
    pub symbolic: RobotModel<'g, 't>,
    /// Effects at joints.
    pub laws: &'t JointLaws,
}

impl<'g, 't> Context<'g, 't> {
    /// Prepares derivations on `graph`; `leading` are the places of run-time base parameters, if any.
    pub fn new(
        graph: &'g Graph,
        description: &'t RobotDescription,
        tree: &'t Tree,
        leading: Option<&[usize]>,
        laws: &'t JointLaws,
    ) -> Self {
        let mut folded = match leading {
            Some(leading) => RobotModel::with_base_parameters(graph, tree, leading),
            None => RobotModel::new(graph, tree, InertiaMode::Folded),
        };
        let mut symbolic = RobotModel::new(graph, tree, InertiaMode::Symbolic);
        folded.offsets = laws.offsets().to_vec();
        symbolic.offsets.clone_from(&folded.offsets);
        Self { description, folded, symbolic, laws }
    }
}

/// One function to compile: a catalogue entry and, where it needs one, its subject.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FunctionRequest {
    /// Name of the catalogue entry.
    pub family: String,
    /// Link, contact point or phase.
    pub subject: Option<String>,
}

impl FunctionRequest {
    /// A function of the whole robot, such as `mass_matrix`.
    pub fn of_robot(family: impl Into<String>) -> Self {
        Self { family: family.into(), subject: None }
    }
}

/// Derives and lowers the requested functions.
///
/// # Errors
/// Unknown functions and subjects, functions that this robot does not have.
pub fn compile(
    description: &RobotDescription,
    tree: &Tree,
    requests: &[FunctionRequest],
) -> Result<CompiledModel, Diagnostic> {
    let compiled = compile_with_empty(description, tree, requests)?;
    match compiled.functions.iter().find(|function| function.is_empty()) {
        None => Ok(compiled),
        Some(function) => {
            let what = format!("`{}` has no elements: this robot has nothing that it is of", function.family);
            Err(Diagnostic::error(what)
                .help("does anything move (--base floating), are there contact points or drives?"))
        }
    }
}

/// The same without the functions that have no elements: those of velocities and forces where nothing moves.
///
/// # Errors
/// As [`compile`].
pub fn compile_what_there_is(
    description: &RobotDescription,
    tree: &Tree,
    requests: &[FunctionRequest],
) -> Result<CompiledModel, Diagnostic> {
    let mut compiled = compile_with_empty(description, tree, requests)?;
    compiled.functions.retain(|function| !function.is_empty());
    Ok(compiled)
}

fn compile_with_empty(
    description: &RobotDescription,
    tree: &Tree,
    requests: &[FunctionRequest],
) -> Result<CompiledModel, Diagnostic> {
    let leading = run_time_parameters(description, tree)?;
    let laws = JointLaws::new(tree, description)?;
    let solvable = Solvable::new(description, tree, &laws);
    let functions = requests
        .iter()
        .map(|request| {
            // A graph of its own keeps the order of derivation, which is also a good order of execution.
            let graph = Graph::new();
            let context = Context::new(&graph, description, tree, leading.as_deref(), &laws);
            let entry = entry(&request.family)?;
            let subject = request.subject.as_deref();
            let refusal = laws.refusal(entry.name).or_else(|| solvable.refusal(entry.name, subject));
            if let Some(refusal) = refusal {
                return Err(refusal);
            }
            let quantity = entry.derive(&context, subject)?;
            without_poles(&graph, entry.name)?;
            let notes = notes::of(description, &laws, entry.name);
            Ok(Function { notes, ..finish(&graph, entry, request.subject.clone(), quantity) })
        })
        .collect::<Result<Vec<_>, Diagnostic>>()?;
    let run_time_parameters = leading.map_or(0, |leading| leading.len());
    let names = distinct_functions(functions.iter().map(|f| f.name.clone()));
    let functions =
        functions.into_iter().zip(names).map(|(f, name)| Function { name, ..f }).collect::<Vec<_>>();
    Ok(CompiledModel { name: description.name.clone(), tree: tree.clone(), functions, run_time_parameters })
}

/// Refuses what divides by zero in every state.
fn without_poles(graph: &Graph, function: &str) -> Result<(), Diagnostic> {
    if !graph.divided_by_zero() {
        return Ok(());
    }
    Err(Diagnostic::error(format!("`{function}` divides by zero in every state of this robot"))
        .help("are masses and inertias of the URDF complete (`bipedc check`), and the contacts of a phase independent?"))
}

/// Places of the base parameters among the standard ones, if the description wants them at run time.
fn run_time_parameters(
    description: &RobotDescription,
    tree: &Tree,
) -> Result<Option<Vec<usize>>, Diagnostic> {
    if !description.generate.runtime_parameters {
        return Ok(None);
    }
    Ok(Some(regressors::leading(tree, &regressors::analysis(tree)?)))
}

/// Places in the dense matrix are of 16 bits, and there has to be an entry.
fn can_be_packed(program: &Program) -> bool {
    let outputs = &program.outputs;
    outputs.len() <= usize::from(u16::MAX) && outputs.iter().any(|&o| o != Operand::Constant(0.0))
}

fn finish(graph: &Graph, entry: &Entry, subject: Option<String>, quantity: Quantity<'_>) -> Function {
    let outputs: Vec<Expr> = quantity.columns.iter().flatten().map(|x| x.expr).collect();
    let program = lower(graph, &outputs, entry.order);
    let name = match &subject {
        Some(subject) => format!("{}_of_{}", entry.name, identifier(subject)),
        None => entry.name.to_owned(),
    };
    Function {
        name,
        family: entry.name,
        subject,
        summary: entry.summary,
        source: entry.source,
        rows: quantity.row_names,
        columns: quantity.column_names,
        row_units: quantity.row_units,
        by_pairs: entry.by_pairs,
        packed: entry.packed && can_be_packed(&program),
        operations: Operations::of(&program),
        program,
        notes: Vec::new(),
    }
}
