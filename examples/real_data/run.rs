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
        let output =
            command.arg("--json").output().map_err(|e| failure(format!("{}: {e}", self.0.display())))?;
        if !output.status.success() {
            return Err(failure(format!("{shown}: {}", String::from_utf8_lossy(&output.stderr))));
        }
        let answer = serde_json::from_slice(&output.stdout).map_err(|e| failure(format!("{shown}: {e}")))?;
        Ok((shown, answer))
    }
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
