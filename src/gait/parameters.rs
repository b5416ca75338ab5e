//! Parameters of a gait by name, whatever its number of phases.
use super::over::Over;
use super::{Assignment, beyond, impossible_speed, replaced, unknown};
use bipedc_compiler::description::gait::GaitParameter;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::magnitude;
use std::collections::BTreeMap;
use std::path::Path;

/// A gait whose steps are chosen by parameters.
pub(crate) trait Parametrised {
    /// Name of the gait.
    fn gait_name(&self) -> &str;
    /// Of the robot.
    fn robot_name(&self) -> &str;
    /// In the order of the file.
    fn parameters(&self) -> &[GaitParameter];
    /// Unit of φ.
    fn phase_unit(&self) -> &str;
    /// The gait's file.
    fn file(&self) -> &Path;

    /// Unit of all speeds.
    fn speed_unit(&self) -> String {
        format!("{}/s", self.phase_unit())
    }

    /// Values that nobody asked otherwise for.
    fn defaults(&self) -> Vec<f64> {
        self.parameters().iter().map(|parameter| parameter.default).collect()
    }

    /// Values with some of them replaced.
    fn with(&self, values: &[f64], assignments: &[Assignment]) -> Result<Vec<f64>, Diagnostics> {
        replaced((self.gait_name(), self.parameters()), values, assignments)
    }

    /// Which parameter has this name.
    fn index(&self, name: &str) -> Option<usize> {
        self.parameters().iter().position(|parameter| parameter.name == name)
    }

    /// That there is no such parameter.
    fn unknown(&self, name: &str) -> Diagnostic {
        unknown((self.gait_name(), self.parameters()), name)
    }

    /// The parameter of an index.
    fn parameter(&self, index: usize) -> &GaitParameter {
        &self.parameters()[index]
    }

    /// Values of parameters by name.
    fn named(&self, values: &[f64]) -> BTreeMap<String, f64> {
        let pairs = self.parameters().iter().zip(values);
        pairs.map(|(parameter, value)| (parameter.name.clone(), *value)).collect()
    }

    /// Warnings of parameters beyond their bounds; `of` says of which step.
    fn outside(&self, values: &[f64], of: &str) -> Vec<Diagnostic> {
        beyond(self.parameters(), values, (of, self.file()))
    }

    /// The parameters of ranges, by index, with their values.
    ///
    /// # Errors
    /// Parameters that the gait does not have, or that stand twice or in `fixed` too; ranges that are none.
    fn axes(&self, over: &[Over], fixed: &[&str]) -> Result<Vec<(usize, Vec<f64>)>, Diagnostics> {
        let (mut found, mut wrong) = (Vec::new(), Vec::new());
        for Over { name, range } in over {
            let Some(index) = self.index(name) else {
                wrong.push(self.unknown(name));
                continue;
            };
            if found.iter().any(|(other, _)| *other == index) {
                let message = format!("`{name}` stands in two ranges");
                wrong
                    .push(Diagnostic::error(message).help("leave out one --over, or name another parameter"));
            } else if fixed.contains(&name.as_str()) {
                let message = format!("`{name}` is fixed and has a range");
                wrong.push(Diagnostic::error(message).help("leave out its --set or its --over"));
            }
            wrong.extend(range.refusal(&format!("--over {name}")));
            // A range that was refused may have any number of values.
            let values = if wrong.is_empty() { range.values() } else { Vec::new() };
            found.push((index, values));
        }
        if wrong.is_empty() { Ok(found) } else { Err(Diagnostics(wrong)) }
    }

    /// Refuses speeds that are none.
    fn check_speeds(&self, speeds: &[f64]) -> Result<(), Diagnostics> {
        let possible = |speed: &f64| *speed > 0.0 && *speed <= magnitude::LARGEST;
        let help = format!("write a speed at mid-stance above 0, in {}", self.speed_unit());
        if speeds.is_empty() {
            return Err(Diagnostic::error("no speed is given").help(help).into());
        }
        let refuse = |speed: &f64| Diagnostic::error(impossible_speed(*speed)).help(help.clone());
        let wrong: Vec<Diagnostic> = speeds.iter().filter(|speed| !possible(speed)).map(refuse).collect();
        if wrong.is_empty() { Ok(()) } else { Err(Diagnostics(wrong)) }
    }
}
