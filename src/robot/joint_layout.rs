//! Names and kinds of the joints, and the base before them.
use bipedc_analysis::robot::{Joint, JointLayout};
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
    let joints = joints.map(|joint| Joint { name: joint.name.clone(), prismatic: joint.prismatic }).collect();
    Ok(JointLayout { joints, base: tree.base })
}
