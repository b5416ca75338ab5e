//! A robot on one foot, by how it answers forces there while it is free: the tree keeps its root, so that both legs are alike.
use super::constrained::{Demand, movable_rows, rows};
use super::constraint::{Block, BodyJacobian, Constraints};
use super::model::{Given, InertiaMode, RobotModel};
use super::sensitivity::Sensitivity;
use super::sensitivity::pinned::{Held, solve_pinned};
use super::standing::{Load, Solution};
use super::support::{Support, SupportKind};
use crate::expression::{Sym, Vector3};
use bipedc_runtime::Argument;

/// A direction in body axes, and whether it is one of a turn.
type Direction<'g> = (Vector3<'g>, bool);
/// The foot that stands, and the directions in which it does.
type Foot<'a, 'g> = (&'a Support, &'a [Direction<'g>]);

/// The response to a load (4.22, 4.23): v̇ or the jump of v in the order of `v`, and λ (N, N m; of an impact N s, N m s) in the published
/// rows; `None` if more than one foot stands, rotors turn, or a direction is one along which nothing can move.
pub(super) fn respond<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    rotors: &[Sym<'g>],
    load: Load<'_, 'g>,
) -> Option<Solution<'g>> {
    let [support] = constraints.supports.as_slice() else { return None };
    let numbers = matches!(model.mode, Some(InertiaMode::Folded | InertiaMode::Plain));
    if model.graph.is_exact() || model.given.is_some() || !numbers || rotors.iter().any(|x| !x.is_zero()) {
        return None;
    }
    if movable_rows(model, constraints, rows).contains(&false) {
        return None;
    }
    let directions = directions(model, support)?;
    let zero = vec![model.constant(0.0); model.tree.nv];
    let foot = (support, directions.as_slice());
    let (x, forces) = match load {
        Load::Forces(tau) => {
            let robot = Sensitivity::new(model, &zero, true, 2.0);
            solve_pinned(&robot, tau, &held(&robot, foot, rates(model, &robot, foot)))
        }
        Load::Impact => {
            let demanded = |block: &Block<'g>| block.demanded(model, Demand::Velocity);
            let rates = constraints.blocks.iter().flat_map(demanded).collect();
            let still = at_rest(model);
            let robot = Sensitivity::new(&still, &zero, false, 2.0);
            solve_pinned(&robot, &zero, &held(&robot, foot, rates))
        }
    };
    Some((x, constraints.publish(&forces)))
}

/// The robot in the same posture without velocities.
fn at_rest<'g, 't>(model: &RobotModel<'g, 't>) -> RobotModel<'g, 't> {
    let mut still = RobotModel::new(model.graph, model.tree, model.mode.unwrap_or(InertiaMode::Folded));
    let q = (0..model.tree.nq).map(|k| model.input(Argument::Q, k)).collect();
    let v = vec![model.constant(0.0); model.tree.nv];
    still.given = Some(Given { q, v, gravity: model.zero3() });
    still
}

/// Accelerations along the directions without accelerations of `v`: the recursion with gravity holds a − g, the point's own is that
/// plus g.
fn rates<'g>(
    model: &RobotModel<'g, '_>,
    robot: &Sensitivity<'_, 'g, '_>,
    (support, directions): Foot<'_, 'g>,
) -> Vec<Sym<'g>> {
    let at = Vector3::constant(model.graph, support.point);
    let seen = BodyJacobian::new(model, support.body, support.point);
    let (linear, angular) = robot.acceleration_in(support.body, at, (model.zero3(), model.zero3()));
    let linear = linear + seen.rotation.transpose() * model.gravity();
    directions.iter().map(|(u, turns)| u.dot(if *turns { angular } else { linear })).collect()
}

/// Unit forces and moments along the directions, about the body's origin.
fn held<'g>(
    robot: &Sensitivity<'_, 'g, '_>,
    (support, directions): Foot<'_, 'g>,
    rates: Vec<Sym<'g>>,
) -> Held<'g> {
    let at = Vector3::constant(robot.model.graph, support.point);
    let unit = |&(u, turns): &Direction<'g>| match turns {
        true => robot.out(support.body, (robot.model.zero3(), u)),
        false => robot.out(support.body, (u, at.cross(u))),
    };
    Held { body: support.body, units: directions.iter().map(unit).collect(), rates }
}

/// The rows of a support, in their order.
fn directions<'g>(model: &RobotModel<'g, '_>, support: &Support) -> Option<Vec<Direction<'g>>> {
    let of = |list: &[[f64; 3]], turns| {
        list.iter().map(|&u| (Vector3::constant(model.graph, u), turns)).collect::<Vec<_>>()
    };
    let whole = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    match &support.kind {
        SupportKind::Point { linear } => Some(of(linear, false)),
        SupportKind::Edge { across, normal } => {
            Some([of(&whole, false), of(&[*across, *normal], true)].concat())
        }
        SupportKind::Flat { linear, angular } => Some([of(linear, false), of(angular, true)].concat()),
        SupportKind::Pivot => None,
    }
}
