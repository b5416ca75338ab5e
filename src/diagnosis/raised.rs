//! Parts of an answer that make the error larger behind the filter at which it is told.
//!
//! A search looks behind a faster filter than the one behind which least is left. There the encoders' noise makes up a part of the model's torque: lighter
//! links, and torques that come late, lower the error because they let less of it through. Behind the slower filter that noise is gone, and what
//! was nothing else makes the error larger.
use super::filtered::{Filtered, Request, filtered};
use crate::measurements::Measured;
use bipedc_analysis::diagnose::{Diagnosis, FoundEffect, Options, root_mean_squares};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::robot::link_inertias::CadError;
use bipedc_effects::effect::{Effect, Kind, Location};

/// Squares of a row that rise by more than this part rise.
const RISES: f64 = 0.01;
/// Another answer may leave so many times as much.
const ALIKE: f64 = 1.01;

/// What a search should do without.
pub(super) struct Raised {
    /// Masses, centres of mass and inertias are as described.
    corrections: bool,
    /// These effects are nowhere.
    effects: Vec<(&'static Kind, Location)>,
}

impl Raised {
    /// What of an answer only raises errors of the judging log behind a cut-off (Hz).
    pub fn by(measured: &Measured, request: &Request<'_>, answer: &Diagnosis, cutoff: f64) -> Option<Self> {
        let logs = filtered(measured, request, cutoff).ok()?;
        let raised = Self {
            corrections: raises(&logs, answer, &answer.inertial_corrections),
            effects: answer
                .effects
                .iter()
                .filter(|found| raises(&logs, answer, std::slice::from_ref(*found)))
                .map(|found| (found.effect.kind, found.effect.location.clone()))
                .collect(),
        };
        (raised.corrections || !raised.effects.is_empty()).then_some(raised)
    }

    /// The same search without it.
    pub fn without(&self, search: &Options) -> Options {
        let mut search = search.clone();
        if self.corrections {
            search.cad = CadError::NONE;
        }
        search.barred.extend(self.effects.iter().cloned());
        search
    }
}

/// Whether an answer that does without what only raised errors stands in the place of the first: it leaves no more, and explains as much.
pub(super) fn is_no_worse(second: &Diagnosis, first: &Diagnosis) -> bool {
    second.rms_after <= ALIKE * first.rms_after && (first.unexplained || !second.unexplained)
}

/// Whether some of what was found makes the squares of rows larger beside all the rest, in their geometric mean too.
fn raises(logs: &Filtered<'_>, answer: &Diagnosis, some: &[FoundEffect]) -> bool {
    if some.is_empty() {
        return false;
    }
    let experiment = logs.judging().unwrap_or(&*logs.train.experiment);
    let is_one = |effect: &&Effect| {
        !some.iter().any(|found| found.effect.kind == effect.kind && found.effect.location == effect.location)
    };
    let all: Vec<Effect> = answer.estimated().cloned().collect();
    let others: Vec<Effect> = all.iter().filter(is_one).cloned().collect();
    let [with, without] = [&all, &others].map(|effects| squares(experiment, effects));
    let changes =
        with.iter().zip(&without).map(|(with, without)| (with / without.max(f64::MIN_POSITIVE)).ln());
    let (most, sum) = changes.fold((0.0_f64, 0.0), |(most, sum), x| (most.max(x), sum + x));
    most > RISES && sum > 0.0
}

fn squares(experiment: &dyn Experiment, effects: &[Effect]) -> Vec<f64> {
    root_mean_squares(experiment, effects).into_iter().map(|rms| rms * rms).collect()
}
