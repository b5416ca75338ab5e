//! `bipedc simulate`: a robot in motion, and the log that its sensors would write.
mod walking;

use crate::arguments::RobotArguments;
use crate::failure::{Failure, Outcome};
use crate::reporting::Outputs;
use crate::{energies, interruption, output};
use bipedc::film::Recorder;
use bipedc::simulation::{driven_model, filmed_model, in_world, plant, true_model};
use bipedc_analysis::report::{Fact, Film};
use bipedc_analysis::simulate::control::Driven;
use bipedc_analysis::simulate::{Actuator, Mechanics, Plant, Run, Scenario, Simulation, Summary, csv_line};
use bipedc_compiler::Robot;
use bipedc_compiler::robot::fnv1a;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::Effect;
use bipedc_effects::files::{Batch, Output};
use bipedc_effects::input;
use clap::Args;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  bipedc simulate robots/tulip --scenario robots/tulip/scenarios/release.toml --out run.csv --report run.html
  bipedc simulate robots/five_link --scenario robots/five_link/scenarios/gait.toml --out run.csv --svg pictures
  bipedc simulate robots/tulip --scenario stand.toml --out run.csv --energy
  bipedc simulate robots/tulip --base fixed --scenario swing.toml --out run.csv --truth truth.json
  bipedc diagnose robots/tulip run.csv                       finds what the scenario hides

A scenario, all keys of which docs/simulation.md explains:

  duration = 4.0                      # s
  step = 0.001                        # s
  [control]
  stiffness = 300.0                   # N m/rad, all joints
  damping = 3.0                       # N m s/rad
  [joint.left_knee_pitch]
  position = 0.4                      # rad, at the start
  sines = [[0.2, 0.5, 0.0]]           # amplitude (rad), frequency (Hz), phase (rad)
  [ground]
  friction = 0.7
  [[effect]]                          # hidden: in the robot, not in its description
  kind = \"coulomb_friction\"
  joint = \"left_knee_pitch\"
  torque = 0.4                        # N m
  [motor.left_knee_pitch]             # gear, rotor, current and voltage, spring and play to the joint
  gear_ratio = 111.0                  # motor turns per turn of the joint
  rotor_inertia = 3.35e-6             # kg m², at the motor shaft
  torque_constant = 0.0259            # N m/A

With method = \"event_driven\" a robot with phases walks from event to event (thesis 4.4): each phase is integrated with error
control to the instant at which it ends, then come impact and relabelling. The assumptions are checked; one that does not hold
ends the run with phase, time, quantity and value, and exit code 3. [[control.output]] are virtual constraints.

Otherwise rigid ground, dry friction and impacts are solved together in every step (Moreau's time stepping, 4.3). The log
has the columns that `compare`, `diagnose` and `identify` read; equal seeds give equal bytes. Ctrl-C ends the run: the log
up to there is kept.
JSON: {\"steps\", \"rows\", \"time\" (s), \"interrupted\", \"worst_residual\", \"not_converged\" (steps), \"contacts\",
\"penetration\" (m), \"energy_made\" (J), \"clipped\": [[joint, steps]], \"wall_time\" (s), \"real_time_factor\", \"log\"};
event-driven: {\"method\", \"rows\", \"time\" (s), \"steps\" (landings), \"end\", \"verdict\": {\"phase\", \"time\", \"quantity\",
\"value\", \"limit\", \"unit\", \"meaning\"}, \"changes\": [{\"time\", \"from\", \"to\", \"impulse\": [{\"foot\", \"x\", \"y\", \"z\"}]}],
\"projected\": {\"position\", \"velocity\"} (onto the contacts of the first phase),
\"integration\", \"relative_tolerance\", \"wall_time\", \"real_time_factor\", \"log\"};
with --energy also \"energy\" (J): {\"kinetic\", \"potential\", \"rotors\", \"ground_springs\": [start, end]; work \"drives\", \"laws\";
losses \"viscous_friction\", \"dry_friction\", \"stops\", \"impacts\", \"sliding\", \"ground_dampers\", their sum \"lost\"; \"remainder\"}.";

/// Exit code of a run that was interrupted, as shells have it.
const INTERRUPTED: u8 = 130;

/// Simulate a robot on the ground or on a stand and log what its sensors would say
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Simulate {
    #[command(flatten)]
    robot: RobotArguments,
    /// What happens: duration, initial state, controllers, ground, hidden effects, sensors
    #[arg(long, value_name = "FILE.toml")]
    scenario: PathBuf,
    /// Where the log goes: a file, which appears whole, or a pipe such as /dev/stdout
    #[arg(long, value_name = "RUN.csv")]
    out: PathBuf,
    /// Also write down what was hidden, as JSON
    #[arg(long, value_name = "TRUTH.json")]
    truth: Option<PathBuf>,
    /// Also say where the energy went: work of the drives, losses in joints, impacts and sliding
    #[arg(long)]
    energy: bool,
    #[command(flatten)]
    outputs: Outputs,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

impl Simulate {
    /// Reads, runs, writes, prints.
    pub fn run(self) -> Outcome {
        let robot = self.robot.read()?;
        let plant = plant(&robot.description, &robot.tree()?)?;
        let scenario = Scenario::open(&self.scenario, &plant)?;
        self.check_files(&robot, &scenario)?;
        let robot = in_world(robot, &scenario.world);
        // Sensors feel the gravity that the scenario says.
        let plant = Plant { gravity: robot.description.gravity, ..plant };
        if let Some(events) = &scenario.events {
            return self.walk(&robot, &plant, &scenario, events);
        }
        let filmed = self.energy || self.outputs.wanted();
        let (model, phases) = output::progress("deriving", || {
            if scenario.outputs.is_some() {
                return driven_model(&robot, &scenario.effects, filmed);
            }
            let derive = if filmed { filmed_model } else { true_model };
            Ok((derive(&robot, &scenario.effects)?, Vec::new()))
        })?;
        let in_file = |error: Diagnostic| Failure(vec![error.or_in_file(&self.scenario)]);
        let mechanics = Mechanics::new(&model, plant.subject.base)?;
        let mut recorder = match self.outputs.wanted() {
            true => Some(Recorder::new(&robot, mechanics, scenario.duration, rows(&scenario))?),
            false => None,
        };
        let mut simulation = Simulation::new(mechanics, &plant, &scenario).map_err(in_file)?;
        if let Some(outputs) = &scenario.outputs {
            simulation = simulation.driven(Driven::new(&model, &plant, &phases, outputs, scenario.phase)?);
        }
        if let Some(recorder) = &mut recorder {
            simulation = simulation.watched(|sample| recorder.take(sample));
        }
        if self.energy {
            simulation = simulation.with_energy()?;
        }
        let truth = self.truth(&robot.description.name, &plant, &scenario)?;
        let mut log = Log::begin(&self.out, &simulation.columns())?;
        let start = Instant::now();
        let stop = interruption::flag();
        let summary = output::bar("simulating", |progress| {
            let mut row = |values: &[f64]| log.row(values);
            let stop = || stop.load(Ordering::Relaxed);
            simulation.run(&mut Run { row: &mut row, progress, stop: &stop })
        });
        let summary = summary.map_err(|error| {
            // What has no inertia ends a run at once, unless the rotor of a motor resists.
            output::diagnostics(&robot.without_inertia().unwrap_or_default());
            in_file(error)
        })?;
        log.commit_with(truth)?;
        if let Some(recorder) = recorder {
            self.outputs.write_film(&self.film(recorder.finish(), &scenario, &summary)?)?;
        }
        self.say(&summary, start.elapsed().as_secs_f64())?;
        Ok(if summary.interrupted { ExitCode::from(INTERRUPTED) } else { ExitCode::SUCCESS })
    }

    /// Before anything is computed.
    fn check_files(&self, robot: &Robot, scenario: &Scenario) -> Result<(), Diagnostic> {
        let mut ledger = self.robot.ledger(robot);
        ledger.reads("the scenario", &self.scenario);
        if let Some(table) = &scenario.trajectory {
            ledger.reads("the scenario's trajectory", table);
        }
        ledger.writes("--out", &self.out)?;
        self.truth.as_ref().map_or(Ok(()), |path| ledger.writes("--truth", path))?;
        self.outputs.note(&mut ledger)
    }

    /// The file of what is hidden, if it is wanted, waiting to take its place.
    fn truth(&self, robot: &str, plant: &Plant, scenario: &Scenario) -> Result<Option<Output>, Failure> {
        let Some(path) = &self.truth else { return Ok(None) };
        let mut file = Output::create(path)?;
        file.put(&self.hidden(robot, plant, scenario)?)?;
        Ok(Some(file))
    }

    /// What the robot has that its description does not say.
    fn hidden(&self, robot: &str, plant: &Plant, scenario: &Scenario) -> Result<String, Failure> {
        let text = input::read_to_string(&self.scenario)?;
        let truth = Truth {
            robot,
            scenario_hash: format!("{:016x}", fnv1a(&text)),
            seed: scenario.seed,
            step: scenario.step,
            effects: &scenario.effects,
            motors: plant
                .joint_names()
                .zip(&scenario.actuators)
                .filter_map(|(name, motor)| Some((name, motor.as_ref()?)))
                .collect(),
        };
        Ok(serde_json::to_string_pretty(&truth).map_err(io::Error::from)? + "\n")
    }

    /// The film with words and provenance.
    fn film(&self, film: Film, scenario: &Scenario, summary: &Summary) -> Result<Film, Failure> {
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let text = input::read_to_string(&self.scenario)?;
        let mut facts = vec![
            Fact::new("scenario", format!("{}, FNV-1a {:016x}", name(&self.scenario), fnv1a(&text))),
            Fact::new("log", format!("{}, {} rows", name(&self.out), summary.rows)),
            Fact::new("time stepping", format!("{} steps of {} s", summary.steps, scenario.step)),
            Fact::new("seed", scenario.seed.to_string()),
        ];
        if summary.contacts > 0 {
            facts.push(Fact::new(
                "worst relative residual of contact",
                format!("{:.1e}", summary.worst_residual),
            ));
            facts.push(Fact::new("deepest penetration", format!("{:.2e} m", summary.penetration)));
        }
        let hidden = scenario.effects.iter().map(|effect| Fact::new("hidden effect", at_place(effect)));
        facts.extend(hidden);
        let clipped = summary.clipped.iter();
        let clipped =
            clipped.map(|(joint, steps)| format!("{joint}: the torque was clipped in {steps} steps"));
        Ok(Film {
            title: format!("{}: simulation of {}", film.robot, name(&self.scenario)),
            summary: told(&film, summary, scenario.step),
            warnings: unsolved(summary).into_iter().chain(clipped).collect(),
            facts,
            ..film
        })
    }

    fn say(&self, summary: &Summary, wall_time: f64) -> Result<(), Failure> {
        let real_time_factor = summary.time / wall_time.max(1e-9);
        if let Some(message) = unsolved(summary) {
            output::diagnostics(&[Diagnostic::warning(message).help("a shorter `step` makes them easier")]);
        }
        if self.json {
            let log = self.out.display().to_string();
            output::print_json(&Answer { summary, wall_time, real_time_factor, log })?;
            return Ok(());
        }
        let mut text = String::new();
        let end = if summary.interrupted { "interrupted after" } else { "simulated" };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{end} {:.3} s in {} steps, {real_time_factor:.0} times as fast as real time",
            summary.time, summary.steps
        );
        if summary.contacts > 0 {
            let _ = writeln!(
                text,
                "contact: at most {} points, worst relative residual {:.1e}, deepest penetration {:.2e} m",
                summary.contacts, summary.worst_residual, summary.penetration
            );
        }
        if summary.energy_made > 1e-9 {
            let _ = writeln!(
                text,
                "an impact made {:.2e} J: restitution differs by direction",
                summary.energy_made
            );
        }
        if let Some(balance) = &summary.energy {
            text += &energies::table(balance);
        }
        for (joint, steps) in &summary.clipped {
            let _ = writeln!(text, "{joint}: the torque was clipped in {steps} steps");
        }
        let _ = writeln!(text, "{} rows in {}", summary.rows, self.out.display());
        output::print(&text)?;
        Ok(())
    }
}

/// Rows that the log will have.
fn rows(scenario: &Scenario) -> usize {
    (scenario.duration / scenario.step / scenario.log_every.max(1) as f64).ceil() as usize
}

fn unsolved(summary: &Summary) -> Option<String> {
    (summary.not_converged > 0).then(|| {
        format!(
            "{} of {} contact problems did not reach the residual; the worst is {:.1e}",
            summary.not_converged, summary.steps, summary.worst_residual
        )
    })
}

/// Such as `coulomb friction at left_knee_pitch`.
fn at_place(effect: &Effect) -> String {
    let location = &effect.location;
    let place = [&location.joint, &location.link, &location.sensor].into_iter().flatten().next();
    let kind = effect.kind.name.replace('_', " ");
    place.map_or_else(|| kind.clone(), |place| format!("{kind} at {place}"))
}

/// Times the weight that only impacts push with.
const BLOW: f64 = 3.0;

/// What happened, in words.
fn told(film: &Film, summary: &Summary, step: f64) -> String {
    let mut words = format!("{:.3} s of motion", summary.time);
    if summary.interrupted {
        words += ", interrupted before the end";
    }
    // Writing to a string cannot fail.
    if let (Some(first), Some(last)) = (film.frames.first(), film.frames.last()) {
        let moved = [0, 1, 2].map(|i| last.center_of_mass[i] - first.center_of_mass[i]);
        let ways = [["forward", "backward"], ["to the left", "to the right"], ["up", "down"]];
        let moves: Vec<String> = (0..3)
            .filter(|&i| moved[i].abs() >= 5e-4)
            .map(|i| format!("{:.3} m {}", moved[i].abs(), ways[i][usize::from(moved[i] < 0.0)]))
            .collect();
        let moves = if moves.is_empty() { "less than a millimetre".to_owned() } else { moves.join(", ") };
        let _ = write!(words, ". The centre of mass moves {moves}");
    }
    if summary.contacts > 0 {
        let all = film.loads.iter().flat_map(|loads| film.time.iter().zip(loads));
        let hardest = all.max_by(|a, b| a.1.total_cmp(b.1));
        if let Some((time, load)) = hardest.filter(|_| film.weight > 0.0) {
            let times = load / film.weight;
            let _ = write!(
                words,
                ". The largest vertical force on a foot is {load:.0} N ({times:.1} times the weight) at {time:.3} s"
            );
            if times > BLOW {
                let impulse = load * 2.0 * step;
                let _ = write!(
                    words,
                    "; impacts on hard ground have no finite force: it stands for an impulse of {impulse:.3} N s in two steps"
                );
            }
        }
    }
    words + "."
}

#[derive(Serialize)]
struct Truth<'a> {
    robot: &'a str,
    scenario_hash: String,
    seed: u64,
    step: f64,
    effects: &'a [Effect],
    /// By joint.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    motors: BTreeMap<&'a str, &'a Actuator>,
}

#[derive(Serialize)]
struct Answer<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    wall_time: f64,
    real_time_factor: f64,
    log: String,
}

/// The log row by row.
struct Log {
    file: Output,
    line: String,
}

impl Log {
    fn begin(path: &Path, columns: &[String]) -> Result<Self, Diagnostic> {
        let mut file = Output::create(path)?;
        file.put(&(columns.join(",") + "\n"))?;
        Ok(Self { file, line: String::new() })
    }

    fn row(&mut self, values: &[f64]) -> Result<(), Diagnostic> {
        csv_line(values, &mut self.line);
        self.file.put(&self.line)
    }

    fn commit_with(self, truth: Option<Output>) -> Result<(), Diagnostic> {
        let mut files = Batch::default();
        files.add(self.file);
        truth.into_iter().for_each(|truth| files.add(truth));
        files.commit()
    }
}
