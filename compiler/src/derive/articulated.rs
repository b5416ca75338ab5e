//! Forward dynamics: articulated bodies, and the choice between them and the factored mass matrix.
use super::RobotModel;
use super::sensitivity::Sensitivity;
use super::solve::Factor;
use crate::expression::{Expr, Sym};
use crate::program::{Operations, Order, Paired, longest_chain, lower};
use crate::tree::Twins;
use bipedc_runtime::Argument;

/// Price of a division in multiplications.
const DIVISION: usize = 4;

/// Accelerations a(q, v, τ) under generalised forces, in the order of `v`, by whichever of [`articulated`],
/// [`factored`] and [`absolute`] takes the fewest operations for this robot.
pub fn forward_dynamics<'g>(model: &RobotModel<'g, '_>, tau: &[Sym<'g>]) -> Vec<Sym<'g>> {
    let ways = [absolute(model, tau), factored(model, tau), articulated(model, tau)];
    ways.into_iter().min_by_key(|way| price(model, way)).expect("there are three ways")
}

/// Operations of `outputs`, a division counted as four.
pub(super) fn price(model: &RobotModel<'_, '_>, outputs: &[Sym<'_>]) -> usize {
    let outputs: Vec<Expr> = outputs.iter().map(|x| x.expr).collect();
    let operations = Operations::of(&lower(model.graph, &outputs, Order::DepthFirst));
    operations.total() + (DIVISION - 1) * operations.divisions
}

/// What `outputs` take on one state, in no unit: instructions, those of both legs that are done as one counted once, and, because not all of
/// them are in flight at a time, the longest chain of them. The weight is from contact dynamics and impacts of three robots, of which it
/// orders the ways right within 7 %.
pub(super) fn duration(model: &RobotModel<'_, '_>, outputs: &[Sym<'_>]) -> usize {
    let outputs: Vec<Expr> = outputs.iter().map(|x| x.expr).collect();
    let program = lower(model.graph, &outputs, Order::DepthFirst);
    let twins = Paired::new(&program, &Twins::of(model.tree)).pairs.into_iter().flatten().count();
    4 * (Operations::of(&program).instructions() - twins) + 7 * longest_chain(&program)
}

/// `τ` as an argument.
pub fn given_forces<'g>(model: &RobotModel<'g, '_>) -> Vec<Sym<'g>> {
    (0..model.tree.nv).map(|k| model.input(Argument::Tau, k)).collect()
}

fn still<'m, 'g, 't>(model: &'m RobotModel<'g, 't>) -> Sensitivity<'m, 'g, 't> {
    Sensitivity::new(model, &vec![model.constant(0.0); model.tree.nv], true, 2.0)
}

pub(super) fn less<'g>(a: &[Sym<'g>], b: &[Sym<'g>]) -> Vec<Sym<'g>> {
    a.iter().zip(b).map(|(&a, &b)| a - b).collect()
}

/// `D⁻¹ (τ − bias)` with the mass matrix factored along the tree.
pub fn factored<'g>(model: &RobotModel<'g, '_>, tau: &[Sym<'g>]) -> Vec<Sym<'g>> {
    let still = still(model);
    Factor::new(model, &still.mass_matrix()).solve(&less(tau, &still.forces()))
}

/// The same with the absolute angles of parallel joints as coordinates: in them the mass matrix of planar
/// chains has constant diagonals and most couplings are single products.
pub fn absolute<'g>(model: &RobotModel<'g, '_>, tau: &[Sym<'g>]) -> Vec<Sym<'g>> {
    let still = still(model);
    let forces = less(&still.in_absolute_angles(tau), &still.absolute_forces());
    let accelerations = Factor::new(model, &still.absolute_mass_matrix()).solve(&forces);
    still.joint_velocities(&accelerations)
}

/// Articulated-body algorithm (Featherstone, "Rigid Body Dynamics Algorithms", table 7.1). Its bias
/// wrenches are those of the motion without joint accelerations, so that what is solved for is the change of
/// every body's acceleration.
pub fn articulated<'g>(model: &RobotModel<'g, '_>, tau: &[Sym<'g>]) -> Vec<Sym<'g>> {
    let still = still(model);
    super::sensitivity::articulated::solve(&still, tau)
}
