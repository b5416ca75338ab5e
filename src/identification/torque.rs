//! From joint torques, or from the rows of a free base with forces at its feet (thesis 5.2).
use super::logs::{Identifiable, content, inspected, inspected_tables, loaded, rigid_layout, table_survey};
use super::{Identified, Job};
use crate::measurements::{Content, Log, Measured};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::identify::{
    Feed, IdentificationResult, Judge, LOOKING, Survey, identify, signal_cutoff, survey,
};
use bipedc_analysis::measure;
use bipedc_analysis::report::Row;
use bipedc_effects::diagnostic::Diagnostics;

/// Reads, estimates; torques over time if they are wanted.
pub fn run(job: &mut Job<'_>) -> Result<(Identified, Vec<Row>), Diagnostics> {
    let measured = job.progress.stage("deriving", || Measured::new(job.robot))?;
    let every: Vec<&Log> = job.logs.iter().copied().chain(job.judge).collect();
    let answer = match content(&measured, &every)? {
        Content::Contacts => of_contacts(job, &measured)?,
        _ => of_torques(job, &measured)?,
    };
    Ok(Identified::new(answer, None))
}

/// The base is held or hangs.
fn of_torques(job: &mut Job<'_>, measured: &Measured) -> Result<IdentificationResult, Diagnostics> {
    let (logs, judge) = job.read_as(&reading(job)?);
    let found = Identifiable::of_torques(job.robot, &logs, job.progress)?;
    let options = job.options.of_joints(&found.layout)?;
    let check = || inspected(measured, job.logs, &job.options.reading);
    let odd = job.progress.stage("checking", check);
    job.pass(odd)?;
    let surveys =
        judge.iter().map(|reading| survey(reading, &found.layout)).collect::<Result<Vec<_>, _>>()?;
    let judge = judge.first().zip(surveys.first()).map(|(reading, survey)| Judge {
        feed: Feed::Logs(&judge),
        survey,
        file: reading.log.path(),
    });
    let feed = Feed::Logs(&logs);
    let work = |progress: &dyn Fn(f64)| identify(&found.parts(), &feed, judge.as_ref(), &options, progress);
    job.progress.counted("identifying", work)
}

/// Behind which filter logs are read: if none was asked for, as fast a one as motion and noise of all that teach allow.
fn reading(job: &Job<'_>) -> Result<measure::Options, Diagnostics> {
    let usual = job.options.reading.clone();
    if !job.any_cutoff || job.options.decimate > 1 {
        return Ok(usual);
    }
    let layout = rigid_layout(job.robot)?;
    let (logs, _) = job.read_as(&measure::Options { cutoff_hz: Some(LOOKING), ..usual.clone() });
    let look = || logs.iter().map(|log| survey(log, &layout)).collect::<Result<Vec<_>, Diagnostics>>();
    let surveys = job.progress.stage("reading", look)?;
    let cutoff_hz = signal_cutoff(&surveys).or(usual.cutoff_hz);
    Ok(measure::Options { cutoff_hz, ..usual })
}

/// The base is free, and forces at the feet are logged.
fn of_contacts(job: &mut Job<'_>, measured: &Measured) -> Result<IdentificationResult, Diagnostics> {
    let reading = &job.options.reading;
    let whole = measure::Options { from_s: None, to_s: None, ..reading.clone() };
    let tables = job.progress.stage("reading", || loaded(measured, job.logs, reading))?;
    let judges = job.progress.stage("reading", || loaded(measured, job.judge.as_slice(), &whole))?;
    job.pass(inspected_tables(&tables, job.logs))?;
    let found = Identifiable::of_contacts(job.robot, &job.read().0, &tables, job.progress)?;
    let options = job.options.of_joints(&found.layout)?;
    let experiments: Vec<&dyn Experiment> = tables.iter().map(|table| &*table.experiment).collect();
    let judging: Vec<&dyn Experiment> = judges.iter().map(|table| &*table.experiment).collect();
    let surveys: Vec<Survey> = judges.iter().map(|table| table_survey(table, &found.layout)).collect();
    let judge = job.judge.zip(surveys.first()).map(|(log, survey)| Judge {
        feed: Feed::Tables(&judging),
        survey,
        file: log.path(),
    });
    let feed = Feed::Tables(&experiments);
    let work = |progress: &dyn Fn(f64)| identify(&found.parts(), &feed, judge.as_ref(), &options, progress);
    job.progress.counted("identifying", work)
}
