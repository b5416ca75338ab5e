//! Impacts (4.20)–(4.22): the velocity just after contacts close, and the impulses that do it.
use super::constrained::{Demand, quickest, respond};
use super::constraint::Constraints;
use super::effects::JointLaws;
use super::model::RobotModel;
use super::standing::Load;
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
    impact_map_with(model, constraints, &[])
}

/// The same with inertias added to the diagonal of D, by row of `v`, kg m²: those of rotors
/// ([`super::drive::reflected_inertia`]). Missing ones are zero.
pub fn impact_map_with<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    rotors: &[f64],
) -> Impact<'g> {
    let rotors: Vec<Sym<'g>> = rotors.iter().map(|&x| model.constant(x)).collect();
    impact_map_of(model, constraints, &rotors)
}

/// The same with the inertias that effects add at joints; their friction is no part of an impact.
pub fn impact_map_with_effects<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    laws: &JointLaws,
) -> Impact<'g> {
    let mut rotors = vec![model.constant(0.0); model.tree.nv];
    for (row, column, m) in laws.inertias(model) {
        if row == column {
            rotors[row] = rotors[row] + m;
        }
    }
    impact_map_of(model, constraints, &rotors)
}

fn impact_map_of<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    rotors: &[Sym<'g>],
) -> Impact<'g> {
    // D (v⁺ − v⁻) = Jᵀ F and J (v⁺ − v⁻) = −J v⁻: a response to no load.
    let no_load = vec![model.constant(0.0); model.tree.nv];
    let eliminated = respond(model, constraints, rotors, &no_load, Demand::Velocity);
    let (jump, impulse) = quickest(model, constraints, rotors, Load::Impact, eliminated);
    let before = (0..model.tree.nv).map(|k| model.input(Argument::V, k));
    Impact { velocity: before.zip(jump).map(|(v, change)| v + change).collect(), impulse }
}
