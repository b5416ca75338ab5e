//! From logs to parameters: what `identify` works with.
use crate::failure::Failure;
use crate::measurements::{Content, Loaded, Measured, subject};
use crate::output;
use bipedc_compiler::Robot;
use bipedc_compiler::identification::base_regressor;
use bipedc_compiler::program::ProgramRegressor;
use bipedc_compiler::tree::anatomy;
use bipedc_runtime::compare::Subject;
use bipedc_runtime::diagnose::{Anatomy, Channel, Experiment};
use bipedc_runtime::diagnostic::{Diagnostic, Diagnostics};
use bipedc_runtime::identify::{BaseSet, Log, Parts, Survey, survey};
use std::path::PathBuf;

/// A robot ready for identification.
pub struct Identified {
    pub subject: Subject,
    anatomy: Anatomy,
    base: BaseSet,
    regressor: ProgramRegressor,
    /// Observed rows of `v`.
    rows: Vec<usize>,
    surveys: Vec<Survey>,
    files: Vec<PathBuf>,
}

impl Identified {
    /// Derives the base parameters of what logs of joint torques measured.
    pub fn of_torques(robot: &Robot, logs: &[Log<'_>]) -> Result<Self, Failure> {
        let subject = subject(&robot.clone().without_effects().tree()?)?;
        let look = || logs.iter().map(|log| survey(log, &subject)).collect::<Result<Vec<_>, Diagnostics>>();
        let surveys = output::progress("reading", look)?;
        let rows = observed(&subject, &surveys)?;
        Self::new(robot, logs, surveys, rows)
    }

    /// The same for logs of a free robot with forces at its feet: the rows of the base.
    pub fn of_contacts(robot: &Robot, logs: &[Log<'_>], loaded: &[Loaded<'_>]) -> Result<Self, Failure> {
        let subject = subject(&robot.clone().without_effects().tree()?)?;
        let measured = |row: &str| loaded.iter().all(|l| l.experiment.rows().iter().any(|r| r.name == row));
        let names: &[&str] = match subject.base.nv() {
            6 => &["force/x", "force/y", "force/z", "moment/x", "moment/y", "moment/z"],
            _ => &["force/x", "force/z", "moment/y"],
        };
        let rows: Vec<usize> =
            (0..names.len()).filter(|&k| measured(&format!("base/{}", names[k]))).collect();
        if rows.is_empty() {
            return Err(Diagnostic::error("the logs tell no force or moment on the base")
                .help("log forces and torques at the feet, not only normal forces")
                .into());
        }
        let surveys = loaded.iter().map(|l| table_survey(l, &subject)).collect();
        Self::new(robot, logs, surveys, rows)
    }

    fn new(robot: &Robot, logs: &[Log<'_>], surveys: Vec<Survey>, rows: Vec<usize>) -> Result<Self, Failure> {
        let rigid = robot.clone().without_effects();
        let tree = rigid.tree()?;
        let derive = || base_regressor(&rigid.description, &tree, &rows);
        let (base, regressor) = output::progress("deriving", derive)?;
        let anatomy = anatomy(&rigid.description, &tree);
        let files = logs.iter().map(|log| log.path.to_path_buf()).collect();
        Ok(Self { subject: subject(&tree)?, anatomy, base, regressor, rows, surveys, files })
    }

    /// What the library wants to know.
    pub fn parts(&self) -> Parts<'_> {
        Parts {
            subject: &self.subject,
            anatomy: &self.anatomy,
            base: &self.base,
            regressor: &self.regressor,
            rows: &self.rows,
            files: &self.files,
            surveys: &self.surveys,
        }
    }
}

/// What a log with forces at the feet shows.
pub fn table_survey(loaded: &Loaded<'_>, subject: &Subject) -> Survey {
    Survey {
        assumptions: loaded.assumptions.clone(),
        warnings: loaded.warnings.clone(),
        ..Survey::of_table(&*loaded.experiment, subject.joints.len(), loaded.cutoff_hz)
    }
}

/// Logs with forces at the feet, in memory.
pub fn loaded<'m>(measured: &'m Measured, logs: &[Log<'_>]) -> Result<Vec<Loaded<'m>>, Failure> {
    let mut all = Vec::new();
    for log in logs {
        let found = measured.load(log.path, log.mapping, &log.options, None)?;
        let acts = |channel| matches!(channel, Channel::BaseForce | Channel::BaseMoment);
        if !found.experiment.rows().iter().any(|row| acts(row.channel)) {
            return Err(Diagnostic::error("the log tells no force or moment on the base")
                .in_file(log.path)
                .help("log the motion of the base, and forces and torques at the feet")
                .into());
        }
        all.push(found);
    }
    Ok(all)
}

/// What the logs hold; all of them the same.
pub fn content(measured: &Measured, logs: &[Log<'_>]) -> Result<Content, Failure> {
    let mut kinds = Vec::new();
    for log in logs {
        let kind = measured.content(log.path, log.mapping)?;
        if !matches!(kind, Content::Efforts | Content::Contacts) {
            return Err(Diagnostic::error("parameters are found in logs over time, not in tables")
                .in_file(log.path)
                .help("give logs whose first column is `time`")
                .into());
        }
        kinds.push(kind);
    }
    if kinds.iter().any(|kind| *kind != kinds[0]) {
        return Err(Diagnostic::error("some logs have a moving base with forces at the feet, others do not")
            .help("give logs of one kind at a time")
            .into());
    }
    Ok(kinds[0])
}

/// Rows of `v` that at least one log measured.
fn observed(subject: &Subject, surveys: &[Survey]) -> Result<Vec<usize>, Diagnostic> {
    let nb = subject.base.nv();
    let joints = (0..subject.joints.len()).filter(|&j| surveys.iter().any(|s| s.effort[j]));
    let rows: Vec<usize> = joints.map(|j| nb + j).collect();
    if rows.is_empty() {
        return Err(Diagnostic::error("no log measures a torque").help("log `<joint>/effort` in N m"));
    }
    Ok(rows)
}

/// Most samples that are looked at for mixed-up channels.
const SAMPLES: usize = 10_000;

/// What is odd about logs of joint torques, before anything is estimated.
pub fn inspected(measured: &Measured, logs: &[Log<'_>]) -> Result<Vec<Diagnostic>, Failure> {
    let mut found = Vec::new();
    for log in logs {
        let experiment = measured.efforts(log.path, log.mapping, &log.options, SAMPLES)?;
        found.extend(experiment.check().into_iter().map(|diagnostic| diagnostic.in_file(log.path)));
    }
    Ok(found)
}
