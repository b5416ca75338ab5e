//! Impacts (4.20)–(4.22): the velocity just after contacts close, and the impulses that do it.
use super::composite::mass_matrix;
use super::constrained::Held;
use super::constraint::Constraints;
use super::model::RobotModel;
use super::solve::Factor;
use crate::expression::Sym;
use bipedc_runtime::Argument;

/// State just after an impact.
#[derive(Debug, Clone)]
pub struct Impact<'g> {
    /// v⁺ in the order of `v`; legs keep their names.
    pub velocity: Vec<Sym<'g>>,
    /// F in the order of [`Constraints::names`], N s and N m s: what the ground does to the robot.
    pub impulse: Vec<Sym<'g>>,
}

/// `[D −Jᵀ; J 0] [v⁺; F] = [D v⁻; 0]`: F = −Y J v⁻, v⁺ = v⁻ + D⁻¹ Jᵀ F.
///
/// (4.22) prints +Jᵀ, which gives the impulse the wrong sign. `constraints` are the contacts that hold just
/// after the impact, kept ones and new ones, on a model whose base is free (floating or planar): on a fixed
/// or pivoting base the root stays where it is during the impact, which is right for a foot that stays down
/// and wrong for one that lifts. v⁻ is [`Argument::V`].
pub fn impact_map<'g>(model: &RobotModel<'g, '_>, constraints: &Constraints<'g>) -> Impact<'g> {
    impact_map_with(model, constraints, &mass_matrix(model))
}

/// The same for another mass matrix, such as one with reflected rotor inertias.
pub fn impact_map_with<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    mass_matrix: &[Vec<Sym<'g>>],
) -> Impact<'g> {
    let before: Vec<Sym<'g>> = (0..model.tree.nv).map(|k| model.input(Argument::V, k)).collect();
    let factor = Factor::new(model, mass_matrix);
    let held = Held::new(&factor, constraints);
    let rows = constraints.blocks.iter().flat_map(|block| &block.jacobian);
    let zero = model.constant(0.0);
    let approach = rows.map(|row| -row.iter().zip(&before).fold(zero, |sum, (&j, &v)| sum + j * v)).collect();
    let impulse = held.forces(approach);
    let jump = factor.back_solve(held.add_response(vec![zero; model.tree.nv], &impulse));
    let velocity = before.iter().zip(jump).map(|(&v, change)| v + change).collect();
    Impact { velocity, impulse: constraints.publish(&impulse) }
}
