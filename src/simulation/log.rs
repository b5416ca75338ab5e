//! Files that a simulation writes: the log, and what was hidden.
use super::Scene;
use bipedc_analysis::simulate::{Actuator, csv_line};
use bipedc_compiler::robot::fnv1a;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::Effect;
use bipedc_effects::files::{Batch, Output};
use bipedc_effects::input;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// What the robot has that its description does not say.
#[derive(Serialize)]
struct Truth<'a> {
    robot: &'a str,
    scenario_hash: String,
    seed: u64,
    step: f64,
    effects: &'a [Effect],
    /// By joint.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    motors: BTreeMap<&'a str, &'a Actuator>,
}

impl Scene {
    /// The file of what is hidden, if it is wanted, waiting to take its place.
    pub(super) fn truth(&self, path: Option<&Path>) -> Result<Option<Output>, Diagnostic> {
        let Some(path) = path else { return Ok(None) };
        let mut file = Output::create(path)?;
        file.put(&self.hidden()?)?;
        Ok(Some(file))
    }

    fn hidden(&self) -> Result<String, Diagnostic> {
        let scenario = &self.scenario;
        let truth = Truth {
            robot: &self.robot.description.name,
            scenario_hash: self.hash()?,
            seed: scenario.seed,
            step: scenario.step,
            effects: &scenario.effects,
            motors: (self.plant.joint_names())
                .zip(&scenario.actuators)
                .filter_map(|(name, motor)| Some((name, motor.as_ref()?)))
                .collect(),
        };
        let text = serde_json::to_string_pretty(&truth).map_err(io::Error::from);
        Ok(text.map_err(|error| Diagnostic::error(error.to_string()))? + "\n")
    }

    /// FNV-1a of the scenario's text, 16 hex digits.
    pub(super) fn hash(&self) -> Result<String, Diagnostic> {
        let text = input::read_to_string(&self.file);
        let text = text.map_err(|error| Diagnostic::error(error.to_string()))?;
        Ok(format!("{:016x}", fnv1a(&text)))
    }
}

/// The log row by row.
pub(super) struct Log {
    file: Output,
    line: String,
}

impl Log {
    pub(super) fn begin(path: &Path, columns: &[String]) -> Result<Self, Diagnostic> {
        let mut file = Output::create(path)?;
        file.put(&(columns.join(",") + "\n"))?;
        Ok(Self { file, line: String::new() })
    }

    pub(super) fn row(&mut self, values: &[f64]) -> Result<(), Diagnostic> {
        csv_line(values, &mut self.line);
        self.file.put(&self.line)
    }

    /// With the files beside it, all or none.
    pub(super) fn commit_with(self, more: impl IntoIterator<Item = Output>) -> Result<(), Diagnostic> {
        let mut files = Batch::default();
        files.add(self.file);
        more.into_iter().for_each(|file| files.add(file));
        files.commit()
    }
}
