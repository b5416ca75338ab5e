//! `bipedc gait map`: the next speed over two parameters.
use super::values::{INTERRUPTED, assignment, note, over, write};
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use bipedc::gait::map::INTERPOLATED_FROM;
use bipedc::gait::{AnyBench, Assignment, Assumptions, MapOptions, Over};
use bipedc_analysis::report::{map_svg, render_map};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::process::ExitCode;

/// As clap has it, but broken where a terminal of 80 columns ends.
const USAGE: &str = "bipedc gait map [OPTIONS] --gait <NAME|FILE.toml> --speed <V>...\n                       --over <NAME=A:B:N> <ROBOT>";

const MAP: &str = "\
Examples:
  bipedc gait map robots/three_link --gait thesis --speed 1 1.5 2 --over step_length=0.1:1.4:200 --over torso_lean=-2:2:200 --svg map.svg
  bipedc gait map robots/five_link --gait thesis --speed 2 --over step_length=0.1:1:50 --over knee=0.05:0.8:50 --page map.html
  bipedc gait map robots/five_link --gait thesis --speed 2 --over step_length=0.1:1:50 --over torso_lean=-0.5:1:50 --assume step,friction,pull --csv map.csv

Each cell is the step that `bipedc gait step --set` with its parameters computes (thesis, figures 7.2 and 7.4). Both steps have the parameters \
of the cell; with --from the step before keeps those named there. The picture has a panel for each speed: colours are speeds \
of the next step, the black line is where it is as fast as before, dashes are the bounds of the gait file, triangles the fastest and \
the slowest next step within them. Cells where the step is not made have the colour of the reason.

Cells of a gait of several phases are followed through all phases, speed by speed; with --from the cell's parameters are taken at mid-stance. \
Their controller keeps friction, push and torques itself where outputs allow it; --assume colours cells whose steps do not, or scuff. From 2000 cells of \
a speed on, most cells of such a gait are interpolated, to a thousandth of the map's speed: those around which cells that were computed are \
what their neighbours say of them. The text says how many were computed, and how far off others are that were computed to see it; \
--every-cell computes them all.

Ctrl-C ends a map early, with code 130: cells that are missing are `not computed`, and the same command with the same --csv goes on \
from there. A file that is there and is another map is not written over.
JSON: {\"gait\", \"robot\", \"speed_unit\", \"parameters\", \"from\", \"over\": [{\"name\", \"unit\", \"bounds\", \"values\"}], \"assume\", \
\"complete\", \"reasons\", \"maps\": [{\"speed\", \"fastest\": {\"next_speed\", \"at\"}, \"slowest\", \"counts\", \"next_speed\": rows, \
\"reason\": rows of indices of \"reasons\", \"interpolation\": {\"computed\", \"interpolated\", \"checked\", \"largest_deviation\", \
\"tolerance\"}, \"computed\": rows of 1 and 0}]}; docs/gaits.md explains every key.";

/// The speed at mid-stance of the next step over two parameters
#[derive(Args)]
#[command(after_help = MAP, override_usage = USAGE)]
pub struct Map {
    #[command(flatten)]
    robot: RobotArguments,
    /// Name of a gait in gaits/ beside the robot's description, or a file
    #[arg(long, value_name = "NAME|FILE.toml")]
    gait: String,
    /// Speeds of the phase variable at the dead centre of the step before, per second; a map each
    #[arg(long, value_name = "V", num_args = 1.., value_delimiter = ',', allow_negative_numbers = true, required = true)]
    speed: Vec<f64>,
    /// A parameter with N values from A to B; twice: columns, then rows
    #[arg(long, value_name = "NAME=A:B:N", value_parser = over, required = true)]
    over: Vec<Over>,
    /// Another parameter (SI units)
    #[arg(long, value_name = "NAME=X", value_parser = assignment)]
    set: Vec<Assignment>,
    /// A parameter of the step before, which then is the same for all cells
    #[arg(long, value_name = "NAME=X", value_parser = assignment)]
    from: Vec<Assignment>,
    /// What has to hold; `step`: the dead centre is passed
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',', default_value = "step")]
    assume: Vec<Assumed>,
    /// Compute every cell, also of large maps of gaits of several phases
    #[arg(long)]
    every_cell: bool,
    /// Write the picture
    #[arg(long, value_name = "OUT.svg")]
    svg: Option<PathBuf>,
    /// Write all cells as a table; goes on from such a file
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
    /// Write a page to look at; opens in any browser, needs no network
    #[arg(long, value_name = "OUT.html")]
    page: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// What has to hold in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Assumed {
    /// The dead centre is passed: always
    Step,
    /// No foot slips
    Friction,
    /// No foot pulls
    Pull,
    /// No foot scuffs
    Clearance,
    /// No torque exceeds its limit
    Torque,
    /// No joint gets to its stop
    Joints,
    /// No joint is faster than its limit
    Velocity,
}

impl Assumed {
    /// In the library's words.
    pub fn all(asked: &[Self]) -> Assumptions {
        Assumptions {
            friction: asked.contains(&Self::Friction),
            pull: asked.contains(&Self::Pull),
            clearance: asked.contains(&Self::Clearance),
            torque: asked.contains(&Self::Torque),
            joints: asked.contains(&Self::Joints),
            velocity: asked.contains(&Self::Velocity),
        }
    }
}

impl Map {
    pub fn run(self) -> Outcome {
        let bench = self.robot.open()?;
        let gait = bench.any_gait(&self.gait)?;
        output::diagnostics(gait.warnings());
        let mut ledger = bench.ledger();
        gait.note(&mut ledger);
        let files = [("--svg", &self.svg), ("--csv", &self.csv), ("--page", &self.page)];
        files.into_iter().try_for_each(|(option, path)| note(&mut ledger, option, path.as_deref()))?;
        let options = MapOptions {
            speeds: self.speed,
            over: self.over,
            set: self.set,
            from: self.from,
            assume: Assumed::all(&self.assume),
            interpolated_from: if self.every_cell { None } else { Some(INTERPOLATED_FROM) },
        };
        let map = match &gait {
            AnyBench::OnePhase(gait) => gait.map(&options, self.csv.as_deref(), &bench.run())?,
            AnyBench::Phased(gait) => {
                gait.map(&bench.phases()?, &options, self.csv.as_deref(), &bench.run())?
            }
        };
        output::diagnostics(&map.messages);
        if let Some(path) = &self.csv {
            output::remark(&format!("wrote {}", path.display()));
        }
        write(self.svg.as_deref(), || map_svg(&map.figure()))?;
        write(self.page.as_deref(), || render_map(&map.figure()))?;
        if self.json {
            output::print_json(&map)?;
        } else {
            output::print(&map.to_string())?;
        }
        Ok(if map.complete { ExitCode::SUCCESS } else { ExitCode::from(INTERRUPTED) })
    }
}
