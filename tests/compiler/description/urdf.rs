//! Every mistake in a URDF has its message, with the line and what to do.
use bipedc_compiler::description::{init_text, model::RobotDescription, parse};
use std::path::Path;

/// A torso with one leg; `BODY` is replaced by what a test adds, and it may replace parts of the rest.
const ROBOT: &str = r#"<robot name="test">
  <link name="torso">
    <inertial>
      <origin xyz="0 0 0.2" rpy="0 0 0"/>
      <mass value="10"/>
      <inertia ixx="0.3" ixy="0" ixz="0" iyy="0.3" iyz="0" izz="0.1"/>
    </inertial>
  </link>
  <link name="leg">
    <inertial>
      <origin xyz="0 0 -0.4" rpy="0 0 0"/>
      <mass value="5"/>
      <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.02"/>
    </inertial>
  </link>
  <joint name="hip" type="revolute">
    <parent link="torso"/>
    <child link="leg"/>
    <origin xyz="0 0 -0.1" rpy="0 0 0"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="60" velocity="6"/>
  </joint>
</robot>
"#;

fn read(urdf: &str) -> Result<(RobotDescription, Vec<String>), String> {
    match parse(urdf, Path::new("robot.urdf"), "", Path::new("biped.toml")) {
        Ok((robot, warnings)) => Ok((robot, warnings.iter().map(ToString::to_string).collect())),
        Err(errors) => Err(errors.to_string()),
    }
}

/// The test robot with replacements, each of which must apply.
fn changed(replacements: &[(&str, &str)]) -> String {
    let mut text = ROBOT.to_string();
    for (old, new) in replacements {
        assert!(text.contains(old), "`{old}` is not in the test robot");
        text = text.replacen(old, new, 1);
    }
    text
}

/// The robot is refused with exactly this message.
#[track_caller]
fn refused(urdf: &str, expected: &str) {
    match read(urdf) {
        Ok(_) => panic!("accepted, expected:\n{expected}"),
        Err(errors) => assert_eq!(errors, expected),
    }
}

/// The robot loads with exactly this one warning.
#[track_caller]
fn warned(urdf: &str, expected: &str) -> RobotDescription {
    match read(urdf) {
        Ok((robot, warnings)) => {
            assert_eq!(warnings, [expected]);
            robot
        }
        Err(errors) => panic!("refused:\n{errors}"),
    }
}

#[test]
fn the_test_robot_is_fine() {
    let (robot, warnings) = read(ROBOT).unwrap();
    assert!(warnings.is_empty());
    assert_eq!((robot.root_link.as_str(), robot.joints[0].axis), ("torso", [0.0, 1.0, 0.0]));
    assert_eq!(robot.joints[0].position_limits, Some((-1.0, 1.0)));
}

include!("urdf/refused.rs");
include!("urdf/warned.rs");
