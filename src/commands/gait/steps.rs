//! `bipedc gait steps` and `bipedc gait capture`: the fewest steps to a speed.
use super::map::Assumed;
use super::values::{INTERRUPTED, assignment, note, over, range, write};
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::{Failure, Outcome};
use crate::terminal::output;
use bipedc::Workbench;
use bipedc::gait::{AnyBench, Assignment, Over, PlanOptions, Plans, Range};
use bipedc_analysis::report::{CurveFigure, curves_svg, render_curves};
use bipedc_effects::diagnostic::Diagnostic;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// As clap has it, but broken where a terminal of 80 columns ends.
const CAPTURE_USAGE: &str = "bipedc gait capture [OPTIONS] --gait <NAME|FILE.toml>\n                           --speed <V|A:B:N> <ROBOT>";
/// The same of the other command.
const USAGE: &str = "bipedc gait steps [OPTIONS] --gait <NAME|FILE.toml>\n                         --from-speed <V|A:B:N> --to <V> <ROBOT>";

const STEPS: &str = "\
Examples:
  bipedc gait steps robots/three_link --gait thesis --from-speed 1 --to 2
  bipedc gait steps robots/five_link --gait thesis --from-speed 1 --to 2 --set knee=0.3 --svg plan.svg
  bipedc gait steps robots/three_link --gait thesis --from-speed 0.5:4:141 --to 2 --alike --svg stairs.svg --csv stairs.csv

Each step chooses its parameters anew within the bounds of the gait file, or within --over (thesis 6.23). The present step is one among its \
own kind, with the parameters of the gait file or those of --from. What a step leaves to the next ones is its parameters, which \
fix the impact, and an energy: sets of energies that ways over N values of each parameter lead to say which speeds so many \
steps reach. Then the way that ends with the wished speed itself is found between two of them, and every step of it computed as \
`bipedc gait step` does, with --before and --from for the two steps ahead of it.

With --alike every step is taken as one among its own kind, as in the thesis: what it leaves is its speed alone, and to go as far as \
possible in each step is optimal. When parameters change, above all postures, real steps are others; the default counts that.

Steps of several phases take their parameters at mid-stance, are followed as they are, and go as far as possible each; --energies draws \
the energies of their zero dynamics.

A range of speeds gives the number of steps for each of them (thesis, figures 7.3 and 7.6).
JSON: {\"gait\", \"robot\", \"speed_unit\", \"to\", \"alike\", \"from\", \"choices\": [{\"name\", \"unit\", \"bounds\", \"values\"}], \"complete\", \
\"plans\": [{\"from_speed\", \"steps\", \"reason\", \"reason_code\", \"plan\": [{\"parameters\", \"speed\", \"energy\"}], \"reach\"}]}; \
docs/gaits.md explains every key.";

const CAPTURE: &str = "\
Examples:
  bipedc gait capture robots/three_link --gait thesis --speed 2
  bipedc gait capture robots/three_link --gait thesis --speed 0.5:4:141 --alike --svg capture.svg

The fewest steps to rest at a dead centre: N-step capturability (thesis, figure 7.3a). The same as `bipedc gait steps --to 0`, \
whose help explains the method and the JSON.";

/// The fewest steps from a speed to another, with the parameters of each step
#[derive(Args)]
#[command(after_help = STEPS, override_usage = USAGE)]
pub struct Steps {
    #[command(flatten)]
    planned: Planned,
    /// Speed at the dead centre of the present step, per second; or a range of them
    #[arg(long, value_name = "V|A:B:N", value_parser = speeds, allow_negative_numbers = true)]
    from_speed: Speeds,
    /// The wished speed at the dead centre of the last step
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    to: f64,
}

/// The fewest steps to rest at a dead centre
#[derive(Args)]
#[command(after_help = CAPTURE, override_usage = CAPTURE_USAGE)]
pub struct Capture {
    #[command(flatten)]
    planned: Planned,
    /// Speed at the dead centre of the present step, per second; or a range of them
    #[arg(long, value_name = "V|A:B:N", value_parser = speeds, allow_negative_numbers = true)]
    speed: Speeds,
}

impl Steps {
    pub fn run(self) -> Outcome {
        self.planned.run("--from-speed", self.from_speed, self.to)
    }
}

impl Capture {
    pub fn run(self) -> Outcome {
        self.planned.run("--speed", self.speed, 0.0)
    }
}

/// One speed or many.
#[derive(Debug, Clone, Copy)]
enum Speeds {
    One(f64),
    Many(Range),
}

fn speeds(text: &str) -> Result<Speeds, String> {
    if text.contains(':') {
        return range(text)
            .map(Speeds::Many)
            .map_err(|why| format!("{why}: write V, or A:B:N such as 0.5:3:51"));
    }
    text.trim()
        .parse()
        .map(Speeds::One)
        .map_err(|_| format!("`{text}` is no number: write V, or A:B:N such as 0.5:3:51"))
}

/// What both commands have.
#[derive(Args)]
struct Planned {
    #[command(flatten)]
    robot: RobotArguments,
    /// Name of a gait in gaits/ beside the robot's description, or a file
    #[arg(long, value_name = "NAME|FILE.toml")]
    gait: String,
    /// A parameter that each step chooses, with N values from A to B [default: all that are not set, within their bounds]
    #[arg(long, value_name = "NAME=A:B:N", value_parser = over)]
    over: Vec<Over>,
    /// A parameter that no step changes (SI units)
    #[arg(long, value_name = "NAME=X", value_parser = assignment)]
    set: Vec<Assignment>,
    /// A parameter of the present step
    #[arg(long, value_name = "NAME=X", value_parser = assignment)]
    from: Vec<Assignment>,
    /// Take every step as one among its own kind, as the thesis does: then a speed is all that a step leaves
    #[arg(long, conflicts_with = "from")]
    alike: bool,
    /// What has to hold in every step; `step`: the dead centre is passed
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',', default_value = "step")]
    assume: Vec<Assumed>,
    /// Most steps, up to 100
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u64).range(1..=100))]
    most: u64,
    /// Write the picture
    #[arg(long, value_name = "OUT.svg")]
    svg: Option<PathBuf>,
    /// Draw the energies of the zero dynamics along the steps of a gait of several phases (thesis, figure 7.10)
    #[arg(long, value_name = "OUT.svg", conflicts_with = "alike")]
    energies: Option<PathBuf>,
    /// Write the steps, or of a range the number of steps, as a table
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
    /// Write a page to look at; opens in any browser, needs no network
    #[arg(long, value_name = "OUT.html")]
    page: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

fn energies(bench: &Workbench, gait: &AnyBench, plans: &Plans) -> Result<CurveFigure, Failure> {
    match gait {
        AnyBench::Phased(gait) => Ok(gait.energies(&bench.phases()?, plans)?),
        AnyBench::OnePhase(_) => {
            let message = "--energies draws steps of several phases; this gait has one";
            let help = "walk a scenario with wished speeds: `bipedc simulate --energies` draws its steps";
            Err(Diagnostic::error(message).help(help).into())
        }
    }
}

impl Planned {
    fn run(self, option: &str, speeds: Speeds, to: f64) -> Outcome {
        let bench = self.robot.open()?;
        let gait = bench.any_gait(&self.gait)?;
        output::diagnostics(gait.warnings());
        let mut ledger = bench.ledger();
        gait.note(&mut ledger);
        let files = [
            ("--svg", &self.svg),
            ("--energies", &self.energies),
            ("--csv", &self.csv),
            ("--page", &self.page),
        ];
        files.into_iter().try_for_each(|(option, path)| note(&mut ledger, option, path.as_deref()))?;
        let from_speeds = match speeds {
            Speeds::One(speed) => vec![speed],
            Speeds::Many(range) => range.checked(option).map_err(Failure::from)?,
        };
        let options = PlanOptions {
            from_speeds,
            to,
            set: self.set,
            from: self.from,
            over: self.over,
            most: self.most as usize,
            alike: self.alike,
            assume: Assumed::all(&self.assume),
        };
        let plans = match &gait {
            AnyBench::OnePhase(gait) => gait.plans(&options, &bench.run())?,
            AnyBench::Phased(gait) => gait.plans(&bench.phases()?, &options, &bench.run())?,
        };
        output::diagnostics(&plans.messages);
        // Interrupted before the first: files that are there stay.
        if !plans.plans.is_empty() {
            write(self.svg.as_deref(), || curves_svg(&plans.figure()))?;
            if let Some(path) = &self.energies {
                let figure = energies(&bench, &gait, &plans)?;
                write(Some(path), || curves_svg(&figure))?;
            }
            write(self.csv.as_deref(), || plans.csv())?;
            write(self.page.as_deref(), || render_curves(&plans.figure()))?;
        }
        if self.json {
            output::print_json(&plans)?;
        } else {
            output::print(&plans.to_string())?;
        }
        Ok(if plans.complete { ExitCode::SUCCESS } else { ExitCode::from(INTERRUPTED) })
    }
}
