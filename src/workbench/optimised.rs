//! Gaits found by optimisation, written, and tried under their own controllers.
use super::Workbench;
use crate::gait::optimise::{
    Demands, MotionMargins, Optimum, Stage, from_neighbour, from_nothing, gait_text,
};
use crate::gait::{ChainOptions, GaitBench, PhasedBench, StepOptions};
use crate::simulation;
use crate::table::table;
use bipedc_analysis::nonlinear::{Ending, Iteration};
use bipedc_compiler::compile::{Collocation, GaitForm, compile_collocation};
use bipedc_compiler::description::gait::{gait_path, parse_any_gait, read_any_gait};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::input;
use serde::Serialize;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What gaits are asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct OptimiseOptions {
    /// The gait whose phases, phase variables and outputs are kept: a name in `gaits/` or a file.
    pub form: String,
    /// Mean walking speeds, m/s; each search after the first begins where the one before ended.
    pub speeds: Vec<f64>,
    /// Bezier coefficients of each output.
    pub coefficients: usize,
    /// Everything else that is asked; its speed does not count.
    pub demands: Demands,
    /// The comment at the beginning of the files.
    pub command: String,
}

/// A gait at one speed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OptimisedGait {
    /// As asked, m/s.
    pub speed: f64,
    /// Whether all constraints hold, as a trajectory.
    pub feasible: bool,
    /// Whether the search came to a minimum.
    pub minimum: bool,
    /// Iterations.
    pub iterations: usize,
    /// Of the search, s.
    pub seconds: f64,
    /// Duration of each phase, s.
    pub durations: Vec<f64>,
    /// m
    pub step_length: f64,
    /// Distances from limits at the nodes.
    pub margins: MotionMargins,
    /// What does not hold, the worst first.
    pub violations: Vec<Violated>,
    /// What the gait does under its own controller; none where the search failed.
    pub closed_loop: Option<ClosedLoop>,
    /// The gait file's text; none where the search failed.
    #[serde(skip)]
    pub text: Option<String>,
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

/// A written gait under its own controller.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClosedLoop {
    /// Whether steps repeat themselves and deviations shrink.
    pub walks: bool,
    /// Why not.
    pub reason: Option<String>,
    /// φ̇ at the dead centre of every step, per s.
    pub speed: Option<f64>,
    /// What is left of a small deviation after a step.
    pub multiplier: Option<f64>,
    /// Mean walking speed, m/s.
    pub walking_speed: Option<f64>,
    /// Of a step, s.
    pub duration: Option<f64>,
}

/// All that were asked for. As text and as JSON they are what `bipedc gait optimise` prints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OptimisedGaits {
    /// Name of the form.
    pub form: String,
    /// Of the robot.
    pub robot: String,
    /// Whether an interruption left speeds out.
    pub complete: bool,
    /// One for each speed.
    pub gaits: Vec<OptimisedGait>,
}

impl Workbench {
    /// Finds gaits of the form of one that exists. `done` is given each as soon as it is found and tried.
    ///
    /// # Errors
    /// No such gait, everything in it that has no meaning; functions that cannot be derived; what `done` says.
    pub fn optimise_gaits(
        &self,
        options: &OptimiseOptions,
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
            complete: true,
            gaits: Vec::new(),
        };
        let mut near: Option<Optimum> = None;
        for &speed in &options.speeds {
            let demands = Demands { speed, ..options.demands.clone() };
            let begin = Instant::now();
            let optimum = self.search(&of, &demands, near.as_ref());
            if (self.stop)() {
                found.complete = false;
                break;
            }
            let mut gait = described(&of, &optimum, (speed, begin.elapsed().as_secs_f64()));
            if gait.feasible {
                let head = format!("Found at {speed} m/s by\n  {}", options.command);
                let text = gait_text(&source, &form, &of, &optimum, (&head, demands.friction.max(0.6)))?;
                let tried = self.progress.stage("walking", || self.tried(&file, &text, &of, &optimum));
                gait.closed_loop = Some(tried);
                gait.text = Some(text);
                near = Some(optimum);
            }
            done(&gait)?;
            found.gaits.push(gait);
        }
        Ok(found)
    }

    fn search(&self, of: &Collocation, demands: &Demands, near: Option<&Optimum>) -> Optimum {
        let stage = format!("optimising for {} m/s", demands.speed);
        self.progress.counted(&stage, |advance| {
            let mut watch = |stage: Stage, at: &Iteration| {
                let half = if stage == Stage::Motion { 0.0 } else { 0.4 };
                // From a barrier of 0.1 to one of 1e-7.
                let part = ((0.1 / at.barrier).log10() / 6.0).clamp(0.0, 1.0);
                advance(half + (if stage == Stage::Motion { 0.4 } else { 0.6 }) * part);
                !(self.stop)()
            };
            match near {
                Some(near) => from_neighbour(of, demands, near, &mut watch),
                None => from_nothing(of, demands, &mut watch),
            }
        })
    }

    /// What the written gait does: by its zero dynamics under its own controller.
    fn tried(&self, form: &Path, text: &str, of: &Collocation, optimum: &Optimum) -> ClosedLoop {
        let file: PathBuf = form.with_file_name("found.toml");
        let result = match of.phases.len() {
            1 => self.cycle(&file, text),
            _ => self.repeated(&file, text, of, optimum),
        };
        result.unwrap_or_else(|why| ClosedLoop {
            walks: false,
            reason: Some(why.0.first().map_or_else(String::new, |first| first.message.clone())),
            speed: None,
            multiplier: None,
            walking_speed: None,
            duration: None,
        })
    }

    fn cycle(&self, file: &Path, text: &str) -> Result<ClosedLoop, Diagnostics> {
        let bench = GaitBench::parse(&self.robot, file, text, &crate::progress::Silent)?;
        let cycles = bench.cycles(&crate::gait::CycleOptions::default(), &self.run())?;
        let of = cycles.cycles.first().ok_or_else(|| Diagnostic::error("no cycle was computed"))?;
        let Some(cycle) = of.cycle else {
            return Err(Diagnostic::error(of.reason.clone().unwrap_or_default()).into());
        };
        let step = bench.step(&StepOptions { speed: cycle.speed, ..StepOptions::default() })?;
        Ok(ClosedLoop {
            walks: step.step.feasible && cycle.multiplier < 1.0,
            reason: step.step.reason.map(|reason| reason.to_string()),
            speed: Some(cycle.speed),
            multiplier: Some(cycle.multiplier),
            walking_speed: Some(cycle.walking_speed),
            duration: Some(cycle.duration),
        })
    }

    /// Steps of several phases until they repeat themselves.
    fn repeated(
        &self,
        file: &Path,
        text: &str,
        of: &Collocation,
        optimum: &Optimum,
    ) -> Result<ClosedLoop, Diagnostics> {
        let bench = PhasedBench::parse(&self.robot, file, text, &crate::progress::Silent)?;
        let walker = simulation::walker(&self.robot)?;
        let step = |speed: f64| -> Result<_, Diagnostics> {
            let found = bench.step(&walker.phases, &ChainOptions { speed, set: Vec::new() })?;
            let next = found.next_speed.filter(|_| found.feasible);
            let why =
                || Diagnostic::error(found.reason.clone().unwrap_or_else(|| "a step is not made".to_owned()));
            next.map(|next| (next, found.duration.unwrap_or(f64::NAN))).ok_or_else(|| why().into())
        };
        let mut speed = optimum.slowest_rate(of, 0);
        for _ in 0..60 {
            let (next, _) = step(speed)?;
            let change = next - speed;
            speed = next;
            if change.abs() < 1e-7 * speed {
                break;
            }
        }
        let small = 1e-3 * speed;
        let [above, below] = [step(speed + small)?, step(speed - small)?];
        let multiplier = (above.0 - below.0) / (2.0 * small);
        let (next, duration) = step(speed)?;
        let repeats = (next - speed).abs() < 1e-4 * speed;
        Ok(ClosedLoop {
            walks: repeats && multiplier.abs() < 1.0,
            reason: (!repeats).then(|| "steps do not settle within 60".to_owned()),
            speed: Some(speed),
            multiplier: Some(multiplier),
            walking_speed: Some(optimum.step_length() / duration),
            duration: Some(duration),
        })
    }
}

fn described(of: &Collocation, optimum: &Optimum, (speed, seconds): (f64, f64)) -> OptimisedGait {
    let violated = |(name, by): &(crate::gait::optimise::RowName, f64)| Violated {
        constraint: name.what.clone(),
        phase: of.phases[name.phase].name.clone(),
        node: name.node,
        by: *by,
    };
    OptimisedGait {
        speed,
        feasible: optimum.violations.iter().all(|(_, by)| by.abs() < FEASIBLE)
            && matches!(optimum.ending, Ending::Minimum | Ending::Feasible),
        minimum: optimum.ending == Ending::Minimum,
        iterations: optimum.iterations,
        seconds,
        durations: optimum.durations(),
        step_length: optimum.step_length(),
        margins: optimum.margins(of),
        violations: optimum.violations.iter().filter(|(_, by)| by.abs() >= FEASIBLE).map(violated).collect(),
        closed_loop: None,
        text: None,
    }
}

/// Violations that are rounding, in the unit of each constraint.
const FEASIBLE: f64 = 1e-5;
/// As many violated constraints as are told.
const TOLD: usize = 12;

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

impl fmt::Display for OptimisedGaits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for gait in &self.gaits {
            writeln!(f, "{gait}")?;
        }
        if !self.complete {
            writeln!(f, "interrupted: speeds are missing")?;
        }
        Ok(())
    }
}

impl fmt::Display for OptimisedGait {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ended = match (self.feasible, self.minimum) {
            (true, true) => "a minimum",
            (true, false) => "feasible, the search ended before a minimum",
            (false, _) => "not found",
        };
        writeln!(f, "{} m/s: {ended}, {} iterations, {:.2} s", self.speed, self.iterations, self.seconds)?;
        if !self.feasible {
            let row = |violated: &Violated| {
                let node = violated.node.map_or_else(|| "end".to_owned(), |node| node.to_string());
                vec![
                    violated.constraint.clone(),
                    violated.phase.clone(),
                    node,
                    format!("{:+.3e}", violated.by),
                ]
            };
            let rows: Vec<Vec<String>> = self.violations.iter().take(TOLD).map(row).collect();
            let left = self.violations.len().saturating_sub(TOLD);
            write!(f, "\n{}", table(&["violated", "phase", "node", "by (SI)"], rows, 2))?;
            return if left > 0 { writeln!(f, "and {left} more") } else { Ok(()) };
        }
        write!(f, "\n{}", table(&["", "value", "unit"], self.numbers(), 1))?;
        match &self.closed_loop {
            Some(tried) if !tried.walks => {
                let why = tried.reason.as_deref().unwrap_or("deviations grow");
                writeln!(
                    f,
                    "\nthe trajectory is feasible, but under its controller the robot does not walk: {why}"
                )
            }
            _ => Ok(()),
        }
    }
}

impl OptimisedGait {
    fn numbers(&self) -> Vec<Vec<String>> {
        let margins = &self.margins;
        let mut rows = vec![
            ("step length", Some(self.step_length), "m"),
            ("duration of a step", Some(self.durations.iter().sum()), "s"),
            ("friction needed", Some(margins.friction), "1"),
            ("friction needed by impacts", margins.impact_friction, "1"),
            ("smallest vertical force", Some(margins.push), "N"),
            ("smallest vertical impulse", margins.impulse, "N s"),
            ("centre of pressure inside by", margins.zmp, "m"),
            ("clearance", margins.clearance, "m"),
            ("torque below its limit by", margins.torque, "N m"),
            ("largest torque", Some(margins.largest_torque), "N m"),
            ("joint inside its limits by", margins.joint, "rad"),
        ];
        if let Some(tried) = &self.closed_loop {
            rows.push(("under its controller: walking speed", tried.walking_speed, "m/s"));
            rows.push(("under its controller: multiplier", tried.multiplier, "1"));
        }
        let row = |(name, value, unit): (&str, Option<f64>, &str)| {
            let value = value.map_or_else(|| "—".to_owned(), |value| format!("{value:.6}"));
            vec![name.to_owned(), value, unit.to_owned()]
        };
        rows.into_iter().map(row).collect()
    }
}
