//! Efforts that are held against no model: those that depend on joints without a position, and of joints whose load their stops carry all along.
use super::rigid::Rigid;
use crate::measure::Missing;
use crate::measure::recording::Recording;
use crate::robot::{Batch, JointLayout, depends_on};
use bipedc_effects::diagnostic::Diagnostic;
use std::convert::Infallible;

/// Takes the efforts out that depend on joints without a position, with the reason, as a comparison leaves them out.
///
/// # Errors
/// No effort is left.
pub(super) fn leave_out(
    rigid: &Rigid<'_>,
    layout: &JointLayout,
    recording: &mut Recording,
) -> Result<(), Diagnostic> {
    let had_efforts = recording.effort.iter().any(Option::is_some);
    let mut torques = |batch: &Batch<'_>| {
        let tau = rigid.inverse_dynamics(batch.q, batch.v, batch.a);
        Ok::<_, Infallible>(tau)
    };
    let unseen = recording.unseen.iter().enumerate().filter(|(_, unseen)| **unseen);
    for (moved, _) in unseen {
        let Ok(depends) = depends_on(layout, moved, &mut torques);
        for other in (0..depends.len()).filter(|other| depends[*other]) {
            if recording.effort[other].take().is_some() {
                recording.missing.push(depends_on_unseen(layout, other, moved));
            }
        }
    }
    let held: Vec<usize> =
        (0..layout.joints.len()).filter(|joint| recording.stops.always(*joint).is_some()).collect();
    let Ok(loads) = if held.is_empty() { Ok(Vec::new()) } else { torques(&recording.trajectory.batch()) };
    for joint in held {
        let load: Vec<f64> = recording.trajectory.of_joint(&loads, joint).collect();
        if is_carried(recording, joint, &load) {
            recording.effort[joint] = None;
            let reason = "it lies at its stop all along, which carries its load and not its drive".to_owned();
            recording.missing.push(Missing { name: layout.joints[joint].name.clone(), reason });
        }
    }
    if had_efforts && recording.effort.iter().all(Option::is_none) {
        return Err(nothing_left(&recording.missing));
    }
    Ok(())
}

/// A drive that makes less than this part of what its joint needs, root mean squares, leaves it to the stop,
const LITTLE: f64 = 0.3;
/// if that pushes the right way in this part of the samples at least.
const MOSTLY: f64 = 0.95;

/// Whether a joint lies at its stop all along and that carries what the model needs there, not the drive.
fn is_carried(recording: &Recording, joint: usize, load: &[f64]) -> bool {
    let (Some(side), Some(effort)) = (recording.stops.always(joint), &recording.effort[joint]) else {
        return false;
    };
    let size = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
    // What the stop makes: the lower one pushes upwards.
    let pushes = load.iter().zip(effort).filter(|(load, effort)| side * (*load - *effort) < 0.0).count();
    size(effort) < LITTLE * LITTLE * size(load) && pushes as f64 >= MOSTLY * load.len() as f64
}

/// Why the effort of joint `other` is left out, where nobody saw joint `moved`.
pub(crate) fn depends_on_unseen(layout: &JointLayout, other: usize, moved: usize) -> Missing {
    let [name, moved] = [other, moved].map(|joint| layout.joints[joint].name.clone());
    Missing { name, reason: format!("its effort depends on `{moved}`, which has no position column") }
}

/// No effort can be held against the model.
pub(crate) fn nothing_left(missing: &[Missing]) -> Diagnostic {
    let reasons: Vec<_> = missing.iter().map(|m| format!("{}: {}", m.name, m.reason)).collect();
    Diagnostic::error("no joint can be compared").help(format!(
        "log position and effort of all joints ({}); joints that are held at an angle stand in biped.toml as `[joints] locked = {{ NAME = ANGLE }}`",
        reasons.join("; ")
    ))
}
