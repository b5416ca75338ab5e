//! `bipedc init`: a first description beside a URDF.
use crate::terminal::failure::Outcome;
use crate::terminal::next::Typed;
use crate::terminal::output;
use bipedc_compiler::description::{BACKWARD, DESCRIPTION_FILE, NO_SHAPE, init};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::{Ledger, write};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc init my_robot/robot.urdf        writes my_robot/biped.toml
  bipedc init my_robot/robot.urdf --force --json

Base, feet, sides and symmetric pairs are guessed from names and kinematics: check every line.
JSON: {\"wrote\", \"next\" (a command)}.";

/// Write a first, commented `biped.toml` beside a URDF
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Init {
    /// The URDF
    #[arg(value_name = "URDF")]
    urdf: PathBuf,
    /// Replace a `biped.toml` that is there
    #[arg(long)]
    force: bool,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

impl Init {
    /// Guesses and writes.
    pub fn run(self) -> Outcome {
        if self.urdf.exists() && !self.urdf.is_file() {
            return Err(Diagnostic::error("the URDF is no file that a description could stand beside")
                .in_file(&self.urdf)
                .help("save what the pipe gives as robot.urdf in a folder of its own first")
                .into());
        }
        let text = init(&self.urdf)?;
        let path = self.urdf.with_file_name(DESCRIPTION_FILE);
        if path.exists() && !self.force {
            return Err(Diagnostic::error("the description exists already")
                .in_file(&path)
                .help("--force replaces it")
                .into());
        }
        let mut ledger = Ledger::default();
        ledger.reads("the URDF", &self.urdf);
        ledger.writes_source("the description", &path)?;
        write(&path, &text)?;
        output::diagnostics(
            &guessed_feet(&text, &path).into_iter().chain(turned_feet(&text, &path)).collect::<Vec<_>>(),
        );
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.map_or_else(|| ".".to_owned(), |folder| folder.display().to_string());
        let next = Typed::command("check").path(Path::new(&folder)).because("to check its guesses");
        output::written(&path, &next, self.json)?;
        Ok(ExitCode::SUCCESS)
    }
}

/// A warning of feet that no collision shape shows: their points are where joints are, and a robot with soles would walk on its ankles.
fn guessed_feet(text: &str, path: &Path) -> Option<Diagnostic> {
    let line = text.lines().position(|line| line.contains(NO_SHAPE))?;
    let message = "no collision shape shows where a foot touches the ground: its points are a guess";
    let help =
        "put the heel and toe (the corners of the sole) of each foot there, m, in the frame of its link";
    Some(Diagnostic::warning(message).in_file(path).at(line + 1, 1).help(help))
}

/// A warning of feet that are longer behind their joints than before them: heel and toe would be exchanged, and no gait found.
fn turned_feet(text: &str, path: &Path) -> Option<Diagnostic> {
    let line = text.lines().position(|line| line.contains(BACKWARD))?;
    let message =
        "the feet are longer towards −x: this robot seems to face −x, and its toes were taken for heels";
    let help = "robots walk towards +x. If it does face −x, give the URDF a root link of its own, fixed to the present one by a joint \
        with rpy=\"0 0 3.141592653589793\", and run `bipedc init` again";
    Some(Diagnostic::warning(message).in_file(path).at(line + 1, 1).help(help))
}
