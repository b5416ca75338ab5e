//! Groups of parameters: base regressor × base parameters = regressor × parameters, on known and random
//! robots; what must and what must not change the rank.
// 3.1416 is what URDFs write.
#![allow(clippy::approx_constant)]
use crate::compiler::regressors::support::{Kinds, answer, from_urdf, on_foot, random_urdf, robot};
use bipedc_compiler::derive::{InertiaMode, Motions, RobotModel, momentum, newton_euler};
use bipedc_compiler::description::model::{Base, RobotDescription};
use bipedc_compiler::exact::{
    BaseParameters, Model, ParameterList, Question, Regressor, Rounded, StateSpace, base_parameters,
};
use bipedc_compiler::expression::{Expr, Graph};
use bipedc_compiler::tree::Tree;
use bipedc_effects::random::Random;

/// Rows of the equations of motion, then energy, first moment and ground wrench.
fn rows(model: &RobotModel<'_, '_>) -> Vec<Expr> {
    let motions = Motions { velocity: true, acceleration: true, gravity: true };
    let mut rows = newton_euler::generalised_forces(model, motions, false);
    rows.push(momentum::kinetic_energy(model) + momentum::potential_energy(model));
    rows.extend(momentum::first_moment(model).0);
    let wrench = momentum::ground_wrench(model);
    rows.extend([wrench.linear.0, wrench.angular.0].concat());
    rows.iter().map(|row| row.expr).collect()
}

/// Finds the base parameters of some of the rows and checks them at random states.
fn check(tree: &Tree, space: &StateSpace<'_>, list: ParameterList, pick: &[usize]) -> BaseParameters {
    let graph = Graph::exact();
    let model = RobotModel::new(&graph, tree, InertiaMode::Symbolic);
    let all = rows(&model);
    let rows: Vec<Expr> = pick.iter().map(|&i| all[i]).collect();
    let found = base_parameters(&graph, &rows, space, list).unwrap_or_else(|e| panic!("{e:?}"));
    let regressor = Regressor::new(&graph, &rows, space, list).unwrap();
    let evaluator = regressor.evaluator(Rounded).unwrap();
    let values = list.values(tree);
    let mut random = Random::new(11);
    for _ in 0..20 {
        for row in regressor.random_rows(&evaluator, space, &mut random).unwrap() {
            let full: f64 = row.iter().zip(&values).map(|(r, p)| r * p).sum();
            let base: f64 = found.parameters.iter().map(|p| row[p.leading] * p.value).sum();
            let scale = row.iter().zip(&values).map(|(r, p)| (r * p).abs()).fold(1e-3, f64::max);
            assert!((full - base).abs() < 1e-10 * scale, "{full} {base} of {scale}");
        }
    }
    found
}

fn floating(description: &RobotDescription, root: &str) -> Tree {
    Tree::new(description, &Base::Floating { root: root.to_owned() }).unwrap()
}

#[test]
fn base_regressor_times_base_parameters_of_tulip() {
    let tree = floating(&robot("tulip"), "right_foot");
    let nv = tree.nv;
    let dynamics: Vec<usize> = (0..nv).collect();
    assert_eq!(check(&tree, &StateSpace::free(&tree), ParameterList::Standard, &dynamics).rank, 94);
    assert_eq!(check(&tree, &StateSpace::free(&tree), ParameterList::Standard, &[nv]).rank, 94);
    let flat = StateSpace::pinned(&tree).with_flat(vec!["left_foot".to_owned()]);
    let zmp = [nv + 7, nv + 8, nv + 6];
    assert_eq!(check(&tree, &flat, ParameterList::Standard, &zmp).rank, 81);
    assert_eq!(check(&tree, &StateSpace::pinned(&tree), ParameterList::Thesis16, &zmp).rank, 85);
    assert_eq!(check(&tree, &flat, ParameterList::FirstMoments, &[nv + 1, nv + 2]).rank, 25);
}

/// On a free base a turning joint adds seven parameters and a sliding one four, wherever the axes are.
#[test]
fn random_trees_have_the_expected_rank() {
    let mut random = Random::new(5);
    for round in 0..12 {
        let odd = round % 2 == 1;
        let kinds = Kinds { revolute: 1 + round % 4, prismatic: round % 3, odd };
        let description = from_urdf(&random_urdf(&mut random, &kinds));
        let tree = floating(&description, "l0");
        let rows: Vec<usize> = (0..tree.nv).collect();
        let found = check(&tree, &StateSpace::free(&tree), ParameterList::Standard, &rows);
        assert_eq!(found.rank, 10 + 7 * kinds.revolute + 4 * kinds.prismatic, "round {round}");
        let joints: Vec<usize> = (6..tree.nv).collect();
        check(&tree, &StateSpace::pinned(&tree), ParameterList::Standard, &joints);
    }
}

#[test]
fn the_answer_does_not_depend_on_the_root() {
    let mut random = Random::new(6);
    let description = from_urdf(&random_urdf(&mut random, &Kinds { revolute: 5, prismatic: 1, odd: false }));
    for root in ["l0", "l3", "l6"] {
        let question = Question { root: Some(root.to_owned()), ..Question::new(Model::Dynamics) };
        assert_eq!(answer(&description, &question).rank, 49);
    }
}

/// A foot tilted against its ankle by an odd angle: certified fractions become long, the rank stays.
#[test]
fn odd_angles_keep_rank_and_groups() {
    let mut description = robot("tulip");
    for joint in &mut description.joints {
        if joint.name == "left_hip_yaw" || joint.name == "right_ankle_roll" {
            joint.origin.rpy = [0.1, -0.2, 0.3];
        }
    }
    let found = answer(&description, &on_foot(Model::ZeroMomentPoint, "Mx My Fz", true));
    assert_eq!(found.rank, 81);
    assert!(found.parameters.iter().flat_map(|p| &p.combination).any(|term| term.exact.is_none()));
    let tree = floating(&description, "right_foot");
    let flat = StateSpace::pinned(&tree).with_flat(vec!["left_foot".to_owned()]);
    let zmp = [tree.nv + 7, tree.nv + 8, tree.nv + 6];
    assert_eq!(check(&tree, &flat, ParameterList::Standard, &zmp).rank, 81);
}

/// A hip at 3.1416 rad is meant to be turned by half a turn.
#[test]
fn a_nearly_right_angle_is_snapped_and_listed() {
    let mut description = robot("tulip");
    let hip = description.joints.iter_mut().find(|joint| joint.name == "left_hip_yaw").unwrap();
    hip.origin.rpy[2] = 3.1416;
    for (of, rows, rank) in [
        (Model::ZeroMomentPoint, "Mx My Fz", 85),
        (Model::CenterOfMass, "x y", 26),
        (Model::Dynamics, "", 94),
    ] {
        let found = answer(&description, &on_foot(of, rows, false));
        assert_eq!(found.rank, rank);
        assert_eq!(found.assumed_right_angles.len(), 1);
        assert_eq!(found.assumed_right_angles[0].1, 3.1416);
    }
}

/// Exporters write 1.57079632679, 3.2e-12 and offsets of 1e-17 m: none of it makes a parameter identifiable.
#[test]
fn digits_of_exporters_do_not_change_the_rank() {
    let mut description = robot("tulip");
    let mut off = [4.9e-12, -3.2e-9, 2.7e-8, -6.1e-7].into_iter().cycle();
    for joint in &mut description.joints {
        joint.origin.rpy = joint.origin.rpy.map(|angle| angle + off.next().unwrap());
        joint.axis = joint.axis.map(|x| if x == 0.0 { off.next().unwrap() } else { x });
        joint.origin.xyz = joint.origin.xyz.map(|x| if x == 0.0 { 1.2e-17 } else { x });
    }
    for (of, rows, rank) in [
        (Model::ZeroMomentPoint, "Mx My Fz", 85),
        (Model::CenterOfMass, "x y", 26),
        (Model::Dynamics, "", 94),
    ] {
        let found = answer(&description, &on_foot(of, rows, false));
        assert_eq!(found.rank, rank);
        assert!(!found.assumed_right_angles.is_empty());
        assert!(found.parameters.iter().flat_map(|p| &p.combination).all(|term| term.exact.is_some()));
    }
}

/// Trunk of Table 8.3: parameters 1, 10, 17–25 in metres, first moments over the total mass.
#[test]
fn table_8_3_is_reproduced() {
    let tulip = robot("tulip");
    let found = answer(&tulip, &on_foot(Model::CenterOfMass, "x y", true));
    let value = |name: &str| {
        let leading = |p: &&bipedc_compiler::exact::BaseParameter| p.combination[0].name == name;
        1e3 * found.parameters.iter().find(leading).unwrap().value / 19.0
    };
    for (name, millimetres) in [
        ("torso.m*cx", -10.95),
        ("torso.m*cy", 76.94),
        ("right_hip_yaw_link.m*cz", 131.13),
        ("right_upper_leg.m*cz", 271.03),
        ("right_lower_leg.m*cz", 256.63),
        ("right_ankle.m*cz", 35.78),
        ("left_upper_leg.m*cz", -43.97),
        ("left_lower_leg.m*cz", -16.37),
        ("left_ankle.m*cz", -1.22),
    ] {
        assert!((value(name) - millimetres).abs() < 0.006, "{name}: {}", value(name));
    }
}

/// The planar robots: one joint levels a foot.
#[test]
fn planar_robots() {
    let seven = robot("seven_link");
    let rank = |of, rows, flat| answer(&seven, &on_foot(of, rows, flat)).rank;
    let ranks = [
        rank(Model::CenterOfMass, "x z", false),
        rank(Model::CenterOfMass, "x", true),
        rank(Model::ZeroMomentPoint, "My Fz", false),
        rank(Model::ZeroMomentPoint, "My Fz", true),
    ];
    assert_eq!(ranks, [14, 11, 20, 19]);
    // Ten numbers of the plane for each body, less what the joints cannot tell: 4 + 3 per joint.
    let whole = answer(&robot("five_link"), &Question::new(Model::Dynamics));
    assert_eq!(whole.rank, 4 + 3 * 4);
}

#[test]
fn bad_questions_are_refused() {
    let tulip = robot("tulip");
    let message = |question: Question| question.answer(&tulip).unwrap_err().to_string();
    assert!(message(on_foot(Model::CenterOfMass, "x w", false)).contains("no row `w`"));
    assert!(
        message(Question { feet_flat: true, ..Question::new(Model::Dynamics) }).contains("the base floats")
    );
    let stated = Question { root: Some("left_hand".to_owned()), ..Question::new(Model::Energy) };
    assert!(message(stated).contains("left_hand"));
}

/// Two parallel joints cannot level a foot that a third one tilts; the answer is an error, not a search.
#[test]
fn a_foot_that_cannot_be_levelled_is_refused() {
    let mut description = robot("tulip");
    description.joints.iter_mut().find(|joint| joint.name == "left_ankle_roll").unwrap().axis =
        [0.0, 1.0, 0.0];
    let error = on_foot(Model::CenterOfMass, "x y", true).answer(&description).unwrap_err().to_string();
    assert!(error.contains("no posture found in which `left_foot` is parallel to the ground"), "{error}");
}
