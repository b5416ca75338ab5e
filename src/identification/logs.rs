//! From logs to what estimators work with.
use super::base_regressor;
use crate::measurements::{Content, Loaded, Log, Measured};
use crate::progress::Progress;
use crate::robot::{ProgramRegressor, joint_layout, joint_layout_with_stops, link_inertias};
use bipedc_analysis::experiments::{Channel, Experiment};
use bipedc_analysis::identify::elastic::{Driven, Look};
use bipedc_analysis::identify::{self, BaseSet, RobotAndLogs, Survey, survey};
use bipedc_analysis::measure;
use bipedc_analysis::robot::{JointLayout, LinkInertias};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::path::PathBuf;

/// A robot ready for identification.
pub struct Identifiable {
    pub layout: JointLayout,
    link_inertias: LinkInertias,
    base: BaseSet,
    regressor: ProgramRegressor,
    /// Observed rows of `v`.
    rows: Vec<usize>,
    surveys: Vec<Survey>,
    files: Vec<PathBuf>,
}

impl Identifiable {
    /// Derives the base parameters of what logs of joint torques measured.
    pub fn of_torques(
        robot: &Robot,
        logs: &[identify::Reading<'_>],
        progress: &dyn Progress,
    ) -> Result<Self, Diagnostics> {
        let layout = rigid_layout(robot)?;
        let look = || logs.iter().map(|log| survey(log, &layout)).collect::<Result<Vec<_>, Diagnostics>>();
        let surveys = progress.stage("reading", look)?;
        for (survey, reading) in surveys.iter().zip(logs) {
            all_seen(&layout, survey).map_err(|error| error.in_file(reading.log.path()))?;
        }
        let rows = observed(&layout, &surveys)?;
        Self::new(robot, files(logs), (surveys, rows), progress)
    }

    /// The same for logs of a free robot with forces at its feet: the rows of the base.
    pub fn of_contacts(
        robot: &Robot,
        logs: &[identify::Reading<'_>],
        loaded: &[Loaded<'_>],
        progress: &dyn Progress,
    ) -> Result<Self, Diagnostics> {
        let layout = joint_layout(&robot.clone().without_effects().tree()?)?;
        let measured = |row: &str| loaded.iter().all(|l| l.experiment.rows().iter().any(|r| r.name == row));
        let names: &[&str] = match layout.base.nv() {
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
        let surveys = loaded.iter().map(|l| table_survey(l, &layout)).collect();
        Self::new(robot, files(logs), (surveys, rows), progress)
    }

    fn new(
        robot: &Robot,
        files: Vec<PathBuf>,
        (surveys, rows): (Vec<Survey>, Vec<usize>),
        progress: &dyn Progress,
    ) -> Result<Self, Diagnostics> {
        let rigid = robot.clone().without_effects();
        let tree = rigid.tree()?;
        let derive = || base_regressor(&rigid.description, &tree, &rows);
        let (base, regressor) = progress.stage("deriving", derive)?;
        let link_inertias = link_inertias(&rigid.description, &tree);
        let layout = joint_layout_with_stops(&tree, &rigid.description)?;
        Ok(Self { layout, link_inertias, base, regressor, rows, surveys, files })
    }

    /// What the library wants to know.
    pub fn parts(&self) -> RobotAndLogs<'_> {
        RobotAndLogs {
            layout: &self.layout,
            link_inertias: &self.link_inertias,
            base: &self.base,
            regressor: &self.regressor,
            rows: &self.rows,
            files: &self.files,
            surveys: &self.surveys,
        }
    }
}

/// Their names.
fn files(logs: &[identify::Reading<'_>]) -> Vec<PathBuf> {
    logs.iter().map(|reading| reading.log.path().to_path_buf()).collect()
}

/// Joints and base of a robot without its effects.
pub fn rigid_layout(robot: &Robot) -> Result<JointLayout, Diagnostics> {
    let rigid = robot.clone().without_effects();
    Ok(joint_layout_with_stops(&rigid.tree()?, &rigid.description)?)
}

/// What a log with forces at the feet shows.
pub fn table_survey(loaded: &Loaded<'_>, layout: &JointLayout) -> Survey {
    Survey {
        assumptions: loaded.assumptions.clone(),
        warnings: loaded.warnings.clone(),
        ..Survey::of_table(&*loaded.experiment, layout.joints.len(), loaded.cutoff_hz)
    }
}

/// Logs with forces at the feet, in memory.
pub fn loaded<'m>(
    measured: &'m Measured,
    logs: &[&Log],
    reading: &measure::Options,
) -> Result<Vec<Loaded<'m>>, Diagnostics> {
    let mut all = Vec::new();
    for log in logs {
        let found = measured.load(log, reading, None)?;
        let acts = |channel| matches!(channel, Channel::BaseForce | Channel::BaseMoment);
        if !found.experiment.rows().iter().any(|row| acts(row.channel)) {
            return Err(Diagnostic::error("the log tells no force or moment on the base")
                .in_file(log.path())
                .help("log the motion of the base, and forces and torques at the feet")
                .into());
        }
        all.push(found);
    }
    Ok(all)
}

/// What the logs hold; all of them the same.
pub fn content(measured: &Measured, logs: &[&Log]) -> Result<Content, Diagnostic> {
    let mut kinds = Vec::new();
    for log in logs {
        let kind = measured.content(log);
        if !matches!(kind, Content::Efforts | Content::Contacts) {
            return Err(Diagnostic::error("parameters are found in logs over time, not in tables")
                .in_file(log.path())
                .help("give logs whose first column is `time`"));
        }
        kinds.push(kind);
    }
    if kinds.iter().any(|kind| *kind != kinds[0]) {
        return Err(Diagnostic::error("some logs have a moving base with forces at the feet, others do not")
            .help("give logs of one kind at a time"));
    }
    Ok(kinds[0])
}

/// Rows of `v` that at least one log measured.
fn observed(layout: &JointLayout, surveys: &[Survey]) -> Result<Vec<usize>, Diagnostic> {
    let nb = layout.base.nv();
    let joints = (0..layout.joints.len()).filter(|&j| surveys.iter().any(|s| s.effort[j]));
    let rows: Vec<usize> = joints.map(|j| nb + j).collect();
    if rows.is_empty() {
        return Err(Diagnostic::error("no log measures a torque").help("log `<joint>/effort` in N m"));
    }
    Ok(rows)
}

/// A joint whose torque was measured was there: taken to stand still at zero it would spoil what all others tell.
///
/// # Errors
/// Names the first that has an effort and no position.
fn all_seen(layout: &JointLayout, survey: &Survey) -> Result<(), Diagnostic> {
    let mut joints = layout.joints.iter().zip(survey.effort.iter().zip(&survey.unseen));
    let Some((joint, _)) = joints.find(|(_, (effort, unseen))| **effort && **unseen) else { return Ok(()) };
    let name = &joint.name;
    Err(Diagnostic::error(format!("the log has `{name}/effort` but no column `{name}/position`")).help(format!(
        "log `{name}/position` (rad), or give its column's name with --mapping; of a joint that stood still take `{name}/effort` out, or lock it in biped.toml: `[joints] locked = {{ {name} = ANGLE }}`"
    )))
}

/// Most samples that are looked at for mixed-up channels.
const SAMPLES: usize = 10_000;

/// What is odd about logs of joint torques, before anything is estimated.
pub fn inspected(measured: &Measured, logs: &[&Log], reading: &measure::Options) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for log in logs {
        // Files that cannot be read were refused before; where nothing can be held against the model nothing looks odd.
        let Ok(experiment) = measured.efforts(log, reading, SAMPLES) else { continue };
        found.extend(checked(&experiment, log));
    }
    found
}

/// What is odd about logs with forces at the feet, in the words of a diagnosis.
pub fn inspected_tables(tables: &[Loaded<'_>], logs: &[&Log]) -> Vec<Diagnostic> {
    tables.iter().zip(logs).flat_map(|(table, log)| checked(&*table.experiment, log)).collect()
}

fn checked(experiment: &dyn Experiment, log: &Log) -> Vec<Diagnostic> {
    experiment.check().into_iter().map(|diagnostic| diagnostic.in_file(log.path())).collect()
}

/// Drives of a description with series elastic ones among them.
pub struct Drives<'d> {
    pub layout: JointLayout,
    /// In the order of the joints.
    pub driven: Vec<Driven<'d>>,
}

impl<'d> Drives<'d> {
    /// Those of `biped.toml`.
    pub fn new(robot: &'d Robot) -> Result<Self, Diagnostics> {
        let layout = joint_layout(&robot.clone().without_effects().tree()?)?;
        if !robot.description.drives.iter().any(|driven| driven.drive.is_elastic()) {
            return Err(Diagnostic::error("the description has no series elastic drive")
                .help("add [drives.JOINT] tables with kind = \"series_elastic\" to biped.toml (robots/README.md), or use --method torque")
                .into());
        }
        let mut all = Vec::new();
        for (joint, named) in layout.joints.iter().enumerate() {
            let Some(drive) = robot.description.drive(&named.name) else { continue };
            let driven = Driven { joint, drive };
            driven.check(&layout)?;
            all.push(driven);
        }
        Ok(Self { layout, driven: all })
    }

    /// Base parameters of the joints whose rows every log shows.
    pub fn bodies(
        &self,
        robot: &Robot,
        logs: &[identify::Reading<'_>],
        (surveys, looks): (&[Survey], &[&Look]),
        progress: &dyn Progress,
    ) -> Result<Identifiable, Diagnostics> {
        let nb = self.layout.base.nv();
        let shown = |j: &usize| looks.iter().all(|look| look.survey.effort[*j]);
        let joints: Vec<usize> = (0..self.layout.joints.len()).filter(shown).collect();
        if !self.driven.iter().any(|d| d.drive.is_elastic() && joints.contains(&d.joint)) {
            return Err(Diagnostic::error("no series elastic drive is logged whole in every log")
                .help("log position, motor_position and motor_current of the same joints in all of them")
                .into());
        }
        let rows = joints.iter().map(|j| nb + j).collect();
        Identifiable::new(robot, files(logs), (surveys.to_vec(), rows), progress)
    }
}
