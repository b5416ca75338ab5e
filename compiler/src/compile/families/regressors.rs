//! Regressors: what is linear in the inertial parameters, separated (5.1), and reduced to base parameters
//! (5.2).
use super::super::Context;
use super::super::quantity::Quantity;
use super::force_units;
use crate::derive::newton_euler::generalised_forces;
use crate::derive::{InertiaMode, Motions, RobotModel, momentum as whole, regressor, shared_columns};
use crate::exact::{BaseParameters, ParameterList, StateSpace, base_parameters as analyse};
use crate::expression::{Expr, Graph, Sym, separate};
use crate::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;

/// Names of the ten standard parameters of every body.
pub fn parameter_names(tree: &Tree) -> Vec<String> {
    const TEN: [&str; 10] = ["m", "m*cx", "m*cy", "m*cz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"];
    tree.bodies.iter().flat_map(|body| TEN.iter().map(move |p| format!("{}.{p}", body.name))).collect()
}

fn parameter_units(tree: &Tree) -> Vec<String> {
    const TEN: [&str; 10] =
        ["kg", "kg m", "kg m", "kg m", "kg m²", "kg m²", "kg m²", "kg m²", "kg m²", "kg m²"];
    tree.bodies.iter().flat_map(|_| TEN.map(str::to_owned)).collect()
}

/// One column per standard parameter.
fn separated<'g>(
    c: &Context<'g, '_>,
    row_names: Vec<String>,
    units: Vec<String>,
    rows: &[Sym<'g>],
) -> Result<Quantity<'g>, Diagnostic> {
    let model = &c.symbolic;
    let outputs: Vec<Expr> = rows.iter().map(|x| x.expr).collect();
    let forms = separate(model.graph, &outputs).map_err(|row| {
        Diagnostic::error(format!("row `{}` is not linear in the inertial parameters", row_names[row]))
    })?;
    let zero = model.constant(0.0);
    let names = parameter_names(model.tree);
    let coefficient = |form: &crate::expression::LinearForm, k: u32| {
        form.coefficients.get(&k).map_or(zero, |&e| Sym::new(model.graph, e))
    };
    let mut columns: Vec<Vec<Sym<'g>>> =
        (0..names.len() as u32).map(|k| forms.iter().map(|form| coefficient(form, k)).collect()).collect();
    (0..model.tree.bodies.len()).for_each(|body| shared_columns::share(model, body, &mut columns, false));
    Ok(Quantity::matrix(row_names, units, names, columns))
}

pub fn inverse_dynamics<'g>(c: &Context<'g, '_>) -> Result<Quantity<'g>, Diagnostic> {
    let tree = c.symbolic.tree;
    let columns = regressor::inverse_dynamics(&c.symbolic);
    Ok(Quantity::matrix(tree.row_names(), force_units(tree), parameter_names(tree), columns))
}

fn named(rows: &[&str], unit: &str) -> (Vec<String>, Vec<String>) {
    (rows.iter().map(|s| (*s).to_owned()).collect(), vec![unit.to_owned(); rows.len()])
}

pub fn energy<'g>(c: &Context<'g, '_>) -> Result<Quantity<'g>, Diagnostic> {
    let (names, units) = named(&["kinetic", "potential"], "J");
    separated(c, names, units, &[whole::kinetic_energy(&c.symbolic), whole::potential_energy(&c.symbolic)])
}

pub fn center_of_mass<'g>(c: &Context<'g, '_>) -> Result<Quantity<'g>, Diagnostic> {
    let (names, units) = named(&["x", "y", "z"], "kg m");
    separated(c, names, units, &whole::first_moment(&c.symbolic).0)
}

pub fn ground_wrench<'g>(c: &Context<'g, '_>) -> Result<Quantity<'g>, Diagnostic> {
    let wrench = whole::ground_wrench(&c.symbolic);
    let zero = c.symbolic.zero3();
    let shape = Quantity::pair(["N", "N m"], zero, zero);
    let rows: Vec<Sym<'g>> = wrench.linear.0.into_iter().chain(wrench.angular.0).collect();
    separated(c, shape.row_names, shape.row_units, &rows)
}

/// The exact analysis of the equations of motion on the tree's base.
pub fn analysis(tree: &Tree) -> Result<BaseParameters, Diagnostic> {
    let tree = tree.structure();
    let graph = Graph::exact();
    let model = RobotModel::new(&graph, tree, InertiaMode::Symbolic);
    let rows: Vec<Expr> = generalised_forces(&model, Motions::ALL, false).iter().map(|x| x.expr).collect();
    analyse(&graph, &rows, &StateSpace::free(tree), ParameterList::Standard)
}

/// Positions of the base parameters' leading columns among the standard parameters.
pub fn leading(tree: &Tree, base: &BaseParameters) -> Vec<usize> {
    let names = parameter_names(tree);
    let position = |name: &String| names.iter().position(|n| n == name);
    base.independent_columns().iter().filter_map(|&k| position(&base.columns[k].name)).collect()
}

pub fn inverse_dynamics_base<'g>(c: &Context<'g, '_>) -> Result<Quantity<'g>, Diagnostic> {
    let tree = c.symbolic.tree;
    let full = inverse_dynamics(c)?;
    let base = analysis(tree)?;
    let columns = leading(tree, &base).into_iter().map(|k| full.columns[k].clone()).collect();
    let names = base.parameters.iter().map(|p| p.text.clone()).collect();
    Ok(Quantity::matrix(full.row_names, full.row_units, names, columns))
}

pub fn base_values<'g>(c: &Context<'g, '_>) -> Result<Quantity<'g>, Diagnostic> {
    let base = analysis(c.symbolic.tree)?;
    let names = base.parameters.iter().map(|p| p.text.clone()).collect();
    let units = base.parameters.iter().map(|p| p.unit.to_owned()).collect();
    let values = base.parameters.iter().map(|p| c.symbolic.constant(p.value)).collect();
    Ok(Quantity::named(names, units, values))
}

pub fn values<'g>(c: &Context<'g, '_>) -> Result<Quantity<'g>, Diagnostic> {
    let tree = c.symbolic.tree;
    // Seen from the main link's frame, where parameters are stated.
    let stated = tree.bodies.iter().map(|body| body.inertia.transformed(&body.main_link.inverse()));
    let values = stated.flat_map(|inertia| inertia.parameters()).map(|x| c.symbolic.constant(x)).collect();
    Ok(Quantity::named(parameter_names(tree), parameter_units(tree), values))
}
