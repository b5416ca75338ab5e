//! Which rows contacts mean.
use super::support::*;
use bipedc_compiler::derive::constrained::constrained_dynamics;
use bipedc_compiler::derive::constraint::Constraints;
use bipedc_compiler::derive::impact::impact_map;
use bipedc_compiler::derive::{InertiaMode, RobotModel};
use bipedc_compiler::description::model::{Base, RobotDescription};
use bipedc_compiler::expression::Graph;
use bipedc_compiler::tree::Tree;
use bipedc_runtime::Argument::{Q, Tau, V};

fn names(description: &RobotDescription, base: &Base, contacts: &[&str]) -> Vec<String> {
    let tree = Tree::new(description, base).unwrap();
    let graph = Graph::new();
    let model = RobotModel::new(&graph, &tree, InertiaMode::Folded);
    let contacts: Vec<_> = contacts.iter().map(|text| contact(&description.feet, text)).collect();
    Constraints::new(&model, &description.feet, &contacts).unwrap().names
}

#[test]
fn one_foot_never_repeats_a_row() {
    let description = robot("biped_3d");
    let base = Base::Floating { root: "torso".to_owned() };
    let count = |contacts: &[&str]| names(&description, &base, contacts).len();
    assert_eq!(count(&["right_foot"]), 6);
    assert_eq!(count(&["right_foot/front"]), 5);
    assert_eq!(count(&["right_foot/front_left"]), 3);
    assert_eq!(count(&["right_foot/front_left", "right_foot/front_right"]), 5);
    assert_eq!(count(&["right_foot/front", "right_foot/rear"]), 6);
    assert_eq!(count(&["right_foot/front", "right_foot/rear_left"]), 6);
    assert_eq!(count(&["right_foot", "right_foot/front", "right_foot"]), 6);
    assert_eq!(count(&["right_foot", "left_foot/rear"]), 11);
    assert_eq!(
        names(&description, &base, &["right_foot/front"]),
        ["force/x", "force/y", "force/z", "moment/across", "moment/normal"]
            .map(|n| format!("right_foot/{n}"))
    );
}

#[test]
fn in_the_plane_heel_and_toe_hold_the_foot() {
    let description = robot("seven_link");
    let base = Base::Planar { root: "torso".to_owned() };
    let expected = ["force/x", "force/z", "moment/y"].map(|n| format!("right_foot/{n}"));
    assert_eq!(names(&description, &base, &["right_foot"]), expected);
    assert_eq!(names(&description, &base, &["right_foot/toe", "right_foot/heel"]), expected);
    assert_eq!(names(&description, &base, &["right_foot/toe"]), expected[..2]);
}

#[test]
fn a_pinned_root_needs_no_rows() {
    let biped = robot("biped_3d");
    let fixed = Base::Fixed { link: "right_foot".to_owned() };
    assert_eq!(names(&biped, &fixed, &["right_foot", "left_foot/rear"]).len(), 5);
    let pivot = Base::Pivot { about: "right_foot/front".to_owned() };
    assert!(names(&biped, &pivot, &["right_foot/front"]).is_empty());
    assert_eq!(names(&biped, &pivot, &["right_foot"]), ["right_foot/moment/pivot"]);
    let planar = robot("seven_link");
    let toe = Base::Pivot { about: "right_foot/toe".to_owned() };
    assert!(names(&planar, &toe, &["right_foot/toe"]).is_empty());
    assert_eq!(names(&planar, &toe, &["right_foot"]), ["right_foot/moment/pivot"]);
    assert_eq!(names(&planar, &toe, &["left_foot/heel"]).len(), 2);
}

#[test]
fn unknown_parts_are_named() {
    let description = robot("biped_3d");
    let tree = tree(&description, "floating");
    let graph = Graph::new();
    let model = RobotModel::new(&graph, &tree, InertiaMode::Folded);
    let mut edge = contact(&description.feet, "right_foot/front");
    edge.part = bipedc_compiler::description::model::ContactPart::Edge("frnt".to_owned());
    let message = Constraints::new(&model, &description.feet, &[edge]).unwrap_err().to_string();
    assert!(message.contains("`right_foot/frnt`") && message.contains("front, rear"), "{message}");
}

#[test]
fn rows_that_the_joints_satisfy_anyway_carry_no_force() {
    // In space the planar robot's second foot cannot leave the first one's plane.
    second_foot_stands(&robot("seven_link"), (1e-12, 1e-9));
}

/// A joint's axes are missed by 1e-11 and 1e-9 rad: rows that vanish for the robot that was meant leave as much behind, and
/// a force that divides by it would be 1e9 N.
#[test]
fn rows_that_the_joints_nearly_satisfy_carry_no_force() {
    for off in [4.9e-12, 3.2e-9] {
        let mut description = robot("seven_link");
        for joint in &mut description.joints {
            joint.origin.rpy[0] += off;
            joint.axis[2] += off;
        }
        let forces = second_foot_stands(&description, (1e3 * off, 1e5 * off));
        assert!(forces.iter().all(|x| x.abs() < 1e4), "{off}: {forces:?}");
    }
}

/// λ of both flat feet, after checks of the rows: at the velocity after an impact, and at the acceleration.
fn second_foot_stands(description: &RobotDescription, tolerances: (f64, f64)) -> Vec<f64> {
    let tree = tree(description, "floating");
    let contacts = ["right_foot", "left_foot"].map(|text| contact(&description.feet, text));
    let function = Function::derive(&tree, |model| {
        let c = Constraints::new(model, &description.feet, &contacts).unwrap();
        let dynamics = constrained_dynamics(model, &c);
        let jacobian = c.jacobian.iter().flatten().copied().collect();
        vec![dynamics.acceleration, dynamics.forces, jacobian, c.rate.clone(), impact_map(model, &c).velocity]
    });
    let mut random = Random::new(SEED + 8);
    let (q, mut v) = (random.configuration(&tree), random.vector(tree.nv, 1.0));
    let tau = vec![1.0; tree.nv];
    v = function.call(&[(Q, &q), (V, &v), (Tau, &tau)])[4].clone();
    let out = function.call(&[(Q, &q), (V, &v), (Tau, &tau)]);
    let j = rows(&out[2], tree.nv);
    let missed = times(&j, &v);
    assert!(error(&missed, &[0.0; 12]) < tolerances.0, "{missed:?}");
    let residual: Vec<f64> = times(&j, &out[0]).iter().zip(&out[3]).map(|(a, w)| a + w).collect();
    assert!(error(&residual, &[0.0; 12]) < tolerances.1, "{residual:?}");
    assert!(out[1].iter().all(|x| x.is_finite()));
    out[1].clone()
}
