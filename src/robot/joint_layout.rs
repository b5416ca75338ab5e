//! Names and kinds of the joints, and the base before them.
use bipedc_analysis::robot::{Joint, JointLayout};
use bipedc_compiler::description::model::RobotDescription;
use bipedc_compiler::tree::{BaseKind, Tree};
use bipedc_effects::diagnostic::Diagnostic;

/// What a comparison has to know of the robot.
///
/// # Errors
/// A pivot as base, whose angle no log tells.
pub fn joint_layout(tree: &Tree) -> Result<JointLayout, Diagnostic> {
    if tree.base == BaseKind::Pivot {
        return Err(Diagnostic::error("a log does not tell the angle of a pivot")
            .help("choose another base with --base floating|planar|fixed"));
    }
    let joints = tree.joints.iter();
    let joints = joints
        .map(|joint| Joint { name: joint.name.clone(), prismatic: joint.prismatic, limits: None })
        .collect();
    Ok(JointLayout { joints, base: tree.base })
}

/// The same with the stops of the joints, as far as the URDF states position limits.
///
/// # Errors
/// As [`joint_layout`].
pub fn joint_layout_with_stops(
    tree: &Tree,
    description: &RobotDescription,
) -> Result<JointLayout, Diagnostic> {
    let mut layout = joint_layout(tree)?;
    for joint in &mut layout.joints {
        let own = description.joints.iter().find(|own| own.name == joint.name);
        joint.limits = own.and_then(|own| own.position_limits).map(|(low, high)| [low, high]);
    }
    Ok(layout)
}
