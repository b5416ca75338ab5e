//! What can be said of the data before anything is searched for in them: channels that are mixed up, joints that
//! hardly move, motions that repeat themselves.
//!
//! An error means that nothing found in the log could be trusted; a warning goes with the answer.
mod alternatives;
mod channels;
mod excitation;
mod hypothesis;
mod signals;
mod standing;

use crate::experiments::Experiment;
use crate::measure::Recording;
use crate::robot::Trajectory;
use crate::robot::link_inertias::LinkInertias;
use bipedc_effects::diagnostic::Diagnostic;
pub(crate) use excitation::SHORT;
pub(super) use excitation::short;
pub(crate) use signals::clipped;

/// Most samples on which the model is asked again under another reading of the log.
const SAMPLES: usize = 600;

/// Torques in some states.
pub(super) type Torques<'a> = dyn Fn(&Trajectory) -> Vec<f64> + 'a;

/// Motion and torques of a log, joint by joint.
pub(super) struct Evidence<'a> {
    /// Names of the joints and whether they are prismatic.
    pub joints: Vec<(&'a str, bool)>,
    pub recording: &'a Recording,
    /// Torques of the rigid model, `states × nv`.
    pub torques: &'a Torques<'a>,
    /// Torques of a unit of mass and of first moment of each body, `states × bodies × 4 × nv`.
    pub moments: &'a Torques<'a>,
    pub links: &'a LinkInertias,
}

impl Evidence<'_> {
    /// Positions of a joint.
    pub fn position(&self, joint: usize) -> impl Iterator<Item = f64> + '_ {
        self.recording.trajectory.positions(joint)
    }
    /// Velocities of a joint.
    pub fn velocity(&self, joint: usize) -> impl Iterator<Item = f64> + '_ {
        self.recording.trajectory.velocities(joint)
    }
}

/// Looks at the training log, and at the log that judges if there is one, each with what was found in it.
pub fn inspect(train: &dyn Experiment, judge: Option<&dyn Experiment>) -> Findings {
    let motion = judge.map(Experiment::motion);
    let mut training = train.check();
    training.extend(crate::measure::repetition::warnings(&train.motion(), motion.as_ref()));
    Findings { training, validation: judge.map_or(Vec::new(), Experiment::check) }
}

/// What [`inspect`] found; no file stands in it yet.
#[derive(Debug, Clone, Default)]
pub struct Findings {
    /// About the training log, or both.
    pub training: Vec<Diagnostic>,
    /// About the log that judges.
    pub validation: Vec<Diagnostic>,
}

/// Everything about one log with joint torques.
pub(super) fn check(evidence: &Evidence<'_>) -> Vec<Diagnostic> {
    // Constants are explained by anything.
    if excitation::nothing_moves(evidence) {
        return vec![
            Diagnostic::error("no joint moves: constant positions tell nothing of what the model lacks")
                .help("record a motion in which all joints move"),
        ];
    }
    let mut found = channels::check(evidence);
    found.extend(excitation::check(evidence));
    found.extend(signals::check(evidence));
    found
}

/// Names in backquotes.
fn list<'n>(names: impl IntoIterator<Item = &'n str>) -> String {
    crate::log::names::list(names, 12)
}

/// Value below which a part of the numbers lies.
fn quantile(values: &mut [f64], part: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let at = ((values.len() - 1) as f64 * part) as usize;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}
