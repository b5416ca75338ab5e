//! The `bipedc` command: parses arguments, calls the library, prints.
mod commands;
mod terminal;

use clap::Parser;
use std::process::ExitCode;
use terminal::{failure, interruption, output};

const EXAMPLES: &str = "\
Examples:
  bipedc init my_robot/robot.urdf                    write a first, commented biped.toml beside a URDF
  bipedc check robots/tulip                          everything wrong or odd with a robot
  bipedc generate robots/tulip                       its equations of motion as a Rust crate in generated/tulip
  bipedc inspect robots/tulip                        all functions with their operation counts
  bipedc evaluate robots/tulip mass_matrix --states states.json
  bipedc compare robots/tulip log.csv.gz             predicted against logged torques
  bipedc identify robots/tulip log.csv --write-urdf new.urdf   masses, centres and inertias with error bars
  bipedc simulate robots/tulip --scenario stand.toml --out run.csv   a log of the robot in motion, on the ground
  bipedc effects coulomb_friction                    what the model may lack, how it looks and what to confuse it with
  bipedc amend robots/tulip --effect coulomb_friction --joint left_knee_pitch --set torque=0.43
  bipedc history robots/tulip                        what was added to the description, and how the error fell

A ROBOT is a folder with `robot.urdf` and `biped.toml`, or one of these files. Units are SI.
Results never overwrite what they were made from; files appear whole or not at all.
Exit codes: 0 done, 1 an error in the input (said on the error stream), 2 wrong usage.";

/// The model compiler for walking robots: a URDF in, specialised allocation-free Rust out
#[derive(Parser)]
#[command(name = "bipedc", version, after_help = EXAMPLES, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: commands::Command,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    bipedc_effects::input::keep_pipes();
    match interruption::watch().map_err(failure::Failure::from).and_then(|()| cli.command.run()) {
        Ok(code) => code,
        Err(failure) => {
            output::diagnostics(&failure.0);
            ExitCode::FAILURE
        }
    }
}
