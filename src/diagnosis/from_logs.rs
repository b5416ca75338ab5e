//! From logs to a diagnosis: reading, searching, and the errors in the form that comparisons use.
use super::behind::{look_behind, slower_where_safe};
use super::filtered::{Filtered, Request, Work, filtered, second_look};
use super::judged::{best_filter, of_all_samples, quietest};
use super::raised::Raised;
use super::stated::{said, state};
use super::{Diagnosed, Inertial, Options};
use crate::measurements::currents::{self, Prepared};
use crate::measurements::{Content, Loaded, Log, Measured};
use crate::progress::Progress;
use crate::report::of_measurements;
use bipedc_analysis::diagnose::{self, Diagnosis, ErrorFall, Stated, support};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::experiments::data_checks::{Findings, inspect};
use bipedc_analysis::measure;
use bipedc_analysis::number::four_decimals;
use bipedc_analysis::parallel::parallel;
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, Severity};
use bipedc_effects::effect::{Effect, Law};

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
    let mut found = answer(&request, &work)?;
    match judged_by_itself(&request, &found.diagnosis, &work) {
        Some(ByItself::Answer(own)) => found = *own,
        Some(ByItself::Filter(second)) => taken_off(&mut found, &second),
        None => {}
    }
    Ok(with_notes(found, &prepared))
}

/// What the training log says beside the answer that another log judged.
enum ByItself {
    /// More acts in it.
    Answer(Box<Diagnosed>),
    /// The same acts in it, and behind the filter of this answer less is left: of fast motion, which the other one took off.
    Filter(Box<Diagnosis>),
}

/// Part of the training log's error that blocks of it must leave to judge instead of a log that does not show what acts there.
const EXPLAINS: f64 = 0.8;

/// The answer that blocks of the training log give, where the log that was to judge is explained down to its noise, the training log is not, and
/// its own blocks tell what acts there beside all that was found.
fn judged_by_itself(request: &Request<'_>, first: &Diagnosis, work: Work<'_>) -> Option<ByItself> {
    let (name, missed, _) = first.unseen_by_judge().filter(|_| !first.unexplained)?;
    let own = Request { validate: None, passed_over: request.validate.clone(), ..request.clone() };
    // What cannot judge itself leaves the first answer.
    let second = answer(&own, work).ok()?;
    let Diagnosis { rows_training, rms_training, .. } = &second.diagnosis;
    // All of that log counts: where its blocks do not show what acts either, nothing is told.
    let left = rows_training.get(name).or_else(|| rms_training.get(name))?.told();
    let effects = first.effects.iter().map(|found| &found.effect);
    let is_told = left < EXPLAINS * missed.told() && tells(&second.diagnosis, effects);
    if !is_told {
        return None;
    }
    // The same effects once more are no reason to let another log judge.
    let is_more = !tells(first, second.diagnosis.estimated()) || second.diagnosis.unexplained;
    Some(match is_more {
        true => ByItself::Answer(Box::new(second)),
        false => ByItself::Filter(Box::new(second.diagnosis)),
    })
}

/// Whether effects stand in an answer, with whatever values.
fn tells<'e>(answer: &Diagnosis, mut effects: impl Iterator<Item = &'e Effect>) -> bool {
    let same = |a: &Effect, b: &Effect| a.kind == b.kind && a.location == b.location;
    effects.all(|effect| answer.estimated().any(|one| same(one, effect)))
}

/// Behind another filter no more than this part of an error is left that is fast motion, which the first one took off.
const TAKEN_OFF: f64 = 0.5;

/// Rows of the training log of which little but noise is left behind the filter of another answer, which explains it, are taken for noise.
fn taken_off(found: &mut Diagnosed, other: &Diagnosis) {
    let answer = &mut found.diagnosis;
    for (rows, others) in
        [(&mut answer.rows_training, &other.rows_training), (&mut answer.rms_training, &other.rms_training)]
    {
        let is_gone = |row: &str, fall: &ErrorFall| {
            others
                .get(row)
                .is_some_and(|other| other.above_noise().is_none() || other.told() < TAKEN_OFF * fall.told())
        };
        let gone = rows.iter_mut().filter(|(row, fall)| is_gone(row, fall));
        gone.for_each(|(_, fall)| fall.gone_at_hz = Some(other.cutoff_hz));
    }
    answer.conclude();
    answer.summary = said(answer);
    if let Some(report) = &mut found.report {
        report.diagnosis = Some(answer.clone());
    }
}

impl<'a> Request<'a> {
    fn new(
        robot: &'a Robot,
        prepared: &Prepared,
        options: &'a Options,
        (search, progress): (diagnose::Options, &'a dyn Progress),
    ) -> Self {
        let (log, validate) = (prepared.logs[0].clone(), prepared.logs.get(1).cloned());
        Self { robot, log, validate, passed_over: None, options, search, does_without: false, progress }
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
    answer.warnings.extend(prepared.warnings.iter().map(Diagnostic::placed));
    if let Some(page) = &mut found.report {
        page.warnings.extend(prepared.warnings.iter().map(Diagnostic::advised));
    }
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

/// Estimates given effects, which must not stand in the robot's description. What the parameters that stand in them are, `stated` says; missing ones are
/// wanted.
///
/// # Errors
/// As [`diagnose()`].
pub fn estimate(
    robot: &Robot,
    (effects, stated): (&[Effect], Stated),
    (train, judge): (&Log, Option<&Log>),
    options: &Options,
    progress: &dyn Progress,
) -> Result<Diagnosed, Diagnostics> {
    let prepared = with_currents(robot, train, judge)?;
    let work = |train: &dyn Experiment, judge: Option<&dyn Experiment>, search: &diagnose::Options| {
        progress.stage("estimating", || diagnose::estimate(train, judge, (effects, stated), search))
    };
    // Effects that are estimated take the place of the drive's own.
    let mut robot = prepared.robot.clone();
    robot
        .description
        .effects
        .retain(|present| !effects.iter().any(|e| e.kind == present.kind && e.location == present.location));
    let request = Request::new(&robot, &prepared, options, (options.search(), progress));
    // What is asked for is estimated, whatever it does to errors.
    Ok(with_notes(first_answer(&request, &work)?.0, &prepared))
}

/// The answer to a request, without what of it only raises errors behind the filter at which it is told.
fn answer(request: &Request<'_>, work: Work<'_>) -> Result<Diagnosed, Diagnostics> {
    let (first, raised) = first_answer(request, work)?;
    let Some(raised) = raised else { return Ok(first) };
    let search = raised.without(&request.search);
    let (second, _) = first_answer(&Request { search, does_without: true, ..request.clone() }, work)?;
    Ok(if raised.is_answered(&second.diagnosis, &first.diagnosis) { second } else { first })
}

/// An answer, and what of it only raises errors, if the search does not do without that already.
fn first_answer(request: &Request<'_>, work: Work<'_>) -> Result<(Diagnosed, Option<Raised>), Diagnostics> {
    let Request { robot, options, progress, .. } = request;
    for log in [Some(&request.log), request.validate.as_ref()].into_iter().flatten() {
        measure::has_filter(log, &options.reading)?;
    }
    let mut measured = progress.stage("deriving", || Measured::new(robot))?;
    measured.with_joints = options.with_joints;
    let cutoff = progress.stage("reading", || measured.cutoff(&request.log, &options.reading))?;
    let cutoff = slower_where_safe(&measured, request, cutoff);
    let mut logs = filtered(&measured, request, cutoff)?;
    let warnings = checked(&measured, request, &logs.reading, (&logs.train, logs.judge.as_ref()))?;
    let mut answer = work(&*logs.train.experiment, logs.judging(), &request.search);
    let mut best = quietest(&measured, request, &logs.reading, &answer);
    if let Some((other, better)) = second_look(&measured, request, (&logs, &answer), best, work) {
        (logs, answer) = (other, better);
        best = quietest(&measured, request, &logs.reading, &answer);
    }
    // What the search has to say of itself is for people too.
    let told = answer.warnings.iter().map(Diagnostic::warning);
    let warned: Vec<Diagnostic> = warnings.iter().cloned().chain(told).collect();
    let Filtered { reading, train, judge } = &logs;
    answer.training = train.source.clone();
    answer.validation = judge.as_ref().map(|judge| judge.source.clone());
    answer.assumptions = train.assumptions.iter().cloned().chain(sticking(&*train.experiment)).collect();
    answer.cutoff_hz = train.cutoff_hz;
    answer.warnings.extend(warnings.iter().map(Diagnostic::placed));
    let compared = match options.reading.cutoff_hz {
        None => best_filter(&measured, request, reading, &mut answer, best)?,
        Some(_) => of_all_samples(&measured, request, reading, &mut answer)?,
    };
    if !compared {
        state(&mut answer, &*train.experiment, logs.judging());
    }
    // Behind a filter that is asked for nothing but that counts, and inertias that are asked for are told.
    let is_open = options.reading.cutoff_hz.is_none() && options.inertial != Inertial::Free;
    let raised =
        (is_open && !request.does_without).then(|| Raised::by(&measured, request, &answer)).flatten();
    look_behind(&measured, request, reading, &mut answer);
    let jumps = at_jumps(&answer);
    answer.assumptions.extend(jumps);
    if let Some(judge) = &request.passed_over {
        let acts = answer.estimated().next().is_some() || answer.unexplained;
        answer.summary.insert_str(0, &passed_over(judge, &request.log, acts));
    }
    let shown = judge.as_ref().unwrap_or(train);
    let report = || of_measurements(robot, &measured, shown, Some(&answer));
    let mut report = options.report.then(report).transpose()?;
    if let Some(page) = &mut report {
        page.warnings.extend(warned.iter().map(Diagnostic::advised));
    }
    Ok((Diagnosed { diagnosis: answer, warnings: warned, report }, raised))
}

/// Rows that are above their noise only where something jumps, and how much is left away from there.
fn at_jumps(answer: &Diagnosis) -> Option<String> {
    let told =
        |(row, fall): (&String, &ErrorFall)| format!("{row} {} {}", four_decimals(fall.told()), fall.unit);
    let rows: Vec<String> = answer.left_at_jumps().map(told).collect();
    (!rows.is_empty()).then(|| {
        format!(
            "what is left above the noise of some rows is left around the moments at which joints turn back or drives reach their limits, which the filter smears; away from them: {}",
            rows.join(", ")
        )
    })
}

/// Said before an answer that does not come from the log that was to judge; whether anything `acts` in the other one.
fn passed_over(judge: &Log, train: &Log, acts: bool) -> String {
    let name = |log: &Log| log.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (judge, train) = (name(judge), name(train));
    if !acts {
        return format!(
            "Behind the filter that suits {judge} best more than noise is left of {train}, of faster motion. Blocks of {train} judge instead.\n"
        );
    }
    format!(
        "{judge} hardly shows what acts in {train}: it is explained down to its noise without it. Blocks of {train} judge instead.\n"
    )
}

/// Which joints rest, turn back, lie at a stop or have clipped efforts, and that their samples are left out there.
fn sticking(experiment: &dyn Experiment) -> Option<String> {
    let shaken = experiment.shaken();
    let share = |row: usize| {
        let sticks = experiment.sticks(row);
        let by_itself =
            (0..sticks.len()).filter(|&i| sticks[i] && !shaken.get(i).is_some_and(|shaken| *shaken));
        let part = by_itself.count() as f64 / sticks.len().max(1) as f64;
        (part > 0.0).then(|| format!("{} {:.0} %", experiment.rows()[row].name, 100.0 * part))
    };
    let joints: Vec<String> = (0..experiment.rows().len()).filter_map(share).collect();
    (!joints.is_empty()).then(|| {
        format!(
            "joints rest and stick, turn back, lie at a stop or have clipped efforts in or next to a part of their samples ({}), where an effort is a bound: left out",
            joints.join(", ")
        )
    })
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
    let mut both = parallel(2, |i| at([0.5 * cutoff, cutoffs[1]][i])).into_iter();
    let (Some(slower), Some(faster)) = (both.next(), both.next()) else { return Ok(Vec::new()) };
    let (slower, faster) = (slower?, faster?);
    let fading = support::fading(&*train.experiment, &*faster.experiment, support::LOUD);
    let mut messages: Vec<String> = support::warning(&fading, cutoffs).into_iter().collect();
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
