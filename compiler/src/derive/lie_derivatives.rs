//! Lie derivatives of a gait's outputs along the dynamics of its phase: what input–output linearisation needs (6.2–6.4).
use super::model::RobotModel;
use super::virtual_constraints::{GaitArguments, VirtualConstraints};
use crate::expression::{Input, Sym, replaced, slopes_along};
use bipedc_runtime::Argument;

/// y = h(q), ẏ = L_f h, ÿ = L_f² h + L_g L_f h τ, where h speaks of φ(q) and the foot that stands is held by the ground.
#[derive(Debug, Clone)]
pub struct LieDerivatives<'g> {
    /// h by output: m or rad.
    pub outputs: Vec<Sym<'g>>,
    /// L_f h: per s.
    pub rates: Vec<Sym<'g>>,
    /// L_f² h, the accelerations of the outputs without torques: per s².
    pub drift: Vec<Sym<'g>>,
    /// L_g L_f h by joint, in the order of `v`, then by output: what one N m adds.
    pub decoupling: Vec<Vec<Sym<'g>>>,
}

/// Derives them. `acceleration` is v̇ of the phase as a function of q, v and τ, affine in τ
/// ([`super::constrained::Constrained`]); h_p and the parameters are arguments.
///
/// L_f² h takes the phase variable's own acceleration with it: φ is a function of q here, no argument.
pub fn lie_derivatives<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &VirtualConstraints<'g>,
    acceleration: &[Sym<'g>],
) -> LieDerivatives<'g> {
    // Behind x and z of the foot.
    let residual = &constraints.residual[2..2 + constraints.wanted.len()];
    along_dynamics(model, (constraints.controlled[0], residual), acceleration)
}

/// The same of outputs in which φ is an argument; `variable` is φ(q).
pub fn along_dynamics<'g>(
    model: &RobotModel<'g, '_>,
    (variable, outputs): (Sym<'g>, &[Sym<'g>]),
    acceleration: &[Sym<'g>],
) -> LieDerivatives<'g> {
    let _work = model.work_on_all("Lie derivatives of the outputs");
    let outputs = replaced(outputs, |input| (input == GaitArguments::PHASE).then_some(variable));
    let rates = slopes_along(&outputs, |input| {
        (input.argument == Argument::Q).then(|| model.input(Argument::V, input.index as usize))
    });
    let zero = model.constant(0.0);
    let free = replaced(acceleration, |input| (input.argument == Argument::Tau).then_some(zero));
    let drift = slopes_along(&rates, |input| match input.argument {
        Argument::Q => Some(model.input(Argument::V, input.index as usize)),
        Argument::V => Some(free[input.index as usize]),
        _ => None,
    });
    let of_torque = |row: usize| {
        let response = response(model, acceleration, row);
        slopes_along(&rates, |input| (input.argument == Argument::V).then(|| response[input.index as usize]))
    };
    let decoupling = model.tree.joints.iter().map(|joint| of_torque(joint.v_index)).collect();
    LieDerivatives { outputs, rates, drift, decoupling }
}

/// What one N m in this row of τ adds to v̇.
pub fn response<'g>(model: &RobotModel<'g, '_>, acceleration: &[Sym<'g>], row: usize) -> Vec<Sym<'g>> {
    let (one, zero) = (model.constant(1.0), model.constant(0.0));
    slopes_along(acceleration, |input| match input.argument {
        Argument::Tau if input.index as usize == row => Some(one),
        Argument::Tau => Some(zero),
        _ => None,
    })
}

/// The guard of the step on its constraint surface at φ = φ₋, of the gait's arguments alone: zero where the step ends.
///
/// h_p has vanished there; `surface` is T ([`super::virtual_constraints::surface`]).
pub fn step_end<'g>(
    model: &RobotModel<'g, '_>,
    arguments: GaitArguments,
    guard: Sym<'g>,
    surface: &[Sym<'g>],
) -> Sym<'g> {
    let end = model.input(Argument::Parameters, GaitArguments::PHASE_END);
    let zero = model.constant(0.0);
    let at_end = |input: Input| match (input.argument, input.index as usize) {
        (Argument::Parameters, 0) => Some(end),
        (Argument::Parameters, index) if index >= arguments.matching(0, 0) => Some(zero),
        _ => None,
    };
    let position = replaced(surface, at_end);
    let guard = replaced(&[guard], at_end);
    replaced(&guard, |input| (input.argument == Argument::Q).then(|| position[input.index as usize]))[0]
}
