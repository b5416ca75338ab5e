//! One file per command.
mod amend;
mod base_parameters;
mod check;
mod compare;
mod completions;
mod diagnose;
mod effects;
mod evaluate;
mod excite;
mod export;
mod gait;
mod generate;
mod history;
mod identify;
mod init;
mod inspect;
mod log;
mod simulate;

use crate::terminal::failure::Outcome;
use clap::Subcommand;

/// All commands.
#[derive(Subcommand)]
pub enum Command {
    Init(init::Init),
    Check(check::Check),
    Generate(generate::Generate),
    Inspect(inspect::Inspect),
    Evaluate(evaluate::Evaluate),
    Log(log::Log),
    Compare(compare::Compare),
    Diagnose(diagnose::Diagnose),
    Effects(effects::Effects),
    Amend(amend::Amend),
    History(history::History),
    Export(export::Export),
    Identify(identify::Identify),
    Excite(excite::Excite),
    Simulate(simulate::Simulate),
    Gait(gait::Gait),
    Completions(completions::Completions),
}

impl Command {
    /// Does what was asked.
    pub fn run(self) -> Outcome {
        match self {
            Self::Init(command) => command.run(),
            Self::Check(command) => command.run(),
            Self::Generate(command) => command.run(),
            Self::Inspect(command) => command.run(),
            Self::Evaluate(command) => command.run(),
            Self::Log(command) => command.run(),
            Self::Compare(command) => command.run(),
            Self::Diagnose(command) => command.run(),
            Self::Effects(command) => command.run(),
            Self::Amend(command) => command.run(),
            Self::History(command) => command.run(),
            Self::Export(command) => command.run(),
            Self::Identify(command) => command.run(),
            Self::Excite(command) => command.run(),
            Self::Simulate(command) => command.run(),
            Self::Gait(command) => command.run(),
            Self::Completions(command) => command.run(),
        }
    }
}
