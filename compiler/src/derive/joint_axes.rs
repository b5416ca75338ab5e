//! Inverse dynamics and mass matrix written in the axes before each joint.
//!
//! The same functions as [`super::newton_euler`] and [`super::composite`] in other axes: bodies along a chain
//! of parallel joints share theirs. Which takes fewer operations depends on the robot; count both.
use super::RobotModel;
use super::kinematics::Motions;
use super::sensitivity::Sensitivity;
use crate::expression::Sym;
use bipedc_runtime::Argument;

/// Generalised forces that a motion needs, in the order of `v`; velocities always count.
pub fn generalised_forces<'g>(model: &RobotModel<'g, '_>, motions: Motions) -> Vec<Sym<'g>> {
    let accelerations: Vec<Sym<'g>> = (0..model.tree.nv)
        .map(|k| if motions.acceleration { model.input(Argument::A, k) } else { model.constant(0.0) })
        .collect();
    Sensitivity::new(model, &accelerations, motions.gravity, 2.0).forces()
}

/// Mass matrix `D`, symmetric, `nv × nv`, all entries.
pub fn mass_matrix<'g>(model: &RobotModel<'g, '_>) -> Vec<Vec<Sym<'g>>> {
    let still = vec![model.constant(0.0); model.tree.nv];
    Sensitivity::new(model, &still, false, 2.0).mass_matrix()
}
