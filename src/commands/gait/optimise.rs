//! `bipedc gait optimise`: gaits found by direct collocation.
use super::values::INTERRUPTED;
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use bipedc::gait::optimise::{MOST_BEGINNINGS, Objective, Wishes};
use bipedc::workbench::{OptimiseOptions, gait_file, may_be_replaced, search_file};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::files::write_with_folders;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// As clap has it, but broken where a terminal of 80 columns ends.
const USAGE: &str = "bipedc gait optimise [OPTIONS] --gait <NAME|FILE.toml> --speed <V>...\n                            --out <NEW.toml|FOLDER> <ROBOT>";

const OPTIMISE: &str = "\
Examples:
  bipedc gait optimise robots/five_link --gait optimised --speed 0.7 --out faster.toml
  bipedc gait optimise robots/five_link --gait optimised --speed 0.6 0.7 0.8 0.9 --out library
  bipedc gait optimise robots/seven_link_v1 --gait collocated --speed 0.4 --friction 0.4 --out gait.toml --json

--gait names a gait whose phases, phase variables and outputs are kept; curves, torques and ends are found anew, from nothing but the \
robot: its posture at ease, feet on straight lines. The whole dynamics hold at the nodes of every phase, with impacts, with \
steps that repeat themselves, and with margins from the ground, friction, torques and joints. The mean squared torque is made small, or by --cost transport \
the work of all joints over weight and distance, with a little of the squared accelerations. Coefficients of the Bezier polynomials are unknowns of the search, so that what is found is a gait file.

What was found is tried as it would be written: steps under its own controller until they repeat themselves, then a walk of the whole robot from event to \
event, with the ground checked as `bipedc simulate` with [assumptions] checks it. Where that walk lacks something of what was asked (speed within 1 %, friction, \
impulses, centre of pressure, clearance, multiplier), the search goes on from there and asks for so much more, six motions at most; a motion \
that does not walk is looked for again on more nodes. Robots with feet have many minima: --beginnings tries several lengths of the first steps and keeps the motion that costs least; \
more of them take longer and often find a gait of half the cost. What is still missing is said, and is in the JSON under \"lacking\". \
A motion that does not walk is written all the same, exit code 3. Where none is found, it is searched for from a usual speed on, step by step: told is the nearest speed that a gait is found at with the limits that are met there (a fast speed is \
come to that way at once). Where that is not found either, the violated constraints are told with phase and node; exit code 4, nothing is written.

--start begins at the curves of another gait with the same phases instead of from nothing: one that was found before, or that somebody else found. A robot without any \
gait gets a form by `bipedc gait new`.

Several speeds make a library: --out is a folder, each search begins where the one before ended. Ctrl-C leaves what is done, \
exit code 130; the same command, also with further speeds behind, takes over what is there and goes on from there: the same bytes as in one run. \
Gaits are taken over if their file and the one in FOLDER/searches are of the same robot, form, options and speeds up to their own; others are found anew and written over.

JSON: {\"form\", \"robot\", \"wished\": {\"mass\" (kg), \"height\" (m), \"gravity\" (m/s²), \"friction\", \"clearance\", \"zmp\" (m), \"impulse\" (N s), \"by_size\"}, \"complete\", \"gaits\": [{\"speed\" (m/s), \"taken_over\", \"feasible\", \"minimum\", \"iterations\", \"seconds\", \"durations\" (s), \"step_length\" (m), \"cost_of_transport\", \
\"margins\": {\"friction\", \"impact_friction\", \"push\" (N), \"impulse\" (N s), \"zmp\", \"clearance\" (m), \"torque\", \"largest_torque\" (N m), \"joint\", \"velocity\"}, \"impulse\" (N s), \"beginnings\": [{\"step\" (m), \"feasible\", \"cost\", \"cost_of_transport\", \"kept\"}], \"rounds\", \"lacking\", \"search_seconds\", \"violations\": \
[{\"constraint\", \"phase\", \"node\", \"by\"}], \"reach\": {\"speed\" (m/s), \"beyond\" (m/s), \"limits\", \"usual\" (m/s)}, \"closed_loop\": {\"walks\", \"reason\", \"speed\" (per s), \"multiplier\", \"walking_speed\" (m/s), \"duration\" (s), \"cost_of_transport\", \"phases\": [{\"name\", \"motion\" and \"walked\": {\"duration\", \"phi_start\", \"phi_end\", \"speed_start\", \"speed_end\"}}], \"margins\": {\"steps\", \"verdict\", \"walking_speed\", \"friction\", \"impact_friction\", \"impulse\", \"zmp\", \"clearance\", \"torque\", \"joint\", \"velocity\"}}}]}.";

/// Finds gaits: the least torques at a walking speed, within all limits
#[derive(Args)]
#[command(after_help = OPTIMISE, override_usage = USAGE)]
pub struct Optimise {
    #[command(flatten)]
    robot: RobotArguments,
    /// The gait whose form is kept: a name in gaits/ beside the robot's description, or a file
    #[arg(long, value_name = "NAME|FILE.toml")]
    gait: String,
    /// A gait with Bezier curves where the search begins, such as one that was found before; without: from nothing
    #[arg(long, value_name = "NAME|FILE.toml")]
    start: Option<String>,
    /// Mean walking speed, m/s; several make a library
    #[arg(long, value_name = "V", num_args = 1.., required = true, allow_negative_numbers = true)]
    speed: Vec<f64>,
    /// The gait file to write; of several speeds the folder
    #[arg(long, value_name = "NEW.toml|FOLDER")]
    out: PathBuf,
    /// What is made small
    #[arg(long, value_name = "WHAT", value_enum, default_value = "torque")]
    cost: MadeSmall,
    /// Coulomb's coefficient that forces and impulses stay below
    #[arg(long, value_name = "MU", default_value_t = 0.6, allow_negative_numbers = true)]
    friction: f64,
    /// Height of feet in the air, m; default 0.010, of small robots a sixtieth of the base's height
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    clearance: Option<f64>,
    /// Distance of centres of pressure from the ends of a sole, m; default as --clearance
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    zmp: Option<f64>,
    /// Smallest vertical impulse on a foot that an impact holds, N s; default 0.1, of light robots less
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    impulse: Option<f64>,
    /// Distance of joints from their stops, rad or m; of a short range a fifth at most
    #[arg(long, value_name = "D", default_value_t = 0.02, allow_negative_numbers = true)]
    joints: f64,
    /// Largest multiplier: what is left of a small deviation after a step
    #[arg(long, value_name = "PART", default_value_t = 0.8, allow_negative_numbers = true)]
    multiplier: f64,
    /// Longest step, as a part of the height of the base
    #[arg(long, value_name = "PART", default_value_t = 0.75, allow_negative_numbers = true)]
    longest_step: f64,
    /// Bezier coefficients of each output
    #[arg(long, value_name = "N", default_value_t = 7)]
    coefficients: usize,
    /// Intervals of a step; each has three nodes
    #[arg(long, value_name = "N", default_value_t = 24)]
    intervals: usize,
    /// Lengths of first steps that a search from nothing begins with, on all cores; the motion that costs least is kept. Default 1, of several phases 2
    #[arg(long, value_name = "N", conflicts_with = "start")]
    beginnings: Option<usize>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// What is made small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MadeSmall {
    /// The mean squared torque
    Torque,
    /// The cost of transport: work of all joints, driving and braking, over weight and distance
    Transport,
}

const DOES_NOT_WALK: u8 = 3;
const NOT_FOUND: u8 = 4;

impl Optimise {
    pub fn run(self) -> Outcome {
        let bench = self.robot.open()?;
        let options = self.options()?;
        let library = options.library.clone();
        let place =
            |speed: f64| library.as_ref().map_or_else(|| self.out.clone(), |folder| gait_file(folder, speed));
        let mut ledger = bench.ledger();
        ledger.reads("the gait", &bench.gait_file(&self.gait)?);
        if let Some(start) = &self.start {
            ledger.reads("the gait to begin from", &bench.gait_file(start)?);
        }
        for &speed in &self.speed {
            ledger.writes_source("--out", &place(speed))?;
            may_be_replaced(&place(speed))?;
        }
        let found = bench.optimise_gaits(
            &options,
            &mut |slow| output::diagnostics(std::slice::from_ref(slow)),
            &mut |gait| {
                if gait.taken_over {
                    output::remark(&format!("{} is there already", place(gait.speed).display()));
                }
                let Some(text) = &gait.text else { return Ok(()) };
                if let (Some(folder), Some(search)) = (&library, &gait.search) {
                    write_with_folders(&search_file(folder, gait.speed), search)?;
                }
                write_found(&place(gait.speed), text)
            },
        )?;
        if self.json {
            output::print_json(&found)?;
        } else {
            output::print(&found.to_string())?;
        }
        Ok(match (found.complete, found.gaits.iter().all(|gait| gait.feasible), found.all_walk()) {
            (false, ..) => ExitCode::from(INTERRUPTED),
            (true, false, _) => ExitCode::from(NOT_FOUND),
            (true, true, false) => ExitCode::from(DOES_NOT_WALK),
            (true, true, true) => ExitCode::SUCCESS,
        })
    }

    fn options(&self) -> Result<OptimiseOptions, Diagnostics> {
        let mut wrong = Vec::new();
        let mut within = |name: &str, value: f64, [low, high]: [f64; 2]| {
            if !(low..=high).contains(&value) {
                let message = format!("{name}: {value} is not possible");
                wrong.push(Diagnostic::error(message).help(format!("write a number from {low} to {high}")));
            }
        };
        self.speed.iter().for_each(|&speed| within("--speed", speed, [0.01, 10.0]));
        if let Some(twice) = (1..self.speed.len()).find(|&k| self.speed[..k].contains(&self.speed[k])) {
            let message = format!("--speed: {} m/s is asked for twice", self.speed[twice]);
            return Err(Diagnostic::error(message).help("give every speed once").into());
        }
        within("--friction", self.friction, [0.05, 5.0]);
        self.clearance.iter().for_each(|&x| within("--clearance", x, [0.0, 1.0]));
        self.zmp.iter().for_each(|&x| within("--zmp", x, [0.0, 1.0]));
        self.impulse.iter().for_each(|&x| within("--impulse", x, [0.0, 1e3]));
        within("--joints", self.joints, [0.0, 1.0]);
        within("--multiplier", self.multiplier, [0.05, 1.0]);
        within("--longest-step", self.longest_step, [0.05, 2.0]);
        within("--coefficients", self.coefficients as f64, [5.0, 16.0]);
        within("--intervals", self.intervals as f64, [6.0, 200.0]);
        self.beginnings.iter().for_each(|&x| within("--beginnings", x as f64, [1.0, MOST_BEGINNINGS as f64]));
        if !wrong.is_empty() {
            return Err(Diagnostics(wrong));
        }
        Ok(OptimiseOptions {
            form: self.gait.clone(),
            start: self.start.clone(),
            speeds: self.speed.clone(),
            coefficients: self.coefficients,
            beginnings: self.beginnings,
            wishes: Wishes {
                friction: self.friction,
                clearance: self.clearance,
                zmp: self.zmp,
                impulse: self.impulse,
                joint: self.joints,
                longest_step: self.longest_step,
                intervals: self.intervals,
                objective: match self.cost {
                    MadeSmall::Torque => Objective::Torque,
                    MadeSmall::Transport => Objective::Transport,
                },
                multiplier: self.multiplier,
            },
            command: self.command(),
            library: (self.speed.len() > 1).then(|| self.out.clone()),
        })
    }

    /// As it would be typed again, without --speed.
    fn command(&self) -> String {
        let given = |name: &str, value: Option<f64>| {
            value.map_or_else(String::new, |value| format!(" --{name} {value}"))
        };
        format!(
            "bipedc gait optimise … --gait {}{}{} --friction {}{}{}{} --joints {} --multiplier {} --longest-step {} --coefficients {} --intervals {}{}",
            self.gait,
            self.start.as_ref().map_or_else(String::new, |start| format!(" --start {start}")),
            if self.cost == MadeSmall::Torque { "" } else { " --cost transport" },
            self.friction,
            given("clearance", self.clearance),
            given("zmp", self.zmp),
            given("impulse", self.impulse),
            self.joints,
            self.multiplier,
            self.longest_step,
            self.coefficients,
            self.intervals,
            given("beginnings", self.beginnings.map(|count| count as f64))
        )
    }
}

fn write_found(path: &Path, text: &str) -> Result<(), Diagnostics> {
    write_with_folders(path, text)?;
    output::remark(&format!("wrote {}", path.display()));
    Ok(())
}
