//! `bipedc gait`: steps on the zero dynamics of a gait.
mod cycle;
mod map;
mod new;
mod optimise;
mod plan;
mod robust;
mod step;
mod steps;
mod values;

use crate::terminal::failure::Outcome;
use clap::{Args, Subcommand};

const EXAMPLES: &str = "\
Examples:
  bipedc gait step robots/three_link --gait thesis --speed 1.5
  bipedc gait step robots/five_link --gait thesis --speed 2 --set knee=0.2 --json
  bipedc gait map robots/three_link --gait thesis --speed 1.5 --over step_length=0.1:1.4:100 --over torso_lean=-2:2:100 --svg map.svg
  bipedc gait steps robots/three_link --gait thesis --from-speed 1 --to 2
  bipedc gait capture robots/three_link --gait thesis --speed 0.5:4:141
  bipedc gait cycle robots/five_link --gait thesis --over step_length=0.15:0.7:23
  bipedc gait robust robots/three_link --scenario robots/three_link/scenarios/robust.toml --disturb push=10
  bipedc gait new robots/five_link --out form.toml
  bipedc gait optimise robots/five_link --gait form.toml --speed 0.7 --out new.toml
  bipedc gait plan robots/tulip --gait dynamic --speed 0.3 --out plan.csv --report plan.html

A gait is a file of virtual constraints, gaits/NAME.toml beside the robot's description; docs/gaits.md explains it. \
`bipedc gait step --help` says what a step is.";

/// Steps of a gait: how fast a robot walks on its virtual constraints
#[derive(Args)]
#[command(after_help = EXAMPLES, arg_required_else_help = true)]
pub struct Gait {
    #[command(subcommand)]
    command: GaitCommand,
}

#[derive(Subcommand)]
enum GaitCommand {
    Step(step::Step),
    Map(map::Map),
    Steps(steps::Steps),
    Capture(steps::Capture),
    Cycle(cycle::Cycle),
    Robust(robust::Robust),
    New(new::New),
    Optimise(optimise::Optimise),
    Plan(plan::Plan),
}

impl Gait {
    /// Does what was asked.
    pub fn run(self) -> Outcome {
        match self.command {
            GaitCommand::Step(command) => command.run(),
            GaitCommand::Map(command) => command.run(),
            GaitCommand::Steps(command) => command.run(),
            GaitCommand::Capture(command) => command.run(),
            GaitCommand::Cycle(command) => command.run(),
            GaitCommand::Robust(command) => command.run(),
            GaitCommand::New(command) => command.run(),
            GaitCommand::Optimise(command) => command.run(),
            GaitCommand::Plan(command) => command.run(),
        }
    }
}
