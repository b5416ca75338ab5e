//! Every way of the tree on the foot, against the constrained equations of the tree on the base.
use super::super::constrained::{Demand, respond};
use super::super::newton_euler::generalised_forces;
use super::super::pinned;
use super::*;
use crate::Robot;
use crate::expression::Graph;
use crate::program::{Evaluator, Order, lower};
use crate::tree::{Rotation, Tree};
use bipedc_runtime::State;
use std::path::Path;

/// Folders below the project, and phases in which a sole, a point or (one) an edge stands alone.
const ROBOTS: [(&str, &str); 10] = [
    ("robots/tulip", "right_support"),
    ("robots/biped_3d", "single_support"),
    ("robots/biped_3d", "toe_support"),
    ("robots/five_link", "single_support"),
    ("robots/seven_link", "single_support"),
    ("robots/seven_link", "toe_support"),
    ("benches/robots/lower12", "right_point"),
    ("benches/robots/lower12", "right_support"),
    ("benches/robots/rabbit5", "right_support"),
    ("benches/robots/biped7", "right_heel"),
];

fn numbers(n: usize, size: f64, seed: f64) -> Vec<f64> {
    (0..n).map(|k| size * (seed + 7.3 * k as f64).sin()).collect()
}

/// Any state: the foot need not be at rest in it.
fn state(tree: &Tree, seed: f64) -> [Vec<f64>; 3] {
    let mut q = numbers(tree.nq, 0.7, seed);
    if tree.nq > tree.nv {
        let norm = q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
        q[3..7].iter_mut().for_each(|x| *x /= norm);
    }
    [q, numbers(tree.nv, 2.0, seed + 1.0), numbers(tree.nv, 20.0, seed + 2.0)]
}

fn values(graph: &Graph, solution: &Solution<'_>, [q, v, tau]: &[Vec<f64>; 3]) -> Vec<f64> {
    let outputs: Vec<_> = solution.0.iter().chain(&solution.1).map(|x| x.expr).collect();
    let program = lower(graph, &outputs, Order::Derivation);
    let mut out = vec![f64::NAN; outputs.len()];
    let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::Tau, tau);
    Evaluator::new(&program).run_one(&state, &mut out);
    out
}

fn agree(name: &str, ours: &[f64], theirs: &[f64]) {
    let scale = theirs.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    for (k, (a, b)) in ours.iter().zip(theirs).enumerate() {
        // Not the other way round: NaN must fail.
        assert!(
            (a - b).abs() <= 1e-10 * scale,
            "{name}: element {k} is {a:e}, not {b:e} (largest {scale:e})"
        );
    }
}

#[test]
fn every_way_finds_the_same_motion_and_forces() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut ways_seen = 0;
    for (folder, phase) in ROBOTS {
        let robot = Robot::read(&project.join(folder)).unwrap();
        let known: Vec<&str> = robot.description.phases.iter().map(|p| p.name.as_str()).collect();
        let phase = robot.description.phases.iter().find(|p| p.name == phase);
        let phase = phase.unwrap_or_else(|| panic!("{folder} has {known:?}"));
        let tree = Tree::new(&robot.description, &robot.description.base).unwrap();
        let graph = Graph::new();
        let model = RobotModel::new(&graph, &tree, InertiaMode::Folded);
        let constraints = Constraints::new(&model, &robot.description.feet, &phase.contacts).unwrap();
        let tau: Vec<_> = (0..tree.nv).map(|k| model.input(Argument::Tau, k)).collect();
        let free = less(&tau, &generalised_forces(&model, Motions::NO_ACCELERATION, false));
        let nothing = vec![model.constant(0.0); tree.nv];
        let first = tree.base_nv().max(3);
        let rotor = |k: usize| model.constant(if k < first { 0.0 } else { 0.03 });
        let rotors: Vec<_> = (0..tree.nv).map(rotor).collect();
        for rotors in [&nothing, &rotors] {
            let dynamics = respond(&model, &constraints, rotors, &free, Demand::Rates);
            let impact = respond(&model, &constraints, rotors, &nothing, Demand::Velocity);
            for (load, theirs) in [(Load::Forces(&tau), dynamics), (Load::Impact, impact)] {
                let mut ways = by_every_way(&model, &constraints, rotors, load);
                let answered = pinned::respond(&model, &constraints, rotors, load);
                assert_eq!(answered.is_some(), rotors.iter().all(|x| x.is_zero()), "{folder} {}", phase.name);
                ways.extend(answered);
                ways_seen += ways.len();
                for (way, ours) in ways.iter().enumerate() {
                    for seed in [0.3, 1.7, 4.4] {
                        let state = state(&tree, seed);
                        let name = format!("{folder} {} way {way}", phase.name);
                        agree(&name, &values(&graph, ours, &state), &values(&graph, &theirs, &state));
                    }
                }
            }
        }
    }
    // No tree is rooted at an edge: there articulated bodies alone answer, without rotors.
    assert_eq!(ways_seen, (ROBOTS.len() - 1) * 10 + 2);
}

/// A right angle written with four digits is 3.7e-6 too large: the knee's axis leaves the plane, and its foot does not turn about y alone.
#[test]
fn a_foot_that_leaves_the_plane_by_last_digits_is_not_rooted_at() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let robot = Robot::read(&project.join("robots/five_link")).unwrap();
    let stands = |tilt: f64| {
        let mut tree = Tree::new(&robot.description, &robot.description.base).unwrap();
        let knee = tree.bodies.iter_mut().find(|body| body.joint == "right_knee_pitch").unwrap();
        knee.placement.rotation = Rotation::from_rpy([tilt, 0.0, 0.0]);
        ["right_tibia", "left_tibia"].map(|link| {
            let body = tree.links.iter().find(|known| known.name == link).unwrap().body.unwrap();
            tree.standing_on(body, [0.0, 0.0, -0.4]).is_some()
        })
    };
    assert_eq!(stands(0.0), [true, true]);
    assert_eq!(stands(3.673e-6), [false, true]);
}
