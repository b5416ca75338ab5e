//! Gaits of several phases: a gait file compiled, and its controller in process.
use super::{Assignment, ChainOptions, Parametrised, replaced};
use crate::progress::Progress;
use bipedc_compiler::Robot;
pub use bipedc_compiler::compile::PhasedProgramController;
use bipedc_compiler::compile::{CompiledPhases, PhasePrograms, compile_phases};
use bipedc_compiler::description::gait::{
    AnyGait, GaitParameter, PhasedGait, gait_path, parse_any_gait, read_any_gait,
};
use bipedc_compiler::robot::fnv1a;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::files::Ledger;
use bipedc_runtime::control::{Feedback, PhasedController, Refusal};
use std::path::{Path, PathBuf};

/// A robot with a gait of several phases.
#[derive(Debug, Clone)]
pub struct PhasedBench {
    /// As the file says.
    pub gait: PhasedGait,
    /// What is odd about the file.
    pub warnings: Vec<Diagnostic>,
    pub(super) file: PathBuf,
    pub(super) compiled: CompiledPhases,
}

/// A robot with one of its gaits, of one phase or of several.
#[derive(Debug, Clone)]
pub enum AnyBench {
    /// A step is one phase on one point.
    OnePhase(Box<super::GaitBench>),
    /// A step is a sequence of phases.
    Phased(Box<PhasedBench>),
}

impl AnyBench {
    /// Reads a gait of a robot, by its name in `gaits/` or by a path, and derives what its controller needs.
    ///
    /// # Errors
    /// No such gait; everything in the file that has no meaning, with line and column; functions that cannot be derived.
    pub fn open(robot: &Robot, name: &str, progress: &dyn Progress) -> Result<Self, Diagnostics> {
        let file = gait_path(&robot.sources, name)?;
        let read = read_any_gait(&file, &robot.sources, &robot.description)?;
        Self::derived(robot, file, read, progress)
    }

    /// The same from a text; `file` gives the gait's name and serves messages.
    ///
    /// # Errors
    /// As [`AnyBench::open`].
    pub fn parse(
        robot: &Robot,
        file: &Path,
        text: &str,
        progress: &dyn Progress,
    ) -> Result<Self, Diagnostics> {
        let read = parse_any_gait(file, text, &robot.sources, &robot.description)?;
        Self::derived(robot, file.to_path_buf(), read, progress)
    }

    fn derived(
        robot: &Robot,
        file: PathBuf,
        (gait, warnings): (AnyGait, Vec<Diagnostic>),
        progress: &dyn Progress,
    ) -> Result<Self, Diagnostics> {
        match gait {
            AnyGait::OnePhase(gait) => super::GaitBench::derived(robot, file, (*gait, warnings), progress)
                .map(Box::new)
                .map(Self::OnePhase),
            AnyGait::Phased(gait) => {
                PhasedBench::derived(robot, file, (gait, warnings), progress).map(Box::new).map(Self::Phased)
            }
        }
    }
}

impl AnyBench {
    /// What is odd about the file.
    pub fn warnings(&self) -> &[Diagnostic] {
        match self {
            Self::OnePhase(bench) => &bench.warnings,
            Self::Phased(bench) => &bench.warnings,
        }
    }

    /// Notes the gait's file, which no output may overwrite.
    pub fn note(&self, ledger: &mut Ledger) {
        match self {
            Self::OnePhase(bench) => bench.note(ledger),
            Self::Phased(bench) => bench.note(ledger),
        }
    }
}

impl PhasedBench {
    /// As [`AnyBench::open`], of a gait that has several phases.
    ///
    /// # Errors
    /// As there; the gait has one phase.
    pub fn open(robot: &Robot, name: &str, progress: &dyn Progress) -> Result<Self, Diagnostics> {
        match AnyBench::open(robot, name, progress)? {
            AnyBench::Phased(bench) => Ok(*bench),
            AnyBench::OnePhase(bench) => Err(one_phase(&bench.file)),
        }
    }

    /// The same from a text; `file` gives the gait's name and serves messages.
    ///
    /// # Errors
    /// As [`PhasedBench::open`].
    pub fn parse(
        robot: &Robot,
        file: &Path,
        text: &str,
        progress: &dyn Progress,
    ) -> Result<Self, Diagnostics> {
        match AnyBench::parse(robot, file, text, progress)? {
            AnyBench::Phased(bench) => Ok(*bench),
            AnyBench::OnePhase(bench) => Err(one_phase(&bench.file)),
        }
    }

    fn derived(
        robot: &Robot,
        file: PathBuf,
        (gait, warnings): (PhasedGait, Vec<Diagnostic>),
        progress: &dyn Progress,
    ) -> Result<Self, Diagnostics> {
        let compiled = progress
            .stage("deriving", || compile_phases(&robot.description, &gait))
            .map_err(|error| error.or_in_file(&file))?;
        Ok(Self { gait, warnings, file, compiled })
    }

    /// Notes the gait's file, which no output may overwrite.
    pub fn note(&self, ledger: &mut Ledger) {
        ledger.reads("the gait", &self.file);
    }

    /// The programs.
    pub fn compiled(&self) -> &CompiledPhases {
        &self.compiled
    }

    /// The gait's controller (6.28) with these parameters instead of the gait's own and with another feedback, if there is one; no phase
    /// has begun.
    ///
    /// # Errors
    /// Parameters that the gait does not have, numbers that are none.
    pub fn controller(
        &self,
        feedback: Option<Feedback<f64>>,
        set: &[Assignment],
    ) -> Result<PhasedProgramController, Diagnostics> {
        let values = self.values(set)?;
        let programs = PhasePrograms::new(&self.compiled, &self.gait)
            .map_err(|error| Diagnostics(vec![error.or_in_file(&self.file)]))?;
        let controller = PhasedController::new(programs);
        let mut controller = match feedback {
            Some(feedback) => controller.with_feedback(feedback),
            None => controller,
        };
        values
            .iter()
            .enumerate()
            .try_for_each(|(index, &value)| controller.ask(index, value))
            .map_err(|refusal: Refusal| Diagnostic::error(refusal.to_string()).in_file(&self.file))?;
        Ok(controller)
    }

    /// q where a search for a posture begins.
    pub(super) fn posture(&self) -> Vec<f64> {
        let tree = &self.compiled.model.tree;
        let mut posture = vec![0.0; tree.nq];
        for joint in &tree.joints {
            // On a planar base q and v have the same places.
            let of_file = self.gait.phases.first().and_then(|phase| phase.posture.get(&joint.name));
            posture[joint.v_index] = of_file.copied().unwrap_or(0.0);
        }
        posture
    }

    /// The gait's parameters with some of them replaced.
    ///
    /// # Errors
    /// Parameters that the gait does not have, numbers that are none.
    pub fn values(&self, set: &[Assignment]) -> Result<Vec<f64>, Diagnostics> {
        let parameters = &self.gait.parameters;
        let defaults: Vec<f64> = parameters.iter().map(|parameter| parameter.default).collect();
        replaced((&self.gait.name, parameters), &defaults, set)
    }

    /// Warnings of parameters of a step beyond their bounds.
    ///
    /// # Errors
    /// Parameters that the gait does not have, numbers that are none.
    pub fn beyond(&self, options: &ChainOptions) -> Result<Vec<Diagnostic>, Diagnostics> {
        let to = self.values(&options.set)?;
        let from = self.with(&to, &options.from)?;
        let mut found = self.outside(&to, "");
        if from != to {
            found.extend(self.outside(&from, " until mid-stance"));
        }
        Ok(found)
    }
}

impl PhasedBench {
    /// A hash of robot, gait and what is asked of them: equal hashes mean equal answers.
    pub(super) fn identity(&self, request: &impl std::fmt::Debug) -> String {
        let version = env!("CARGO_PKG_VERSION");
        let parts = format!("{version}\0{:?}\0{:?}\0{request:?}", self.compiled.description, self.gait);
        format!("{:016x}", fnv1a(&parts))
    }
}

impl Parametrised for PhasedBench {
    fn gait_name(&self) -> &str {
        &self.gait.name
    }
    fn robot_name(&self) -> &str {
        &self.compiled.description.name
    }
    fn parameters(&self) -> &[GaitParameter] {
        &self.gait.parameters
    }
    fn phase_unit(&self) -> &str {
        self.gait.phases.first().map_or("", |phase| &phase.unit)
    }
    fn file(&self) -> &Path {
        &self.file
    }
}

fn one_phase(file: &Path) -> Diagnostics {
    Diagnostic::error("this gait has one phase").in_file(file).help("name one of several phases").into()
}
