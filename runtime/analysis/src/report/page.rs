//! The page as a whole.
use super::data::Report;
use super::{causes, opening, payload, sections, svg};
use crate::experiments::plotted::Row;
use crate::number::{percent, with_unit};
use maud::{DOCTYPE, Markup, PreEscaped, html};

const PLOT_LIBRARY: &str = include_str!("assets/vendor/uplot/uPlot.iife.min.js");
const PLOT_LICENCE: &str = include_str!("assets/vendor/uplot/LICENSE");
const PLOT_STYLE: &str = include_str!("assets/vendor/uplot/uPlot.min.css");
const FIGURE_STYLE: &str = include_str!("assets/figure.css");
const STYLE: &str = include_str!("assets/page.css");
const PLOTS: &str = include_str!("assets/plots.js");
const TOUCH: &str = include_str!("assets/touch.js");
const THEME: &str = include_str!("assets/theme.js");
const PAGE: &str = include_str!("assets/page.js");
/// Nothing may be loaded from anywhere.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'";

/// The page as one HTML document, below [`super::LARGEST_PAGE`] bytes.
pub fn render(report: &Report) -> String {
    let content = html! {
        (opening::section(report))
        (places(report))
        (joint(report))
        @if let Some(diagnosis) = &report.diagnosis { (causes::section(diagnosis)) }
        (sections::estimates(report))
        (sections::staircase(report))
        (sections::changes(report))
        (sections::basis(report))
    };
    let scripts = [TOUCH, PAGE].concat();
    let parts = PageParts { content, numbers: payload::json(report), style: "", scripts: &scripts };
    document(&report.title, &report.robot, parts)
}

/// What pages differ in.
pub(super) struct PageParts<'a> {
    pub content: Markup,
    /// JSON that may stand in a `<script>` element.
    pub numbers: String,
    /// CSS besides that of all pages.
    pub style: &'a str,
    /// After those that all pages have: uPlot, helpers for plots, the theme.
    pub scripts: &'a str,
}

/// A page that loads nothing.
pub(super) fn document(title: &str, robot: &str, parts: PageParts<'_>) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(PLOT_STYLE)) (PreEscaped(FIGURE_STYLE)) (PreEscaped(STYLE)) (PreEscaped(parts.style)) }
            }
            body {
                (header(title, robot))
                main { (parts.content) }
                footer { "Made by bipedc. Plots by uPlot (MIT)." }
                script id="numbers" type="application/json" { (PreEscaped(parts.numbers)) }
                script { "/*!\n" (PreEscaped(PLOT_LICENCE)) "*/\n" (PreEscaped(PLOT_LIBRARY)) }
                script { (PreEscaped(PLOTS)) (PreEscaped(THEME)) (PreEscaped(parts.scripts)) }
            }
        }
    };
    page.into_string()
}

fn header(title: &str, robot: &str) -> Markup {
    html! {
        header {
            div {
                p.robot { (robot) }
                h1 { (title) }
            }
            button #theme type="button" hidden { "Theme: automatic" }
        }
    }
}

/// Where the model fails: the table of rows, which chooses the row that is plotted.
fn places(report: &Report) -> Markup {
    if report.rows.is_empty() {
        return html! {};
    }
    let amended = report.rows.iter().any(|row| row.rms_after.is_some());
    let units = units(&report.rows);
    let begins = |group: usize| units[..group].iter().map(|rows| rows.len()).sum::<usize>();
    html! {
        section.places aria-labelledby="where" {
            h2 #where { "Where the model fails" }
            p.hint { "Choose a row with a click or with the arrow keys, here or in the drawing; check boxes, or Ctrl or Shift with a click, show several." }
            div.table {
                table #rows data-first=(worst(&report.rows)) {
                    caption { "The largest error first. Unexplained: what neither model nor noise accounts for, as a share of the measured signal" }
                    thead { (heads(amended, after(&report.rows))) }
                    @for (group, rows) in units.iter().enumerate() { tbody {
                        @if units.len() > 1 { tr.unit { th colspan="5" scope="rowgroup" { "errors in " (rows[0].unit) } } }
                        @for (index, row) in rows.iter().enumerate() { (line(begins(group) + index, row)) }
                    } }
                }
            }
        }
    }
}

/// Neighbouring rows of one unit.
pub(super) fn units(rows: &[Row]) -> Vec<&[Row]> {
    rows.chunk_by(|a, b| a.unit == b.unit).collect()
}

/// What the second model is called.
pub(super) fn after(rows: &[Row]) -> &str {
    rows.first().map_or("with effects", |row| row.series.after())
}

/// By whom a residual is explained.
fn by(rows: &[Row]) -> &'static str {
    if after(rows) == "with effects" { "by the effects" } else { "by the estimate" }
}

fn heads(amended: bool, after: &str) -> Markup {
    let both = if amended { format!(" nominal → {after}") } else { String::new() };
    html! {
        tr {
            th scope="col" { "no." }
            th scope="col" { "row" }
            th.number scope="col" { "error (RMS)" small { (both) } }
            th.share scope="col" { "unexplained" small { (both) } }
            th.number.noise-column scope="col" { "noise" }
        }
    }
}

/// A row of the table: its name is the button.
fn line(index: usize, row: &Row) -> Markup {
    let bar = |share: f64| {
        let width = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
        let style = format!("--share:{width:.3}");
        html! { span class=(format!("bar u{}", svg::degree(share))) style=(style) aria-hidden="true" {} (percent(share)) }
    };
    let arrow = |before: String, after: Option<String>| {
        after.map_or_else(|| before.clone(), |after| format!("{before} → {after}"))
    };
    let error = match row.rms_after {
        Some(after) => arrow(with_unit(row.rms_before, ""), Some(with_unit(after, &row.unit))),
        None => with_unit(row.rms_before, &row.unit),
    };
    let told = row.rms_moving[0].map(|before| match row.moving_after() {
        Some(after) => arrow(with_unit(before, ""), Some(with_unit(after, &row.unit))),
        None => with_unit(before, &row.unit),
    });
    let noise = if row.noise > 0.0 { with_unit(row.noise, &row.unit) } else { "unknown".to_owned() };
    let shares = arrow(percent(row.unexplained_before), row.unexplained_after.map(percent));
    html! {
        tr data-words=(format!("Unexplained {shares}, error {error}, noise {noise}.")) {
            td.no {
                @if !row.series.is_empty() { input type="checkbox" data-also=(index) aria-label=(format!("show {} in the plots", row.name)); " " }
                (index + 1)
            }
            th scope="row" { button type="button" data-row=(index) aria-pressed="false" { (row.name) } }
            td.number.error { (error) @if let Some(told) = &told { br; small { (told) " where free" } } }
            td.share {
                (bar(row.unexplained_before))
                @if let Some(share) = row.unexplained_after { " → " (percent(share)) }
            }
            td.number.noise-column { (noise) }
        }
    }
}

/// The row that is shown first: the first of which more than noise is left.
fn worst(rows: &[Row]) -> usize {
    rows.iter().position(|row| row.unexplained_before > 0.0).unwrap_or(0)
}

/// The plots of the chosen row; the script fills them.
fn joint(report: &Report) -> Markup {
    if report.rows.iter().all(|row| row.series.is_empty()) {
        return html! {};
    }
    let tool = |action: &str, sign: &str, words: &str| {
        html! { button type="button" data-plot=(action) aria-label=(words) title=(words) { (sign) } }
    };
    html! {
        section #plots aria-labelledby="chosen" {
            h2 { span #chosen aria-live="polite" { "Over time" } }
            p #chosen-numbers {}
            p #chosen-note {}
            div.tools role="toolbar" aria-label="Time window" {
                (tool("out", "−", "show more time")) (tool("in", "+", "show less time"))
                (tool("left", "←", "earlier")) (tool("right", "→", "later"))
                (tool("reset", "whole log", "show the whole log"))
                span.hint { "drag to zoom, Shift and drag to move, double click for the whole log; keys ← → + − 0" }
            }
            div #time-plots {}
            div.table #parts {}
            h3 { "What the residual goes with" }
            p.marks { span.mark-before aria-hidden="true" { "▪" } " measured − nominal"
                @if report.rows.iter().any(|row| row.rms_after.is_some()) { span.mark-after aria-hidden="true" { "✚" } " explained " (by(&report.rows)) }
                span.hint { "samples of the time window above" @if report.rows.iter().any(|row| row.noise > 0.0) { "; grey: twice the noise" } } }
            div #scatter-plots {}
            noscript { p { "The plots need JavaScript; the numbers stand in the tables." } }
        }
    }
}
