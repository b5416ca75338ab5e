//! `bipedc gait robust`: how often a gait survives what its model does not know.
use super::values::{INTERRUPTED, note, write};
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use bipedc::simulation::{DisturbanceKind, RobustOptions};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

const ROBUST: &str = "\
Examples:
  bipedc gait robust robots/three_link --scenario robots/three_link/scenarios/robust.toml
  bipedc gait robust robots/three_link --scenario robots/three_link/scenarios/robust.toml --disturb push=5 --disturb push=10 --trials 200 --svg robust.svg

Walks the scenario again and again, from event to event, each time with another disturbance of the robot that the controller does not \
know; twice each time: with the parameters of the scenario, and with parameters chosen anew at each mid-stance from the measured state \
for the scenario's wished speeds (docs/gaits.md). A walk succeeds if it takes all its steps and every assumption that the scenario checks \
holds; slipping counts as a failure as falling does.

  push   N s  a horizontal push on the base, either way, 0.1 s long, at some time in the first second
  mass   1    masses and inertias of all links, each by another part
  slope  rad  the ground falls or rises
  height m    each foothold is higher or lower than the one before; only where a foot lands where it meets the ground
  noise  rad  standard deviation of all measured positions (rad, m), ten times that of velocities; a controller that is asked every ms
  delay  s    measurements are that late, in whole ms, and torques held for 1 ms

Sizes are limits of uniform distributions but for noise and delay. The usual ones are 0.1 mass √(gravity × height of the hips) of a push \
and 0.007 of that height, in two digits, whatever the size of the robot: 5.2 N s and 4.9 mm of one of 20 kg and 0.7 m. Equal seeds give equal trials, of all sizes and both ways alike. Ctrl-C ends \
with code 130 and what was tried so far.
JSON: {\"robot\", \"scenario\", \"steps\", \"seed\", \"complete\", \"tried\": [{\"disturbance\": {\"kind\", \"size\"}, \"fixed\": {\"successes\", \"trials\", \
\"rate\", \"interval\": [low, high], \"failures\": {why: count}}, \"chosen\": the same, \"only_fixed\", \"only_chosen\" (trials that succeed one way \
alone)}]}.";

/// How often walks under disturbances come to their end, with and without choosing parameters anew
#[derive(Args)]
#[command(after_help = ROBUST)]
pub struct Robust {
    #[command(flatten)]
    robot: RobotArguments,
    /// A scenario of a gait with wished speeds
    #[arg(long, value_name = "FILE.toml")]
    scenario: PathBuf,
    /// A disturbance, with its size [default: each of them with its usual size: push and height by the robot's, below, mass=0.1, slope=0.02, noise=0.001, delay=0.002]
    #[arg(long, value_name = "KIND[=SIZE]", value_parser = disturbance)]
    disturb: Vec<Asked>,
    /// Trials of each disturbance
    #[arg(long, value_name = "N", default_value_t = 1000)]
    trials: usize,
    /// Of all random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Write the picture
    #[arg(long, value_name = "OUT.svg")]
    svg: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// A disturbance, and its size where it is not the usual one.
type Asked = (DisturbanceKind, Option<f64>);

/// `KIND` or `KIND=SIZE`.
fn disturbance(text: &str) -> Result<Asked, String> {
    let (name, size) = text.split_once('=').map_or((text, None), |(name, size)| (name, Some(size)));
    let kind = DisturbanceKind::ALL.into_iter().find(|kind| kind.name() == name.trim());
    let names = DisturbanceKind::ALL.map(DisturbanceKind::name).join(", ");
    let kind = kind.ok_or_else(|| format!("there is no disturbance `{name}`: write one of {names}"))?;
    let Some(size) = size else { return Ok((kind, None)) };
    let size = size.trim().parse().map_err(|_| format!("`{size}` is no number"))?;
    let most = if kind == DisturbanceKind::Mass { 0.9 } else { 1e3 };
    if !(0.0..=most).contains(&size) {
        return Err(format!("a size of {size} is not possible: write 0 to {most} {}", kind.unit()));
    }
    Ok((kind, Some(size)))
}

impl Robust {
    pub fn run(self) -> Outcome {
        let bench = self.robot.open()?;
        let scene = bench.scene(&self.scenario)?;
        let mut ledger = bench.ledger();
        scene.note(&mut ledger);
        note(&mut ledger, "--svg", self.svg.as_deref())?;
        let disturbances = match &self.disturb[..] {
            [] => scene.disturbances(),
            asked => asked.iter().map(|&(kind, size)| scene.disturbance(kind, size)).collect(),
        };
        let options = RobustOptions { trials: self.trials, seed: self.seed, disturbances };
        let robust = scene.robust(&options, &bench.run())?;
        write(self.svg.as_deref(), || robust.svg())?;
        if self.json {
            output::print_json(&robust)?;
        } else {
            output::print(&robust.to_string())?;
        }
        Ok(if robust.complete { ExitCode::SUCCESS } else { ExitCode::from(INTERRUPTED) })
    }
}
