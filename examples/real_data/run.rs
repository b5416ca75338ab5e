//! Asking the program, in a folder of one's own.
use serde_json::Value;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What went wrong.
#[derive(Debug)]
pub struct Failure(String);

/// A failure with this message.
pub fn failure(message: impl Into<String>) -> Failure {
    Failure(message.into())
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Failure {}

/// A folder that goes when it is no longer needed.
pub struct Scratch(PathBuf);

impl Scratch {
    /// A new folder among the system's temporary ones.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn new(name: &str) -> Result<Self, Failure> {
        let folder = std::env::temp_dir().join(format!("{name}-{}", std::process::id()));
        let scratch = Self(folder);
        scratch.folder("")?;
        Ok(scratch)
    }

    /// A folder within it.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn folder(&self, name: &str) -> Result<PathBuf, Failure> {
        let folder = self.0.join(name);
        std::fs::create_dir_all(&folder).map_err(|e| failure(format!("{}: {e}", folder.display())))?;
        Ok(folder)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What remains of it disturbs nobody.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A machine's questions: data, a folder to write into, whom to ask.
pub type Machine = fn(&Path, &Path, &Program) -> Result<Vec<Part>, Failure>;

/// One question to the program, and its answer.
pub struct Part {
    /// Heading of the page.
    pub title: &'static str,
    /// What was done and what is known, Markdown.
    pub words: String,
    /// As typed, with names instead of folders.
    pub command: String,
    /// What `bipedc diagnose --json` says.
    pub answer: Value,
    /// What `bipedc compare` measures before and after `bipedc amend --from`, on the log that judges, whole.
    pub measured: Vec<Row>,
}

/// A row of `bipedc compare`.
pub struct Row {
    /// Its name, as in the answer's `rows`.
    pub name: String,
    /// Errors (rms) of the robot as described, and as amended.
    pub errors: [f64; 2],
}

/// The program.
pub struct Program(pub PathBuf);

impl Program {
    /// Runs `bipedc diagnose … --json`. `named` are files and what a page calls them.
    ///
    /// # Errors
    /// The program fails or says something that is no JSON.
    pub fn diagnose(&self, files: &[(&Path, &str)], options: &[&str]) -> Result<(String, Value), Failure> {
        let mut command = Command::new(&self.0);
        command.arg("diagnose");
        let mut shown = "bipedc diagnose".to_owned();
        let mut add = |argument: &Path, name: &str| {
            command.arg(argument);
            shown.push(' ');
            shown.push_str(name);
        };
        for (at, (file, name)) in files.iter().enumerate() {
            if at == 2 {
                add(Path::new("--validate"), "--validate");
            }
            add(file, name);
        }
        options.iter().for_each(|option| add(Path::new(option), option.rsplit('/').next().unwrap_or(option)));
        let answer = self.json(command.arg("--json"), &shown)?;
        Ok((shown, answer))
    }

    /// Amends a copy of the robot by an answer, and compares both with the log that judged (the last one in `files`).
    ///
    /// # Errors
    /// The program fails, or files cannot be written.
    pub fn measure(
        &self,
        files: &[(&Path, &str)],
        options: &[&str],
        answer: &Value,
    ) -> Result<Vec<Row>, Failure> {
        let (Some((robot, _)), Some((log, _))) = (files.first(), files.last()) else { return Ok(Vec::new()) };
        let amended = copy(robot, &robot.with_extension("amended"))?;
        let found = robot.with_extension("json");
        std::fs::write(&found, answer.to_string())
            .map_err(|e| failure(format!("{}: {e}", found.display())))?;
        let mut amend = Command::new(&self.0);
        self.json(amend.arg("amend").arg(&amended).arg("--from").arg(&found).arg("--json"), "bipedc amend")?;
        let compare = |robot: &Path| -> Result<Vec<Value>, Failure> {
            let mut command = Command::new(&self.0);
            command.arg("compare").args([robot, log]).arg("--json");
            for pair in options.windows(2).filter(|pair| ["--cutoff", "--mapping"].contains(&pair[0])) {
                command.args(pair);
            }
            let answer = self.json(&mut command, "bipedc compare")?;
            Ok(answer["channels"].as_array().cloned().unwrap_or_default())
        };
        let (before, after) = (compare(robot)?, compare(&amended)?);
        let rms = |channel: &Value| channel["rms"].as_f64().unwrap_or(f64::NAN);
        let row = |(before, after): (&Value, &Value)| Row {
            name: after["name"].as_str().unwrap_or_default().to_owned(),
            errors: [rms(before), rms(after)],
        };
        Ok(before.iter().zip(&after).map(row).collect())
    }

    /// What a command prints as JSON.
    fn json(&self, command: &mut Command, shown: &str) -> Result<Value, Failure> {
        let output = command.output().map_err(|e| failure(format!("{}: {e}", self.0.display())))?;
        if !output.status.success() {
            return Err(failure(format!("{shown}: {}", String::from_utf8_lossy(&output.stderr))));
        }
        serde_json::from_slice(&output.stdout).map_err(|e| failure(format!("{shown}: {e}")))
    }
}

/// A copy of a robot's two files in another folder, which is made anew.
fn copy(robot: &Path, to: &Path) -> Result<PathBuf, Failure> {
    let copied = || {
        if to.exists() {
            std::fs::remove_dir_all(to)?;
        }
        std::fs::create_dir_all(to)?;
        for file in ["robot.urdf", "biped.toml"] {
            std::fs::copy(robot.join(file), to.join(file))?;
        }
        Ok(to.to_owned())
    };
    copied().map_err(|e: std::io::Error| failure(format!("{}: {e}", to.display())))
}

/// Writes a robot: a copy of a URDF, and its `biped.toml`.
///
/// # Errors
/// A file that cannot be written.
pub fn robot(folder: &Path, urdf: &str, description: &str) -> Result<PathBuf, Failure> {
    let robot = folder.join("robot");
    std::fs::create_dir_all(&robot)
        .and_then(|()| std::fs::write(robot.join("robot.urdf"), urdf))
        .and_then(|()| std::fs::write(robot.join("biped.toml"), description))
        .map_err(|e| failure(format!("{}: {e}", robot.display())))?;
    Ok(robot)
}

/// The text of a file.
///
/// # Errors
/// It cannot be read.
pub fn text(file: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(file).map_err(|e| failure(format!("{}: {e}", file.display())))
}
