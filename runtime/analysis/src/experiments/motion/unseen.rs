//! Joints of which no position is logged: an effort that depends on their motion is held against no model.
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
    if had_efforts && recording.effort.iter().all(Option::is_none) {
        return Err(nothing_left(&recording.missing));
    }
    Ok(())
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
