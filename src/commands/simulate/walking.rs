//! `bipedc simulate` from event to event: phases, their changes, the verdict.
use super::{Log, Simulate, at_place};
use crate::failure::{Failure, Outcome};
use crate::{interruption, output};
use bipedc::film::Recorder;
use bipedc::simulation::true_walker;
use bipedc_analysis::report::{Fact, Film};
use bipedc_analysis::simulate::phases::{FootImpulse, Projected, Violation, WalkSummary, Walking, columns};
use bipedc_analysis::simulate::{EventDriven, Mechanics, Plant, Run, Scenario};
use bipedc_compiler::Robot;
use bipedc_compiler::robot::fnv1a;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::input;
use comfy_table::{CellAlignment, Table};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Exit code of a run that a violated assumption ended.
const VERDICT: u8 = 3;
/// Changes of phase that the table shows.
const SHOWN: usize = 40;

impl Simulate {
    /// Walks, writes, prints.
    pub(super) fn walk(
        &self,
        robot: &Robot,
        plant: &Plant,
        scenario: &Scenario,
        events: &EventDriven,
    ) -> Outcome {
        let in_file = |error: Diagnostic| Failure(vec![error.or_in_file(&self.scenario)]);
        let filmed = self.outputs.wanted();
        let walker = output::progress("deriving", || true_walker(robot, &scenario.effects, filmed))?;
        let mut recorder = match filmed {
            true => {
                let mechanics = Mechanics::new(&walker.model, plant.subject.base)?;
                let rows = (scenario.duration / scenario.step).ceil() as usize;
                Some(Recorder::new(robot, mechanics, scenario.duration, rows)?)
            }
            false => None,
        };
        let truth = self.truth(&robot.description.name, plant, scenario)?;
        let mut log = Log::begin(&self.out, &columns(plant, scenario)?)?;
        let start = Instant::now();
        let stop = interruption::flag();
        let walking = Walking { model: &walker.model, phases: &walker.phases, plant, scenario };
        let summary = output::bar("walking", |progress| {
            let mut row = |values: &[f64]| log.row(values);
            let stop = || stop.load(Ordering::Relaxed);
            let mut run = Run { row: &mut row, progress, stop: &stop };
            walking.run(&mut run, &mut |sample| {
                if let Some(recorder) = &mut recorder {
                    recorder.take(sample);
                }
            })
        });
        let summary = summary.map_err(in_file)?;
        log.commit_with(truth)?;
        if let Some(recorder) = recorder {
            self.outputs.write_film(&self.walked(recorder.finish(), scenario, events, &summary)?)?;
        }
        self.tell(scenario, &summary, start.elapsed().as_secs_f64())?;
        Ok(match summary.end {
            "verdict" => ExitCode::from(VERDICT),
            "interrupted" => ExitCode::from(super::INTERRUPTED),
            _ => ExitCode::SUCCESS,
        })
    }

    /// The film with words and provenance.
    fn walked(
        &self,
        film: Film,
        scenario: &Scenario,
        events: &EventDriven,
        summary: &WalkSummary,
    ) -> Result<Film, Failure> {
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let text = input::read_to_string(&self.scenario)?;
        let mut facts = vec![
            Fact::new("scenario", format!("{}, FNV-1a {:016x}", name(&self.scenario), fnv1a(&text))),
            Fact::new("log", format!("{}, {} rows", name(&self.out), summary.rows)),
            Fact::new(
                "from event to event",
                format!(
                    "DOP853, relative tolerance {:e}, {} steps, {} evaluations",
                    events.relative, summary.integration.steps, summary.integration.evaluations
                ),
            ),
        ];
        facts.extend(scenario.effects.iter().map(|effect| Fact::new("hidden effect", at_place(effect))));
        Ok(Film {
            title: format!("{}: simulation of {}", film.robot, name(&self.scenario)),
            summary: words(summary) + ".",
            warnings: summary.verdict.iter().map(verdict).collect(),
            facts,
            ..film
        })
    }

    fn tell(&self, scenario: &Scenario, summary: &WalkSummary, wall_time: f64) -> Result<(), Failure> {
        let real_time_factor = summary.time / wall_time.max(1e-9);
        if let Some(violation) = &summary.verdict {
            let help = "from there on the model says nothing; the log ends there. [assumptions] says what is checked";
            output::diagnostics(&[Diagnostic::error(verdict(violation)).in_file(&self.scenario).help(help)]);
        }
        if self.json {
            let log = self.out.display().to_string();
            let relative_tolerance = scenario.events.as_ref().map_or(0.0, |events| events.relative);
            let method = "event_driven";
            let answer = Answer { method, summary, relative_tolerance, wall_time, real_time_factor, log };
            output::print_json(&answer)?;
            return Ok(());
        }
        let mut text = format!("{}, {real_time_factor:.0} times as fast as real time\n", words(summary));
        let Projected { position, velocity } = summary.projected;
        if position > 0.0 || velocity > 0.0 {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "the initial state was moved onto the contacts of its phase: by at most {position:.1e} rad or m and {velocity:.1e} rad/s or m/s"
            );
        }
        if !summary.changes.is_empty() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{}", table(summary));
            if summary.changes.len() > SHOWN {
                let _ = writeln!(text, "… and {} more: see --json", summary.changes.len() - SHOWN);
            }
        }
        let integration = &summary.integration;
        let _ = writeln!(
            text,
            "integration: {} steps ({} more were rejected), {} evaluations of the dynamics",
            integration.steps, integration.rejected, integration.evaluations
        );
        let _ = writeln!(text, "{} rows in {}", summary.rows, self.out.display());
        output::print(&text)?;
        Ok(())
    }
}

/// What happened, in words.
fn words(summary: &WalkSummary) -> String {
    let steps = if summary.steps == 1 { "step" } else { "steps" };
    let end = match summary.end {
        "verdict" => ", then an assumption of the model did not hold",
        "interrupted" => ", then interrupted",
        _ => "",
    };
    format!("walked {} {steps} in {:.4} s{end}", summary.steps, summary.time)
}

/// The verdict as a sentence.
fn verdict(violation: &Violation) -> String {
    let Violation { phase, time, quantity, value, limit, unit, meaning } = violation;
    let (value, limit) = (figure(*value), figure(*limit));
    format!(
        "in phase `{phase}` at {time:.6} s: {meaning}: {quantity} is {value} {unit}, the limit is {limit} {unit}"
    )
}

/// Six decimals where they say something.
fn figure(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        1e-3..1e6 => format!("{x:.6}"),
        _ => format!("{x:.3e}"),
    }
}

fn table(summary: &WalkSummary) -> Table {
    let mut table = Table::new();
    table.load_preset(comfy_table::presets::NOTHING);
    table.set_header(["time (s)", "from", "to", "impulse x, z (N s)"]);
    let impulse = |impulses: &[FootImpulse]| {
        let of = |i: &FootImpulse| format!("{} {:.4}, {:.4}", i.foot, i.x, i.z);
        impulses.iter().map(of).collect::<Vec<_>>().join("; ")
    };
    for change in summary.changes.iter().take(SHOWN) {
        table.add_row([
            format!("{:.6}", change.time),
            change.from.clone(),
            change.to.clone(),
            impulse(&change.impulse),
        ]);
    }
    if let Some(column) = table.column_mut(0) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

#[derive(Serialize)]
struct Answer<'a> {
    method: &'static str,
    #[serde(flatten)]
    summary: &'a WalkSummary,
    relative_tolerance: f64,
    wall_time: f64,
    real_time_factor: f64,
    log: String,
}
