//! `bipedc excite`: joint trajectories from which parameters can be identified well.
mod plot;
mod postures;
mod say;
mod separate;
mod subject;

use crate::arguments::RobotArguments;
use crate::failure::Outcome;
use crate::{interruption, output};
use bipedc_analysis::identify::excite::{Basis, Criterion, Family, Machine, Request, Scaling, design};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::Output;
use clap::{Args, ValueEnum};
use postures::{PostureArguments, Shared};
use separate::SeparateArguments;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Duration;
use subject::Excited;

const EXAMPLES: &str = "\
Examples:
  bipedc excite robots/tulip_v1_leg --duration 10 --harmonics 5 --out trajectory.csv
  bipedc excite robots/tulip_v1_leg --joints right_hip_pitch,right_knee_pitch --margin 20 --out gentle.csv
  bipedc excite robots/tulip --base fixed --acceleration 15 --time-limit 120 --out trajectory.csv --json
  bipedc excite robots/tulip_v1_leg --separate coulomb_friction viscous_friction --joint right_knee_pitch --out apart.csv
  bipedc excite robots/tulip_v1_leg --separate rotor_inertia payload --joint right_knee_pitch --link right_lower_leg --out apart.csv
  bipedc excite robots/tulip --postures 50 --placements 10 --out postures.csv --plot postures.svg

A log of a poor motion tells some parameters only together. This looks for the joint trajectories whose base regressor
(thesis 5.9) has the smallest condition number, within the limits of position, velocity and effort of the URDF
(thesis 5.16): the condition number says how many times more the errors of the worst parameter grow than those of the best.
Below 100 is good; above some hundreds expect parameters that the log does not tell.

Trajectories are finite Fourier series: they repeat after --duration and start and end at rest, so that they may be run
over and over. With --degree5 they are polynomials of degree 5 as in the thesis; these may begin and end in motion
unless --at-rest.
Then: run the motion on the robot, log positions and efforts, and ask `bipedc identify`.

With --separate: the motion that best tells two effects of the library apart which `bipedc diagnose` could not tell apart.

With --postures: sets of static postures for force plates (thesis 5.24), both feet flat on K placements, within the joints'
limits, the centre of pressure inside the support. Add measured columns cop/x and cop/y to the file and ask
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

/// More rows than this are a mistake.
const ROWS: f64 = 1e7;

impl Excite {
    /// Reads, searches, writes, prints.
    pub fn run(self) -> Outcome {
        let request = self.request()?;
        let robot = self.robot.read()?;
        let mut ledger = self.robot.ledger(&robot);
        ledger.writes("--out", &self.out)?;
        self.postures.note(&mut ledger)?;
        if let Some(postures) = self.postures.postures {
            let shared = Shared {
                robot: &robot,
                out: &self.out,
                margin: request.margin,
                gap: self.gap,
                criterion: request.criterion,
                seed: self.seed,
                starts: self.starts,
                evaluations: self.evaluations.unwrap_or(2000),
                time_limit: request.time_limit,
                json: self.json,
            };
            return self.postures.run(postures, &shared);
        }
        let mut excited =
            output::progress("deriving", || Excited::new(&robot, &self.joints, self.acceleration, self.gap))?;
        if self.separate.wanted() {
            let rows = (self.duration * self.rate).round() as usize + 1;
            return self.separate.run(&robot, excited, &request, &self.out, rows, self.json);
        }
        let assumptions = excited.assumptions.clone();
        let machine = excited.machine();
        // Whether the file can be written shows before the search, not after it.
        let mut file = Output::create(&self.out)?;
        let interrupted = interruption::flag();
        let stop = || interrupted.load(Ordering::Relaxed);
        let found = output::bar("searching", |progress| design(&machine, &request, progress, &stop))?;
        let count = (self.duration * self.rate).round() as usize + 1;
        file.put(&csv(&machine, &found.basis, &found.coefficients, count))?;
        file.commit()?;
        let answer = say::Answer::new(&robot.description.name, &machine, &request, &found, &assumptions)
            .with_file(&self.out, count);
        if self.json {
            output::print_json(&answer)?;
        } else {
            output::print(&answer.to_string())?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// What is wanted, in the library's words.
    fn request(&self) -> Result<Request, Diagnostic> {
        let refuse = |what: &str, value: f64, help: &str| {
            Err(Diagnostic::error(format!("{what} is {value}")).help(help.to_owned()))
        };
        if !(self.duration.is_finite() && self.duration > 0.0) {
            return refuse("--duration", self.duration, "give a time above 0 s; 10 is usual");
        }
        if !(self.rate.is_finite() && self.rate > 0.0) {
            return refuse("--rate", self.rate, "give a frequency above 0 Hz");
        }
        if self.duration * self.rate > ROWS {
            return refuse(
                "--rate times --duration",
                self.duration * self.rate,
                "give at most ten million rows",
            );
        }
        if !(0.0..=90.0).contains(&self.margin) {
            return refuse("--margin", self.margin, "give 0 to 90 per cent");
        }
        if let Some(limit) = self.acceleration.filter(|limit| !(limit.is_finite() && *limit > 0.0)) {
            return refuse("--acceleration", limit, "give a number above 0 rad/s²");
        }
        let seconds = |limit: f64| Duration::try_from_secs_f64(limit).ok().filter(|limit| !limit.is_zero());
        let time_limit = match self.time_limit {
            Some(limit) => match seconds(limit) {
                None => return refuse("--time-limit", limit, "give a time above 0 s"),
                some => some,
            },
            None => None,
        };
        Ok(Request {
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
            time_limit,
        })
    }
}

/// The trajectory as a log: time and what every joint does.
fn csv(machine: &Machine<'_>, basis: &Basis, coefficients: &[f64], count: usize) -> String {
    let motion = machine.motion(basis, coefficients, count);
    let joints = &machine.subject.joints;
    let mut text = String::from("time");
    for joint in joints {
        let name = &joint.name;
        let _ = write!(text, ",{name}/position,{name}/velocity,{name}/acceleration");
    }
    text.push('\n');
    for i in 0..count {
        let _ = write!(text, "{:.9}", basis.duration() * i as f64 / (count.max(2) - 1) as f64);
        for at in i * joints.len()..(i + 1) * joints.len() {
            // Adding zero makes -0 a 0.
            let [q, v, a] = [motion.q[at], motion.v[at], motion.a[at]].map(|x| (x * 1e9).round() / 1e9 + 0.0);
            let _ = write!(text, ",{q:.9},{v:.9},{a:.9}");
        }
        text.push('\n');
    }
    text
}
