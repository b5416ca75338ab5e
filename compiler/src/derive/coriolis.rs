//! The Coriolis matrix.
use super::RobotModel;
use super::sensitivity::{Column, Sensitivity};
use crate::expression::Sym;

/// Coriolis matrix `C(q, v)`, `nv × nv`: `C v` = bias − gravity, and `Ḋ − 2 C` is skew-symmetric along the
/// motion, for a floating base's twist components too.
///
/// The factorisation is `C = Σ m Jᵀ J̇` over all points of all bodies, with `J` the Jacobian of the point with
/// respect to `v`: then `Ḋ − 2 C = Σ m (J̇ᵀ J − Jᵀ J̇)`. On coordinates (fixed, pivot and planar bases) it is
/// that of the Christoffel symbols (4.20), on bodies that of Echeandia and Wensing, "Numerical methods to
/// compute the Coriolis matrix and Christoffel symbols for rigid-body systems" (2021). It is evaluated by one
/// recursion, O(n × depth).
pub fn coriolis_matrix<'g>(model: &RobotModel<'g, '_>) -> Vec<Vec<Sym<'g>>> {
    let zero = vec![model.constant(0.0); model.tree.nv];
    Sensitivity::new(model, &zero, false, 1.0).matrix(Column::UnitRate)
}
