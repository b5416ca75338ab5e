//! Arguments that several commands share.
use crate::amendment::history::History;
use crate::failure::Failure;
use crate::output;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{Entry, FunctionRequest, Scope, entry};
use bipedc_compiler::description::model::Base;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::Ledger;
use clap::Args;
use std::path::PathBuf;

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
    pub fn read(&self) -> Result<Robot, Failure> {
        let robot = self.read_quietly()?;
        output::diagnostics(&robot.warnings);
        Ok(robot)
    }

    /// Reads the robot and keeps its warnings.
    pub fn read_quietly(&self) -> Result<Robot, Failure> {
        let robot = Robot::read(&self.path)?;
        if self.base.is_none() && self.root.is_none() {
            return Ok(robot);
        }
        let present = match robot.description.base {
            Base::Floating { .. } => "floating",
            Base::Planar { .. } => "planar",
            Base::Fixed { .. } => "fixed",
            Base::Pivot { .. } => "pivot",
        };
        let robot = robot.with_base(self.base.as_deref().unwrap_or(present), self.root.as_deref())?;
        // Whether the root exists shows only when the tree is built.
        robot.tree()?;
        Ok(robot)
    }

    /// What the robot was read from; outputs must not overwrite it.
    pub fn ledger(&self, robot: &Robot) -> Ledger {
        let mut ledger = Ledger::default();
        robot.note(&mut ledger);
        ledger.reads("the description's history", &History::path(&robot.sources.toml_path));
        ledger
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
    /// The function of this name about this frame or phase.
    pub fn request(&self, function: &str) -> Result<FunctionRequest, Diagnostic> {
        let entry: &Entry = entry(function)?;
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
