//! From files to a diagnosis: reading, searching, and the errors in the form that comparisons use.
use crate::currents::{self, Prepared};
use crate::failure::Failure;
use crate::measurements::{Content, Loaded, Measured};
use crate::output;
use bipedc_analysis::diagnose::{Diagnosis, Options, Selected, diagnose, errors, estimate, summary, support};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::experiments::data_checks::{Findings, inspect};
use bipedc_analysis::log::Mapping;
use bipedc_analysis::measure;
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, Severity};
use bipedc_effects::effect::{Effect, Law};
use std::path::{Path, PathBuf};

/// What is to be diagnosed, and how.
#[derive(Debug, Clone, Default)]
pub struct Request {
    pub log: PathBuf,
    pub validate: Option<PathBuf>,
    pub mapping: Mapping,
    /// Times between which samples of the first log count, and the filter.
    pub reading: measure::Options,
    /// Stance foot of postures, striking foot of impacts.
    pub foot: Option<String>,
    /// Logs with foot forces: also the joints' efforts.
    pub with_joints: bool,
    /// Kinds of rows that count, as in JSON; none: all.
    pub channels: Vec<String>,
    pub search: Options,
    /// Go on although channels are mixed up.
    pub anyway: bool,
    /// Estimate the effects of the description again, beside what is found.
    pub refit: bool,
}

/// Is shown the measurements that judged, and the answer.
pub type Witness<'w> = &'w dyn Fn(&Measured, &Loaded<'_>, &Diagnosis) -> Result<(), Failure>;

/// Finds out what is missing; warnings about the files come with the answer.
pub fn diagnose_files(
    robot: &Robot,
    request: &Request,
    witness: Witness<'_>,
) -> Result<(Diagnosis, Vec<Diagnostic>), Failure> {
    let (mut prepared, request) = with_currents(robot, request)?;
    if prepared.has_motors && !request.refit {
        let message = "rotor inertia and friction of the drives are taken as described: what is off there may be mistaken for other effects";
        let warning = Diagnostic::warning(message).in_file(&request.log);
        prepared.warnings.push(warning.help("add --refit to estimate them beside what is found"));
    }
    let (robot, request) = refitting(&prepared.robot, &request);
    let work = |train: &dyn Experiment, judge: Option<&dyn Experiment>, search: &Options| {
        output::bar("diagnosing", |progress| diagnose(train, judge, search, progress))
    };
    Ok(with_notes(answer(&robot, &request, work, witness)?, &prepared))
}

/// Motor currents become efforts where the logs have no others.
fn with_currents(robot: &Robot, request: &Request) -> Result<(Prepared, Request), Failure> {
    let logs: Vec<&Path> =
        [Some(&request.log), request.validate.as_ref()].into_iter().flatten().map(PathBuf::as_path).collect();
    let prepared = currents::prepare(robot, &logs, &request.mapping)?;
    let request = Request { mapping: prepared.mapping.clone(), ..request.clone() };
    Ok((prepared, request))
}

/// What was assumed of currents stands in the answer.
fn with_notes(
    (mut answer, mut warnings): (Diagnosis, Vec<Diagnostic>),
    prepared: &Prepared,
) -> (Diagnosis, Vec<Diagnostic>) {
    answer.assumptions.extend(prepared.assumptions.iter().cloned());
    answer.warnings.extend(prepared.warnings.iter().map(|warning| warning.message.clone()));
    warnings.extend(prepared.warnings.iter().cloned());
    (answer, warnings)
}

/// Takes effects that are to be estimated again out of the description and lets them stand from the start instead.
fn refitting(robot: &Robot, request: &Request) -> (Robot, Request) {
    let (mut robot, mut request) = (robot.clone(), request.clone());
    if request.refit {
        // A user's formula has no columns of its own, and the assumptions have no parameters.
        let fixed =
            |effect: &Effect| effect.kind.law == Law::Formula || effect.kind.estimated().next().is_none();
        let (kept, standing) = robot.description.effects.drain(..).partition(fixed);
        robot.description.effects = kept;
        request.search.standing = standing;
    }
    (robot, request)
}

/// Estimates given effects, which must not stand in the robot's description.
pub fn estimate_files(
    robot: &Robot,
    effects: &[Effect],
    request: &Request,
) -> Result<(Diagnosis, Vec<Diagnostic>), Failure> {
    let (prepared, request) = with_currents(robot, request)?;
    let work = |train: &dyn Experiment, judge: Option<&dyn Experiment>, search: &Options| {
        output::progress("estimating", || estimate(train, judge, effects, search))
    };
    // Effects that are estimated take the place of the drive's own.
    let mut robot = prepared.robot.clone();
    robot
        .description
        .effects
        .retain(|present| !effects.iter().any(|e| e.kind == present.kind && e.location == present.location));
    Ok(with_notes(answer(&robot, &request, work, &|_, _, _| Ok(()))?, &prepared))
}

fn answer(
    robot: &Robot,
    request: &Request,
    work: impl FnOnce(&dyn Experiment, Option<&dyn Experiment>, &Options) -> Diagnosis,
    witness: Witness<'_>,
) -> Result<(Diagnosis, Vec<Diagnostic>), Failure> {
    let mut measured = output::progress("deriving", || Measured::new(robot))?;
    measured.with_joints = request.with_joints;
    let mut reading = request.reading.clone();
    let cutoff =
        output::progress("reading", || measured.cutoff(&request.log, &request.mapping, &request.reading))?;
    if cutoff > 0.0 {
        reading.cutoff_hz = Some(cutoff);
    }
    let foot = request.foot.as_deref();
    let load = |file: &Path, reading: &measure::Options| -> Result<Loaded<'_>, Failure> {
        let loaded = measured.load(file, &request.mapping, reading, foot)?;
        selected(loaded, &request.channels).map_err(|e| Failure(vec![e.in_file(file)]))
    };
    let train = load(&request.log, &reading)?;
    let judging = measure::Options { from_s: None, to_s: None, ..reading.clone() };
    let judge = match &request.validate {
        Some(file) => Some(load(file, &judging)?),
        None => None,
    };
    if let (Some(judge), Some(file)) = (&judge, &request.validate) {
        alike(&train, judge, file)?;
    }
    let mut warnings = train.warnings.clone();
    warnings.extend(unsupported(&measured, request, &reading, &train)?);
    warnings.extend(judge.iter().flat_map(|judge| judge.warnings.iter().cloned()));
    let judging_experiment = judge.as_ref().map(|judge| &*judge.experiment);
    let found = output::progress("checking the data", || inspect(&*train.experiment, judging_experiment));
    warnings.extend(admitted(found, request)?);
    let mut answer = work(&*train.experiment, judging_experiment, &request.search);
    answer.training = train.source.clone();
    answer.validation = judge.as_ref().map(|judge| judge.source.clone());
    answer.assumptions = train.assumptions.clone();
    answer.cutoff_hz = cutoff;
    answer.warnings.extend(warnings.iter().map(|warning| warning.message.clone()));
    if request.reading.cutoff_hz.is_none() {
        best_filter(&measured, request, &mut answer)?;
    }
    witness(&measured, judge.as_ref().unwrap_or(&train), &answer)?;
    Ok((answer, warnings))
}

/// The same with the rows of some channels only.
fn selected<'m>(mut loaded: Loaded<'m>, channels: &[String]) -> Result<Loaded<'m>, Diagnostic> {
    if !channels.is_empty() {
        loaded.experiment = Box::new(Selected::new(loaded.experiment, channels)?);
    }
    Ok(loaded)
}

/// What the gate found as warnings, or its errors unless they are to be passed over.
fn admitted(found: Findings, request: &Request) -> Result<Vec<Diagnostic>, Failure> {
    let validation = request
        .validate
        .iter()
        .flat_map(|file| found.validation.iter().map(move |finding| finding.clone().in_file(file)));
    let training = found.training.iter().map(|finding| finding.clone().in_file(&request.log));
    let mut all: Vec<Diagnostic> = training.chain(validation).collect();
    if all.iter().any(|finding| finding.severity == Severity::Error) && !request.anyway {
        let last =
            Diagnostic::warning("nothing was searched for: what is found in such data cannot be trusted");
        all.push(last.help("put the data right, or pass --anyway if they are as they should be"));
        return Err(Failure(all));
    }
    all.iter_mut().for_each(|finding| finding.severity = Severity::Warning);
    Ok(all)
}

/// Warnings where the log cannot support estimates: joints in which the model's torque fades as the cut-off doubles.
fn unsupported(
    measured: &Measured,
    request: &Request,
    reading: &measure::Options,
    train: &Loaded<'_>,
) -> Result<Vec<Diagnostic>, Failure> {
    let Some(cutoff) = reading.cutoff_hz else { return Ok(Vec::new()) };
    if measured.content(&request.log, &request.mapping)? != Content::Efforts {
        return Ok(Vec::new());
    }
    let cutoffs = [cutoff, 2.0 * cutoff];
    let at = |cutoff: f64| {
        let reading = measure::Options { cutoff_hz: Some(cutoff), ..reading.clone() };
        measured.load(&request.log, &request.mapping, &reading, None)
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
            .in_file(&request.log)
            .help("record a motion in which the drives work hard, or estimate from another log")
    };
    Ok(messages.into_iter().map(warning).collect())
}

/// Both files must show the same rows.
fn alike(train: &Loaded<'_>, judge: &Loaded<'_>, file: &Path) -> Result<(), Failure> {
    let names = |loaded: &Loaded<'_>| -> Vec<String> {
        loaded.experiment.rows().iter().map(|row| row.name.clone()).collect()
    };
    let (a, b) = (names(train), names(judge));
    let problem = if train.source.hash == judge.source.hash {
        Diagnostic::error("the validation log is the training log: it cannot judge what was fitted to it")
            .help("record another motion, or leave --validate out: then blocks of the log judge")
    } else if a != b {
        let differ: Vec<&str> = a
            .iter()
            .filter(|n| !b.contains(n))
            .chain(b.iter().filter(|n| !a.contains(n)))
            .map(String::as_str)
            .collect();
        Diagnostic::error(format!(
            "the validation log measures other things than the training log: {}",
            differ.join(", ")
        ))
        .help("use logs with the same columns")
    } else {
        return Ok(());
    };
    Err(Diagnostics(vec![problem.in_file(file)]).into())
}

/// Errors at the cut-off that fits best once the effects are in, as a comparison would choose it.
fn best_filter(measured: &Measured, request: &Request, answer: &mut Diagnosis) -> Result<(), Failure> {
    let efforts = measured.content(&request.log, &request.mapping)? == Content::Efforts;
    if !efforts
        || !request.channels.is_empty()
        || !answer.inertial_corrections.is_empty()
        || request.validate.is_none()
    {
        return Ok(());
    }
    let standing = answer.standing.iter().map(|found| found.effect.clone());
    let effects: Vec<Effect> = standing.chain(answer.steps.iter().map(|step| step.effect.clone())).collect();
    let at = |file: &Path, cutoff: f64| -> Result<_, Failure> {
        let reading = measure::Options { cutoff_hz: Some(cutoff), ..measure::Options::default() };
        let loaded = measured.load(file, &request.mapping, &reading, None)?;
        Ok(errors(&*loaded.experiment, &effects))
    };
    let mut best: Option<(f64, f64)> = None;
    for cutoff in measure::CANDIDATES {
        // A cut-off beyond half the sampling rate is not one.
        let Ok(falls) = at(&request.log, cutoff) else { continue };
        let error = falls.get("effort").map_or(f64::INFINITY, |fall| fall.after);
        if best.is_none_or(|(_, least)| error < least) {
            best = Some((cutoff, error));
        }
    }
    if let (Some((cutoff, _)), Some(file)) = (best, &request.validate)
        && cutoff != answer.cutoff_hz
    {
        let falls = at(file, cutoff)?;
        if let Some(fall) = falls.get("effort") {
            (answer.rms_before, answer.rms_after) = (fall.before, fall.after);
        }
        answer.rms = falls;
        answer.judged_at_hz = Some(cutoff);
        answer.summary = summary(answer);
    }
    Ok(())
}
