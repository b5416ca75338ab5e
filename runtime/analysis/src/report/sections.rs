//! Warnings, estimates, history, and what all of it rests on.
use super::causes::lines;
use super::data::Report;
use super::svg;
use crate::number::with_unit;
use maud::{Markup, html};

/// What the data could not support.
pub(super) fn warnings(report: &Report) -> Vec<String> {
    let found = report.diagnosis.iter().flat_map(|d| &d.warnings);
    distinct(report.warnings.iter().chain(found))
}

/// In order, each once; not again without its advice.
fn distinct<'a>(texts: impl Iterator<Item = &'a String>) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for text in texts {
        if !out.iter().any(|known| known.starts_with(text.as_str())) {
            out.push(text.clone());
        }
    }
    out
}

/// Estimated numbers, with their intervals drawn.
pub(super) fn estimates(report: &Report) -> Markup {
    if report.estimates.is_empty() {
        return html! {};
    }
    html! {
        section aria-labelledby="estimates" {
            h2 #estimates { "Estimated parameters" }
            div.table { table {
                caption { "Line: 95 % interval, from zero where that is near; diamond: estimate" }
                thead { tr {
                    th scope="col" { "parameter" }
                    th.number scope="col" { "estimate" }
                    th.number scope="col" { "std. error" }
                    th.number scope="col" { "described" }
                    th scope="col" { "interval" }
                } }
                tbody { @for e in &report.estimates { tr {
                    th scope="row" { (e.name) }
                    td.number { (with_unit(e.value, &e.unit)) }
                    td.number { (with_unit(e.standard_error, "")) }
                    td.number { (with_unit(e.described, "")) }
                    td { @if let Some(picture) = svg::interval(e.value, Some(e.interval), (e.described, e.described)) { (picture) } }
                } } }
            } }
        }
    }
}

/// The history as picture and table.
pub(super) fn staircase(report: &Report) -> Markup {
    let steps = svg::steps(report);
    let Some((picture, (width, height))) = svg::staircase(&steps) else { return html! {} };
    let dated = steps.iter().any(|s| !s.date.is_empty());
    let trained = steps.iter().any(|s| s.training.is_some());
    let pair = |fall: &Option<crate::diagnose::ErrorFall>| {
        fall.as_ref().map_or_else(
            || "–".to_owned(),
            |f| format!("{} → {}", with_unit(f.before, ""), with_unit(f.after, &f.unit)),
        )
    };
    html! {
        section aria-labelledby="stairs" {
            h2 #stairs { "How the error fell" }
            div.scroll tabindex="0" role="region" aria-label="Staircase of the error" {
                svg.staircase viewBox=(format!("0 0 {width} {height}")) width=(width) height=(height) role="img"
                    aria-label="The error after each step; the same numbers stand in the table below" { (picture) }
            }
            div.table { table {
                caption { "Root mean square error before and after each step" }
                thead { tr {
                    th scope="col" { "step" }
                    @if dated { th scope="col" { "date" } }
                    th.number scope="col" { "held-out data" }
                    @if trained { th.number scope="col" { "training data" } }
                } }
                tbody { @for step in &steps { tr {
                    th scope="row" { (step.label) }
                    @if dated { td.date { (step.date) } }
                    td.number { (pair(&step.held_out)) }
                    @if trained { td.number { (pair(&step.training)) } }
                } } }
            } }
        }
    }
}

/// What was done to the description, with all its numbers.
pub(super) fn changes(report: &Report) -> Markup {
    if report.changes.is_empty() {
        return html! {};
    }
    html! {
        section aria-labelledby="changes" {
            h2 #changes { "What was done to the description" }
            div.table { table {
                caption { "Parameters as they were written, with 95 % intervals where they are known" }
                thead { tr { @for head in ["step", "date", "what", "effect", "parameters"] { th scope="col" { (head) } } } }
                tbody { @for change in &report.changes { tr {
                    td.number { (change.step) }
                    td.date { (change.date) }
                    td { (change.action) }
                    th scope="row" { (change.effect) }
                    td.values { @for parameter in &change.parameters { div { (parameter) } } }
                } } }
            } }
        }
    }
}

/// Preprocessing, data, assumptions.
pub(super) fn basis(report: &Report) -> Markup {
    let assumptions =
        distinct(report.assumptions.iter().chain(report.diagnosis.iter().flat_map(|d| &d.assumptions)));
    let mut facts: Vec<(String, String)> =
        report.facts.iter().map(|f| (f.name.clone(), f.value.clone())).collect();
    if let Some(diagnosis) = &report.diagnosis {
        let source =
            |s: &crate::measure::DataSource| format!("{}, {} samples, FNV-1a {}", s.file, s.samples, s.hash);
        facts.push(("estimated from".to_owned(), source(&diagnosis.training)));
        let judge = diagnosis.validation.as_ref().map_or_else(|| "blocks of the same log".to_owned(), source);
        facts.push(("judged on".to_owned(), judge));
        if diagnosis.cutoff_hz > 0.0 && !report.facts.iter().any(|f| f.name == "cut-off") {
            facts.push(("cut-off".to_owned(), with_unit(diagnosis.cutoff_hz, "Hz")));
        }
        if let Some(judged) = diagnosis.judged_at_hz {
            facts.push(("cut-off of the errors".to_owned(), format!("{judged} Hz")));
        }
    }
    if assumptions.is_empty() && facts.is_empty() {
        return html! {};
    }
    html! {
        section aria-labelledby="basis" {
            h2 #basis { "What this rests on" }
            @if !facts.is_empty() {
                dl.facts { @for (name, value) in &facts { div { dt { (name) } dd { (value) } } } }
            }
            (lines("Assumed", "assumptions", &assumptions))
        }
    }
}
