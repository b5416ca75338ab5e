//! Arguments that several commands share.
use super::failure::Failure;
use super::progress::Bars;
use super::{interruption, output};
use bipedc::workbench::BaseChoice;
use bipedc::{Robot, Workbench};
use bipedc_compiler::compile::{FunctionRequest, Scope, entry_and_subject};
use bipedc_effects::diagnostic::Diagnostic;
use clap::Args;
use std::path::PathBuf;
use std::sync::Arc;

/// Which robot, on which base.
#[derive(Args)]
pub struct RobotArguments {
    /// Folder with `robot.urdf` and `biped.toml`, or one of these files
    #[arg(value_name = "ROBOT")]
    pub path: PathBuf,
    /// How the robot hangs in the world, instead of what its description says
    #[arg(long, value_name = "KIND", value_parser = ["floating", "planar", "fixed", "pivot"])]
    pub base: Option<String>,
    /// Link or contact point (FOOT/POINT; for a pivot also FOOT/EDGE) that carries the base coordinates
    #[arg(long, value_name = "LINK")]
    pub root: Option<String>,
}

impl RobotArguments {
    /// Reads the robot; its warnings go to the error stream.
    pub fn open(&self) -> Result<Workbench, Failure> {
        let bench = self.open_quietly()?;
        output::diagnostics(&bench.robot().warnings);
        Ok(bench)
    }

    /// The robot alone; its warnings go to the error stream.
    pub fn read(&self) -> Result<Robot, Failure> {
        Ok(self.open()?.into_robot())
    }

    /// Reads the robot and keeps its warnings.
    pub fn open_quietly(&self) -> Result<Workbench, Failure> {
        let base = BaseChoice { kind: self.base.clone(), root: self.root.clone() };
        Ok(Workbench::open_on(&self.path, base)?
            .watched(Arc::new(Bars::default()))
            .stopped_when(interruption::asked()))
    }

    /// The overrides as they were typed, for commands to repeat.
    pub fn overrides(&self) -> String {
        let option = |name: &str, value: &Option<String>| {
            value.as_ref().map_or_else(String::new, |value| format!(" --{name} {value}"))
        };
        option("base", &self.base) + &option("root", &self.root)
    }
}

/// The frame or phase that a function is about.
#[derive(Args)]
pub struct SubjectArguments {
    /// Link, for functions of one frame
    #[arg(long, value_name = "LINK", conflicts_with_all = ["point", "phase"])]
    link: Option<String>,
    /// Contact point FOOT/POINT, for functions of one frame
    #[arg(long, value_name = "FOOT/POINT", conflicts_with = "phase")]
    point: Option<String>,
    /// Phase of the description, for constrained dynamics and impacts
    #[arg(long, value_name = "PHASE")]
    phase: Option<String>,
}

impl SubjectArguments {
    /// The function of this name about this frame or phase, or about the one that its name ends with.
    pub fn request(&self, function: &str, robot: &Robot) -> Result<FunctionRequest, Diagnostic> {
        let (entry, of_name) = entry_and_subject(function)?;
        if of_name.is_some() {
            return FunctionRequest::named(function, &robot.description, &robot.tree()?);
        }
        let (frame, phase) = (self.link.clone().or_else(|| self.point.clone()), self.phase.clone());
        let misplaced = |what: &str, help: &str| {
            Err(Diagnostic::error(format!("`{function}` is not about one {what}")).help(help))
        };
        match entry.scope {
            Scope::Frame if phase.is_some() => misplaced("phase", "leave out --phase"),
            Scope::Phase | Scope::Impact if frame.is_some() => {
                misplaced("frame", "leave out --link and --point; name a phase with --phase")
            }
            Scope::Robot | Scope::Contacts if frame.is_some() => {
                misplaced("frame", "leave out --link and --point")
            }
            Scope::Robot | Scope::Contacts if phase.is_some() => misplaced("phase", "leave out --phase"),
            _ => Ok(FunctionRequest { family: entry.name.to_owned(), subject: frame.or(phase) }),
        }
    }
}
