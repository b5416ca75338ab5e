//! What a gait's controller needs: Lie derivatives of its outputs, the end of a step.
use super::function;
use crate::compile::{Function, Quantity, without_poles};
use crate::derive::constrained::{constrained_dynamics, constrained_dynamics_with_effects};
use crate::derive::constraint::Constraints;
use crate::derive::effects::JointLaws;
use crate::derive::lie_derivatives as derive;
use crate::derive::virtual_constraints::{GaitArguments, virtual_constraints};
use crate::derive::{InertiaMode, RobotModel};
use crate::description::gait::Gait;
use crate::description::model::RobotDescription;
use crate::expression::{Graph, Sym};
use crate::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;

/// h, L_f h and L_f² h, then L_g L_f h by joint; one row for each output. `stance` is the index of the contact point that stands.
pub(super) fn lie_derivatives(
    description: &RobotDescription,
    tree: &Tree,
    gait: &Gait,
    stance: usize,
) -> Result<Function, Diagnostic> {
    let graph = Graph::new();
    let model = RobotModel::new(&graph, tree, InertiaMode::Folded);
    let laws = JointLaws::new(tree, description)?;
    let phase = description.phases.iter().find(|phase| phase.name == gait.phase.name);
    let contacts = phase.map_or(&[][..], |phase| &phase.contacts);
    let held = Constraints::new(&model, &description.feet, contacts)?;
    let motion = match laws.is_empty() {
        true => constrained_dynamics(&model, &held),
        false => constrained_dynamics_with_effects(&model, &held, &laws),
    };
    let constraints = virtual_constraints(&model, gait, stance)?;
    let derived = derive::lie_derivatives(&model, &constraints, &motion.acceleration);
    let (rows, units) =
        gait.phase.outputs.iter().map(|output| (output.name.clone(), output.unit.clone())).unzip();
    let joints = tree.joints.iter().map(|joint| format!("L_g L_f h/{}", joint.name));
    let names = ["h", "L_f h", "L_f² h"].into_iter().map(str::to_owned).chain(joints).collect();
    let mut columns = vec![derived.outputs, derived.rates, derived.drift];
    columns.extend(derived.decoupling);
    let head = (
        "lie_derivatives",
        "(6.2), (6.3)",
        "The outputs h(q) with h_p, their rates L_f h, their accelerations without torques L_f² h, then what one N m at each joint \
         adds to them, L_g L_f h.",
    );
    without_poles(&graph, "the gait's controller")?;
    Ok(function(&graph, head, Quantity::matrix(rows, units, names, columns)))
}

/// The guard at the end of a step on the constraint surface, as a function of φ₋ and the parameters.
pub(super) fn step_end<'g>(
    model: &RobotModel<'g, '_>,
    gait: &Gait,
    guard: Sym<'g>,
    position: &[Sym<'g>],
) -> Function {
    let end = derive::step_end(model, GaitArguments::new(gait), guard, position);
    let head = (
        "step_end",
        "(6.1), (6.5)",
        "The guard on the constraint surface at φ = φ₋: zero where a step with these parameters ends.",
    );
    function(model.graph, head, Quantity::scalar("guard", "1", end))
}
