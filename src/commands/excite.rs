//! `bipedc excite`: joint trajectories from which parameters can be identified well.
mod postures;
mod separate;

use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use bipedc::excitation::Options;
use bipedc_analysis::identify::excite::{Criterion, Family, Request, Scaling};
use bipedc_effects::diagnostic::Diagnostic;
use clap::{Args, ValueEnum};
use postures::PostureArguments;
use separate::SeparateArguments;
use serde::Serialize;
use std::fmt::Display;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

const EXAMPLES: &str = "\
Examples:
  bipedc excite robots/tulip_v1_leg --duration 10 --harmonics 5 --out trajectory.csv
  bipedc excite robots/tulip_v1_leg --joints right_hip_pitch,right_knee_pitch --margin 20 --out gentle.csv
  bipedc excite robots/tulip --base fixed --acceleration 15 --time-limit 120 --out trajectory.csv --json
  bipedc excite robots/tulip_v1_leg --separate coulomb_friction viscous_friction --joint right_knee_pitch --out apart.csv
  bipedc excite robots/tulip_v1_leg --separate rotor_inertia payload --joint right_knee_pitch --link right_lower_leg --out apart.csv
  bipedc excite robots/tulip --postures 50 --placements 10 --out postures.csv --plot postures.svg

A log of a poor motion tells some parameters only together. This looks for the joint trajectories whose base regressor \
(thesis 5.9) has the smallest condition number, within the limits of position, velocity and effort of the URDF \
(thesis 5.16): the condition number says how many times more the errors of the worst parameter grow than those of the best.
Below 100 is good; above some hundreds expect parameters that the log does not tell.

Trajectories are finite Fourier series: they repeat after --duration and start and end at rest, so that they may be run \
over and over. With --degree5 they are polynomials of degree 5 as in the thesis; these may begin and end in motion \
unless --at-rest.
Then: run the motion on the robot, log positions and efforts, and ask `bipedc identify`.

With --separate: the motion that best tells two effects of the library apart which `bipedc diagnose` could not tell apart.

With --postures: sets of static postures for force plates (thesis 5.24), both feet flat on K placements, within the joints' \
limits, the centre of pressure inside the support. Add measured columns cop/x and cop/y to the file and ask \
`bipedc identify --method cop`. Ctrl-C ends the search with the best so far.

The soles are kept apart (--gap), other links are not: always try a designed motion slowly and in simulation first.
docs/experiments.md explains the method and every key of --json.";

/// What is made small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum By {
    /// Condition number of the regressor with columns of length 1 (of postures: as it stands)
    Condition,
    /// Condition number of the regressor as it stands, in SI units (as in the thesis, 5.16)
    Unscaled,
    /// Minus the logarithm of the determinant of the information
    Information,
}

/// Design joint trajectories, or static postures, that tell parameters well
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Excite {
    #[command(flatten)]
    robot: RobotArguments,
    /// Joints that move [default: those with an actuator]; the others stay at 0 or at the nearest position they can have
    #[arg(long, value_name = "JOINTS", value_delimiter = ',')]
    joints: Vec<String>,
    /// Of the motion, s
    #[arg(long, value_name = "T", allow_negative_numbers = true, default_value_t = 10.0)]
    duration: f64,
    /// Number of harmonics of 1/duration
    #[arg(long, value_name = "N", default_value_t = 5)]
    harmonics: usize,
    /// Polynomials of degree 5 instead of Fourier series
    #[arg(long, conflicts_with = "harmonics")]
    degree5: bool,
    /// Polynomials that begin and end without velocity
    #[arg(long, requires = "degree5")]
    at_rest: bool,
    /// Where the trajectory goes
    #[arg(long, value_name = "TRAJECTORY.csv")]
    out: PathBuf,
    /// Rows per second of the file, Hz
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, default_value_t = 200.0)]
    rate: f64,
    /// Part of every limit left unused, per cent
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true, default_value_t = 5.0)]
    margin: f64,
    /// Largest acceleration of every joint, rad/s² or m/s² [default: what efforts allow]
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    acceleration: Option<f64>,
    /// Least distance between the soles, m
    #[arg(long, value_name = "M", allow_negative_numbers = true, default_value_t = 0.02)]
    gap: f64,
    /// What is made small
    #[arg(long, value_enum, default_value = "condition", conflicts_with = "separate")]
    criterion: By,
    /// Of the random starts: equal seeds give equal files unless time ran out
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Number of random starts
    #[arg(long, value_name = "N", default_value_t = 6)]
    starts: usize,
    /// Most evaluations of the cost in one start [default: 400, for postures 2000]
    #[arg(long, value_name = "N")]
    evaluations: Option<usize>,
    /// After this the best so far is taken, s
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    time_limit: Option<f64>,
    #[command(flatten)]
    separate: SeparateArguments,
    #[command(flatten)]
    postures: PostureArguments,
    /// Print the answer as JSON (docs/experiments.md explains every key)
    #[arg(long)]
    json: bool,
}

impl Excite {
    /// Reads, searches, writes, prints.
    pub fn run(self) -> Outcome {
        let options = self.options()?;
        let bench = self.robot.open()?;
        let mut ledger = bench.ledger();
        ledger.writes("--out", &self.out)?;
        self.postures.note(&mut ledger)?;
        if let Some(options) = self.postures.options(&options, self.evaluations) {
            return self.print(&bench.design_postures(&options, &self.out)?);
        }
        match self.separate.options() {
            Some(asked) => self.print(&bench.separate_effects(&options, &asked, &self.out)?),
            None => self.print(&bench.design_motion(&options, &self.out)?),
        }
    }

    fn print(&self, answer: &(impl Display + Serialize)) -> Outcome {
        if self.json {
            output::print_json(answer)?;
        } else {
            output::print(&answer.to_string())?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// What is wanted, in the library's words.
    fn options(&self) -> Result<Options, Diagnostic> {
        let mut options = Options {
            joints: self.joints.clone(),
            acceleration: self.acceleration,
            gap: self.gap,
            rate: self.rate,
            request: self.request(),
        };
        options.check()?;
        options.request.time_limit = self.limits()?;
        Ok(options)
    }

    fn request(&self) -> Request {
        Request {
            family: match (self.degree5, self.at_rest) {
                (true, true) => Family::RestingPolynomial(5),
                (true, false) => Family::Polynomial(5),
                _ => Family::Fourier(self.harmonics),
            },
            duration: self.duration,
            margin: self.margin / 100.0,
            scaling: if self.criterion == By::Unscaled { Scaling::Own } else { Scaling::Unit },
            criterion: match self.criterion {
                By::Condition | By::Unscaled => Criterion::Condition,
                By::Information => Criterion::Information,
            },
            seed: self.seed,
            starts: self.starts,
            evaluations: self.evaluations.unwrap_or(400),
            time_limit: None,
        }
    }

    /// Refuses what only arguments can get wrong; the time limit.
    fn limits(&self) -> Result<Option<Duration>, Diagnostic> {
        let refuse = |what: &str, value: f64, help: &str| {
            Err(Diagnostic::error(format!("{what} is {value}")).help(help.to_owned()))
        };
        if !(0.0..=90.0).contains(&self.margin) {
            return refuse("--margin", self.margin, "give 0 to 90 per cent");
        }
        let seconds = |limit: f64| Duration::try_from_secs_f64(limit).ok().filter(|limit| !limit.is_zero());
        match self.time_limit {
            Some(limit) => match seconds(limit) {
                None => refuse("--time-limit", limit, "give a time above 0 s"),
                some => Ok(some),
            },
            None => Ok(None),
        }
    }
}
