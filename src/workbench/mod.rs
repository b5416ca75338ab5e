//! A robot on the bench: compared with logs, diagnosed, amended, identified, simulated, filmed.
mod closed_loop;
mod cycles;
mod explaining;
mod identified;
mod lack;
mod library;
mod optimised;
mod optimised_text;
mod reach;
mod rounds;
mod search;
mod wished;

pub use closed_loop::{ClosedLoop, PhaseCourse, PhaseCourses};
pub use explaining::{Event, Explained};
pub use library::{gait_file, may_be_replaced, search_file};
pub use optimised::{OptimiseOptions, OptimisedGait, OptimisedGaits};
pub use reach::Reach;
pub use search::Beginning;
pub use wished::Wished;

use crate::amendment::diagnosis::{Selection, propose};
use crate::amendment::history::History;
use crate::amendment::{self, Amended, Proposal, Undone};
use crate::comparison::{self, Compared};
use crate::diagnosis::{self, Diagnosed, Inertial};
use crate::excitation::{
    self, DesignedMotion, PostureOptions, PostureSet, SeparateOptions, SeparatingMotion,
};
use crate::gait::{AnyBench, ChainOptions, ChainStep, GaitBench, PhasedBench};
use crate::identification::{self, Identified};
use crate::inventory::{self, Inventory};
use crate::measurements::Log;
use crate::progress::{Progress, Run, Silent};
use crate::report::steps_of;
use crate::simulation::{self, Scene, Simulated};
use bipedc_analysis::diagnose::{Diagnosis, Stated};
use bipedc_analysis::log::Mapping;
use bipedc_analysis::log::names::JOINT_QUANTITIES;
use bipedc_analysis::report::Report;
use bipedc_analysis::simulate::phases::PhaseSpec;
use bipedc_compiler::Robot;
use bipedc_compiler::description::SourceFiles;
use bipedc_compiler::description::gait::gait_path;
use bipedc_compiler::description::model::Base;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::Effect;
use bipedc_effects::files::Ledger;
use bipedc_runtime::control::Controller;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A robot as its description says, with the effects that it has, ready for everything that logs and scenarios can tell of it.
///
/// ```no_run
/// # fn main() -> Result<(), bipedc::Diagnostics> {
/// let robot = bipedc::Workbench::open("robots/tulip")?;
/// let train = robot.log("train.csv.gz")?;
/// let judge = robot.log("validation.csv.gz")?;
/// println!("{}", robot.compare(&judge)?);
/// let diagnosis = robot.diagnose(&train, Some(&judge))?;
/// println!("{diagnosis}");
/// println!("{}", robot.amended(&diagnosis)?.compare(&judge)?);
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct Workbench {
    robot: Robot,
    path: PathBuf,
    base: BaseChoice,
    progress: Arc<dyn Progress>,
    stop: Arc<dyn Fn() -> bool + Send + Sync>,
}

/// What logs may say of joints that the description holds (fixed or locked ones): they have no place in the model.
fn held_columns(robot: &Robot) -> impl Iterator<Item = String> {
    let held = robot.description.joints.iter().filter(|joint| !joint.kind.moves());
    held.flat_map(|joint| JOINT_QUANTITIES.map(|quantity| format!("{}/{quantity}", joint.name)))
}

/// Joints whose encoder is the motor's, with the motor's turns per turn of the joint.
fn motor_encoders(robot: &Robot) -> BTreeMap<String, f64> {
    let description = &robot.description;
    let turns = |joint: &String| {
        let driven = description.drives.iter().find(|driven| driven.joint == *joint);
        (joint.clone(), driven.map_or(1.0, |driven| driven.drive.turns()))
    };
    description.motor_encoders.iter().map(turns).collect()
}

/// How the robot hangs in the world, instead of what its description says.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BaseChoice {
    /// `floating`, `planar`, `fixed` or `pivot`.
    pub kind: Option<String>,
    /// Link or contact point (FOOT/POINT; for a pivot also FOOT/EDGE) that carries the base coordinates.
    pub root: Option<String>,
}

impl BaseChoice {
    fn apply(&self, robot: Robot) -> Result<Robot, Diagnostic> {
        if *self == Self::default() {
            return Ok(robot);
        }
        let present = match robot.description.base {
            Base::Floating { .. } => "floating",
            Base::Planar { .. } => "planar",
            Base::Fixed { .. } => "fixed",
            Base::Pivot { .. } => "pivot",
        };
        let robot = robot.with_base(self.kind.as_deref().unwrap_or(present), self.root.as_deref())?;
        // Whether the root exists shows only when the tree is built.
        robot.tree()?;
        Ok(robot)
    }
}

impl Workbench {
    /// Reads a robot: a folder with `robot.urdf` and `biped.toml`, or one of these files.
    ///
    /// # Errors
    /// Everything in the files that has no meaning, with line and column.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Diagnostics> {
        Self::open_on(path, BaseChoice::default())
    }

    /// The same on another base.
    ///
    /// # Errors
    /// As [`Workbench::open`]; a base or root that does not exist.
    pub fn open_on(path: impl AsRef<Path>, base: BaseChoice) -> Result<Self, Diagnostics> {
        let path = path.as_ref().to_path_buf();
        let robot = base.apply(Robot::read(&path)?)?;
        Ok(Self { robot, path, base, progress: Arc::new(Silent), stop: Arc::new(|| false) })
    }

    /// With somebody who is told how far things are.
    #[must_use]
    pub fn watched(self, progress: Arc<dyn Progress>) -> Self {
        Self { progress, ..self }
    }

    /// With a flag that ends simulations and searches when it is set; what was found so far is kept.
    #[must_use]
    pub fn stopped_by(self, flag: Arc<AtomicBool>) -> Self {
        self.stopped_when(move || flag.load(Ordering::Relaxed))
    }

    /// The same by a question, which is asked from where an early end begins to make sense.
    #[must_use]
    pub fn stopped_when(self, stop: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self { stop: Arc::new(stop), ..self }
    }

    /// The robot, with what is odd about its description.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The robot alone.
    pub fn into_robot(self) -> Robot {
        self.robot
    }

    /// Where it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The files that it was read from, which no output may overwrite.
    pub fn ledger(&self) -> Ledger {
        let mut ledger = Ledger::default();
        self.robot.note(&mut ledger);
        ledger.reads("the description's history", &History::path(&self.robot.sources.toml_path));
        ledger
    }

    /// Opens a log, or a table of postures or impacts, whose columns have our names (`docs/logs.md`).
    ///
    /// # Errors
    /// As [`Log::open`].
    pub fn log(&self, path: impl AsRef<Path>) -> Result<Log, Diagnostics> {
        self.log_with(path, Mapping::default())
    }

    /// Opens one whose columns have other names, factors or signs.
    ///
    /// # Errors
    /// As [`Log::with_mapping`].
    pub fn log_with(&self, path: impl AsRef<Path>, mapping: Mapping) -> Result<Log, Diagnostics> {
        let ignored = held_columns(&self.robot).chain(mapping.ignored).collect();
        let motor_encoders = motor_encoders(&self.robot);
        Log::with_mapping(path, Mapping { ignored, motor_encoders, ..mapping })
    }

    /// What a file holds, also one whose columns have names that are not ours; `docs/logs.md` explains all columns.
    ///
    /// # Errors
    /// As [`inventory::examine()`].
    pub fn inventory(&self, path: impl AsRef<Path>, mapping: &Mapping) -> Result<Inventory, Diagnostics> {
        let mapping = Mapping { motor_encoders: motor_encoders(&self.robot), ..mapping.clone() };
        inventory::examine(path, &mapping, Some(&inventory::Robot::of(&self.robot)?))
    }

    /// What the model predicts against what was logged, row by row: rms, largest error, noise.
    ///
    /// # Errors
    /// As [`comparison::compare()`].
    pub fn compare(&self, log: &Log) -> Result<Compared, Diagnostics> {
        self.compare_with(log, &comparison::Options::default())
    }

    /// The same as asked.
    ///
    /// # Errors
    /// As [`comparison::compare()`].
    pub fn compare_with(&self, log: &Log, options: &comparison::Options) -> Result<Compared, Diagnostics> {
        let mut compared = comparison::compare(&self.robot, log, options, &*self.progress)?;
        compared.report = compared.report.map(|report| self.with_history(report));
        Ok(compared)
    }

    /// Which effects the description lacks, where, how large, how sure. `judge` is a log of another motion; without it blocks of
    /// `train` judge.
    ///
    /// # Errors
    /// As [`diagnosis::diagnose()`].
    pub fn diagnose(&self, train: &Log, judge: Option<&Log>) -> Result<Diagnosed, Diagnostics> {
        self.diagnose_with(train, judge, &diagnosis::Options::default())
    }

    /// The same as asked.
    ///
    /// # Errors
    /// As [`diagnosis::diagnose()`].
    pub fn diagnose_with(
        &self,
        train: &Log,
        judge: Option<&Log>,
        options: &diagnosis::Options,
    ) -> Result<Diagnosed, Diagnostics> {
        let mut found = diagnosis::diagnose(&self.robot, (train, judge), options, &*self.progress)?;
        found.report = found.report.map(|report| self.with_history(report));
        Ok(found)
    }

    /// The parameters of given effects; those that stand in an effect are kept, missing ones are estimated. Effects of these
    /// kinds at these places that the description has do not stand meanwhile.
    ///
    /// # Errors
    /// As [`diagnosis::estimate()`].
    pub fn estimate(
        &self,
        effects: &[Effect],
        train: &Log,
        judge: Option<&Log>,
    ) -> Result<Diagnosed, Diagnostics> {
        let mut robot = self.robot.clone();
        // An effect that is estimated anew does not stand meanwhile.
        robot.description.effects.retain(|present| {
            !effects.iter().any(|e| e.kind == present.kind && e.location == present.location)
        });
        // What is not asked for does not change: neither do masses and inertias.
        let options = diagnosis::Options { inertial: Inertial::Known, ..diagnosis::Options::default() };
        diagnosis::estimate(&robot, (effects, Stated::Held), (train, judge), &options, &*self.progress)
    }

    /// The robot with what a diagnosis found, in memory: no file changes.
    ///
    /// # Errors
    /// Effects that the description cannot hold.
    pub fn amended(&self, diagnosis: &Diagnosis) -> Result<Self, Diagnostics> {
        let proposal = propose(diagnosis, &Selection::default(), "diagnosis")?;
        if proposal.effects.is_empty() {
            return Ok(self.clone());
        }
        self.with(&proposal)
    }

    /// The robot with a proposal, in memory.
    fn with(&self, proposal: &Proposal) -> Result<Self, Diagnostics> {
        let amended = amendment::amend_in_memory(&self.robot.sources, proposal)?;
        let sources = SourceFiles { toml_text: amended.after, ..self.robot.sources.clone() };
        let (description, warnings) = sources.parse()?;
        let robot = self.base.apply(Robot { description, warnings, sources })?;
        Ok(Self { robot, ..self.clone() })
    }

    /// Writes what a diagnosis found into `biped.toml`, with a step of the history beside it (as `bipedc amend --from`), and
    /// reads the robot again.
    ///
    /// # Errors
    /// No `biped.toml` that could be amended, effects that it cannot hold, files that cannot be written: then nothing was changed.
    pub fn amend(&self, diagnosis: &Diagnosis) -> Result<Self, Diagnostics> {
        let proposal = propose(diagnosis, &Selection::default(), "diagnosis")?;
        if !proposal.effects.is_empty() {
            self.amend_with(&proposal, false)?;
        }
        self.reopened()
    }

    /// Writes a proposal into `biped.toml`; with `dry_run` only says what would change.
    ///
    /// # Errors
    /// As [`Workbench::amend`].
    pub fn amend_with(&self, proposal: &Proposal, dry_run: bool) -> Result<Amended, Diagnostics> {
        amendment::amend(&self.path, proposal, dry_run)
    }

    /// Takes the last step of the history back, byte for byte; with `force` also where the description was edited since.
    ///
    /// # Errors
    /// As [`amendment::undo()`].
    pub fn undo(&self, force: bool) -> Result<Undone, Diagnostic> {
        amendment::undo(&self.path, force)
    }

    /// What was done to the description so far.
    ///
    /// # Errors
    /// No description that could have one; a damaged history.
    pub fn history(&self) -> Result<History, Diagnostic> {
        amendment::open(&self.path).map(|(_, _, history)| history)
    }

    /// Reads the same files again.
    ///
    /// # Errors
    /// As [`Workbench::open_on`].
    pub fn reopened(&self) -> Result<Self, Diagnostics> {
        let robot = self.base.apply(Robot::read(&self.path)?)?;
        Ok(Self { robot, ..self.clone() })
    }

    /// Masses, centres of mass, inertias and friction from joint torques, with error bars; `judge` is a log of another motion, that
    /// only judges.
    ///
    /// # Errors
    /// As [`identification::identify()`].
    pub fn identify(&self, logs: &[&Log], judge: Option<&Log>) -> Result<Identified, Diagnostics> {
        self.identify_with(logs, judge, &identification::Options::default())
    }

    /// The same as asked.
    ///
    /// # Errors
    /// As [`identification::identify()`].
    pub fn identify_with(
        &self,
        logs: &[&Log],
        judge: Option<&Log>,
        options: &identification::Options,
    ) -> Result<Identified, Diagnostics> {
        identification::identify(&self.robot, logs, judge, options, &*self.progress)
    }

    /// The robot in the world of a scenario.
    ///
    /// # Errors
    /// As [`Scene::open`].
    pub fn scene(&self, scenario: impl AsRef<Path>) -> Result<Scene, Diagnostics> {
        Scene::open(&self.robot, scenario.as_ref())
    }

    /// Runs a scenario and writes the log that the robot's sensors would write.
    ///
    /// # Errors
    /// As [`Scene::simulate`].
    pub fn simulate(
        &self,
        scene: &Scene,
        out: impl AsRef<Path>,
        options: &simulation::Options,
    ) -> Result<Simulated, Diagnostics> {
        scene.simulate(out.as_ref(), options, &self.run())
    }

    /// The same under a controller of one's own, as it would run on the robot.
    ///
    /// # Errors
    /// As [`Scene::simulate_with`].
    pub fn simulate_with(
        &self,
        scene: &Scene,
        controller: &mut dyn Controller<f64>,
        out: impl AsRef<Path>,
        options: &simulation::Options,
    ) -> Result<Simulated, Diagnostics> {
        scene.simulate_with(controller, out.as_ref(), options, &self.run())
    }

    /// One of the robot's gaits: by its name in `gaits/` beside the description, or a file.
    ///
    /// # Errors
    /// As [`GaitBench::open`].
    pub fn gait(&self, name: &str) -> Result<GaitBench, Diagnostics> {
        GaitBench::open(&self.robot, name, &*self.progress)
    }

    /// The file of one of the robot's gaits, named as there.
    ///
    /// # Errors
    /// There is no such gait.
    pub fn gait_file(&self, name: &str) -> Result<PathBuf, Diagnostics> {
        Ok(gait_path(&self.robot.sources, name)?)
    }

    /// The same of a gait with any number of phases.
    ///
    /// # Errors
    /// As [`AnyBench::open`].
    pub fn any_gait(&self, name: &str) -> Result<AnyBench, Diagnostics> {
        AnyBench::open(&self.robot, name, &*self.progress)
    }

    /// A step of a gait of several phases on its zero dynamics.
    ///
    /// # Errors
    /// As [`PhasedBench::step`]; phases that cannot be derived.
    pub fn chained_step(&self, gait: &PhasedBench, options: &ChainOptions) -> Result<ChainStep, Diagnostics> {
        gait.step(&self.phases()?, options)
    }

    /// The phases of the robot with their endings, which steps of several phases need.
    ///
    /// # Errors
    /// Phases that cannot be derived.
    pub fn phases(&self) -> Result<Vec<PhaseSpec>, Diagnostics> {
        Ok(self.progress.stage("deriving", || simulation::walker(&self.robot))?.phases)
    }

    /// Designs a motion from which parameters are told well, and writes it.
    ///
    /// # Errors
    /// As [`excitation::design_motion`].
    pub fn design_motion(
        &self,
        options: &excitation::Options,
        out: impl AsRef<Path>,
    ) -> Result<DesignedMotion, Diagnostics> {
        excitation::design_motion(&self.robot, options, out.as_ref(), &self.run())
    }

    /// Designs the motion that best tells two effects apart, and writes it.
    ///
    /// # Errors
    /// As [`excitation::separate_effects`].
    pub fn separate_effects(
        &self,
        options: &excitation::Options,
        asked: &SeparateOptions,
        out: impl AsRef<Path>,
    ) -> Result<SeparatingMotion, Diagnostics> {
        excitation::separate_effects(&self.robot, (options, asked), out.as_ref(), &self.run())
    }

    /// Designs static postures for force plates, and writes them.
    ///
    /// # Errors
    /// As [`excitation::design_postures`].
    pub fn design_postures(
        &self,
        options: &PostureOptions,
        out: impl AsRef<Path>,
    ) -> Result<PostureSet, Diagnostics> {
        excitation::design_postures(&self.robot, options, out.as_ref(), &self.run())
    }

    /// Who watches, and who may end what takes long.
    pub fn run(&self) -> Run<'_> {
        Run { progress: &*self.progress, stop: &*self.stop }
    }

    fn with_history(&self, report: Report) -> Report {
        Report { history: steps_of(&self.path), ..report }
    }
}
