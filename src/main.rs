//! The `bipedc` command: parses arguments, calls the library, prints.
mod commands;
mod terminal;

use clap::{Command, CommandFactory, FromArgMatches, Parser};
use std::process::ExitCode;
use terminal::{assignments, failure, interruption, output};

const EXAMPLES: &str = "\
Examples:
  bipedc init my_robot/robot.urdf          a first, commented biped.toml
  bipedc check robots/tulip                everything wrong or odd with a robot
  bipedc generate robots/tulip             its equations of motion in Rust
  bipedc inspect robots/tulip              all functions and what they cost
  bipedc evaluate robots/tulip mass_matrix --states states.json
  bipedc log log.csv.gz                    what a log holds, how it is sampled
  bipedc compare robots/tulip log.csv.gz   predicted against logged torques
  bipedc diagnose robots/tulip train.csv --validate other.csv --json > diagnosis.json
  bipedc amend robots/tulip --from diagnosis.json
  bipedc history robots/tulip              what was added, how the error fell
  bipedc effects coulomb_friction          what a model may lack, how it looks
  bipedc identify robots/tulip log.csv --write-urdf new.urdf
  bipedc simulate robots/tulip --scenario stand.toml --out run.csv
  bipedc gait step robots/three_link --gait thesis --speed 1.5

A ROBOT is a folder with `robot.urdf` and `biped.toml`, or one of these files. Units are SI.
Results never overwrite what they were made from; files appear whole or not at all.
Exit codes: 0 done, 1 an error in the input (said on the error stream), 2 wrong usage.";

/// Finds out what the model of a walking robot lacks, where and how large, from its logs; and compiles the model to allocation-free Rust
#[derive(Parser)]
#[command(name = "bipedc", version, after_help = EXAMPLES, arg_required_else_help = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: commands::Command,
}

/// The command line; help is as wide as the terminal, and 80 columns where none is known: in a pager, most of all.
fn command() -> Command {
    const UNKNOWN: usize = 80;
    let told = std::env::var("COLUMNS").is_ok_and(|columns| columns.parse::<usize>().is_ok());
    let known = told || terminal_size::terminal_size().is_some();
    if known { Cli::command() } else { Cli::command().term_width(UNKNOWN) }
}

fn main() -> ExitCode {
    let read = command().try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match read {
        Ok(cli) => cli,
        Err(error) => assignments::explained(error).exit(),
    };
    bipedc_effects::input::keep_pipes();
    match interruption::watch().map_err(failure::Failure::from).and_then(|()| cli.command.run()) {
        Ok(code) => code,
        Err(failure) => {
            output::diagnostics(&failure.0);
            ExitCode::FAILURE
        }
    }
}
