//! Gaits of a robot: a gait file compiled, and steps on its zero dynamics.
mod chain;
mod checked;
pub mod choice;
mod controller;
pub mod cycle;
pub mod map;
pub mod optimise;
mod over;
mod parameters;
mod phased;
pub mod plan;
mod text;

pub use bipedc_analysis::gait::{Assumptions, Reason};
pub(crate) use chain::light;
pub use chain::{Chain, ChainOptions, ChainStep, ChainedPhase, Hop, MidStance, PhaseEnergy, Refused};
pub use controller::ProgramController;
pub use cycle::{CycleOptions, Cycles, Whole, WholeCycle};
pub use map::{GaitMap, MapOptions};
pub use over::{Over, Range};
pub(crate) use parameters::Parametrised;
pub use phased::{AnyBench, PhasedBench, PhasedProgramController};
pub use plan::{PlanOptions, Plans};

use crate::progress::Progress;
use bipedc_analysis::gait::{GaitModel, GaitSettings, Step};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{CompiledGait, ProgramModel, compile_gait};
use bipedc_compiler::description::gait::{
    Gait, GaitParameter, PHASE_START, gait_path, parse_gait, read_gait,
};
use bipedc_compiler::description::suggest;
use bipedc_compiler::robot::fnv1a;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::formula::Formula;
use bipedc_effects::files::Ledger;
use bipedc_effects::magnitude;
use serde::{Serialize, Serializer};
use std::path::{Path, PathBuf};

/// A robot with one of its gaits.
#[derive(Debug, Clone)]
pub struct GaitBench {
    /// As the file says.
    pub gait: Gait,
    /// What is odd about the file.
    pub warnings: Vec<Diagnostic>,
    file: PathBuf,
    compiled: CompiledGait,
    model: ProgramModel,
}

/// A parameter by name with a number.
pub type Assignment = (String, f64);

/// What step is asked for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepOptions {
    /// Speed φ̇_m at the dead centre of the step before, per s.
    pub speed: f64,
    /// Parameters of both steps, where they are not the gait's own.
    pub set: Vec<Assignment>,
    /// Parameters of the step before, where they are others.
    pub from: Vec<Assignment>,
    /// Parameters of the step before that one, where they are others; without any of them the step before follows its own kind.
    pub before: Vec<Assignment>,
}

/// A step with its question. As text and as JSON it is what `bipedc gait step` prints.
#[derive(Debug, Clone, PartialEq)]
pub struct Stepped {
    /// What comes of it.
    pub step: Step,
    /// The gait's parameters.
    pub parameters: Vec<GaitParameter>,
    /// Their values in the next step and in the one before.
    pub values: [Vec<f64>; 2],
    /// φ̇_m of the step before, per s.
    pub speed: f64,
    /// Unit of φ.
    pub unit: String,
    /// Parameters beyond their bounds.
    pub messages: Vec<Diagnostic>,
}

impl GaitBench {
    /// Reads a gait of a robot, by its name in `gaits/` or by a path, and derives what its steps need.
    ///
    /// # Errors
    /// No such gait; everything in the file that has no meaning, with line and column; functions that cannot be derived.
    pub fn open(robot: &Robot, name: &str, progress: &dyn Progress) -> Result<Self, Diagnostics> {
        let file = gait_path(&robot.sources, name)?;
        let read = read_gait(&file, &robot.sources, &robot.description)?;
        Self::derived(robot, file, read, progress)
    }

    /// The same from a text; `file` gives the gait's name and serves messages.
    ///
    /// # Errors
    /// As [`GaitBench::open`].
    pub fn parse(
        robot: &Robot,
        file: &Path,
        text: &str,
        progress: &dyn Progress,
    ) -> Result<Self, Diagnostics> {
        let read = parse_gait(file, text, &robot.sources, &robot.description)?;
        Self::derived(robot, file.to_path_buf(), read, progress)
    }

    fn derived(
        robot: &Robot,
        file: PathBuf,
        (gait, warnings): (Gait, Vec<Diagnostic>),
        progress: &dyn Progress,
    ) -> Result<Self, Diagnostics> {
        let compiled = progress
            .stage("deriving", || compile_gait(&robot.description, &gait))
            .map_err(|error| error.or_in_file(&file))?;
        let model = ProgramModel::new(compiled.model.clone());
        let bench = Self { gait, warnings, file, compiled, model };
        bench.checked().map_err(|error| error.or_in_file(&bench.file))?;
        Ok(bench)
    }

    /// Notes the gait's file, which no output may overwrite.
    pub fn note(&self, ledger: &mut Ledger) {
        ledger.reads("the gait", &self.file);
    }

    /// The programs.
    pub fn compiled(&self) -> &CompiledGait {
        &self.compiled
    }

    /// The gait's functions, ready for steps.
    ///
    /// # Errors
    /// The model lacks a function: a fault of the compiler.
    pub fn model(&self) -> Result<GaitModel<'_>, Diagnostic> {
        let CompiledGait { description, model, points, .. } = &self.compiled;
        let phase = &self.gait.phase;
        let impact_map = model.functions.iter().find(|function| function.family == "impact_map");
        let mut posture = vec![0.0; model.tree.nq];
        let joints = &model.tree.joints;
        for joint in joints {
            posture[joint.v_index] = phase.posture.get(&joint.name).copied().unwrap_or(0.0);
        }
        let limit = |name: &str| description.joints.iter().find(|joint| joint.name == name)?.effort_limit;
        let settings = GaitSettings {
            parameters: self.gait.parameters.len(),
            outputs: phase.outputs.len(),
            between: phase.guard.between,
            impact_matching: phase.impact_matching,
            depends_on_start: self.depends_on_start(),
            impact_map: impact_map.map_or_else(String::new, |function| function.name.clone()),
            points: *points,
            posture,
            friction: self.gait.limits.friction,
            position_limits: description.stops(joints.iter().map(|joint| joint.name.as_str())),
            velocity_limits: description.velocity_limits(joints.iter().map(|joint| joint.name.as_str())),
            effort_limits: joints.iter().map(|joint| limit(&joint.name)).collect(),
        };
        GaitModel::new(&self.model, settings)
    }

    /// Whether φ₊ stands in what is wanted, directly or in a quantity.
    fn depends_on_start(&self) -> bool {
        let wanted = self.gait.phase.outputs.iter().flat_map(|output| output.wanted.names());
        let mut names = wanted.chain(self.gait.quantities.values().flat_map(Formula::names));
        names.any(|name| name == PHASE_START)
    }

    /// One step.
    ///
    /// # Errors
    /// Parameters that the gait does not have, numbers that are none.
    pub fn step(&self, options: &StepOptions) -> Result<Stepped, Diagnostics> {
        let speed = options.speed;
        if !(0.0..=magnitude::LARGEST).contains(&speed) {
            let help =
                "write the speed at mid-stance, 0 or more, in the unit of the phase variable per second";
            return Err(Diagnostic::error(impossible_speed(speed)).help(help).into());
        }
        let defaults: Vec<f64> = self.gait.parameters.iter().map(|parameter| parameter.default).collect();
        let to = self.with(&defaults, &options.set)?;
        let from = self.with(&to, &options.from)?;
        let mut messages = self.beyond(&to, "");
        if from != to {
            messages.extend(self.beyond(&from, " of the step before"));
        }
        let before = self.with(&from, &options.before)?;
        if before != from {
            messages.extend(self.beyond(&before, " of the first step"));
        }
        let step = self.model()?.pair(Some(&before), &from, &to).step(speed);
        Ok(Stepped {
            step,
            parameters: self.gait.parameters.clone(),
            values: [to, from],
            speed,
            unit: self.gait.phase.unit.clone(),
            messages,
        })
    }

    /// A hash of robot, gait and what is asked of them: equal hashes mean equal answers.
    fn identity(&self, request: &impl std::fmt::Debug) -> String {
        let version = env!("CARGO_PKG_VERSION");
        let parts = format!("{version}\0{:?}\0{:?}\0{request:?}", self.compiled.description, self.gait);
        format!("{:016x}", fnv1a(&parts))
    }

    /// Warnings of parameters beyond their bounds.
    pub(crate) fn beyond(&self, values: &[f64], of: &str) -> Vec<Diagnostic> {
        beyond(&self.gait.parameters, values, (of, &self.file))
    }
}

impl Parametrised for GaitBench {
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
        &self.gait.phase.unit
    }
    fn file(&self) -> &Path {
        &self.file
    }
}

/// What is wrong with a speed.
fn impossible_speed(speed: f64) -> String {
    // Three hundred digits are no help.
    if speed.abs() < 1e9 {
        format!("a speed of {speed} is not possible")
    } else {
        format!("a speed of {speed:e} is not possible")
    }
}

/// Values of a gait's parameters with some of them replaced.
fn replaced(
    (gait, parameters): (&str, &[GaitParameter]),
    values: &[f64],
    assignments: &[Assignment],
) -> Result<Vec<f64>, Diagnostics> {
    let mut values = values.to_vec();
    let mut wrong = Vec::new();
    for (place, (name, value)) in assignments.iter().enumerate() {
        if assignments[..place].iter().any(|(other, _)| other == name) {
            let message = format!("`{name}` is set twice");
            wrong.push(Diagnostic::error(message).help("leave one of them out"));
            continue;
        }
        let Some(index) = parameters.iter().position(|parameter| parameter.name == *name) else {
            wrong.push(unknown((gait, parameters), name));
            continue;
        };
        if !value.is_finite() || magnitude::refusal(*value).is_some() {
            let message = format!("`{name}` = {value} is not possible");
            let help = format!("write a number in {}", parameters[index].unit);
            wrong.push(Diagnostic::error(message).help(help));
            continue;
        }
        values[index] = *value;
    }
    if wrong.is_empty() { Ok(values) } else { Err(Diagnostics(wrong)) }
}

fn unknown((gait, parameters): (&str, &[GaitParameter]), name: &str) -> Diagnostic {
    let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    let message = format!("the gait `{gait}` has no parameter `{name}`");
    Diagnostic::error(message).help(suggest(name, names, "parameters"))
}

/// Warnings of parameters beyond their bounds.
fn beyond(parameters: &[GaitParameter], values: &[f64], (of, file): (&str, &Path)) -> Vec<Diagnostic> {
    let outside = parameters.iter().zip(values).filter(|(parameter, value)| {
        let [low, high] = parameter.bounds;
        !(low..=high).contains(value)
    });
    let warning = |(parameter, value): (&GaitParameter, &f64)| {
        let GaitParameter { name, unit, bounds: [low, high], .. } = parameter;
        Diagnostic::warning(format!(
            "`{name}`{of} = {value} {unit} lies outside its bounds {low} to {high} {unit}"
        ))
        .in_file(file)
        .help("computed all the same")
    };
    outside.map(warning).collect()
}

impl Serialize for Stepped {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.step.serialize(serializer)
    }
}
