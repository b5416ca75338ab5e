//! The diagnosis' answer, asked for through the command line.
use super::Context;
use crate::generator::{Failure, failure};
use bipedc_analysis::diagnose::intervals;
use bipedc_effects::effect::Effect;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// What `bipedc diagnose --json` prints; the part that is judged.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub struct Answer {
    pub effects: Vec<Effect>,
    /// 95 % intervals of each effect's parameters, by name.
    #[serde(skip)]
    pub intervals: Vec<BTreeMap<String, [f64; 2]>>,
    pub inertial_corrections: Vec<Effect>,
    pub indistinguishable: Vec<Vec<Vec<Effect>>>,
    pub unexplained: bool,
    pub suspects: Vec<String>,
    pub rms: BTreeMap<String, Fall>,
}

/// An error before and after, on held-out data.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Fall {
    pub after: f64,
}

/// Asks. Also how long it took, s.
///
/// # Errors
/// The program fails, takes too long, or prints no JSON.
pub fn ask(
    context: &Context,
    robot: &Path,
    [train, validation]: [&Path; 2],
    scratch: &Path,
) -> Result<(Answer, f64), Failure> {
    std::fs::create_dir_all(scratch).map_err(|e| failure(e.to_string()))?;
    // Into files: a pipe that nobody empties would stop the program.
    let paths = ["answer.json", "messages.txt"].map(|name| scratch.join(name));
    let create = |path: &Path| File::create(path).map_err(|e| failure(format!("{}: {e}", path.display())));
    let start = Instant::now();
    let mut child = Command::new(&context.program)
        .arg("diagnose")
        .arg(robot)
        .arg(train)
        .arg("--validate")
        .arg(validation)
        .arg("--json")
        .args(&context.with)
        .stdin(Stdio::null())
        .stdout(create(&paths[0])?)
        .stderr(create(&paths[1])?)
        .spawn()
        .map_err(|e| failure(format!("{}: {e}", context.program.display())))?;
    let status = loop {
        if let Some(status) = child.try_wait().map_err(|e| failure(e.to_string()))? {
            break status;
        }
        if start.elapsed() > context.patience {
            // It may have ended just now.
            let _ = child.kill();
            let _ = child.wait();
            return Err(failure(format!("no answer within {} s", context.patience.as_secs())));
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    let seconds = start.elapsed().as_secs_f64();
    let [out, err] = paths.map(|path| std::fs::read_to_string(path).unwrap_or_default());
    if !status.success() {
        let lines: Vec<&str> =
            err.lines().filter(|line| line.contains("error") || line.contains("panicked")).collect();
        return Err(failure(lines.first().copied().unwrap_or("failed without a message").to_owned()));
    }
    let no_such = |e: serde_json::Error| failure(format!("the answer is no such JSON: {e}"));
    let answer: Answer = serde_json::from_str(&out).map_err(no_such)?;
    let sure: Sure = serde_json::from_str(&out).map_err(no_such)?;
    let intervals = sure.effects.into_iter().map(|effect| effect.ci95).collect();
    Ok((Answer { intervals, ..answer }, seconds))
}

/// The same JSON, read for how sure its numbers are.
#[derive(Deserialize)]
struct Sure {
    effects: Vec<SureEffect>,
}

#[derive(Deserialize)]
struct SureEffect {
    #[serde(default, deserialize_with = "intervals")]
    ci95: BTreeMap<String, [f64; 2]>,
}
