//! From event to event (thesis 4.4): phases, their changes, the verdict.
use super::chosen::{self, WalkedSpeeds};
use super::fastest::FastestJoint;
use super::log::Log;
use super::stepping::at_place;
use super::{Options, Outcome, Scene, Simulated, walker_for};
use crate::film::Recorder;
use crate::progress::Run;
use bipedc_analysis::report::{Fact, Film};
use bipedc_analysis::simulate::phases::{
    FootImpulse, LandingGuard, Projected, Violation, WalkEnd, WalkSummary, Walking, columns,
};
use bipedc_analysis::simulate::{self, EventDriven, Mechanics, Sample};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_runtime::control::{Borrowed, Controller};
use comfy_table::{CellAlignment, Table};
use std::cell::RefCell;
use std::fmt::Write as _;
use std::path::Path;
use std::rc::Rc;
use std::time::Instant;

/// Changes of phase that the table shows.
const SHOWN: usize = 40;

impl Scene {
    /// Walks, writes.
    pub(super) fn walk(
        &self,
        events: &EventDriven,
        own: Option<&mut dyn Controller<f64>>,
        out: &Path,
        options: &Options,
        run: &Run<'_>,
    ) -> Result<Simulated, Diagnostics> {
        let Self { robot, plant, scenario, .. } = self;
        let in_file = |error: Diagnostic| error.or_in_file(&self.file);
        if options.energy {
            let message = "where energy goes is known of time stepping alone, and this scenario walks from event to event";
            let help = "leave --energy out; `bipedc gait cycle` says what a step costs";
            return Err(in_file(Diagnostic::error(message).help(help)).into());
        }
        let derive = || walker_for(robot, scenario, options.film);
        let walker = run.progress.stage("deriving", derive)?;
        let recorder = || {
            let mechanics = Mechanics::new(&walker.model, plant.layout.base)?;
            let rows = (scenario.duration / scenario.step).ceil() as usize;
            Recorder::new(robot, mechanics, scenario.duration, rows)
        };
        let mut recorder = options.film.then(recorder).transpose()?;
        let truth = self.truth(options.truth.as_deref())?;
        let mut log = Log::begin(out, &columns(&walker.model, plant, scenario)?)?;
        let start = Instant::now();
        let walking = walker.walking(plant, scenario);
        let own_gait = self.gait.as_ref().filter(|gait| own.is_none() && gait.wishes.is_some());
        let mut row = |values: &[f64]| log.row(values);
        let by_gait = own.is_none() && self.gait.is_some();
        let mut watch = |sample: &Sample| {
            if let Some(recorder) = &mut recorder {
                recorder.take(sample);
            }
        };
        let progress = run.progress;
        let (summary, speeds) = match own_gait {
            Some(gait) => self.with_choosers(gait, run, |choosers| {
                Ok(progress.counted("walking", |progress| {
                    let mut run = simulate::Run { row: &mut row, progress, stop: run.stop };
                    let watched = (&mut run, &mut watch as &mut dyn FnMut(&Sample));
                    chosen::walk((gait, choosers), &walking, watched, options.energies)
                }))
            })?,
            None => progress.counted("walking", |progress| {
                let mut run = simulate::Run { row: &mut row, progress, stop: run.stop };
                (self.walked_by(&walking, own, (&mut run, &mut watch)), None)
            }),
        };
        let summary = summary.map_err(in_file)?;
        log.commit_with(truth)?;
        let film = recorder.map(|recorder| self.walked(recorder.finish(), events, out, &summary));
        let (film, mut messages) = (film.transpose()?, self.warnings());
        let fastest = summary.fastest.filter(|_| by_gait);
        let velocity = fastest.and_then(|found| FastestJoint::new(plant, found));
        messages.extend(velocity.as_ref().and_then(FastestJoint::warning));
        messages.extend(self.verdict(&summary));
        let outcome = Outcome::Walked { summary, relative_tolerance: events.relative, speeds };
        Ok(Simulated { velocity, ..Simulated::new(outcome, (out, start), film, messages) })
    }

    /// Under somebody's own controller, else the scenario's gait, else its outputs.
    fn walked_by(
        &self,
        walking: &Walking<'_>,
        own: Option<&mut dyn Controller<f64>>,
        (run, watch): (&mut simulate::Run<'_>, &mut dyn FnMut(&Sample)),
    ) -> Result<WalkSummary, Diagnostic> {
        match (own, &self.gait) {
            (Some(own), _) => walking.run_with(Borrowed(own), run, watch),
            (None, Some(gait)) => {
                let ending = gait.ending(Rc::new(RefCell::new(gait.values().to_vec())));
                let ending = ending.as_ref().map(|ending| ending as &LandingGuard<'_>);
                walking.run_until(gait.controller.clone(), ending, run, watch)
            }
            (None, None) => walking.run(run, watch),
        }
    }

    /// What ended the walk, if an assumption did.
    fn verdict(&self, summary: &WalkSummary) -> Vec<Diagnostic> {
        let help =
            "from there on the model says nothing; the log ends there. [assumptions] says what is checked";
        let message =
            |found: &Violation| Diagnostic::error(verdict_words(found)).in_file(&self.file).help(help);
        summary.verdict.iter().map(message).collect()
    }

    /// The film with words and provenance.
    fn walked(
        &self,
        film: Film,
        events: &EventDriven,
        out: &Path,
        summary: &WalkSummary,
    ) -> Result<Film, Diagnostic> {
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut facts = vec![
            Fact::new("scenario", format!("{}, FNV-1a {}", name(&self.file), self.hash()?)),
            Fact::new("log", format!("{}, {} rows", name(out), summary.rows)),
            Fact::new(
                "from event to event",
                format!(
                    "DOP853, relative tolerance {:e}, {} steps, {} evaluations",
                    events.relative, summary.integration.steps, summary.integration.evaluations
                ),
            ),
        ];
        facts.extend(self.scenario.effects.iter().map(|effect| Fact::new("hidden effect", at_place(effect))));
        Ok(Film {
            title: format!("{}: simulation of {}", film.robot, name(&self.file)),
            summary: sentence(summary) + ".",
            warnings: summary.verdict.iter().map(verdict_words).collect(),
            facts,
            ..film
        })
    }
}

/// What happened, for people.
pub(super) fn text(
    (summary, speeds): (&WalkSummary, Option<&WalkedSpeeds>),
    real_time_factor: f64,
    log: &Path,
) -> String {
    let mut text = format!("{}, {real_time_factor:.0} times as fast as real time\n", sentence(summary));
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
    if summary.unplanned > 0 {
        let _ = writeln!(
            text,
            "{} changes were not in the order of the phases: contacts came or went early, late or at once",
            summary.unplanned
        );
    }
    if let Some(speeds) = speeds {
        let _ = write!(text, "{speeds}");
    }
    let integration = &summary.integration;
    let _ = writeln!(
        text,
        "integration: {} steps ({} more were rejected), {} evaluations of the dynamics",
        integration.steps, integration.rejected, integration.evaluations
    );
    let _ = writeln!(text, "{} rows in {}", summary.rows, log.display());
    text
}

/// What happened, in words.
fn sentence(summary: &WalkSummary) -> String {
    let steps = if summary.steps == 1 { "step" } else { "steps" };
    let end = match summary.end {
        WalkEnd::Verdict => ", then an assumption of the model did not hold",
        WalkEnd::Interrupted => ", then interrupted",
        WalkEnd::Duration | WalkEnd::Steps => "",
    };
    format!("walked {} {steps} in {:.4} s{end}", summary.steps, summary.time)
}

/// The verdict as a sentence.
fn verdict_words(violation: &Violation) -> String {
    let Violation { phase, time, quantity, value, limit, unit, meaning } = violation;
    let (value, limit) = (figure(*value), figure(*limit));
    format!(
        "in phase `{phase}` at {time:.6} s: {meaning}: {quantity} is {value} {unit}, the limit is {limit} {unit}"
    )
}

/// Six decimals where they say something.
pub(super) fn figure(x: f64) -> String {
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
