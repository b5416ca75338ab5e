//! Friction and springs of series elastic drives, then bodies (thesis 5.3).
use super::logs::Drives;
use super::{Identified, Job};
use bipedc_analysis::identify::elastic::{ElasticParts, Look, identify_elastic, look};
use bipedc_analysis::identify::{IdentificationResult, Reading, Survey};
use bipedc_analysis::report::Row;
use bipedc_effects::diagnostic::Diagnostics;

/// Reads, estimates; torques over time if they are wanted.
pub fn run(job: &mut Job<'_>) -> Result<(Identified, Vec<Row>), Diagnostics> {
    let Job { robot, progress, .. } = *job;
    let options = job.options.of_drives()?;
    let drives = Drives::new(robot)?;
    let (logs, judge) = job.read();
    let see = |reading: &Reading<'_>| look(reading, &drives.layout, &drives.driven);
    let looks =
        progress.stage("reading", || logs.iter().map(see).collect::<Result<Vec<_>, Diagnostics>>())?;
    let judging = judge
        .first()
        .map(|reading| Ok::<_, Diagnostics>((reading, progress.stage("reading", || see(reading))?)))
        .transpose()?;
    let surveys: Vec<Survey> = looks.iter().map(|look| look.survey.clone()).collect();
    let every: Vec<&Look> = looks.iter().chain(judging.iter().map(|(_, look)| look)).collect();
    let bodies = drives.bodies(robot, &logs, (&surveys, &every), progress)?;
    let parts = ElasticParts { parts: bodies.parts(), drives: &drives.driven, looks: &looks, logs: &logs };
    let judge = judging.as_ref().map(|(reading, look)| (*reading, look));
    let work = |progress: &dyn Fn(f64)| identify_elastic(&parts, judge, &options, progress);
    let answer = progress.counted("identifying", work)?;
    let (identification, links, pictures) = (answer.identification, answer.links, answer.pictures);
    let (found, pictures) = Identified::new(IdentificationResult { identification, links, pictures }, None);
    Ok((Identified { drives: Some(answer.drives), ..found }, pictures))
}
