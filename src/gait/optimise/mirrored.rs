//! Joints that exchange their roles with the legs: where the limits of a pair leave no position that both have, no step repeats itself.
use bipedc_compiler::compile::Collocation;
use bipedc_compiler::description::SourceFiles;
use bipedc_compiler::description::model::{Joint, JointKind, SymmetricPair};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};

/// Part of a joint's range that is kept from each of its stops at most.
const KEPT: f64 = 0.2;

/// Positions that a search lets a joint have, which keeps this distance from its stops, rad or m.
pub(super) fn between([low, high]: [f64; 2], distance: f64) -> [f64; 2] {
    let kept = distance.min(KEPT * (high - low));
    [low + kept, high - kept]
}

/// That every pair has a position that both joints reach, `distance` (rad or m) from their stops: what the left one does in one step, the right one does in
/// the next.
///
/// # Errors
/// Each pair that has none, at its right joint in the URDF.
pub fn exchangeable(of: &Collocation, distance: f64, sources: &SourceFiles) -> Result<(), Diagnostics> {
    if !of.changes.iter().any(|change| change.relabel) {
        return Ok(());
    }
    let pairs = of.description.symmetric_joints.iter();
    let wrong: Vec<Diagnostic> = pairs
        .filter_map(|pair| {
            let error = refusal(&of.description.joints, pair, distance)?.in_file(&sources.urdf_path);
            let place = sources.joint_place(&pair.right);
            Some(match place {
                Some((line, column)) => error.at(line, column),
                None => error,
            })
        })
        .collect();
    if wrong.is_empty() { Ok(()) } else { Err(Diagnostics(wrong)) }
}

/// What is wrong with a pair, if something is.
fn refusal(joints: &[Joint], pair: &SymmetricPair, distance: f64) -> Option<Diagnostic> {
    let limits = |name: &str| -> Option<(JointKind, [f64; 2])> {
        let joint = joints.iter().find(|joint| joint.name == name && joint.kind.moves())?;
        joint.position_limits.map(|(low, high)| (joint.kind, [low, high]))
    };
    let ((kind, left), (_, right)) = (limits(&pair.left)?, limits(&pair.right)?);
    let apart = |sign: f64| !overlap(between(left, distance), mirrored(between(right, distance), sign));
    if !apart(pair.sign) {
        return None;
    }
    let unit = if kind == JointKind::Prismatic { "m" } else { "rad" };
    let [low, high] = mirrored(right, pair.sign);
    let message = format!(
        "no step can repeat itself with these limits: `{}` has {} to {} {unit}, `{}` has {} to {} {unit}, which is {low} to {high} {unit} of the left one; the \
         gait exchanges the legs, so that both have to do the same, {distance} {unit} from their stops",
        pair.left, left[0], left[1], pair.right, right[0], right[1]
    );
    let axes = format!(
        "turn the <axis> of one of them round, or write sign = {} for the pair in [symmetry] of biped.toml, if that is how the axes are; or ",
        -pair.sign
    );
    let axes = if apart(-pair.sign) { String::new() } else { axes };
    let help = format!("{axes}correct lower and upper of the joint whose limits are wrong");
    Some(Diagnostic::error(message).help(help))
}

/// The least distance from a stop that is asked of any joint, rad or m, where joints of a short range are asked for less.
pub fn least_distance(of: &Collocation, distance: f64) -> f64 {
    let limits = of.description.joints.iter().filter_map(|joint| joint.position_limits);
    limits.map(|(low, high)| between([low, high], distance)[0] - low).fold(distance, f64::min)
}

/// Limits of a right joint as those of its left one.
fn mirrored([low, high]: [f64; 2], sign: f64) -> [f64; 2] {
    // Adding zero takes the sign off it.
    if sign < 0.0 { [-high + 0.0, -low + 0.0] } else { [low, high] }
}

fn overlap(a: [f64; 2], b: [f64; 2]) -> bool {
    a[0].max(b[0]) <= a[1].min(b[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_compiler::description::model::Pose;

    fn knee(name: &str, kind: JointKind, limits: (f64, f64)) -> Joint {
        Joint {
            name: name.to_owned(),
            kind,
            parent: "thigh".to_owned(),
            child: "shank".to_owned(),
            origin: Pose::default(),
            axis: [0.0, 1.0, 0.0],
            position_limits: Some(limits),
            velocity_limit: None,
            effort_limit: None,
        }
    }

    fn said(left: (f64, f64), right: (f64, f64), sign: f64) -> Option<Diagnostic> {
        let joints = [knee("kl", JointKind::Revolute, left), knee("kr", JointKind::Revolute, right)];
        let pair = SymmetricPair { left: "kl".to_owned(), right: "kr".to_owned(), sign };
        refusal(&joints, &pair, 0.02)
    }

    #[test]
    fn limits_that_one_motion_cannot_have_are_refused_by_name_and_number() {
        let found = said((0.0, 1.0), (-1.0, 0.0), 1.0).unwrap();
        for word in ["`kl` has 0 to 1 rad", "`kr` has -1 to 0 rad", "which is -1 to 0 rad"] {
            assert!(found.message.contains(word), "{found}");
        }
        assert!(found.help.as_ref().is_some_and(|help| help.contains("sign = -1")), "{found}");
        // Neither sign helps: then it is the limits.
        let found = said((0.1, 1.0), (1.2, 2.0), 1.0).unwrap();
        assert!(
            found.help.as_ref().is_some_and(|help| help.starts_with("correct lower and upper")),
            "{found}"
        );
    }

    #[test]
    fn limits_with_a_position_for_both_are_not() {
        assert_eq!(said((0.0, 1.0), (-1.0, 0.0), -1.0), None);
        assert_eq!(said((-1.0, 0.5), (0.4, 1.0), 1.0), None);
        // 0.02 rad from the stops nothing is left.
        assert!(said((-1.0, 0.42), (0.4, 1.0), 1.0).is_some());
    }
}
