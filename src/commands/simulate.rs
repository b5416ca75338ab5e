//! `bipedc simulate`: a robot in motion, and the log that its sensors would write.
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use crate::terminal::pages::Pages;
use bipedc::Workbench;
use bipedc::simulation::{Options, Scene, Simulated};
use bipedc_analysis::report::curves_svg;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::write_with_folders;
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc simulate robots/tulip --scenario robots/tulip/scenarios/release.toml --out run.csv --report run.html
  bipedc simulate robots/five_link --scenario robots/five_link/scenarios/gait.toml --out run.csv --svg pictures
  bipedc simulate robots/three_link --scenario robots/three_link/scenarios/speeds.toml --out run.csv --energies energies.svg
  bipedc simulate robots/tulip --scenario stand.toml --out run.csv --energy
  bipedc simulate robots/tulip --base fixed --scenario swing.toml --out run.csv --truth truth.json
  bipedc diagnose robots/tulip run.csv         finds what the scenario hides

A scenario, all keys of which docs/simulation.md explains:

  duration = 4.0             # s
  step = 0.001               # s
  [control]
  stiffness = 300.0          # N m/rad, all joints
  damping = 3.0              # N m s/rad
  [joint.left_knee_pitch]
  position = 0.4             # rad, at the start
  sines = [[0.2, 0.5, 0.0]]  # amplitude (rad), frequency (Hz), phase (rad)
  [ground]
  friction = 0.7
  shapes = true              # links that are no feet touch the ground too
  [[effect]]                 # hidden: in the robot, not in its description
  kind = \"coulomb_friction\"
  joint = \"left_knee_pitch\"
  torque = 0.4               # N m
  [motor.left_knee_pitch]    # gear, rotor, current, voltage, spring and play
  gear_ratio = 111.0         # motor turns per turn of the joint
  rotor_inertia = 3.35e-6    # kg m², at the motor shaft
  torque_constant = 0.0259   # N m/A

With method = \"event_driven\" a robot with phases walks from event to event (thesis 4.4): each phase is integrated with error \
control to the instant at which it ends, then come impact and relabelling. The assumptions are checked; one that does not hold \
ends the run with phase, time, quantity and value, and exit code 3. [[control.output]] are virtual constraints; `gait` and `speeds` of [control] have the \
parameters of a gait chosen at each mid-stance (docs/gaits.md).

Otherwise rigid ground, dry friction and impacts are solved together in every step (Moreau's time stepping, 4.3). The log \
has the columns that `compare`, `diagnose` and `identify` read; equal seeds give equal bytes. Ctrl-C ends the run: the log \
up to there is kept.
JSON: {\"steps\", \"rows\", \"time\" (s), \"interrupted\", \"refused\" (why the controller had no command any more, if so), \"worst_residual\", \"not_converged\" (steps), \"contacts\", \
\"penetration\" (m), \"energy_made\" (J), \"clipped\": [[joint, steps]], \"fall\": null or {\"time\" (s), \"cause\": \"touch\", \"lean\" or \"height\", \"link\"}, \"wall_time\" (s), \"real_time_factor\", \"log\"}; \
event-driven: {\"method\", \"rows\", \"time\" (s), \"steps\" (landings), \"end\", \"verdict\": {\"phase\", \"time\", \"quantity\", \
\"value\", \"limit\", \"unit\", \"meaning\"}, \"changes\": [{\"time\", \"from\", \"to\", \"impulse\": [{\"foot\", \"x\", \"y\", \"z\"}]}], \
\"projected\": {\"position\", \"velocity\"} (onto the contacts of the first phase), \
with wished speeds \"speeds\": {\"unit\", \"wished\", \"met\", \"largest_miss\", \"largest_surprise\", \"steps\": [{\"step\", \"time\", \"wished\", \"predicted\", \"reached\", \"rests_before\", \
\"choice\", \"steps_to_wished\", \"parameters\"}], \"keep\" (what choices kept)}; of a gait \"velocity\": {\"joint\", \"time\" (s), \"speed\", \"limit\", \"margin\" (rad/s or m/s)} (the joint nearest to its velocity limit); \"integration\", \"relative_tolerance\", \"wall_time\", \"real_time_factor\", \"log\"}; \
with --energy also \"energy\" (J): {\"kinetic\", \"potential\", \"rotors\", \"ground_springs\": [start, end]; work \"drives\", \"laws\"; \
losses \"viscous_friction\", \"dry_friction\", \"stops\", \"impacts\", \"sliding\", \"ground_dampers\", their sum \"lost\"; \"remainder\"}.";

/// Exit code of a run that was interrupted, as shells have it.
const INTERRUPTED: u8 = 130;
/// Exit code of a run that a violated assumption ended.
const VERDICT: u8 = 3;

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
    /// Also write down, call by call and to the last bit, what the controller of [walking] was told by its sensors and asked for: its crate
    /// (`generate --controller`) has an example that answers it again
    #[arg(long, value_name = "TOLD.csv")]
    told: Option<PathBuf>,
    /// Also say where the energy went: work of the drives, losses in joints, impacts and sliding
    #[arg(long)]
    energy: bool,
    /// Also draw the energies of the zero dynamics, of a scenario with wished speeds (thesis, figures 7.8 and 7.9)
    #[arg(long, value_name = "OUT.svg")]
    energies: Option<PathBuf>,
    #[command(flatten)]
    pages: Pages,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

impl Simulate {
    /// Reads, runs, writes, prints.
    pub fn run(self) -> Outcome {
        let bench = self.robot.open()?;
        let scene = bench.scene(&self.scenario)?;
        self.check_files(&bench, &scene)?;
        let options = Options {
            truth: self.truth.clone(),
            told: self.told.clone(),
            energy: self.energy,
            film: self.pages.wanted(),
            energies: self.energies.is_some(),
        };
        let simulated = bench.simulate(&scene, &self.out, &options)?;
        if let Some(film) = &simulated.film {
            self.pages.write_film(film)?;
        }
        if let Some(path) = &self.energies {
            self.draw(path, &bench, &simulated)?;
        }
        output::diagnostics(&simulated.messages);
        if self.json {
            output::print_json(&simulated)?;
        } else {
            output::print(&simulated.to_string())?;
        }
        Ok(if simulated.is_refuted() {
            ExitCode::from(VERDICT)
        } else if simulated.is_interrupted() {
            ExitCode::from(INTERRUPTED)
        } else {
            ExitCode::SUCCESS
        })
    }

    /// Energies of the zero dynamics.
    fn draw(&self, path: &Path, bench: &Workbench, simulated: &Simulated) -> Result<(), Diagnostic> {
        let Some(speeds) = simulated.speeds() else {
            let message = "--energies draws the steps of a scenario with wished speeds; this one has none";
            return Err(Diagnostic::error(message).help("add speeds = [1.5, 1.6] to [control] beside `gait`"));
        };
        let name = self.scenario.file_name().unwrap_or_default().to_string_lossy();
        let robot = &bench.robot().description.name;
        write_with_folders(
            path,
            &curves_svg(&speeds.figure(robot, &format!("{name}: energies of the zero dynamics"))),
        )
    }

    /// Before anything is computed.
    fn check_files(&self, bench: &Workbench, scene: &Scene) -> Result<(), Diagnostic> {
        let mut ledger = bench.ledger();
        scene.note(&mut ledger);
        ledger.writes("--out", &self.out)?;
        self.truth.as_ref().map_or(Ok(()), |path| ledger.writes("--truth", path))?;
        self.told.as_ref().map_or(Ok(()), |path| ledger.writes("--told", path))?;
        self.energies.as_ref().map_or(Ok(()), |path| ledger.writes("--energies", path))?;
        self.pages.note(&mut ledger)
    }
}
