//! Logs without a motion of the base, of a robot whose root is a foot that stays where it is (thesis 5.4.2).
//!
//! The base rests, so its rows are what the ground does to the robot at the root's origin. Where that lies on the ground,
//! as a point of the sole does, normal forces and their centre tell the moments about x and y: horizontal forces have no
//! arm. Samples at which the foot hardly carries anything do not count: it may have moved.
use super::ContactRecording;
use crate::robot::calls::ModelCalls;
use crate::robot::feet::FootCalls;
use crate::robot::{BaseKind, Robot};
use bipedc_effects::diagnostic::Diagnostic;

/// Part of what all feet carry on average that the standing foot must carry.
const CARRIES: f64 = 0.1;
/// A frame that moves by less with the joints does not move, m.
const FIXED: f64 = 1e-9;

/// The foot that the robot's base is fixed to.
pub(super) fn foot(robot: &Robot<'_>) -> Option<usize> {
    if robot.layout.base != BaseKind::Floating {
        return None;
    }
    let calls = ModelCalls::new(robot.model);
    let first = calls.nq - robot.layout.joints.len();
    (0..robot.feet.len()).find(|&foot| {
        let Ok(own) = FootCalls::new(&calls, &robot.feet[foot]) else { return false };
        let at = |angle: f64| {
            let mut q = calls.rest(robot.layout.base);
            // Different angles, so that no two joints undo each other.
            q[first..].iter_mut().enumerate().for_each(|(k, q)| *q = angle * (1.0 + (k as f64).sin()));
            own.sole(&calls, &robot.feet[foot], &q)
        };
        let (rest, bent) = (at(0.0), at(0.3));
        (rest.origin - bent.origin).norm() < FIXED && (rest.rotation - bent.rotation).norm() < FIXED
    })
}

/// What is taken for granted then.
pub(super) fn assumption(foot: &str) -> String {
    format!(
        "no base/… columns: the sole of `{foot}` stays level where it is, and its axes are those in which forces of all feet are logged"
    )
}

impl ContactRecording {
    /// Leaves out samples at which the standing foot carries too little, and what the filter smears into others.
    pub(super) fn keep_standing(&mut self, robot: &Robot<'_>) -> Result<(), Diagnostic> {
        let Some(foot) = self.standing else { return Ok(()) };
        let name = &robot.feet[foot].name;
        if !self.feet[foot].is_logged {
            return Err(Diagnostic::error(format!("the standing foot `{name}` has no forces in the log"))
                .help(format!(
                    "log `{name}/force/z` with `{name}/cop/x`, `/y`, or name another foot with --stance"
                )));
        }
        let own: Vec<f64> = self.feet[foot].signals.iter().map(|s| s[2]).collect();
        let all = |i: usize| self.feet.iter().filter_map(|f| f.signals.get(i)).map(|s| s[2]).sum::<f64>();
        let mean = self.kept.iter().map(|i| all(*i)).sum::<f64>() / self.kept.len().max(1) as f64;
        let least = CARRIES * mean;
        let reach = (0.5 / self.cutoff_hz / self.step).ceil() as usize;
        let carries = |i: usize| {
            let around = i.saturating_sub(reach)..(i + reach + 1).min(own.len());
            own[around].iter().all(|force| *force > least)
        };
        let before = self.kept.len();
        let kept: Vec<usize> = self.kept.iter().copied().filter(|i| carries(*i)).collect();
        if mean.is_nan() || mean <= 0.0 || kept.len() < before.min(8) {
            let message = format!(
                "the standing foot `{name}` carries next to nothing: {:.1} N of {mean:.1} N on average",
                own.iter().sum::<f64>() / own.len().max(1) as f64
            );
            return Err(Diagnostic::error(message)
                .help("name the foot that stands with --stance; forces of the ground on the foot are positive upwards"));
        }
        if kept.len() < before {
            self.assumptions.push(format!(
                "{} of {before} samples are left out: `{name}` carries less than a tenth of the weight there",
                before - kept.len()
            ));
        }
        self.kept = kept;
        Ok(())
    }
}
