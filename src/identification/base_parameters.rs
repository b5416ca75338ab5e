//! What parameter identification needs of a robot: base parameters of the observed rows, and their regressor.
use crate::robot::ProgramRegressor;
use bipedc_analysis::identify::BaseSet;
use bipedc_compiler::compile::{FunctionRequest, compile, parameter_names};
use bipedc_compiler::derive::newton_euler::generalised_forces;
use bipedc_compiler::derive::{InertiaMode, Motions, RobotModel};
use bipedc_compiler::description::model::RobotDescription;
use bipedc_compiler::exact::{BaseParameters, Model, ParameterList, Question, StateSpace, base_parameters};
use bipedc_compiler::expression::{Expr, Graph};
use bipedc_compiler::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;

/// The base parameters of these rows of the equations of motion (indices into `v`), in exact arithmetic.
///
/// # Errors
/// As [`base_parameters`].
pub fn observed_base(tree: &Tree, rows: &[usize]) -> Result<BaseParameters, Diagnostic> {
    let tree = tree.structure();
    let graph = Graph::exact();
    let model = RobotModel::new(&graph, tree, InertiaMode::Symbolic);
    let forces = generalised_forces(&model, Motions::ALL, false);
    let rows: Vec<Expr> = rows.iter().filter_map(|&row| forces.get(row)).map(|x| x.expr).collect();
    base_parameters(&graph, &rows, &StateSpace::free(tree), ParameterList::Standard)
}

/// The base parameters of the observed rows and the columns of the regressor that belong to them.
///
/// # Errors
/// As [`observed_base`] and [`compile`].
pub fn base_regressor(
    description: &RobotDescription,
    tree: &Tree,
    rows: &[usize],
) -> Result<(BaseSet, ProgramRegressor), Diagnostic> {
    let set = base_set(&observed_base(tree, rows)?, tree)?;
    let leading: Vec<usize> = (0..set.sums.len()).filter_map(|k| set.leading(k)).collect();
    let request = FunctionRequest::of_robot("inverse_dynamics_regressor");
    let rigid = description.clone().without_effects();
    let compiled = compile(&rigid, tree, &[request])?;
    let program = &compiled.functions[0].program;
    Ok((set, ProgramRegressor::new(program, (tree.nq, tree.nv), &leading)))
}

/// The base parameters of what the ground does to a robot that stands on its root (thesis 5.4): a point of a sole, or a
/// foot. `of` is the centre of mass (rows x, y, z times mass) or the ground's wrench (Fx … Mz).
///
/// # Errors
/// As [`Question::answer`].
pub fn standing_base(
    description: &RobotDescription,
    tree: &Tree,
    root: &str,
    (of, rows): (Model, &[&str]),
    feet_flat: bool,
) -> Result<BaseSet, Diagnostic> {
    let question = Question {
        root: Some(root.to_owned()),
        fixed: Some(true),
        rows: rows.iter().map(|row| (*row).to_owned()).collect(),
        feet_flat,
        ..Question::new(of)
    };
    base_set(&question.answer(description)?, tree)
}

/// Sums over named columns as sums over the parameters of a tree, ten per body.
fn base_set(base: &BaseParameters, tree: &Tree) -> Result<BaseSet, Diagnostic> {
    let names = parameter_names(tree);
    let place = |column: usize| {
        let name = &base.columns[column].name;
        names.iter().position(|n| n == name).ok_or_else(|| {
            Diagnostic::error(format!("the regressor has no column `{name}`"))
                .help("links whose names differ only in characters that identifiers cannot have?")
        })
    };
    let mut set = BaseSet::default();
    for parameter in &base.parameters {
        set.names.push(parameter.text.clone());
        set.units.push(parameter.unit);
        let sum = parameter.combination.iter().map(|term| Ok((place(term.column)?, term.coefficient)));
        set.sums.push(sum.collect::<Result<_, Diagnostic>>()?);
    }
    Ok(set)
}
