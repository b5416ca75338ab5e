//! A first look at a log: which motion it shows, how fast joints go, what was measured.
use super::reading::Reading;
use super::row_cutoff::AccelerationSpectrum;
use crate::experiments::Experiment;
use crate::measure::Directions;
use crate::measure::{JointPositions, Missing, Recording};
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};

/// Positions are kept this far apart, s: enough to know a motion again.
const GRID: f64 = 0.01;

/// What a log shows, without its samples.
#[derive(Debug, Clone, Default)]
pub struct Survey {
    /// Positions of the joints, thinned.
    pub motion: JointPositions,
    /// Largest speed of each joint, rad/s.
    pub speed: Vec<f64>,
    /// Sum of the squares of its speeds, rad²/s², over all samples.
    pub squares: Vec<f64>,
    /// Whether each joint's effort was measured.
    pub effort: Vec<bool>,
    /// Whether no position of it was.
    pub unseen: Vec<bool>,
    /// Whether the motion of the base was logged.
    pub base: bool,
    /// Number of usable samples.
    pub samples: usize,
    /// Sampling step, s.
    pub step: f64,
    /// Cut-off of the filter, Hz.
    pub cutoff_hz: f64,
    /// How fast and how noisy accelerations are.
    pub accelerations: AccelerationSpectrum,
    /// What could not be used and why.
    pub missing: Vec<Missing>,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
    /// What is odd about the log.
    pub warnings: Vec<Diagnostic>,
}

/// Looks at a log.
///
/// # Errors
/// Those of the reader; a log without motion or efforts.
pub fn survey(reading: &Reading<'_>, layout: &JointLayout) -> Result<Survey, Diagnostics> {
    let joints = layout.joints.len();
    let bv = layout.base.nv();
    let mut found = Survey { speed: vec![0.0; joints], squares: vec![0.0; joints], ..Survey::default() };
    found.motion.positions = vec![Vec::new(); joints];
    let mut visit = |recording: &mut Recording| {
        if recording.samples() >= AccelerationSpectrum::stretch(recording.step) {
            found.look(recording, bv);
            recording.clear();
        }
        Ok(())
    };
    let recording =
        Recording::each(reading.log, layout, &reading.options, Some(&Directions::default()), &mut visit)?;
    found.look(&recording, bv);
    found.accelerations.finish(&recording);
    found.effort = recording.effort.iter().map(Option::is_some).collect();
    found.unseen = recording.unseen.clone();
    (found.step, found.cutoff_hz) = (recording.step, recording.cutoff_hz);
    (found.missing, found.assumptions) = (recording.missing, recording.assumptions);
    found.warnings = recording.warnings;
    refuse(&found, reading, layout)?;
    Ok(found)
}

impl Survey {
    /// Goes on with the samples of a recording, whose base has so many velocities.
    fn look(&mut self, recording: &Recording, bv: usize) {
        self.samples += recording.samples();
        for (i, &time) in recording.time.iter().enumerate() {
            let [q, v] = recording.trajectory.joints_at(i);
            for ((most, squares), v) in self.speed.iter_mut().zip(&mut self.squares).zip(v) {
                *most = most.max(v.abs());
                *squares += v * v;
            }
            if self.motion.time.last().is_none_or(|last| time - last >= 0.999 * GRID) {
                self.motion.push(time, q);
            }
        }
        let width = bv + recording.effort.len();
        self.base |=
            bv > 0 && recording.trajectory.v.chunks_exact(width).any(|v| v[..bv].iter().any(|x| *x != 0.0));
        self.accelerations.hear(recording);
    }

    /// What an experiment in memory shows.
    pub fn of_table(experiment: &dyn Experiment, joints: usize, cutoff_hz: f64) -> Self {
        let motion = experiment.motion();
        let mut steps: Vec<f64> = experiment.time().windows(2).map(|w| w[1] - w[0]).collect();
        steps.sort_by(f64::total_cmp);
        Self {
            speed: vec![0.0; joints],
            squares: vec![0.0; joints],
            effort: vec![false; joints],
            base: true,
            samples: experiment.time().len(),
            step: steps.get(steps.len() / 2).copied().unwrap_or(0.0),
            cutoff_hz,
            motion,
            ..Self::default()
        }
    }
}

/// Logs from which nothing can be learnt.
fn refuse(found: &Survey, reading: &Reading<'_>, layout: &JointLayout) -> Result<(), Diagnostics> {
    let refused = |message: String, help: &str| {
        // What is odd about the log usually says why.
        let error = Diagnostic::error(message).in_file(reading.log.path()).help(help);
        Err(Diagnostics(found.warnings.iter().cloned().chain([error]).collect()))
    };
    if found.samples < 50 {
        let message = format!("only {} samples of the log can be used", found.samples);
        return refused(message, "at least a few seconds of motion are needed");
    }
    if !found.effort.contains(&true) && !found.base {
        let first = layout.joints.first().map_or("joint", |joint| joint.name.as_str());
        return refused(
            "the log has no efforts: without torques there is nothing to fit".to_owned(),
            &format!("give columns such as `{first}/effort`, or name others in a mapping file"),
        );
    }
    if !found.base && found.speed.iter().all(|speed| *speed < 1e-6) {
        return refused(
            "no joint moves: constant positions tell no dynamic parameters".to_owned(),
            "record a motion in which all joints move",
        );
    }
    Ok(())
}
