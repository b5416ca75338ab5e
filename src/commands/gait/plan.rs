//! `bipedc gait plan`: walks on flat feet, from footsteps to joint motions.
use super::values::{INTERRUPTED, assignment, note, write};
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use bipedc::gait::Assignment;
use bipedc::walking::{self, Method, Options, Path};
use bipedc_analysis::report::render_film;
use bipedc_analysis::walking::{Advance, read_settings};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::process::ExitCode;

const PLAN: &str = "\
Examples:
  bipedc gait plan robots/tulip --gait forward --out plan.csv --report plan.html
  bipedc gait plan robots/tulip --gait turn --angle 15 --count 6 --out plan.csv
  bipedc gait plan robots/tulip --gait dynamic --speed 0.3 --count 12 --out plan.csv --report plan.html
  bipedc gait plan robots/tulip --gait dynamic --speed 0.15,0.3,0.15 --turning 0.2 --count 18 --out curve.csv
  bipedc gait plan robots/tulip --gait steps --steps footsteps.csv --out plan.csv --json

forward, side and turn are statically stable: the weight is shifted over a foot, the other one is lifted and placed, each with a cosine profile \
of velocities (thesis 6.43), and the centre of mass stays above the support polygon. steps does that along a table of footsteps. dynamic is \
dynamically stable: the zero moment point goes from foot to foot while both stand; the centre of mass follows by a bounded divergent component of \
motion, and what the moving limbs add to the pendulum's zero moment point is fed back until the whole robot's meets its reference. pendulum is the \
thesis' own: a linear inverted pendulum per step without double support (6.45), (6.46). dynamic and pendulum take --steps, too.

Joint angles follow by differential inverse kinematics without drift (6.47-6.53) within the joints' limits. Every sample is held against \
limits of position, velocity and torque, the margin of the zero moment point, clearance, friction and the distance of feet and legs. Where one does not \
hold, the first is named with step, time, joint, value and limit; exit code 4: the report is written and shows it, the plan is not. Where no joint \
angles do what is wished, step, joint and time are told; exit code 1.

Numbers such as `com_height`, `step_height` or `margin` are derived from the robot; walking.toml beside its description, --walking and --set NAME=X state \
them instead. docs/walking.md lists them, and the columns of the plan; `[control] trajectory = \"plan.csv\"` in a scenario lets `bipedc simulate` follow it.

JSON: {\"robot\", \"method\", \"complete\", \"holds\", \"samples\", \"duration\" (s), \"moved\": [m, m, rad], \"speed\" (m/s), \"rounds\", \"zmp_error\" (m), \
\"violation\": {\"quantity\", \"of\", \"value\", \"limit\": {\"least\"|\"most\"}, \"unit\", \"time\" (s), \"step\", \"phase\"}, \"violations\" (samples), \"nearest\": [the same], \
\"settings\": {name: number}, \"footsteps\": [{\"foot\", \"x\", \"y\" (m), \"yaw\" (rad), \"duration\" (s)}], \"phases\": [{\"kind\", \"step\", \"start\", \"duration\" (s), \
\"swing\"}], \"soles\": [{\"foot\", \"link\", \"center\" (m), \"axes\", \"corners\" (m)}]}.";

/// Plans a walk on flat feet: footsteps to joint motions that keep the balance and every limit
#[derive(Args)]
#[command(after_help = PLAN)]
pub struct Plan {
    #[command(flatten)]
    robot: RobotArguments,
    /// How the robot walks
    #[arg(long, value_enum)]
    gait: Walk,
    /// Steps, the one that joins the feet at the end included
    #[arg(long, value_name = "N", default_value_t = 6)]
    count: usize,
    /// forward: how far each step goes beyond the other foot, m [default: a twelfth of the height of the centre of mass]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    stride: Option<f64>,
    /// side: how far each pair of steps goes to the left, m [default: a fifteenth of the height of the centre of mass]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    side: Option<f64>,
    /// turn: by how much each pair of steps turns to the left, degrees
    #[arg(long, value_name = "DEG", default_value_t = 15.0, allow_negative_numbers = true)]
    angle: f64,
    /// dynamic, pendulum: speed forward, m/s; several, separated by commas, have equal shares of the steps
    #[arg(
        long,
        value_name = "V[,V…]",
        value_delimiter = ',',
        default_value = "0",
        allow_negative_numbers = true
    )]
    speed: Vec<f64>,
    /// dynamic, pendulum: speed to the left, m/s
    #[arg(long, value_name = "V", default_value_t = 0.0, allow_negative_numbers = true)]
    sideways: f64,
    /// dynamic, pendulum: turning to the left, rad/s
    #[arg(long, value_name = "W", default_value_t = 0.0, allow_negative_numbers = true)]
    turning: f64,
    /// A table of footsteps: foot,x,y,yaw[,duration] (left or right, m, m, rad, s)
    #[arg(long, value_name = "STEPS.csv")]
    steps: Option<PathBuf>,
    /// A file like walking.toml, instead of the robot's own
    #[arg(long, value_name = "FILE.toml")]
    walking: Option<PathBuf>,
    /// One of the numbers of the walk (SI units), such as com_height=0.6
    #[arg(long, value_name = "NAME=X", value_parser = assignment)]
    set: Vec<Assignment>,
    /// Write the plan: joints, base, feet, balance over time
    #[arg(long, value_name = "PLAN.csv")]
    out: Option<PathBuf>,
    /// Write a page that shows the robot walk; opens in any browser, needs no network
    #[arg(long, value_name = "PLAN.html")]
    report: Option<PathBuf>,
    /// Write the picture of footprints and balance
    #[arg(long, value_name = "PLAN.svg")]
    svg: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Walk {
    /// Statically stable, straight ahead
    Forward,
    /// Statically stable, to the side
    Side,
    /// Statically stable, on the spot
    Turn,
    /// Statically stable, along --steps
    Steps,
    /// Dynamically stable
    Dynamic,
    /// Linear inverted pendulums alone
    Pendulum,
}

const DOES_NOT_HOLD: u8 = 4;

impl Plan {
    pub fn run(self) -> Outcome {
        let bench = self.robot.open()?;
        let mut ledger = bench.ledger();
        let (mut stated, own) = match &self.walking {
            Some(file) => (read_settings(file)?, Some(file.clone())),
            None => walking::robots_own(bench.robot())?,
        };
        own.iter().for_each(|file| ledger.reads("the numbers of the walk", file));
        self.steps.iter().for_each(|file| ledger.reads("the footsteps", file));
        let files = [("--out", &self.out), ("--report", &self.report), ("--svg", &self.svg)];
        files.into_iter().try_for_each(|(option, path)| note(&mut ledger, option, path.as_deref()))?;
        self.set.iter().try_for_each(|(name, value)| stated.set(name, *value))?;
        let options = Options { method: self.method(), path: self.path()?, stated };
        let plan = walking::plan(bench.robot(), &options, &bench.run())?;
        if let Some(path) = &self.report {
            let page = render_film(&plan.film()?);
            write(Some(path), || page)?;
        }
        write(self.svg.as_deref(), || plan.picture())?;
        let holds = plan.violation.is_none() && plan.complete;
        if let (true, Some(path)) = (holds, &self.out) {
            plan.write(path)?;
            output::remark(&format!("wrote {}", path.display()));
        }
        if self.json {
            output::print_json(&plan)?;
        } else {
            output::print(&plan.to_string())?;
        }
        Ok(match (plan.complete, holds) {
            (false, _) => ExitCode::from(INTERRUPTED),
            (true, false) => ExitCode::from(DOES_NOT_HOLD),
            (true, true) => ExitCode::SUCCESS,
        })
    }

    fn method(&self) -> Method {
        match self.gait {
            Walk::Dynamic => Method::Dynamic,
            Walk::Pendulum => Method::Pendulum,
            _ => Method::Static,
        }
    }

    /// What the steps are, with everything that has no meaning.
    fn path(&self) -> Result<Path, Diagnostics> {
        let mut wrong = Vec::new();
        let mut within = |name: &str, value: f64, most: f64| {
            if !(-most..=most).contains(&value) {
                let message = format!("{name}: {value} is not possible");
                wrong.push(Diagnostic::error(message).help(format!("write a number from -{most} to {most}")));
            }
        };
        within("--angle", self.angle, 180.0);
        self.stride.iter().for_each(|&x| within("--stride", x, 10.0));
        self.side.iter().for_each(|&x| within("--side", x, 10.0));
        self.speed.iter().for_each(|&v| within("--speed", v, 10.0));
        within("--sideways", self.sideways, 10.0);
        within("--turning", self.turning, 10.0);
        if !(1..=500).contains(&self.count) {
            let message = format!("--count: {} steps are not possible", self.count);
            wrong.push(Diagnostic::error(message).help("write a number from 1 to 500"));
        }
        if self.gait == Walk::Steps && self.steps.is_none() {
            wrong.push(Diagnostic::error("--gait steps needs footsteps").help("add --steps FOOTSTEPS.csv"));
        }
        if self.steps.is_some() && matches!(self.gait, Walk::Forward | Walk::Side | Walk::Turn) {
            let message = "--steps says where feet go, --gait forward, side or turn as well";
            wrong.push(Diagnostic::error(message).help("write --gait steps, or --gait dynamic"));
        }
        if !wrong.is_empty() {
            return Err(Diagnostics(wrong));
        }
        if let Some(file) = &self.steps {
            return Ok(Path::Table(file.clone()));
        }
        let of = |forward, sideways, turn| Advance { forward, sideways, turn };
        Ok(match self.gait {
            Walk::Forward => Path::Forward(self.stride, self.count),
            Walk::Side => Path::Sideways(self.side, self.count),
            Walk::Turn => Path::Repeated(vec![of(0.0, 0.0, 0.5 * self.angle.to_radians())], self.count),
            _ => {
                let at = |speed: &f64| of(*speed, self.sideways, self.turning);
                Path::AtSpeed(self.speed.iter().map(at).collect(), self.count)
            }
        })
    }
}
