//! From logs to a diagnosis: reading, searching, and the errors in the form that comparisons use.
use super::stated::state;
use super::{Diagnosed, Options};
use crate::measurements::currents::{self, Prepared};
use crate::measurements::{Content, Loaded, Log, Measured, SAMPLES};
use crate::progress::Progress;
use crate::report::of_measurements;
use bipedc_analysis::diagnose::{self, Diagnosis, Selected, errors, support};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::experiments::data_checks::{Findings, inspect};
use bipedc_analysis::measure::{self, HELD};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, Severity};
use bipedc_effects::effect::{Effect, Law};
use std::path::Path;

/// Two logs, and what is asked of them.
struct Request<'a> {
    robot: &'a Robot,
    log: Log,
    validate: Option<Log>,
    options: &'a Options,
    search: diagnose::Options,
    progress: &'a dyn Progress,
}

/// Finds out what is missing in a robot's description; `judge` is a log of another motion, without which blocks of `train`
/// judge.
///
/// # Errors
/// Logs that cannot be read, hold nothing to explain or do not fit together; channels that are mixed up.
pub fn diagnose(
    robot: &Robot,
    (train, judge): (&Log, Option<&Log>),
    options: &Options,
    progress: &dyn Progress,
) -> Result<Diagnosed, Diagnostics> {
    let mut prepared = with_currents(robot, train, judge)?;
    if prepared.has_motors && !options.refit {
        let message = "rotor inertia and friction of the drives are taken as described: what is off there may be mistaken for other effects";
        let warning = Diagnostic::warning(message).in_file(train.path());
        prepared.warnings.push(warning.help("add --refit to estimate them beside what is found"));
    }
    let (robot, search) = refitting(&prepared.robot, options);
    let request = Request::new(&robot, &prepared, options, (search, progress));
    let work = |train: &dyn Experiment, judge: Option<&dyn Experiment>, search: &diagnose::Options| {
        progress.counted("diagnosing", |progress| diagnose::diagnose(train, judge, search, progress))
    };
    Ok(with_notes(answer(&request, work)?, &prepared))
}

impl<'a> Request<'a> {
    fn new(
        robot: &'a Robot,
        prepared: &Prepared,
        options: &'a Options,
        (search, progress): (diagnose::Options, &'a dyn Progress),
    ) -> Self {
        let (log, validate) = (prepared.logs[0].clone(), prepared.logs.get(1).cloned());
        Self { robot, log, validate, options, search, progress }
    }
}

/// Motor currents become efforts where the logs have no others.
fn with_currents(robot: &Robot, train: &Log, judge: Option<&Log>) -> Result<Prepared, Diagnostics> {
    let logs: Vec<&Log> = [train].into_iter().chain(judge).collect();
    currents::prepare(robot, &logs)
}

/// What was assumed of currents stands in the answer.
fn with_notes(mut found: Diagnosed, prepared: &Prepared) -> Diagnosed {
    let answer = &mut found.diagnosis;
    answer.assumptions.extend(prepared.assumptions.iter().cloned());
    answer.warnings.extend(prepared.warnings.iter().map(|warning| warning.message.clone()));
    found.warnings.extend(prepared.warnings.iter().cloned());
    found
}

/// Takes effects that are to be estimated again out of the description and lets them stand from the start instead.
fn refitting(robot: &Robot, options: &Options) -> (Robot, diagnose::Options) {
    let (mut robot, mut search) = (robot.clone(), options.search());
    if options.refit {
        // A user's formula has no columns of its own, and the assumptions have no parameters.
        let fixed =
            |effect: &Effect| effect.kind.law == Law::Formula || effect.kind.estimated().next().is_none();
        let (kept, standing) = robot.description.effects.drain(..).partition(fixed);
        robot.description.effects = kept;
        search.standing = standing;
    }
    (robot, search)
}

/// Estimates given effects, which must not stand in the robot's description. Parameters that stand in an effect are kept,
/// missing ones are wanted.
///
/// # Errors
/// As [`diagnose()`].
pub fn estimate(
    robot: &Robot,
    effects: &[Effect],
    (train, judge): (&Log, Option<&Log>),
    options: &Options,
    progress: &dyn Progress,
) -> Result<Diagnosed, Diagnostics> {
    let prepared = with_currents(robot, train, judge)?;
    let work = |train: &dyn Experiment, judge: Option<&dyn Experiment>, search: &diagnose::Options| {
        progress.stage("estimating", || diagnose::estimate(train, judge, effects, search))
    };
    // Effects that are estimated take the place of the drive's own.
    let mut robot = prepared.robot.clone();
    robot
        .description
        .effects
        .retain(|present| !effects.iter().any(|e| e.kind == present.kind && e.location == present.location));
    let request = Request::new(&robot, &prepared, options, (options.search(), progress));
    Ok(with_notes(answer(&request, work)?, &prepared))
}

fn answer(
    request: &Request<'_>,
    work: impl FnOnce(&dyn Experiment, Option<&dyn Experiment>, &diagnose::Options) -> Diagnosis,
) -> Result<Diagnosed, Diagnostics> {
    let Request { robot, options, progress, .. } = request;
    let mut measured = progress.stage("deriving", || Measured::new(robot))?;
    measured.with_joints = options.with_joints;
    let mut reading = options.reading.clone();
    let cutoff = progress.stage("reading", || measured.cutoff(&request.log, &options.reading))?;
    if cutoff > 0.0 {
        reading.cutoff_hz = Some(cutoff);
    }
    let foot = options.foot.as_deref();
    let load = |log: &Log, reading: &measure::Options| -> Result<Loaded<'_>, Diagnostics> {
        let loaded = measured.load(log, reading, foot)?;
        Ok(selected(loaded, &options.channels).map_err(|e| e.in_file(log.path()))?)
    };
    let mut train = load(&request.log, &reading)?;
    let judging = measure::Options { from_s: None, to_s: None, ..reading.clone() };
    let mut judge = request.validate.as_ref().map(|log| load(log, &judging)).transpose()?;
    if let (Some(alone), Some(log)) = (judge.take(), &request.validate) {
        let both;
        (train, both) = alike(train, alone, log.path())?;
        judge = Some(both);
    }
    let warnings = checked(&measured, request, &reading, (&train, judge.as_ref()))?;
    let judging_experiment = judge.as_ref().map(|judge| &*judge.experiment);
    let mut answer = work(&*train.experiment, judging_experiment, &request.search);
    answer.training = train.source.clone();
    answer.validation = judge.as_ref().map(|judge| judge.source.clone());
    answer.assumptions = train.assumptions.iter().cloned().chain(sticking(&*train.experiment)).collect();
    answer.cutoff_hz = cutoff;
    answer.warnings.extend(warnings.iter().map(|warning| warning.message.clone()));
    let compared = match options.reading.cutoff_hz {
        None => best_filter(&measured, request, &reading, &mut answer)?,
        Some(_) => of_all_samples(&measured, request, &reading, &mut answer)?,
    };
    if !compared {
        state(&mut answer, &*train.experiment, judging_experiment);
    }
    let shown = judge.as_ref().unwrap_or(&train);
    let report = || of_measurements(robot, &measured, shown, Some(&answer));
    let report = options.report.then(report).transpose()?;
    Ok(Diagnosed { diagnosis: answer, warnings, report })
}

/// Which joints stick, and that their samples are left out there.
fn sticking(experiment: &dyn Experiment) -> Option<String> {
    let share = |row: usize| {
        let sticks = experiment.sticks(row);
        let part = sticks.iter().filter(|sticks| **sticks).count() as f64 / sticks.len().max(1) as f64;
        (part > 0.0).then(|| format!("{} {:.0} %", experiment.rows()[row].name, 100.0 * part))
    };
    let joints: Vec<String> = (0..experiment.rows().len()).filter_map(share).collect();
    (!joints.is_empty()).then(|| {
        format!(
            "joints stick in or next to a part of their samples ({}), where dry friction may be anything between its bounds: left out",
            joints.join(", ")
        )
    })
}

/// The same with the rows of some channels only.
fn selected<'m>(mut loaded: Loaded<'m>, channels: &[String]) -> Result<Loaded<'m>, Diagnostic> {
    if !channels.is_empty() {
        loaded.experiment = Box::new(Selected::new(loaded.experiment, channels)?);
    }
    Ok(loaded)
}

/// What is odd about the data, before anything is searched for.
fn checked(
    measured: &Measured,
    request: &Request<'_>,
    reading: &measure::Options,
    (train, judge): (&Loaded<'_>, Option<&Loaded<'_>>),
) -> Result<Vec<Diagnostic>, Diagnostics> {
    let mut warnings = train.warnings.clone();
    warnings.extend(unsupported(measured, request, reading, train)?);
    warnings.extend(judge.iter().flat_map(|judge| judge.warnings.iter().cloned()));
    let judging = judge.map(|judge| &*judge.experiment);
    let found = request.progress.stage("checking the data", || inspect(&*train.experiment, judging));
    warnings.extend(admitted(found, request)?);
    Ok(warnings)
}

/// What the gate found as warnings, or its errors unless they are to be passed over.
fn admitted(found: Findings, request: &Request<'_>) -> Result<Vec<Diagnostic>, Diagnostics> {
    let validation = request
        .validate
        .iter()
        .flat_map(|log| found.validation.iter().map(move |finding| finding.clone().in_file(log.path())));
    let training = found.training.iter().map(|finding| finding.clone().in_file(request.log.path()));
    let mut all: Vec<Diagnostic> = training.chain(validation).collect();
    if all.iter().any(|finding| finding.severity == Severity::Error) && !request.options.anyway {
        let last =
            Diagnostic::warning("nothing was searched for: what is found in such data cannot be trusted");
        all.push(last.help("put the data right, or pass --anyway if they are as they should be"));
        return Err(Diagnostics(all));
    }
    all.iter_mut().for_each(|finding| finding.severity = Severity::Warning);
    Ok(all)
}

/// Warnings where the log cannot support estimates: joints in which the model's torque fades as the cut-off doubles.
fn unsupported(
    measured: &Measured,
    request: &Request<'_>,
    reading: &measure::Options,
    train: &Loaded<'_>,
) -> Result<Vec<Diagnostic>, Diagnostics> {
    let Some(cutoff) = reading.cutoff_hz else { return Ok(Vec::new()) };
    if measured.content(&request.log) != Content::Efforts {
        return Ok(Vec::new());
    }
    let cutoffs = [cutoff, 2.0 * cutoff];
    let at = |cutoff: f64| {
        let reading = measure::Options { cutoff_hz: Some(cutoff), ..reading.clone() };
        measured.load(&request.log, &reading, None)
    };
    let (slower, faster) = (at(0.5 * cutoff)?, at(cutoffs[1])?);
    let fading = support::fading(&*train.experiment, &*faster.experiment);
    let mut messages: Vec<String> = fading.iter().map(|joint| joint.warning(cutoffs)).collect();
    if let Some(kept) = support::kept(&*slower.experiment, &*faster.experiment)
        && kept < support::KEEPS
    {
        messages.push(format!(
            "this log hardly supports estimates of masses and inertias, as free swings do: estimated freely, only \
             {:.0} % of them remain when the filter's cut-off rises from {:.1} to {:.1} Hz",
            100.0 * kept.max(0.0),
            0.5 * cutoff,
            cutoffs[1]
        ));
    }
    let warning = |message: String| {
        Diagnostic::warning(message)
            .in_file(request.log.path())
            .help("record a motion in which the drives work hard, or estimate from another log")
    };
    Ok(messages.into_iter().map(warning).collect())
}

/// Both files show the same rows: those that one of them alone shows are left out.
fn alike<'m>(
    mut train: Loaded<'m>,
    mut judge: Loaded<'m>,
    file: &Path,
) -> Result<(Loaded<'m>, Loaded<'m>), Diagnostic> {
    if train.source.hash == judge.source.hash {
        let message = "the validation log is the training log: it cannot judge what was fitted to it";
        return Err(Diagnostic::error(message)
            .help("record another motion, or leave --validate out: then blocks of the log judge")
            .in_file(file));
    }
    let names = |loaded: &Loaded<'_>| -> Vec<String> {
        loaded.experiment.rows().iter().map(|row| row.name.clone()).collect()
    };
    let (a, b) = (names(&train), names(&judge));
    let (both, mut single): (Vec<String>, Vec<String>) = a.iter().cloned().partition(|name| b.contains(name));
    single.extend(b.iter().filter(|name| !a.contains(name)).cloned());
    if single.is_empty() {
        return Ok((train, judge));
    }
    if both.is_empty() {
        let message =
            format!("the validation log measures nothing that the training log does: {}", single.join(", "));
        return Err(Diagnostic::error(message).help("use logs with the same columns").in_file(file));
    }
    train.assumptions.push(format!("left out, because one log alone shows them: {}", single.join(", ")));
    train.experiment = Box::new(Selected::named(train.experiment, &both));
    judge.experiment = Box::new(Selected::named(judge.experiment, &both));
    Ok((train, judge))
}

/// Errors at the cut-off that fits the judging log best once everything is in: the one that a comparison of that log with the
/// amended model chooses, so that both state the same. False if it is the one of the search.
fn best_filter(
    measured: &Measured,
    request: &Request<'_>,
    reading: &measure::Options,
    answer: &mut Diagnosis,
) -> Result<bool, Diagnostics> {
    let efforts = measured.content(&request.log) == Content::Efforts;
    if !efforts || !request.options.channels.is_empty() {
        return Ok(false);
    }
    let effects: Vec<Effect> = answer.estimated().cloned().collect();
    let (log, mut whole) = match &request.validate {
        Some(log) => (log, measure::Options { from_s: None, to_s: None, ..reading.clone() }),
        None => (&request.log, reading.clone()),
    };
    let mut best: Option<(f64, f64)> = None;
    for cutoff in measure::CANDIDATES {
        whole.cutoff_hz = Some(cutoff);
        // A cut-off beyond half the sampling rate is not one.
        let Ok(loaded) = measured.load(log, &whole, None) else { continue };
        let falls = errors(&*loaded.experiment, None, &effects).rms_training;
        let error = falls.get("effort").map_or(f64::INFINITY, |fall| fall.after);
        if best.is_none_or(|(_, least)| error < least) {
            best = Some((cutoff, error));
        }
    }
    let cutoff = best.map_or(answer.cutoff_hz, |(cutoff, _)| cutoff);
    if cutoff != answer.cutoff_hz {
        answer.judged_at_hz = Some(cutoff);
        return as_compared(measured, request, reading, answer);
    }
    of_all_samples(measured, request, reading, answer)
}

/// The errors of a log that the search saw a part of only: of all its samples, as `compare` measures them.
fn of_all_samples(
    measured: &Measured,
    request: &Request<'_>,
    reading: &measure::Options,
    answer: &mut Diagnosis,
) -> Result<bool, Diagnostics> {
    let efforts = measured.content(&request.log) == Content::Efforts;
    let judged = answer.validation.as_ref().unwrap_or(&answer.training);
    // Of a longer log more than half of the most are left when it was thinned.
    let long = answer.training.samples.max(judged.samples) > SAMPLES / 2;
    if !efforts || !long || !request.options.channels.is_empty() {
        return Ok(false);
    }
    as_compared(measured, request, reading, answer)
}

/// The errors of all samples that are held, at the cut-off at which a comparison judges.
fn as_compared(
    measured: &Measured,
    request: &Request<'_>,
    reading: &measure::Options,
    answer: &mut Diagnosis,
) -> Result<bool, Diagnostics> {
    let effects: Vec<Effect> = answer.estimated().cloned().collect();
    let cutoff = answer.judged_at_hz.unwrap_or(answer.cutoff_hz);
    let at = measure::Options { cutoff_hz: Some(cutoff), ..reading.clone() };
    let whole = measure::Options { from_s: None, to_s: None, ..at.clone() };
    let train = measured.efforts(&request.log, &at, HELD)?;
    let judge = request.validate.as_ref().map(|log| measured.efforts(log, &whole, HELD)).transpose()?;
    let judge = judge.as_ref().map(|judge| judge as &dyn Experiment);
    answer.take(errors(&train, judge, &effects));
    state(answer, &train, judge);
    for (step, errors) in answer.steps.iter_mut().zip(&answer.step_errors) {
        [step.before, step.after] = errors.held_out.get("effort").copied().unwrap_or_default();
    }
    Ok(true)
}
