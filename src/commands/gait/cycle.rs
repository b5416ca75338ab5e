//! `bipedc gait cycle`: walking that repeats itself.
use super::values::{INTERRUPTED, assignment, note, over, write};
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use bipedc::gait::{AnyBench, Assignment, CycleOptions, Over};
use bipedc_analysis::report::{curves_svg, render_curves};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

const CYCLE: &str = "\
Examples:
  bipedc gait cycle robots/three_link --gait thesis
  bipedc gait cycle robots/five_link --gait thesis --set torso_lean=0.4 --over step_length=0.15:0.7:23 --svg cycles.svg

Steps with the same parameters become a cycle where the impact takes what the fall gives: E = P₋ δ/(δ − 1) (thesis 6.17). Its multiplier \
is δ: that part of a small deviation of the speed is left after each step. Work is that of the torques that the motion needs, \
over a whole step; braking counts as driving does. A cycle of several phases is found by following steps until they repeat themselves; its \
step length is how far the base comes.
K at mid-stance (thesis 6.19) is told between which steps keep friction, push and torques, and the speeds from which steps come back to the cycle that way. Without \
--over the whole robot is simulated from states near the beginning of a step: its multipliers are those of the full hybrid model.
JSON: {\"gait\", \"robot\", \"speed_unit\", \"energy_unit\", \"over\", \"over_unit\", \"complete\", \"cycles\": [{\"parameters\", \"cycle\": {\"speed\", \"multiplier\", \
\"duration\" (s), \"step_length\" (m), \"walking_speed\" (m/s), \"work\" (J), \"net_work\" (J), \"cost_of_transport\", \"energy\", \"k_min\", \"k_max\", \"basin\"}, \"reason\", \"whole\": {\"multipliers\": [[real, imaginary]], \"miss\", \"repeats\": {\"off\", \"miss\", \"rounds\"}, \"reason\"}}]}.";

/// Walking that repeats itself: its speed, stability and cost
#[derive(Args)]
#[command(after_help = CYCLE)]
pub struct Cycle {
    #[command(flatten)]
    robot: RobotArguments,
    /// Name of a gait in gaits/ beside the robot's description, or a file
    #[arg(long, value_name = "NAME|FILE.toml")]
    gait: String,
    /// A parameter (SI units)
    #[arg(long, value_name = "NAME=X", value_parser = assignment)]
    set: Vec<Assignment>,
    /// A cycle for each of N values of a parameter from A to B
    #[arg(long, value_name = "NAME=A:B:N", value_parser = over)]
    over: Option<Over>,
    /// Write the picture of a range
    #[arg(long, value_name = "OUT.svg", requires = "over")]
    svg: Option<PathBuf>,
    /// Write all cycles as a table
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
    /// Write a page of a range to look at; opens in any browser, needs no network
    #[arg(long, value_name = "OUT.html", requires = "over")]
    page: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl Cycle {
    pub fn run(self) -> Outcome {
        let bench = self.robot.open()?;
        let gait = bench.any_gait(&self.gait)?;
        output::diagnostics(gait.warnings());
        let mut ledger = bench.ledger();
        gait.note(&mut ledger);
        let files = [("--svg", &self.svg), ("--csv", &self.csv), ("--page", &self.page)];
        files.into_iter().try_for_each(|(option, path)| note(&mut ledger, option, path.as_deref()))?;
        let options = CycleOptions { set: self.set, over: self.over };
        let mut cycles = match &gait {
            AnyBench::OnePhase(gait) => gait.cycles(&options, &bench.run())?,
            AnyBench::Phased(gait) => gait.cycles(&bench.phases()?, &options, &bench.run())?,
        };
        if cycles.over.is_none() {
            bench.whole_cycle(&gait, &mut cycles)?;
        }
        output::diagnostics(&cycles.messages);
        write(self.svg.as_deref(), || curves_svg(&cycles.figure()))?;
        write(self.csv.as_deref(), || cycles.csv())?;
        write(self.page.as_deref(), || render_curves(&cycles.figure()))?;
        if self.json {
            output::print_json(&cycles)?;
        } else {
            output::print(&cycles.to_string())?;
        }
        Ok(if cycles.complete { ExitCode::SUCCESS } else { ExitCode::from(INTERRUPTED) })
    }
}
