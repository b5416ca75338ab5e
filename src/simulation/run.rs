//! A scenario that is run: what is asked for, what comes of it.
use super::chosen::WalkedSpeeds;
use super::fastest::FastestJoint;
use super::footsteps::{FootstepSummary, Footsteps};
use super::gait::Walker;
use super::touching::touching;
use super::{in_world, plant, stepping, walking};
use crate::progress::Run;
use bipedc_analysis::report::Film;
use bipedc_analysis::simulate::phases::{WalkEnd, WalkSummary};
use bipedc_analysis::simulate::{Plant, Scenario, Summary};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::files::Ledger;
use bipedc_runtime::control::Controller;
use serde::{Serialize, Serializer};
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A robot in the world of a scenario.
#[derive(Debug, Clone)]
pub struct Scene {
    pub(super) robot: Robot,
    /// The robot with contact points on other links than the feet, where the scenario says so.
    pub(super) touching: Option<Robot>,
    pub(super) plant: Plant,
    pub(super) scenario: Scenario,
    pub(super) file: PathBuf,
    pub(super) gait: Option<Walker>,
    pub(super) footsteps: Option<Footsteps>,
}

/// What a simulation writes and keeps beside the log.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Also write down what was hidden, as JSON.
    pub truth: Option<PathBuf>,
    /// Also write down, call by call and to the last bit, what the controller of a walk by footsteps was told by its sensors and asked for.
    pub told: Option<PathBuf>,
    /// Also say where the energy went.
    pub energy: bool,
    /// Also keep the motion as a film.
    pub film: bool,
    /// Also keep the energies of the zero dynamics, where parameters are chosen for each step.
    pub energies: bool,
}

/// How a run went.
#[derive(Debug, Clone)]
pub enum Outcome {
    /// By time stepping.
    Stepped(Summary),
    /// From event to event.
    Walked {
        /// Landings, changes of phase, the verdict.
        summary: WalkSummary,
        /// Of the integration.
        relative_tolerance: f64,
        /// Wished and reached speeds, where parameters were chosen for each step.
        speeds: Option<WalkedSpeeds>,
    },
}

/// A run that is over, its log written. As text and as JSON it is what `bipedc simulate` prints.
#[derive(Debug, Clone)]
pub struct Simulated {
    /// How it went.
    pub outcome: Outcome,
    /// What it took, s.
    pub wall_time: f64,
    /// Simulated time per wall time.
    pub real_time_factor: f64,
    /// Where the log is.
    pub log: PathBuf,
    /// The motion, if it was wanted.
    pub film: Option<Film>,
    /// Contact problems that were not solved, an assumption that did not hold.
    pub messages: Vec<Diagnostic>,
    /// How it walked, if by footsteps.
    pub walk: Option<FootstepSummary>,
    /// The joint nearest to its velocity limit, if a gait drives the robot and a joint has one.
    pub velocity: Option<FastestJoint>,
}

impl Scene {
    /// Reads a scenario for a robot.
    ///
    /// # Errors
    /// A base that is not simulated; everything in the scenario that has no meaning, with line and column.
    pub fn open(robot: &Robot, scenario: &Path) -> Result<Self, Diagnostics> {
        let plant = plant(&robot.description, &robot.tree()?)?;
        let file = scenario.to_path_buf();
        let mut scenario = Scenario::open(scenario, &plant)?;
        let gait = Walker::open(robot, &mut scenario, &file)?;
        let footsteps = Footsteps::open(robot, &mut scenario, &file)?;
        let robot = in_world(robot.clone(), &scenario.world);
        // Sensors feel the gravity that the scenario says.
        let mut plant = Plant { gravity: robot.description.gravity, ..plant };
        let touching = scenario.shapes.as_ref().map(|shapes| touching(&robot, shapes));
        let touching = touching.transpose().map_err(|error| error.or_in_file(&file))?;
        let touching = touching.map(|(robot, links)| {
            plant.shapes = links;
            robot
        });
        Ok(Self { robot, touching, plant, scenario, file, gait, footsteps })
    }

    /// Notes the files that were read, so that outputs do not overwrite them.
    pub fn note(&self, ledger: &mut Ledger) {
        ledger.reads("the scenario", &self.file);
        if let Some(table) = &self.scenario.trajectory {
            ledger.reads("the scenario's trajectory", table);
        }
        self.gait.iter().for_each(|gait| gait.note(ledger));
        self.footsteps.iter().for_each(|walk| walk.note(ledger));
    }

    /// What is odd about the gait that drives the robot, if one does.
    pub(super) fn warnings(&self) -> Vec<Diagnostic> {
        self.gait.as_ref().map_or_else(Vec::new, Walker::warnings)
    }

    /// Runs the scenario and writes the log that the robot's sensors would write: `out` appears whole or not at all.
    ///
    /// # Errors
    /// Functions that cannot be derived, motions without solution, files that cannot be written.
    pub fn simulate(&self, out: &Path, options: &Options, run: &Run<'_>) -> Result<Simulated, Diagnostics> {
        if let (Some(path), None) = (&options.told, &self.footsteps) {
            self.told(None, path)?;
        }
        match &self.scenario.events {
            Some(events) => self.walk(events, None, out, options, run),
            None => self.step(None, out, options, run),
        }
    }

    /// The same under a controller of one's own, over the scenario's servos and instead of its outputs. In time stepping it is
    /// told the true state once per step, always in phase 0; from event to event it acts all the time, on the robot
    /// as its phases name it.
    ///
    /// # Errors
    /// As [`Scene::simulate`]; the controller has no command for a state.
    pub fn simulate_with(
        &self,
        controller: &mut dyn Controller<f64>,
        out: &Path,
        options: &Options,
        run: &Run<'_>,
    ) -> Result<Simulated, Diagnostics> {
        match &self.scenario.events {
            Some(events) => self.walk(events, Some(controller), out, options, run),
            None => self.step(Some(controller), out, options, run),
        }
    }
}

impl Simulated {
    pub(super) fn new(
        outcome: Outcome,
        (log, start): (&Path, Instant),
        film: Option<Film>,
        messages: Vec<Diagnostic>,
    ) -> Self {
        let wall_time = start.elapsed().as_secs_f64();
        let time = match &outcome {
            Outcome::Stepped(summary) => summary.time,
            Outcome::Walked { summary, .. } => summary.time,
        };
        let real_time_factor = time / wall_time.max(1e-9);
        Self {
            outcome,
            wall_time,
            real_time_factor,
            log: log.to_path_buf(),
            film,
            messages,
            walk: None,
            velocity: None,
        }
    }

    /// Whether it was stopped before its end.
    pub fn is_interrupted(&self) -> bool {
        match &self.outcome {
            Outcome::Stepped(summary) => summary.interrupted,
            Outcome::Walked { summary, .. } => summary.end == WalkEnd::Interrupted,
        }
    }

    /// When a robot that walks by itself, or is stepped, fell, s: as its controller noticed, or as the simulation saw, whichever was first. A controller
    /// that estimates where it is may not notice.
    pub fn fell(&self) -> Option<f64> {
        let noticed = self.walk.as_ref().and_then(|walk| walk.fell);
        let seen = match &self.outcome {
            Outcome::Stepped(summary) => summary.fall.as_ref().map(|fall| fall.time),
            Outcome::Walked { .. } => None,
        };
        noticed.into_iter().chain(seen).reduce(f64::min)
    }

    /// Wished and reached speeds, where parameters were chosen for each step.
    pub fn speeds(&self) -> Option<&WalkedSpeeds> {
        match &self.outcome {
            Outcome::Walked { speeds, .. } => speeds.as_ref(),
            Outcome::Stepped(_) => None,
        }
    }

    /// Whether an assumption of the model did not hold and ended it.
    pub fn is_refuted(&self) -> bool {
        match &self.outcome {
            Outcome::Walked { summary, .. } => summary.end == WalkEnd::Verdict,
            Outcome::Stepped(summary) => summary.refused.is_some(),
        }
    }
}

impl fmt::Display for Simulated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (factor, log) = (self.real_time_factor, self.log.as_path());
        let velocity = self.velocity.as_ref().map_or_else(String::new, FastestJoint::text);
        let text = match &self.outcome {
            Outcome::Stepped(summary) => stepping::text((summary, self.walk.as_ref()), factor, log),
            Outcome::Walked { summary, speeds, .. } => walking::text((summary, speeds.as_ref()), factor, log),
        };
        f.write_str(&(text + &velocity))
    }
}

#[derive(Serialize)]
struct Stepped<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    #[serde(skip_serializing_if = "Option::is_none")]
    walk: Option<&'a FootstepSummary>,
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity: Option<&'a FastestJoint>,
    wall_time: f64,
    real_time_factor: f64,
    log: String,
}

#[derive(Serialize)]
struct Walked<'a> {
    method: &'static str,
    #[serde(flatten)]
    summary: &'a WalkSummary,
    #[serde(skip_serializing_if = "Option::is_none")]
    speeds: Option<&'a WalkedSpeeds>,
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity: Option<&'a FastestJoint>,
    relative_tolerance: f64,
    wall_time: f64,
    real_time_factor: f64,
    log: String,
}

impl Serialize for Simulated {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { wall_time, real_time_factor, .. } = *self;
        let (log, velocity) = (self.log.display().to_string(), self.velocity.as_ref());
        match &self.outcome {
            Outcome::Stepped(summary) => {
                let walk = self.walk.as_ref();
                Stepped { summary, walk, velocity, wall_time, real_time_factor, log }.serialize(serializer)
            }
            Outcome::Walked { summary, relative_tolerance, speeds } => {
                let (method, relative_tolerance, speeds) =
                    ("event_driven", *relative_tolerance, speeds.as_ref());
                Walked {
                    method,
                    summary,
                    speeds,
                    velocity,
                    relative_tolerance,
                    wall_time,
                    real_time_factor,
                    log,
                }
                .serialize(serializer)
            }
        }
    }
}
