//! Every mistake in `biped.toml` has its message, with line, column and what to do.
use bipedc_compiler::description::model::{Base, RobotDescription};
use bipedc_compiler::description::parse;
use std::path::Path;

/// A planar robot with two legs with feet.
const URDF: &str = include_str!("../../../robots/seven_link/robot.urdf");
/// A robot in three dimensions.
const URDF_3D: &str = include_str!("../../../robots/biped_3d/robot.urdf");

const FEET: &str = "[feet.left_foot]
points.heel = [-0.09, 0.0, -0.092]
points.toe = [0.15, 0.0, -0.092]
[feet.right_foot]
points.heel = [-0.09, 0.0, -0.092]
points.toe = [0.15, 0.0, -0.092]
";

fn read(urdf: &str, toml: &str) -> Result<(RobotDescription, String), String> {
    match parse(urdf, Path::new("robot.urdf"), toml, Path::new("biped.toml")) {
        Ok((robot, warnings)) => {
            Ok((robot, warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n\n")))
        }
        Err(errors) => Err(errors.to_string()),
    }
}

#[track_caller]
fn refused(toml: &str, expected: &str) {
    match read(URDF, toml) {
        Ok(_) => panic!("accepted, expected:\n{expected}"),
        Err(errors) => assert_eq!(errors, expected),
    }
}

#[track_caller]
fn refused_3d(toml: &str, expected: &str) {
    match read(URDF_3D, toml) {
        Ok(_) => panic!("accepted, expected:\n{expected}"),
        Err(errors) => assert_eq!(errors, expected),
    }
}

#[track_caller]
fn warned(toml: &str, expected: &str) {
    match read(URDF, toml) {
        Ok((_, warnings)) => assert_eq!(warnings, expected),
        Err(errors) => panic!("refused:\n{errors}"),
    }
}

#[test]
fn an_empty_description_has_sensible_defaults() {
    let (robot, warnings) = read(URDF, "").unwrap();
    assert_eq!(warnings, "");
    assert_eq!(robot.name, "seven_link");
    assert_eq!(robot.base, Base::Floating { root: "torso".into() });
    assert_eq!(robot.gravity, [0.0, 0.0, -9.81]);
    assert_eq!(robot.actuated_joints.len(), 6);
    assert!(robot.feet.is_empty() && robot.phases.is_empty() && robot.drives.is_empty());
}

#[test]
fn next_phase_sign_and_side_have_defaults() {
    let toml = format!(
        "symmetry.joints = [{{ left = \"left_knee_pitch\", right = \"right_knee_pitch\" }}]\n{FEET}
[[phase]]\nname = \"a\"\n[[phase]]\nname = \"b\"\ncontacts = [\"left_foot/toe\"]\n"
    );
    let (robot, _) = read(URDF, &toml).unwrap();
    assert_eq!(robot.symmetric_joints[0].sign, 1.0);
    assert_eq!(robot.phases.iter().map(|phase| phase.next.as_str()).collect::<Vec<_>>(), ["b", "a"]);
    assert!(robot.feet.iter().all(|foot| foot.side.is_some()));
}

#[test]
fn corners_in_any_order_and_under_any_name_give_the_edges() {
    let toml = "[feet.right_foot.points]\na = [-0.1, 0.05, 0]\nb = [0.2, -0.05, 0]\nc = [0.2, 0.05, 0]\nd = [-0.1, -0.05, 0]\n";
    let (robot, _) = read(URDF_3D, toml).unwrap();
    let edges = &robot.feet[0].edges;
    let edge = |name: &str| edges.iter().find(|edge| edge.name == name).unwrap().points.clone();
    assert_eq!(edge("front"), ["c", "b"]);
    assert_eq!(edge("rear"), ["a", "d"]);
    assert_eq!(edge("left"), ["c", "a"]);
    assert_eq!(edge("right"), ["b", "d"]);
}

include!("toml/keys.rs");
include!("toml/parts.rs");
include!("toml/effects.rs");
