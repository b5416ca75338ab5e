//! The constraint surface of a phase as equations that an iteration solves (6.30), what the ground has to provide along it (6.38–6.41), and the
//! ratio of the phase variables' rates where the next phase begins (6.35).
use super::configuration;
use super::phased::{Names, joined};
use super::phased_in_process::standing;
use crate::compile::{Function, Quantity};
use crate::derive::RobotModel;
use crate::derive::constraint::Constraints;
use crate::derive::effects::JointLaws;
use crate::derive::impact::{impact_map, impact_map_with_effects};
use crate::derive::momentum::wrench_along_surface;
use crate::derive::relabel::Relabelling;
use crate::derive::virtual_constraints::{
    PhaseConstraints, configuration_jacobian, contact_places, phase_constraints, slopes_with_phase,
};
use crate::description::gait::PhasedGait;
use crate::description::model::{Phase, RobotDescription};
use crate::expression::{Sym, replaced};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::Argument;

/// Coordinates of the contact points that a phase holds: of each foot x and z of its first point, z of a second one, which keeps it from turning.
fn held<'g>(
    model: &RobotModel<'g, '_>,
    description: &RobotDescription,
    phase: &Phase,
) -> (Vec<String>, Vec<Sym<'g>>) {
    let places = contact_places(model);
    let (mut names, mut found) = (Vec::new(), Vec::new());
    for foot in &description.feet {
        for (k, point) in standing(foot, &phase.contacts).into_iter().take(2).enumerate() {
            let name = format!("{}/{point}", foot.name);
            let Some(index) = model.tree.points.iter().position(|known| known.name == name) else { continue };
            for (axis, &value) in ["x", "z"].into_iter().zip(&places[index]).skip(k) {
                names.push(format!("{name}/{axis}"));
                found.push(value);
            }
        }
    }
    (names, found)
}

/// How many coordinates a phase holds.
pub(super) fn held_count(description: &RobotDescription, phase: &Phase) -> usize {
    let of_foot = |points: usize| [0, 2, 3][points.min(2)];
    description.feet.iter().map(|foot| of_foot(standing(foot, &phase.contacts).len())).sum()
}

/// What vanishes on the surface with its slopes and second slopes.
pub(super) fn surface_equations<'g>(
    model: &RobotModel<'g, '_>,
    names: &Names<'_>,
    constraints: &PhaseConstraints<'g>,
    (description, phase): (&RobotDescription, &Phase),
) -> Vec<Function> {
    let (mut rows, coordinates) = held(model, description, phase);
    let (outputs, units) = names.outputs();
    let metres = vec!["m".to_owned(); rows.len()];
    let units: Vec<String> = metres.into_iter().chain(units).chain([names.phase.unit.clone()]).collect();
    rows.extend(outputs.into_iter().chain(["phase".to_owned()]));
    let phase = model.input(Argument::Parameters, 0);
    let all = joined(coordinates, &joined(constraints.outputs.clone(), &[constraints.controlled[0] - phase]));
    let vector = |values: Vec<Sym<'g>>| Quantity::named(rows.clone(), units.clone(), values);
    let along = slopes_with_phase(model, &all, true);
    let columns = configuration_jacobian(model.tree, &all);
    let of = [
        vector(all.clone()),
        Quantity::matrix(rows.clone(), units.clone(), configuration(model.tree).0, columns),
        vector(slopes_with_phase(model, &all, false)),
        vector(slopes_with_phase(model, &along, true)),
    ];
    SURFACE.into_iter().zip(of).map(|(head, of)| names.function(model.graph, head, of)).collect()
}

const SURFACE: [super::Head; 4] = [
    (
        "surface_equations",
        "(6.30)",
        "Coordinates of the contact points that the ground holds, the outputs h(q, p) with h_p, φ(q) − φ: q = T(φ) is where the first are what \
         they were as the phase began and the others vanish.",
    ),
    ("surface_slopes", "(6.30)", "Slopes of these equations with respect to q: J."),
    ("surface_rates", "(6.30)", "Their slopes with respect to φ at constant q: J T′ = −these."),
    (
        "surface_curvatures",
        "(6.30)",
        "Their second slopes where q changes with v = T′ and φ with 1: J T″ = −these.",
    ),
];

/// φ̇ just after the phase's end over φ̇ just before it, at q = T(φ₋) and v = T′(φ₋) of the phase that ends: η of (6.35).
///
/// # Errors
/// Formulas and contacts without a value.
pub(super) fn rate_ratio<'g>(
    model: &RobotModel<'g, '_>,
    (gait, index): (&PhasedGait, usize),
    names: &Names<'_>,
    (description, phase, laws): (&RobotDescription, &Phase, &JointLaws),
) -> Result<Function, Diagnostic> {
    let next = phase_constraints(model, gait, (index + 1) % gait.phases.len())?.controlled[0];
    let after = super::rates(model, &[next]);
    let all = |argument: Argument, count: usize| (0..count).map(move |k| model.input(argument, k)).collect();
    let (mut q, mut v): (Vec<Sym<'g>>, Vec<Sym<'g>>) =
        (all(Argument::Q, model.tree.nq), all(Argument::V, model.tree.nv));
    if !phase.impact.is_empty() {
        let closed = Constraints::new(model, &description.feet, &phase.impact)?;
        v = match laws.is_empty() {
            true => impact_map(model, &closed),
            false => impact_map_with_effects(model, &closed, laws),
        }
        .velocity;
    }
    if phase.relabel {
        let exchange = Relabelling::new(model.tree, description)?;
        (q, v) = (exchange.configuration(&q), exchange.velocity(&v));
    }
    let moved = |input: crate::expression::Input| match input.argument {
        Argument::Q => Some(q[input.index as usize]),
        Argument::V => Some(v[input.index as usize]),
        _ => None,
    };
    let head = (
        "rate_ratio",
        "η of (6.35)",
        "φ̇ of the next phase where it begins, over φ̇ where this one ends: at q = T(φ₋), v = T′(φ₋); impact and exchange of legs count.",
    );
    Ok(names.function(model.graph, head, Quantity::scalar("eta", "1", replaced(&after, moved)[0])))
}

/// Force and moment of the ground along a surface, by φ̈, φ̇² and at rest; of all phases alike.
pub(super) fn ground_on_surface(model: &RobotModel<'_, '_>) -> Function {
    let columns = wrench_along_surface(model).map(|w| vec![w.linear[0], w.linear[2], w.angular[1]]).to_vec();
    let words = |all: [&str; 3]| all.map(str::to_owned).to_vec();
    let of = Quantity::matrix(
        words(["force/x", "force/z", "moment/y"]),
        words(["N", "N", "N m"]),
        words(["per acceleration", "per squared rate", "at rest"]),
        columns,
    );
    let head = (
        "ground_on_surface",
        "(6.38)–(6.41)",
        "What the ground provides along a constraint surface, at q = T, v = T′, a = T″: times φ̈, φ̇² and 1 its force along x and z and its moment \
         about y and the world's origin; −moment/y over force/z is the zero moment point on the ground z = 0.",
    );
    super::function(model.graph, head, of)
}
