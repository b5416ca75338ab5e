//! `identify --method zmp`: a robot in motion, from its joint encoders and the forces of the ground (thesis 5.4.2).
use super::Identify;
use super::cop::NoRegressor;
use super::ground::{Center, Ground, GroundAnswer, Mass, mean_joints, parameters};
use crate::failure::Failure;
use crate::identifying::{Identified, loaded, table_survey};
use crate::measurements::{Content, Loaded, Measured, content, subject};
use crate::output;
use bipedc::standing::{Root, Standing};
use bipedc_analysis::experiments::{Channel, Experiment};
use bipedc_analysis::identify::cop::confounded;
use bipedc_analysis::identify::{Answer, Feed, Judge, Log, Parts, Survey, identify};
use bipedc_analysis::measure;
use bipedc_analysis::robot::LinkInertias;
use bipedc_compiler::Robot;
use bipedc_compiler::exact::Model;
use bipedc_effects::diagnostic::Diagnostic;
use std::path::PathBuf;

/// Estimates from logs; with the motion of the base the rows of the base, else those of the standing foot.
pub fn run(
    command: &Identify,
    robot: &Robot,
    logs: &[Log<'_>],
    judge: &[Log<'_>],
) -> Result<(Answer, GroundAnswer), Failure> {
    let joints = subject(&robot.clone().without_effects().tree()?)?;
    let mut with_base = 0;
    for log in logs.iter().chain(judge) {
        match content(&joints, log.path, log.mapping)? {
            Content::Contacts => with_base += 1,
            Content::Efforts => {}
            Content::Postures | Content::Impacts => {
                return Err(Diagnostic::error("--method zmp needs logs over time, not a table")
                    .in_file(log.path)
                    .help("postures at rest: --method cop")
                    .into());
            }
        }
    }
    if with_base == 0 {
        return standing(command, robot, logs, judge);
    }
    if with_base < logs.len() + judge.len() {
        return Err(Diagnostic::error("some logs have the motion of the base, others do not")
            .help("give logs of one kind at a time")
            .into());
    }
    let own = output::progress("deriving", || Measured::new(robot))?;
    let tables = output::progress("reading", || loaded(&own, logs))?;
    let judges = output::progress("reading", || loaded(&own, judge))?;
    let found = Identified::of_contacts(robot, logs, &tables)?;
    let torso = own.root_link(robot);
    estimate(command, (&found.parts(), &own, torso, None), &tables, (&judges, judge))
}

/// The robot stands on a foot that does not move.
fn standing(
    command: &Identify,
    robot: &Robot,
    logs: &[Log<'_>],
    judge: &[Log<'_>],
) -> Result<(Answer, GroundAnswer), Failure> {
    let standing = Standing::new(robot, command.stance.as_deref(), Root::Sole)?;
    let measured = output::progress("deriving", || Measured::new(&standing.robot))?;
    let read = |logs: &[Log<'_>]| {
        let one = |log: &Log<'_>| measured.contacts(log.path, log.mapping, &log.options);
        output::progress("reading", || logs.iter().map(one).collect::<Result<Vec<_>, _>>())
    };
    let (tables, judges) = (read(logs)?, read(judge)?);
    let rows = common_rows(&tables);
    let base = output::progress("deriving", || standing.base(Model::ZeroMomentPoint, &rows, false))?;
    let surveys: Vec<Survey> = tables.iter().map(|table| table_survey(table, &measured.subject)).collect();
    let files: Vec<PathBuf> = logs.iter().map(|log| log.path.to_path_buf()).collect();
    let parts = Parts {
        subject: &measured.subject,
        link_inertias: &standing.link_inertias,
        base: &base,
        regressor: &NoRegressor,
        rows: &[],
        files: &files,
        surveys: &surveys,
    };
    let stance = Some(standing.stance.clone());
    estimate(command, (&parts, &measured, standing.torso.clone(), stance), &tables, (&judges, judge))
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
    command: &Identify,
    (parts, measured, torso, stance): (&Parts<'_>, &Measured, String, Option<String>),
    tables: &[Loaded<'_>],
    (judges, judge_logs): (&[Loaded<'_>], &[Log<'_>]),
) -> Result<(Answer, GroundAnswer), Failure> {
    let experiments: Vec<&dyn Experiment> = tables.iter().map(|table| &*table.experiment).collect();
    let judging: Vec<&dyn Experiment> = judges.iter().map(|table| &*table.experiment).collect();
    let surveys: Vec<Survey> = judges.iter().map(|table| table_survey(table, parts.subject)).collect();
    let judge = judge_logs.first().zip(surveys.first()).map(|(log, survey)| Judge {
        feed: Feed::Tables(&judging),
        survey,
        file: log.path,
    });
    let options = command.estimation()?;
    let feed = Feed::Tables(&experiments);
    let work = |progress: &dyn Fn(f64)| identify(parts, &feed, judge.as_ref(), &options, progress);
    let answer = output::bar("identifying", work)?;
    let first = experiments.first().copied();
    let ground =
        first.map(|experiment| ground(experiment, &answer, (parts.link_inertias, measured), torso, stance));
    let ground = ground.ok_or_else(|| Diagnostic::error("no log was given"))?;
    let whole = GroundAnswer { identification: answer.identification.clone(), ground };
    Ok((answer, whole))
}

fn ground(
    experiment: &dyn Experiment,
    answer: &Answer,
    (link_inertias, measured): (&LinkInertias, &Measured),
    torso: String,
    stance: Option<String>,
) -> Ground {
    let nominal = link_inertias.parameters();
    let physical = parameters(link_inertias, &answer.links);
    let joints = mean_joints(experiment, measured.subject.joints.len());
    let described: f64 = nominal.iter().step_by(10).sum();
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

/// How logs are read: the filter and the times.
pub fn reading(command: &Identify) -> measure::Options {
    measure::Options {
        cutoff_hz: Some(command.cutoff),
        trim_s: command.trim,
        from_s: command.from,
        to_s: command.to,
        ..measure::Options::default()
    }
}
