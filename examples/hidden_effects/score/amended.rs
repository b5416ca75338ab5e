//! What is left once an answer is written into the description: through the command line, as a user does it.
use super::Context;
use super::answer::Answer;
use crate::generator::sway_sensors::CUTOFF;
use crate::generator::{Failure, failure};
use bipedc_effects::effect::Effect;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Errors of a kind of channel in a log on feet, at one cut-off, of the robot with what was found and of the robot with what is hidden.
///
/// # Errors
/// Files that cannot be copied, commands that fail.
pub fn errors_on_feet(
    context: &Context,
    (robot, log): (&Path, &Path),
    scratch: &Path,
    (found, hidden, kind): (&Answer, &[Effect], &str),
) -> Result<[f64; 2], Failure> {
    let corrected: Vec<Effect> = [&found.effects[..], &found.inertial_corrections].concat();
    let error = |effects: &[Effect], name: &str| {
        let amended = scratch.join(name);
        std::fs::create_dir_all(&amended).map_err(|e| failure(e.to_string()))?;
        for file in ["robot.urdf", "biped.toml"] {
            std::fs::copy(robot.join(file), amended.join(file)).map_err(|e| failure(e.to_string()))?;
        }
        if !effects.is_empty() {
            let answer = amended.join("answer.json");
            let text = serde_json::json!({ "effects": effects }).to_string();
            std::fs::write(&answer, text).map_err(|e| failure(e.to_string()))?;
            printed(Command::new(&context.program).arg("amend").arg(&amended).arg("--from").arg(&answer))?;
        }
        let cutoff = CUTOFF.to_string();
        let mut compare = Command::new(&context.program);
        compare.arg("compare").arg(&amended).arg(log).args(["--cutoff", &cutoff, "--json"]);
        let compared: Value =
            serde_json::from_str(&printed(&mut compare)?).map_err(|e| failure(e.to_string()))?;
        compared["kinds"][kind]["rms"].as_f64().ok_or_else(|| failure(format!("`{kind}` was not compared")))
    };
    Ok([error(&corrected, "found")?, error(hidden, "hidden")?])
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
