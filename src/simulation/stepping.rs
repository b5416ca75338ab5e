//! Time stepping with contacts (thesis 4.3), as a film and in words.
use super::estimated::EstimateWatch;
use super::fastest::{FastestJoint, FastestWatch};
use super::footsteps::{FootstepSummary, Footsteps, Record};
use super::log::Log;
use super::told::ToldLog;
use super::{Options, Outcome, Scene, Simulated, driven_model, energies, filmed_model, true_model};
use crate::film::Recorder;
use crate::progress::Run;
use bipedc_analysis::report::{Fact, Film};
use bipedc_analysis::simulate::control::PhasedController;
use bipedc_analysis::simulate::phases::PhaseSpec;
use bipedc_analysis::simulate::{self, Mechanics, Scenario, Simulation, Summary};
use bipedc_compiler::compile::ProgramModel;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::Effect;
use bipedc_runtime::control::{Borrowed, Controller};
use std::fmt::Write as _;
use std::path::Path;
use std::rc::Rc;
use std::time::Instant;

impl Scene {
    /// Steps, writes.
    pub(super) fn step(
        &self,
        own: Option<&mut dyn Controller<f64>>,
        out: &Path,
        options: &Options,
        run: &Run<'_>,
    ) -> Result<Simulated, Diagnostics> {
        let Self { robot, plant, scenario, .. } = self;
        let filmed = options.energy || options.film;
        let (model, phases) = run.progress.stage("deriving", || self.model(filmed))?;
        let in_file = |error: Diagnostic| error.or_in_file(&self.file);
        let mechanics = Mechanics::new(&model, plant.layout.base)?;
        let recorder = || Recorder::new(robot, mechanics, scenario.duration, rows(scenario));
        let mut recorder = options.film.then(recorder).transpose()?;
        if self.footsteps.is_some() && own.is_none() {
            recorder = recorder.map(Recorder::with_balance);
        }
        let mut watch = EstimateWatch::default();
        let mut fastest = (own.is_none() && self.gait.is_some()).then(|| FastestWatch::new(plant));
        let simulation = Simulation::new(mechanics, plant, scenario).map_err(in_file)?;
        let footsteps = self.footsteps.as_ref().filter(|_| own.is_none());
        let told = options.told.as_deref().map(|path| self.told(footsteps, path)).transpose()?;
        let stepping = footsteps.map(|footsteps| footsteps.controller(told));
        let record = stepping.as_ref().map(|(_, record)| Rc::clone(record));
        // Somebody's own controller gets its refusal back.
        let is_own = own.is_some();
        let mut simulation = match stepping {
            Some((controller, _)) => simulation.controlled(controller),
            None => self.driven(simulation, (&model, &phases), own)?,
        };
        simulation = simulation.watched(|sample| {
            fastest.iter_mut().for_each(|fastest| fastest.see(sample));
            if let Some(recorder) = &mut recorder {
                let balance = record.as_ref().and_then(|record| record.borrow().live.balance(&sample.q));
                recorder.take_balanced(sample, balance);
            }
            let Some(record) = &record else { return };
            let Record { summary, live, .. } = &mut *record.borrow_mut();
            if let Some(estimate) = live.estimate.filter(|_| summary.fell.is_none()) {
                summary.estimated = Some(watch.see(&sample.q, &estimate));
            }
        });
        if !is_own {
            simulation = simulation.until_refused();
        }
        if options.energy {
            simulation = simulation.with_energy()?;
        }
        let truth = self.truth(options.truth.as_deref())?;
        let mut log = Log::begin(out, &simulation.columns())?;
        let start = Instant::now();
        let summary = run.progress.counted("simulating", |progress| {
            let mut row = |values: &[f64]| log.row(values);
            simulation.run(&mut simulate::Run { row: &mut row, progress, stop: run.stop })
        });
        let summary = summary.map_err(|error| self.ended(error))?;
        let told = record.as_ref().and_then(|record| record.borrow_mut().told.take());
        log.commit_with(truth.into_iter().chain(told.map(ToldLog::end).transpose()?))?;
        let film = recorder.map(|recorder| self.film(recorder.finish(), out, &summary)).transpose()?;
        let warning = |text| Diagnostic::warning(text).help("a shorter `step` makes them easier");
        let refused = summary.refused.iter().map(|why| {
            Diagnostic::error(why.clone())
                .in_file(&self.file)
                .help("the log ends there; a film (--film) shows how it came to that")
        });
        let warned = unsolved(&summary).into_iter().map(warning);
        let velocity = fastest.and_then(FastestWatch::end);
        let fast = velocity.as_ref().and_then(FastestJoint::warning);
        let messages = self.warnings().into_iter().chain(warned).chain(fast).chain(refused).collect();
        let walk = record.map(|record| record.borrow().summary.clone());
        Ok(Simulated {
            walk,
            velocity,
            ..Simulated::new(Outcome::Stepped(summary), (out, start), film, messages)
        })
    }

    /// The file of what the controller is told.
    pub(super) fn told(&self, footsteps: Option<&Footsteps>, path: &Path) -> Result<ToldLog, Diagnostic> {
        let Some(footsteps) = footsteps else {
            let message = "no controller of walks by footsteps is told anything here";
            return Err(Diagnostic::error(message).in_file(&self.file).help("add [walking]"));
        };
        footsteps.told(path, &self.plant, self.scenario.sensors.velocities)
    }

    /// The same under somebody's own controller, else the scenario's gait, else its outputs.
    fn driven<'s, 'c: 's>(
        &'s self,
        simulation: Simulation<'s>,
        (model, phases): (&'s ProgramModel, &'s [PhaseSpec]),
        own: Option<&'s mut (dyn Controller<f64> + 'c)>,
    ) -> Result<Simulation<'s>, Diagnostic> {
        let Self { plant, scenario, .. } = self;
        let controller = match (own, &self.gait, &scenario.outputs) {
            (Some(own), ..) => return Ok(simulation.controlled(Borrowed(own))),
            (None, Some(gait), _) => {
                PhasedController::new(model, plant, phases, gait.controller.clone(), scenario.phase)?
            }
            (None, None, Some(outputs)) => {
                PhasedController::of_outputs(model, plant, phases, outputs, scenario.phase)?
            }
            (None, None, None) => return Ok(simulation),
        };
        Ok(simulation.phased(controller))
    }

    /// The robot as built; with the functions of its phases where virtual constraints drive it.
    fn model(&self, filmed: bool) -> Result<(ProgramModel, Vec<PhaseSpec>), Diagnostic> {
        let (robot, scenario) = (self.touching.as_ref().unwrap_or(&self.robot), &self.scenario);
        if scenario.outputs.is_some() || self.gait.is_some() {
            return driven_model(robot, &scenario.effects, filmed);
        }
        let derive = if filmed { filmed_model } else { true_model };
        Ok((derive(robot, &scenario.effects)?, Vec::new()))
    }

    /// Why a run came to nothing.
    fn ended(&self, error: Diagnostic) -> Diagnostics {
        // What has no inertia ends a run at once, unless the rotor of a motor resists.
        let mut all = self.robot.without_inertia().unwrap_or_default();
        all.push(error.or_in_file(&self.file));
        Diagnostics(all)
    }

    /// The film with words and provenance.
    fn film(&self, film: Film, out: &Path, summary: &Summary) -> Result<Film, Diagnostic> {
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let scenario = &self.scenario;
        let mut facts = vec![
            Fact::new("scenario", format!("{}, FNV-1a {}", name(&self.file), self.hash()?)),
            Fact::new("log", format!("{}, {} rows", name(out), summary.rows)),
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
            title: format!("{}: simulation of {}", film.robot, name(&self.file)),
            summary: sentences(&film, summary, scenario.step),
            warnings: unsolved(summary).into_iter().chain(clipped).collect(),
            facts,
            ..film
        })
    }
}

/// What happened, for people.
pub(super) fn text(
    (summary, walk): (&Summary, Option<&FootstepSummary>),
    real_time_factor: f64,
    log: &Path,
) -> String {
    let mut text = String::new();
    let end = match summary {
        Summary { interrupted: true, .. } => "interrupted after",
        Summary { refused: Some(_), .. } => "ended after",
        _ => "simulated",
    };
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
    if let Some(walk) = walk {
        text += &walk.to_string();
    }
    // A controller that saw it has said so.
    if let Some(fall) = summary.fall.as_ref().filter(|_| walk.is_none_or(|walk| walk.fell.is_none())) {
        let _ = writeln!(text, "the robot fell at {:.3} s: {}", fall.time, fall.words());
    }
    if summary.energy_made > 1e-9 {
        let _ =
            writeln!(text, "an impact made {:.2e} J: restitution differs by direction", summary.energy_made);
    }
    if let Some(balance) = &summary.energy {
        text += &energies::table(balance);
    }
    for (joint, steps) in &summary.clipped {
        let _ = writeln!(text, "{joint}: the torque was clipped in {steps} steps");
    }
    let _ = writeln!(text, "{} rows in {}", summary.rows, log.display());
    text
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
pub(super) fn at_place(effect: &Effect) -> String {
    let location = &effect.location;
    let place = [&location.joint, &location.link, &location.sensor].into_iter().flatten().next();
    let kind = effect.kind.name.replace('_', " ");
    place.map_or_else(|| kind.clone(), |place| format!("{kind} at {place}"))
}

/// Times the weight that only impacts push with.
const BLOW: f64 = 3.0;

/// What happened, in words.
fn sentences(film: &Film, summary: &Summary, step: f64) -> String {
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
    if let Some(fall) = &summary.fall {
        let _ = write!(words, ". The robot falls at {:.3} s: {}", fall.time, fall.words());
    }
    if summary.contacts > 0 {
        words += &hardest(film, step);
    }
    words + "."
}

/// The largest force on a foot; what only an impact pushes with is told as the impulse that it is.
fn hardest(film: &Film, step: f64) -> String {
    let of_foot = |(foot, loads): (usize, &'_ Vec<f64>)| {
        let all = film.time.iter().copied().zip(loads.iter().copied());
        all.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(time, load)| (foot, time, load))
    };
    let hardest = film.loads.iter().enumerate().filter_map(of_foot).max_by(|a, b| a.2.total_cmp(&b.2));
    let Some((foot, time, load)) = hardest.filter(|_| film.weight > 0.0) else { return String::new() };
    let (times, name) = (load / film.weight, film.feet.get(foot).map_or("a foot", |foot| &foot.name));
    if times <= BLOW {
        return format!(
            ". The largest vertical force is {load:.0} N ({times:.1} times the weight), on {name} at {time:.3} s"
        );
    }
    let impulse = load * 2.0 * step;
    format!(
        ". The hardest impact is an impulse of {impulse:.3} N s on {name} at {time:.3} s: what the weight gives in {:.3} s. \
         Hard ground has no finite force at an impact: the {load:.0} N in the plots are this impulse over two steps",
        impulse / film.weight
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_analysis::report::FilmFoot;

    /// What hard ground pushes with for two steps is no force that a robot feels for long: it is told as the impulse that it is.
    #[test]
    fn impacts_are_told_as_impulses() {
        let feet = vec![FilmFoot { name: "left_foot".to_owned(), side: None }];
        let landing = |load: f64| Film {
            weight: 100.0,
            time: vec![0.0, 0.001],
            loads: vec![vec![90.0, load]],
            feet: feet.clone(),
            ..Film::default()
        };
        let words = hardest(&landing(31_900.0), 0.001);
        assert!(words.contains("an impulse of 63.800 N s on left_foot at 0.001 s"), "{words}");
        assert!(
            words.contains("what the weight gives in 0.638 s") && !words.contains("times the weight"),
            "{words}"
        );
        assert!(hardest(&landing(250.0), 0.001).contains("250 N (2.5 times the weight), on left_foot"));
    }
}
