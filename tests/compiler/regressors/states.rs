//! What the exact analysis evaluates: the same physics as the rounded graph, and feet that really are flat.
use crate::compiler::regressors::support::robot;
use bipedc_compiler::derive::{InertiaMode, Motions, RobotModel, frames, newton_euler};
use bipedc_compiler::description::model::{Base, RobotDescription};
use bipedc_compiler::exact::{Arithmetic, Evaluator, Field, Rounded, StateSpace};
use bipedc_compiler::expression::{Expr, Graph, Sym};
use bipedc_compiler::tree::Tree;
use bipedc_effects::random::Random;
use bipedc_runtime::Argument;

/// TUlip with two joints turned by odd angles.
fn odd_tulip() -> RobotDescription {
    let mut description = robot("tulip");
    for joint in &mut description.joints {
        if ["left_hip_yaw", "right_ankle_roll", "left_ankle_roll"].contains(&joint.name.as_str()) {
            joint.origin.rpy = [0.1, -0.2, 0.3];
        }
    }
    description
}

fn standing(description: &RobotDescription) -> Tree {
    Tree::new(description, &Base::Floating { root: "right_foot".to_owned() }).unwrap()
}

#[test]
fn exact_and_rounded_graph_have_the_same_physics() {
    let tree = standing(&odd_tulip());
    let values = |graph: &Graph| {
        let model = RobotModel::new(graph, &tree, InertiaMode::Symbolic);
        let motions = Motions { velocity: true, acceleration: true, gravity: true };
        let rows: Vec<Expr> =
            newton_euler::generalised_forces(&model, motions, false).iter().map(|row| row.expr).collect();
        let evaluator = Evaluator::new(Rounded, graph, &rows).unwrap();
        let mut random = Random::new(4);
        // Parameters come last in the order of inputs, so that both graphs draw the same state.
        let mut inputs: Vec<_> = evaluator.inputs().collect();
        inputs.sort();
        let state = StateSpace::free(&tree).sample(&Rounded, inputs.into_iter(), &mut random).unwrap();
        evaluator.run(&state).unwrap()
    };
    let (exact, rounded) = (values(&Graph::exact()), values(&Graph::new()));
    let scale = rounded.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    for (a, b) in exact.iter().zip(&rounded) {
        assert!((a - b).abs() < 1e-13 * scale, "{a} {b}");
    }
}

/// Tilt of the left foot, and its rate and acceleration: two components each, in world axes.
fn tilt(graph: &Graph, tree: &Tree) -> Vec<Expr> {
    let model = RobotModel::new(graph, tree, InertiaMode::Symbolic);
    let poses = frames::world_poses(&model);
    let foot = tree.frame("left_foot").unwrap();
    let pose = frames::frame_pose(&model, &poses, foot);
    let columns = frames::jacobian(&model, &poses, foot.body, pose.position);
    let sum = |argument: Argument| {
        [0, 1].map(|row| {
            let terms =
                columns.iter().enumerate().map(|(k, column)| column.1[row] * model.input(argument, k));
            terms.fold(model.constant(0.0), |sum, term| sum + term)
        })
    };
    let rate = sum(Argument::V);
    let drift = frames::jacobian_rate_times_velocity(&model, &poses, foot);
    let acceleration = sum(Argument::A);
    let tilt: [Sym<'_>; 2] = [pose.rotation[(0, 2)], pose.rotation[(1, 2)]];
    let change = [acceleration[0] + drift[3], acceleration[1] + drift[4]];
    [tilt, rate, change].concat().iter().map(|x| x.expr).collect()
}

fn tilts<A: Arithmetic>(arithmetic: A, tree: &Tree) -> Vec<A::Value> {
    let graph = Graph::exact();
    let evaluator = Evaluator::new(arithmetic, &graph, &tilt(&graph, tree)).unwrap();
    let space = StateSpace::pinned(tree).with_flat(vec!["left_foot".to_owned()]);
    let mut random = Random::new(8);
    let mut out = Vec::new();
    while out.len() < 60 {
        // About every other draw has no square root.
        if let Some(state) = space.sample(&evaluator.arithmetic, evaluator.inputs(), &mut random) {
            out.extend(evaluator.run(&state).unwrap());
        }
    }
    out
}

#[test]
fn flat_feet_are_flat() {
    for description in [robot("tulip"), robot("biped_3d"), odd_tulip()] {
        let tree = standing(&description);
        for field in Field::all().take(2) {
            assert!(tilts(field, &tree).iter().all(|&x| x == 0));
        }
        let rounded = tilts(Rounded, &tree);
        let worst = rounded.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        assert!(worst < 1e-9, "{worst}");
    }
}
