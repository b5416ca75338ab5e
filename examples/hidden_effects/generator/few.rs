//! Robots of which two to four joints move and all others are held where they are. Added last.
use super::truth::Group;

/// Names of these cases.
pub const FEW: &str = "few_joints";

/// Group, name, robot, kinds with their places, and the joints that move.
type Entry =
    (Group, &'static str, &'static str, &'static [(&'static str, &'static str)], &'static [&'static str]);

const LEG: &[&str] = &["left_hip_pitch", "left_knee_pitch", "left_ankle_pitch"];
const LEFT_ARM: &[&str] = &["left_shoulder_pitch", "left_elbow", "left_wrist_pitch"];
const ARM: &[&str] = &["shoulder", "elbow"];
const SMALL_LEG: &[&str] = &["right_hip_pitch", "right_knee"];

pub const CASES: &[Entry] = &[
    (Group::Clean, "clean", "tulip", &[], LEG),
    (Group::Clean, "clean", "humanoid", &[], LEFT_ARM),
    (Group::Clean, "clean", "arm", &[], ARM),
    (Group::Clean, "clean", "small_biped", &[], SMALL_LEG),
    (Group::Single, "coulomb", "tulip", &[("coulomb_friction", "left_knee_pitch")], LEG),
    (Group::Single, "viscous", "humanoid", &[("viscous_friction", "left_elbow")], LEFT_ARM),
    (Group::Single, "asymmetric", "arm", &[("asymmetric_coulomb_friction", "elbow")], ARM),
    (Group::Single, "coulomb", "small_biped", &[("coulomb_friction", "right_hip_pitch")], SMALL_LEG),
];
