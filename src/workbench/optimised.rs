//! Gaits found by optimisation, written, and tried under their own controllers.
use super::closed_loop::ClosedLoop;
use super::reach::Reach;
use super::search::{Beginning, is_found};
use super::wished::Wished;
use super::{Workbench, library};
use crate::gait::optimise::{MotionMargins, Optimum, Wishes, exchangeable, size, stays};
use crate::simulation::Trial;
use bipedc_analysis::nonlinear::Ending;
use bipedc_compiler::compile::{Collocation, CollocationPhase, GaitForm, compile_collocation};
use bipedc_compiler::description::gait::{AnyGait, FilePlace, gait_path, parse_any_gait, read_any_gait};
use bipedc_compiler::description::model::RobotDescription;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::input;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What gaits are asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct OptimiseOptions {
    /// The gait whose phases, phase variables and outputs are kept: a name in `gaits/` or a file.
    pub form: String,
    /// A gait with curves at which the search begins, a name in `gaits/` or a file; none: from nothing.
    pub start: Option<String>,
    /// Mean walking speeds, m/s; each search after the first begins where the one before ended.
    pub speeds: Vec<f64>,
    /// Bezier coefficients of each output.
    pub coefficients: usize,
    /// Lengths of first steps that a search from nothing begins with, of which the motion that costs least is kept; none: as usual for the phases.
    pub beginnings: Option<usize>,
    /// Everything else that is wished.
    pub wishes: Wishes,
    /// The comment at the beginning of the files, without the speeds.
    pub command: String,
    /// Folder of a library, whose gaits of the same request are taken over; none: all are found anew.
    pub library: Option<PathBuf>,
}

/// A gait at one speed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OptimisedGait {
    /// As asked, m/s.
    pub speed: f64,
    /// An earlier run of the same request found it.
    pub taken_over: bool,
    /// Whether all constraints hold, as a trajectory.
    pub feasible: bool,
    /// Whether the search came to a minimum.
    pub minimum: bool,
    /// Iterations.
    pub iterations: usize,
    /// Of everything, s.
    pub seconds: f64,
    /// Of the first search alone, s.
    pub search_seconds: f64,
    /// Duration of each phase, s.
    pub durations: Vec<f64>,
    /// m
    pub step_length: f64,
    /// ∫ Σ \|τ q̇\| dt over weight and distance, at the nodes, 1.
    pub cost_of_transport: f64,
    /// Distances from limits at the nodes.
    pub margins: MotionMargins,
    /// What does not hold, the worst first.
    pub violations: Vec<Violated>,
    /// The nearest speed that gaits are found at, where none is at the one that was asked for; none: it is not known.
    pub reach: Option<Reach>,
    /// What the landing of a toe can push with, where the search looked for it; none: it did not.
    pub landing: Option<Landing>,
    /// Smallest vertical impulse that the walk is to keep, N s: less than what is usual where the landing of the toe pushes with less.
    pub impulse: f64,
    /// Of the last search that had several.
    pub beginnings: Vec<Beginning>,
    /// Searches: after the first one each asked for a little more where the walk under the controller lacked something.
    pub rounds: usize,
    /// What the gait does under its own controller; none where the search failed.
    pub closed_loop: Option<ClosedLoop>,
    /// What was wished and does not hold under its controller.
    pub lacking: Vec<String>,
    /// The gait file's text; none where the search failed.
    #[serde(skip)]
    pub text: Option<String>,
    /// Where the search ended, for the next one; none where the gait is no part of a library.
    #[serde(skip)]
    pub search: Option<String>,
}

/// What the landing of a toe can push with: while other feet stand, the posture alone says how its impulses are shared out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Landing {
    /// The phase that it ends.
    pub phase: String,
    /// Smallest vertical impulse on a foot that stands, N s, at the fastest landing and in the best posture that was found.
    pub push: f64,
    /// What the search asked for, N s.
    pub asked: f64,
    /// Joints that carry a foot and are not above its sole: what they carry are toes.
    pub toe_joints: Vec<String>,
}

/// A constraint that does not hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Violated {
    /// Which.
    pub constraint: String,
    /// In which phase.
    pub phase: String,
    /// At which node; none: where the phase ends, or in all of it.
    pub node: Option<usize>,
    /// By how much, in the unit of the constraint.
    pub by: f64,
}

/// All that were asked for. As text and as JSON they are what `bipedc gait optimise` prints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OptimisedGaits {
    /// Name of the form.
    pub form: String,
    /// Of the robot.
    pub robot: String,
    /// What every walk is to keep.
    pub wished: Wished,
    /// Whether an interruption left speeds out.
    pub complete: bool,
    /// One for each speed.
    pub gaits: Vec<OptimisedGait>,
}

impl Workbench {
    /// Finds gaits of the form of one that exists. `warned` hears at once of what will hardly be found, `done` is given each gait as soon as it is found and tried.
    ///
    /// # Errors
    /// No such gait, everything in it that has no meaning; functions that cannot be derived; what `done` says.
    pub fn optimise_gaits(
        &self,
        options: &OptimiseOptions,
        warned: &mut dyn FnMut(&Diagnostic),
        done: &mut dyn FnMut(&OptimisedGait) -> Result<(), Diagnostics>,
    ) -> Result<OptimisedGaits, Diagnostics> {
        let file = gait_path(&self.robot.sources, &options.form)?;
        // Everything about a file that is none or too large is said where a gait is read.
        read_any_gait(&file, &self.robot.sources, &self.robot.description)?;
        let cannot =
            |error: std::io::Error| Diagnostic::error(format!("cannot be read: {error}")).in_file(&file);
        let source = input::read_to_string(&file).map_err(cannot)?;
        let (gait, _) = parse_any_gait(&file, &source, &self.robot.sources, &self.robot.description)?;
        let form = GaitForm::new(&gait, options.coefficients);
        let derive = || compile_collocation(&self.robot.description, &form);
        let of = self.progress.stage("deriving", derive).map_err(|error| error.or_in_file(&file))?;
        let mut found = OptimisedGaits {
            form: options.form.clone(),
            robot: self.robot.description.name.clone(),
            wished: Wished::new(&of, &options.wishes),
            complete: true,
            gaits: Vec::new(),
        };
        exchangeable(&of, options.wishes.joint, &self.robot.sources)?;
        options
            .speeds
            .iter()
            .filter_map(|&speed| found.wished.slow(&of, speed))
            .for_each(|slow| warned(&slow));
        let seed = options.start.as_ref().map(|name| self.seed(name)).transpose()?;
        if seed.is_none() {
            grows(&of, &gait, options).map_err(|error| error.in_file(&file))?;
        }
        let asked = Asked {
            file: &file,
            source: &source,
            form: &form,
            of: &of,
            seed: seed.as_ref(),
            options,
            description: &self.robot.description,
        };
        let trial = self.progress.stage("deriving", || Trial::new(&self.robot, &of))?;
        let mut near: Option<Optimum> = None;
        for index in 0..options.speeds.len() {
            let gait = match self.taken_over(&asked, &trial, index)? {
                Some(found) => Some(found),
                None => self.found_at(&asked, &trial, index, near.as_ref())?,
            };
            let Some((mut gait, optimum)) = gait else {
                found.complete = false;
                break;
            };
            if gait.feasible {
                let keeps = options.library.is_some() && !gait.taken_over;
                gait.search = keeps.then(|| library::search_text(&asked.identity(index), &gait, &optimum));
                near = Some(optimum);
            }
            done(&gait)?;
            found.gaits.push(gait);
        }
        Ok(found)
    }

    /// A gait to begin from, with its form derived.
    fn seed(&self, name: &str) -> Result<(AnyGait, Collocation), Diagnostics> {
        let file = gait_path(&self.robot.sources, name)?;
        let (gait, _) = read_any_gait(&file, &self.robot.sources, &self.robot.description)?;
        let form = GaitForm::new(&gait, 5);
        let derive = || compile_collocation(&self.robot.description, &form);
        let seed = self.progress.stage("deriving", derive).map_err(|error| error.or_in_file(&file))?;
        Ok((gait, seed))
    }
}

/// That the phase variable grows along the motion from which a search begins, without which none comes to anything.
///
/// # Errors
/// It falls or stays, at its place in the form.
fn grows(of: &Collocation, gait: &AnyGait, options: &OptimiseOptions) -> Result<(), Diagnostic> {
    let Some(&speed) = options.speeds.first() else { return Ok(()) };
    let Some((phase, [first, last])) = stays(of, &options.wishes.demands(speed, size(of))) else {
        return Ok(());
    };
    let FilePlace { line, column } = match gait {
        AnyGait::OnePhase(gait) => gait.phase.variable_at,
        AnyGait::Phased(gait) => gait.phases[phase].variable_at,
    };
    let CollocationPhase { name, unit, .. } = &of.phases[phase];
    let does = if last < first { "falls" } else { "stays" };
    let message = format!(
        "the phase variable of phase `{name}` {does} as the robot goes forward: {first:.6} {unit} where the phase begins, {last:.6} {unit} where it ends, in the motion that the search begins with"
    );
    let help = "the search needs one that grows all along the phase, such as the angle of the leg that stands; if it has the wrong sign, turn it in every formula";
    Err(Diagnostic::error(message).at(line, column).help(help))
}

/// What stays the same over all speeds.
pub(super) struct Asked<'a> {
    pub file: &'a Path,
    pub source: &'a str,
    pub form: &'a GaitForm,
    pub of: &'a Collocation,
    pub seed: Option<&'a (AnyGait, Collocation)>,
    pub options: &'a OptimiseOptions,
    description: &'a RobotDescription,
}

/// Beginnings of searches for steps of one phase, which end at the same motion from nearly anywhere, and of several.
const USUAL_BEGINNINGS: [usize; 2] = [1, 2];

impl Asked<'_> {
    /// Lengths of first steps that a search from nothing begins with.
    pub fn beginnings(&self) -> usize {
        let usual = USUAL_BEGINNINGS[usize::from(self.of.phases.len() > 1)];
        self.options.beginnings.unwrap_or(usual)
    }

    /// Of the request up to a speed.
    pub fn identity(&self, index: usize) -> String {
        let start = self.seed.map(|(gait, _)| gait);
        library::identity((self.description, self.source), start, self.options, index)
    }

    /// The comment at the beginning of a gait file, with the speeds up to its own: further ones change nothing about it.
    pub fn head(&self, index: usize) -> String {
        let OptimiseOptions { speeds, command, library, .. } = self.options;
        let mark = match library {
            Some(_) => format!(", {},", library::mark(&self.identity(index))),
            None => String::new(),
        };
        let speeds: Vec<String> = speeds[..=index].iter().map(ToString::to_string).collect();
        format!(
            "Found at {} m/s{mark} by\n  {command} --speed {}",
            self.options.speeds[index],
            speeds.join(" ")
        )
    }
}

pub(super) fn described(of: &Collocation, optimum: &Optimum, (speed, impulse): (f64, f64)) -> OptimisedGait {
    let violated = |(name, by): &(crate::gait::optimise::RowName, f64)| Violated {
        constraint: name.what.clone(),
        phase: of.phases[name.phase].name.clone(),
        node: name.node,
        by: *by,
    };
    OptimisedGait {
        speed,
        taken_over: false,
        feasible: is_found(optimum),
        minimum: optimum.ending == Ending::Minimum,
        iterations: optimum.iterations,
        seconds: 0.0,
        search_seconds: 0.0,
        durations: optimum.durations(),
        step_length: optimum.step_length(),
        cost_of_transport: optimum.cost_of_transport(of),
        margins: optimum.margins(of),
        violations: optimum.violations.iter().map(violated).collect(),
        reach: None,
        landing: optimum.landing.map(|landing| Landing {
            phase: of.phases[landing.phase].name.clone(),
            push: landing.push,
            asked: impulse,
            toe_joints: toe_joints(of),
        }),
        impulse,
        beginnings: Vec::new(),
        rounds: 1,
        closed_loop: None,
        lacking: Vec::new(),
        text: None,
        search: None,
    }
}

/// Joints above their foot are over this part of its sole: not within a hundredth of its ends.
const ABOVE: std::ops::Range<f64> = 0.01..0.99;

/// Joints that carry a foot and have all of its sole in front of them, or behind.
fn toe_joints(of: &Collocation) -> Vec<String> {
    let beside = |link: &str, points: &[[f64; 3]]| {
        let joint = of.description.joints.iter().find(|joint| joint.child == link)?;
        let [&heel, &toe] = [points.first()?, points.last()?];
        // The joint is at the origin of the link's frame: its place along the sole, from 0 at the heel to 1 at the toe.
        let along: [f64; 3] = std::array::from_fn(|k| toe[k] - heel[k]);
        let of_joint: f64 = along.iter().zip(heel).map(|(d, h)| -d * h).sum();
        let place = of_joint / along.iter().map(|d| d * d).sum::<f64>();
        (place.is_finite() && !ABOVE.contains(&place)).then(|| joint.name.clone())
    };
    let feet = of.description.feet.iter();
    feet.filter_map(|foot| {
        let points: Vec<[f64; 3]> = foot.points.iter().map(|point| point.position).collect();
        beside(&foot.link, &points)
    })
    .collect()
}

impl OptimisedGaits {
    /// Whether every gait was found and walks.
    pub fn all_walk(&self) -> bool {
        self.gaits.iter().all(OptimisedGait::walks)
    }
}

impl OptimisedGait {
    /// Whether it was found and walks under its own controller.
    pub fn walks(&self) -> bool {
        self.feasible && self.closed_loop.as_ref().is_some_and(|tried| tried.walks)
    }
}
