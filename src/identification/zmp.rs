//! A robot in motion, from its joint encoders and the forces of the ground (thesis 5.4.2).
use super::cop::NoRegressor;
use super::ground::{Center, Ground, Mass, mean_joints, parameters};
use super::logs::{Identifiable, inspected_tables, loaded, table_survey};
use super::standing::{Root, StandingRobot};
use super::{Identified, Job};
use crate::measurements::{Content, Loaded, Log, Measured};
use crate::robot::joint_layout;
use bipedc_analysis::experiments::{Channel, Experiment};
use bipedc_analysis::identify::cop::confounded;
use bipedc_analysis::identify::{Feed, IdentificationResult, Judge, RobotAndLogs, Survey, identify};
use bipedc_analysis::measure;
use bipedc_analysis::report::Row;
use bipedc_analysis::robot::LinkInertias;
use bipedc_compiler::exact::Model;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::path::PathBuf;

/// Estimates from logs; with the motion of the base the rows of the base, else those of the standing foot.
pub fn run(job: &mut Job<'_>) -> Result<(Identified, Vec<Row>), Diagnostics> {
    let Job { robot, progress, .. } = *job;
    let joints = joint_layout(&robot.clone().without_effects().tree()?)?;
    let mut with_base = 0;
    for log in job.logs.iter().copied().chain(job.judge) {
        match log.content(&joints) {
            Content::Contacts => with_base += 1,
            Content::Efforts => {}
            Content::Postures | Content::Impacts => {
                return Err(Diagnostic::error("--method zmp needs logs over time, not a table")
                    .in_file(log.path())
                    .help("postures at rest: --method cop")
                    .into());
            }
        }
    }
    if with_base == 0 {
        return standing(job);
    }
    if with_base < job.logs.len() + job.judge.iter().len() {
        return Err(Diagnostic::error("some logs have the motion of the base, others do not")
            .help("give logs of one kind at a time")
            .into());
    }
    let own = progress.stage("deriving", || Measured::new(robot))?;
    let (reading, whole) = readings(job);
    let tables = progress.stage("reading", || loaded(&own, job.logs, &reading))?;
    let judges = progress.stage("reading", || loaded(&own, job.judge.as_slice(), &whole))?;
    let found = Identifiable::of_contacts(robot, &job.read().0, &tables, progress)?;
    let torso = own.root_link(robot);
    estimate(job, (&found.parts(), &own, torso, None), &tables, &judges)
}

/// How the logs that teach are read, and the one that judges.
fn readings(job: &Job<'_>) -> (measure::Options, measure::Options) {
    let reading = job.options.reading.clone();
    (reading.clone(), measure::Options { from_s: None, to_s: None, ..reading })
}

/// The robot stands on a foot that does not move.
fn standing(job: &mut Job<'_>) -> Result<(Identified, Vec<Row>), Diagnostics> {
    let progress = job.progress;
    let standing = StandingRobot::new(job.robot, job.options.stance.as_deref(), Root::Sole)?;
    let measured = progress.stage("deriving", || Measured::new(&standing.robot))?;
    let (reading, whole) = readings(job);
    let read = |logs: &[&Log], reading: &measure::Options| {
        let one = |log: &&Log| measured.contacts(log, reading);
        progress.stage("reading", || logs.iter().map(one).collect::<Result<Vec<_>, _>>())
    };
    let (tables, judges) = (read(job.logs, &reading)?, read(job.judge.as_slice(), &whole)?);
    let rows = common_rows(&tables);
    let base = progress.stage("deriving", || standing.base(Model::ZeroMomentPoint, &rows, false))?;
    let surveys: Vec<Survey> = tables.iter().map(|table| table_survey(table, &measured.layout)).collect();
    let files: Vec<PathBuf> = job.logs.iter().map(|log| log.path().to_path_buf()).collect();
    let parts = RobotAndLogs {
        layout: &measured.layout,
        link_inertias: &standing.link_inertias,
        base: &base,
        regressor: &NoRegressor,
        rows: &[],
        files: &files,
        surveys: &surveys,
    };
    let stance = Some(standing.stance.clone());
    estimate(job, (&parts, &measured, standing.torso.clone(), stance), &tables, &judges)
}

/// Rows of the wrench that every log has, in the words of the exact model.
fn common_rows(tables: &[Loaded<'_>]) -> Vec<&'static str> {
    let names = [
        ("base/force/x", "Fx"),
        ("base/force/y", "Fy"),
        ("base/force/z", "Fz"),
        ("base/moment/x", "Mx"),
        ("base/moment/y", "My"),
        ("base/moment/z", "Mz"),
    ];
    let has = |name: &str| tables.iter().all(|t| t.experiment.rows().iter().any(|row| row.name == name));
    names.into_iter().filter(|(name, _)| has(name)).map(|(_, row)| row).collect()
}

fn estimate(
    job: &mut Job<'_>,
    (parts, measured, torso, stance): (&RobotAndLogs<'_>, &Measured, String, Option<String>),
    tables: &[Loaded<'_>],
    judges: &[Loaded<'_>],
) -> Result<(Identified, Vec<Row>), Diagnostics> {
    job.pass(inspected_tables(tables, job.logs))?;
    let experiments: Vec<&dyn Experiment> = tables.iter().map(|table| &*table.experiment).collect();
    let judging: Vec<&dyn Experiment> = judges.iter().map(|table| &*table.experiment).collect();
    let surveys: Vec<Survey> = judges.iter().map(|table| table_survey(table, parts.layout)).collect();
    let judge = job.judge.zip(surveys.first()).map(|(log, survey)| Judge {
        feed: Feed::Tables(&judging),
        survey,
        file: log.path(),
    });
    let options = job.options.estimation()?;
    let feed = Feed::Tables(&experiments);
    let work = |progress: &dyn Fn(f64)| identify(parts, &feed, judge.as_ref(), &options, progress);
    let answer = job.progress.counted("identifying", work)?;
    let first = experiments.first().copied();
    let ground =
        first.map(|experiment| ground(experiment, &answer, (parts.link_inertias, measured), torso, stance));
    let ground = ground.ok_or_else(|| Diagnostic::error("no log was given"))?;
    Ok(Identified::new(answer, Some(ground)))
}

fn ground(
    experiment: &dyn Experiment,
    answer: &IdentificationResult,
    (link_inertias, measured): (&LinkInertias, &Measured),
    torso: String,
    stance: Option<String>,
) -> Ground {
    let nominal = link_inertias.parameters();
    let physical = parameters(link_inertias, &answer.links);
    let joints = mean_joints(experiment, measured.layout.joints.len());
    let described: f64 = nominal.mass();
    // The only base parameter in kg that the vertical force tells is the whole mass.
    let total = answer.identification.parameters.iter().find(|p| p.unit == "kg");
    let mass = match total {
        Some(p) => Mass {
            value: p.value,
            standard_error: Some(p.standard_error),
            described,
            source: "vertical force",
        },
        None => Mass { value: described, standard_error: None, described, source: "the description" },
    };
    Ground {
        stance,
        mass,
        center_of_mass: Center::new(measured, &joints, &nominal, &physical),
        models: Vec::new(),
        in_metres: Vec::new(),
        confounded: confounded(experiment, &[Channel::BaseForce, Channel::BaseMoment], &torso),
    }
}
