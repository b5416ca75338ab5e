//! From logs to parameters: what `identify` works with.
use crate::failure::Failure;
use crate::measurements::{Content, Measured, subject};
use crate::output;
use bipedc_compiler::Robot;
use bipedc_compiler::identification::base_regressor;
use bipedc_compiler::program::ProgramRegressor;
use bipedc_compiler::tree::anatomy;
use bipedc_runtime::compare::Subject;
use bipedc_runtime::diagnose::{Anatomy, Experiment};
use bipedc_runtime::diagnostic::{Diagnostic, Diagnostics};
use bipedc_runtime::identify::{BaseSet, Log, Survey, survey};

/// A robot ready for identification.
pub struct Identified {
    pub subject: Subject,
    pub anatomy: Anatomy,
    pub base: BaseSet,
    pub regressor: ProgramRegressor,
    /// Observed rows of `v`.
    pub rows: Vec<usize>,
    /// What each log shows.
    pub surveys: Vec<Survey>,
}

impl Identified {
    /// Looks at all logs and derives the base parameters of what they measured.
    pub fn new(robot: &Robot, logs: &[Log<'_>]) -> Result<Self, Failure> {
        let rigid = robot.clone().without_effects();
        let tree = rigid.tree()?;
        let subject = subject(&tree)?;
        let look = || logs.iter().map(|log| survey(log, &subject)).collect::<Result<Vec<_>, Diagnostics>>();
        let surveys = output::progress("reading", look)?;
        let rows = observed(&subject, &surveys)?;
        let derive = || base_regressor(&rigid.description, &tree, &rows);
        let (base, regressor) = output::progress("deriving", derive)?;
        let anatomy = anatomy(&rigid.description, &tree);
        Ok(Self { subject, anatomy, base, regressor, rows, surveys })
    }
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

/// What is odd about the logs, before anything is estimated.
pub fn inspected(robot: &Robot, logs: &[Log<'_>]) -> Result<Vec<Diagnostic>, Failure> {
    let measured = Measured::new(robot)?;
    let mut found = Vec::new();
    for log in logs {
        let content = measured.content(log.path, log.mapping)?;
        if content == Content::Contacts {
            let message = "the base moves and feet touch the ground: their forces act on the joints too";
            let help = "give logs of a robot that hangs or is held, or leave the feet's columns out if they never touched";
            found.push(Diagnostic::error(message).in_file(log.path).help(help));
        }
        if content == Content::Efforts {
            let experiment = measured.efforts(log.path, log.mapping, &log.options, SAMPLES)?;
            found.extend(experiment.check().into_iter().map(|diagnostic| diagnostic.in_file(log.path)));
        }
    }
    Ok(found)
}
