//! What a described robot predicts against what was measured, and where they differ.
mod free_run;
mod places;

use crate::measurements::currents::{self, Prepared};
use crate::measurements::{Content, Log, Measured, SAMPLES};
use crate::progress::Progress;
use crate::report::of_measurements;
use crate::robot::{ProgramTorques, joint_layout};
use bipedc_analysis::compare::{Comparison, FreeRun, Reading, channels_of, compare_file};
use bipedc_analysis::diagnose::{Breakdown, breakdowns};
use bipedc_analysis::measure;
use bipedc_analysis::report::Report;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::FunctionRequest;
use bipedc_effects::diagnostic::Diagnostics;
use bipedc_effects::effect::{Effect, Law};
use serde::Serialize;
use std::fmt;
use std::ops::Deref;

/// How a robot is compared with a log. By default: the whole log, at the filter that fits best.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Times between which samples count, and the filter.
    pub reading: measure::Options,
    /// Also say where the model fails.
    pub places: bool,
    /// Also let the model run ahead under the logged efforts, for so many seconds from one measured state to the next.
    pub free_run: Option<f64>,
    /// Stance foot of postures, striking foot of impacts; by default the right one.
    pub foot: Option<String>,
    /// Also fill a report.
    pub report: bool,
}

/// A comparison, and what was asked for beside it. As text and as JSON it is what `bipedc compare` prints; warnings are not part
/// of the text.
#[derive(Debug, Clone, Serialize)]
pub struct Compared {
    /// Errors of all channels.
    #[serde(flatten)]
    pub comparison: Comparison,
    /// Where the model fails, row by row.
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    pub places: Option<Vec<Breakdown>>,
    /// How far the model gets by itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub free_run: Option<FreeRun>,
    /// Measurements against the model, to look at.
    #[serde(skip)]
    pub report: Option<Report>,
}

impl Deref for Compared {
    type Target = Comparison;
    fn deref(&self) -> &Comparison {
        &self.comparison
    }
}

impl fmt::Display for Compared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.comparison.fmt(f)?;
        f.write_str(&self.places.as_deref().map(places::text).unwrap_or_default())?;
        f.write_str(&self.free_run.as_ref().map(free_run::text).unwrap_or_default())
    }
}

/// A robot with the effects of its description against a log.
///
/// # Errors
/// Logs that cannot be read or hold nothing to compare; a free run of a robot that is not held or of which something is not logged.
pub fn compare(
    robot: &Robot,
    log: &Log,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Compared, Diagnostics> {
    let Prepared { robot, logs, assumptions, warnings, .. } = currents::prepare(robot, &[log])?;
    let log = &logs[0];
    let content = log.content(&joint_layout(&robot.tree()?)?);
    if options.free_run.is_some() {
        free_run::refuse(&robot, content, log)?;
    }
    let mut reading = options.reading.clone();
    let mut comparison = None;
    if content == Content::Efforts {
        let efforts = compare_efforts(&robot, log, &options.reading, progress)?;
        reading.cutoff_hz = Some(efforts.cutoff_hz);
        comparison = Some(efforts);
    }
    let mut compared = match comparison {
        Some(comparison) if !(options.places || options.report) => {
            Compared { comparison, places: None, free_run: None, report: None }
        }
        comparison => look_closer(&robot, log, (&reading, options), comparison, progress)?,
    };
    let reading = measure::Options { cutoff_hz: Some(compared.cutoff_hz), ..options.reading.clone() };
    let run = |seconds| free_run::predict(&robot, log, &reading, seconds, progress);
    compared.free_run = options.free_run.map(run).transpose()?;
    compared.comparison.assumptions.extend(assumptions);
    compared.comparison.warnings.extend(warnings);
    Ok(compared)
}

/// Loads the file as an experiment: for what only that knows, and for files that are no logs of efforts.
fn look_closer(
    robot: &Robot,
    log: &Log,
    (reading, options): (&measure::Options, &Options),
    comparison: Option<Comparison>,
    progress: &dyn Progress,
) -> Result<Compared, Diagnostics> {
    let mut measured = progress.stage("deriving", || Measured::new(robot))?;
    measured.with_joints = true;
    let cutoff = measured.cutoff(log, reading)?;
    let cutoff_hz = (cutoff > 0.0).then_some(cutoff);
    let reading = measure::Options { cutoff_hz, ..reading.clone() };
    let foot = options.foot.as_deref();
    let loaded = progress.stage("reading", || measured.load(log, &reading, foot))?;
    let comparison = comparison.unwrap_or_else(|| {
        let reading = Reading {
            abscissa: loaded.content.abscissa(),
            cutoff_hz: loaded.cutoff_hz,
            trim_s: if loaded.content == Content::Contacts { reading.trim_s } else { 0.0 },
            missing: Vec::new(),
            assumptions: loaded.assumptions.clone(),
            warnings: loaded.warnings.clone(),
        };
        Comparison::of_experiment(&*loaded.experiment, reading)
    });
    let report = || of_measurements(robot, &measured, &loaded, None);
    Ok(Compared {
        comparison,
        report: options.report.then(report).transpose()?,
        places: options.places.then(|| breakdowns(&*loaded.experiment)),
        free_run: None,
    })
}

/// Logged efforts against the compiled model with the effects of its description.
///
/// Effects that no function of one state contains (delays, saturated drives, springs and play behind motors whose angle alone is
/// logged, rotors and friction of motors that turn otherwise than their joints, signs of friction with which efforts jump) are applied to the
/// whole log instead.
fn compare_efforts(
    robot: &Robot,
    log: &Log,
    reading: &measure::Options,
    progress: &dyn Progress,
) -> Result<Comparison, Diagnostics> {
    let layout = joint_layout(&robot.tree()?)?;
    let request = FunctionRequest::of_robot("inverse_dynamics");
    let compiled = progress.stage("deriving", || robot.compile_only(&[request]))?;
    let mut torques = ProgramTorques::new(&compiled)?;
    let mut comparison =
        progress.stage("reading and comparing", || compare_file(&mut torques, &layout, log, reading))?;
    let rows = log.rows();
    let outside = |effect: &Effect| {
        let joint = effect.location.joint.as_deref().unwrap_or_default();
        let [by_motor, by_link] =
            ["motor_position", "position"].map(|angle| rows.has(&format!("{joint}/{angle}")));
        match effect.kind.law {
            Law::Delay | Law::TrueTorque(_) => true,
            Law::SeriesElasticity | Law::Backlash => by_motor && !by_link,
            _ => by_motor && by_link && effect.kind.simulation.is_on_motor(),
        }
    };
    if !robot.description.effects.iter().any(outside) {
        let reading = measure::Options { cutoff_hz: Some(comparison.cutoff_hz), ..reading.clone() };
        let without = || without_sticking(robot, log, &reading, &mut comparison);
        if !progress.stage("looking where joints stick", without) {
            return Ok(comparison);
        }
    }
    let measured = progress.stage("deriving", || Measured::new(robot))?;
    let mut all = Vec::new();
    for cutoff in comparison.cutoffs.iter().map(|c| c.cutoff_hz) {
        let reading = measure::Options { cutoff_hz: Some(cutoff), ..reading.clone() };
        let experiment =
            progress.stage("reading and comparing", || measured.efforts(log, &reading, usize::MAX))?;
        all.push((cutoff, channels_of(&experiment)));
    }
    comparison.judged_again(all);
    Ok(comparison)
}

/// Errors without the samples at which joints stick, as a diagnosis has them. A log that makes no experiment (too short, a base of which
/// no log tells) does not say where they do. Whether efforts jump with a friction of the description.
fn without_sticking(
    robot: &Robot,
    log: &Log,
    reading: &measure::Options,
    comparison: &mut Comparison,
) -> bool {
    let Ok(measured) = Measured::new(robot) else { return false };
    let Ok(experiment) = measured.efforts(log, reading, SAMPLES) else { return false };
    comparison.leave_out(&experiment.recording().missing);
    comparison.without_sticking(&experiment);
    comparison.assumptions.extend(experiment.set_aside());
    experiment.has_sharp_signs()
}
