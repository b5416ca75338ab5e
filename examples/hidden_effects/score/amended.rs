//! What is left once an answer is written into the description: through the command line, as a user does it.
use super::Context;
use super::answer::Answer;
use crate::generator::sway_sensors::CUTOFF;
use crate::generator::{Failure, failure};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Error of a kind of channel in a log on feet, at the cut-off of the true model's, of the robot with what the answer in `scratch` found.
///
/// # Errors
/// Files that cannot be copied, commands that fail.
pub fn error_on_feet(
    context: &Context,
    (robot, log): (&Path, &Path),
    scratch: &Path,
    (answer, kind): (&Answer, &str),
) -> Result<f64, Failure> {
    let amended = scratch.join("amended");
    std::fs::create_dir_all(&amended).map_err(|e| failure(e.to_string()))?;
    for file in ["robot.urdf", "biped.toml"] {
        std::fs::copy(robot.join(file), amended.join(file)).map_err(|e| failure(e.to_string()))?;
    }
    if !(answer.effects.is_empty() && answer.inertial_corrections.is_empty()) {
        printed(
            Command::new(&context.program)
                .arg("amend")
                .arg(&amended)
                .arg("--from")
                .arg(scratch.join("answer.json")),
        )?;
    }
    let cutoff = CUTOFF.to_string();
    let mut compare = Command::new(&context.program);
    compare.arg("compare").arg(&amended).arg(log).args(["--cutoff", &cutoff, "--json"]);
    let compared: Value =
        serde_json::from_str(&printed(&mut compare)?).map_err(|e| failure(e.to_string()))?;
    compared["kinds"][kind]["rms"].as_f64().ok_or_else(|| failure(format!("`{kind}` was not compared")))
}

/// What a command prints.
fn printed(command: &mut Command) -> Result<String, Failure> {
    let output = command.output().map_err(|e| failure(e.to_string()))?;
    if !output.status.success() {
        return Err(failure(
            String::from_utf8_lossy(&output.stderr).lines().next().unwrap_or("failed").to_owned(),
        ));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
