//! Zero dynamics of a gait: α φ̈ + β φ̇² + γ = 0 (6.6, Table 6.3 corrected), for a planar robot on one pinned foot.
use super::kinematics::Motions;
use super::model::RobotModel;
use super::newton_euler::generalised_forces;
use super::virtual_constraints::configuration_jacobian;
use crate::expression::{Input, Sym, replaced};
use bipedc_runtime::Argument;

/// α, β and γ at q = T, v = T′, a = T″ ([`Argument::Q`], [`Argument::V`], [`Argument::A`]).
///
/// With n the one direction that neither torques of joints nor the force on the foot reach, nᵀ [B W] = 0:
/// α = nᵀ D T′, β = nᵀ (C T′ + D T″), γ = nᵀ G. n is the turn of the whole robot about the foot, one radian per radian, so
/// that α φ̇ is the angular momentum σ about that point and σ̇ = −γ (6.7). α is linear in v: at any velocity it is σ.
#[derive(Debug, Clone)]
pub struct ZeroDynamics<'g> {
    /// kg m² per unit of φ.
    pub alpha: Sym<'g>,
    /// The slope of α along the constraint surface.
    pub beta: Sym<'g>,
    /// N m.
    pub gamma: Sym<'g>,
}

/// Derives them; `foot` are x and z of the foot that stands.
pub fn zero_dynamics<'g>(model: &RobotModel<'g, '_>, foot: &[Sym<'g>; 2]) -> ZeroDynamics<'g> {
    let turn = turn_about_foot(model, foot);
    let along = |motions: Motions| {
        let forces = generalised_forces(model, motions, false);
        turn.iter().zip(&forces).fold(model.constant(0.0), |sum, (&n, &force)| sum + n * force)
    };
    let accelerated = along(Motions { velocity: false, acceleration: true, gravity: false });
    // D T′: the forces of an acceleration, with the velocity in its place.
    let to_velocity = |input: Input| {
        (input.argument == Argument::A).then(|| model.input(Argument::V, input.index as usize))
    };
    ZeroDynamics {
        alpha: replaced(&[accelerated], to_velocity)[0],
        beta: along(Motions { gravity: false, ..Motions::ALL }),
        gamma: along(Motions::AT_REST),
    }
}

/// Rows x, z and pitch of n: across both rows of the foot's Jacobian in the columns of the base, which no joint moves.
fn turn_about_foot<'g>(model: &RobotModel<'g, '_>, foot: &[Sym<'g>; 2]) -> [Sym<'g>; 3] {
    let columns = configuration_jacobian(model.tree, foot);
    let entry = |row: usize, column: usize| columns[column][row];
    let minor = |a: usize, b: usize| entry(0, a) * entry(1, b) - entry(0, b) * entry(1, a);
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}
