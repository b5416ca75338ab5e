//! How the error fell, step by step.
use super::chart::{Axis, Chart};
use super::px;
use super::rows::keys;
use crate::diagnose::{Diagnosis, ErrorFall};
use crate::number::with_unit;
use crate::report::data::{HistoryStep, Report};
use maud::{Markup, html};

/// The history, or else the steps of the diagnosis.
pub(in crate::report) fn steps(report: &Report) -> Vec<HistoryStep> {
    if !report.history.is_empty() {
        return report.history.clone();
    }
    let Some(diagnosis) = &report.diagnosis else { return Vec::new() };
    let unit = headline(diagnosis).map_or_else(String::new, |fall| fall.unit.clone());
    let noise = headline(diagnosis).map_or(0.0, |fall| fall.noise);
    let step = |step: &crate::diagnose::Step| HistoryStep {
        label: step.effect.to_string(),
        date: String::new(),
        training: None,
        held_out: Some(ErrorFall {
            unit: unit.clone(),
            before: step.before,
            after: step.after,
            noise,
            ..ErrorFall::default()
        }),
    };
    diagnosis.steps.iter().map(step).collect()
}

/// The kind of channel that the diagnosis is about.
pub(in crate::report) fn headline(diagnosis: &Diagnosis) -> Option<&ErrorFall> {
    let kinds = ["post_impact_velocity", "cop", "effort"];
    let same = |fall: &&ErrorFall| fall.before == diagnosis.rms_before && fall.after == diagnosis.rms_after;
    let found = kinds.iter().filter_map(|kind| diagnosis.rms.get(*kind)).find(same);
    found.or_else(|| diagnosis.rms.get("effort"))
}

/// Levels of one data set: before the first step, then after each; NaN where a step does not say.
fn levels(steps: &[HistoryStep], of: impl Fn(&HistoryStep) -> Option<&ErrorFall>) -> Vec<f64> {
    let first = steps.first().and_then(&of).map_or(f64::NAN, |fall| fall.before);
    std::iter::once(first).chain(steps.iter().map(|s| of(s).map_or(f64::NAN, |fall| fall.after))).collect()
}

/// The stairs to draw.
struct Stairs {
    /// With numbers on the treads: held-out errors, or training errors without those.
    main: Vec<f64>,
    class: &'static str,
    /// Training errors beside held-out ones.
    other: Option<Vec<f64>>,
    noise: f64,
    unit: String,
}

impl Stairs {
    fn new(steps: &[HistoryStep]) -> Option<Self> {
        let has = |values: &[f64]| values.iter().any(|x| x.is_finite());
        let unit = steps.iter().find_map(|s| s.held_out.as_ref().or(s.training.as_ref()))?.unit.clone();
        let noise = steps.iter().filter_map(|s| s.held_out.as_ref()).map(|f| f.noise).fold(0.0, f64::max);
        let held_out = levels(steps, |s| s.held_out.as_ref());
        let training = levels(steps, |s| s.training.as_ref());
        Some(if has(&held_out) {
            let other = has(&training).then_some(training);
            Self { main: held_out, class: "held-out", other, noise, unit }
        } else {
            Self { main: training, class: "training", other: None, noise, unit }
        })
    }

    fn entries(&self) -> Vec<(&'static str, &'static str)> {
        let words = if self.class == "training" { "training data" } else { "held-out data" };
        let mut entries = vec![(self.class, words)];
        entries.extend(self.other.as_ref().map(|_| ("training", "training data")));
        entries.extend((self.noise > 0.0).then_some(("floor", "noise")));
        entries
    }

    fn chart(&self) -> Chart {
        let count = self.main.len() as f64;
        let all = self.main.iter().chain(self.other.iter().flatten()).copied();
        Chart {
            left: 70.0,
            top: 34.0,
            width: count * 130.0f64.min(760.0 / count).max(76.0),
            height: 190.0,
            x: Axis::exact(String::new(), 0.0, count),
            y: Axis::around(format!("error, RMS ({})", self.unit), all, true),
            x_ticks: false,
        }
    }
}

/// The staircase; `None` without steps.
pub(in crate::report) fn staircase(steps: &[HistoryStep]) -> Option<(Markup, (f64, f64))> {
    let stairs = Stairs::new(steps)?;
    let chart = stairs.chart();
    let bottom = chart.top + chart.height;
    let captions = captions(steps);
    let middle = |i: usize| px(chart.x(i as f64 + 0.5));
    let values = || stairs.main.iter().enumerate().filter(|(_, value)| value.is_finite());
    let content = html! {
        (chart.axes())
        @if stairs.noise > 0.0 {
            (chart.line("floor", [chart.x.low, chart.x.high].into_iter().map(|x| (x, stairs.noise))))
        }
        @if let Some(other) = &stairs.other { (chart.line("training", treads(other))) }
        (chart.line(stairs.class, treads(&stairs.main)))
        (keys(70.0, 16.0, &stairs.entries()))
        @for (i, value) in values() {
            text class="value" x=(middle(i)) y=(px(chart.y(*value) - 7.0)) text-anchor="middle" { (with_unit(*value, "")) }
        }
        @for (i, lines) in captions.iter().enumerate() { @for (k, line) in lines.iter().enumerate() {
            text class="tick" x=(middle(i)) y=(px(bottom + 17.0 + 14.0 * k as f64)) text-anchor="middle" { (line) }
        } }
    };
    let deepest = captions.iter().map(Vec::len).max().unwrap_or(1);
    Some((content, (chart.left + chart.width + 20.0, bottom + 14.0 + 14.0 * deepest as f64)))
}

/// Corners of the stairs.
fn treads(values: &[f64]) -> impl Iterator<Item = (f64, f64)> + '_ {
    values.iter().enumerate().flat_map(|(i, v)| [(i as f64, *v), (i as f64 + 1.0, *v)])
}

/// What stands below each tread, in short lines.
fn captions(steps: &[HistoryStep]) -> Vec<Vec<String>> {
    let mut all = vec![vec!["nominal".to_owned(), "model".to_owned()]];
    for step in steps {
        let mut lines = wrapped(&format!("+ {}", step.label), 19);
        if !step.date.is_empty() {
            lines.push(step.date.chars().take(10).collect());
        }
        all.push(lines);
    }
    all
}

/// Words in lines of at most `width` characters where they allow it; long names break at `_` and `/`.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for piece in text.split_inclusive([' ', '_', '/']) {
        let last = lines.len() - 1;
        if !lines[last].is_empty() && lines[last].chars().count() + piece.trim_end().chars().count() > width {
            lines.push(String::new());
        }
        let last = lines.len() - 1;
        lines[last].push_str(piece);
    }
    lines.truncate(5);
    lines
}
