//! Maps as a page.
use super::data::{MapFigure, Table};
use super::picture::{caption, mark, one, panel_size};
use super::raster::{colour, hex, shade};
use crate::number::significant;
use crate::report::page::{PageParts, document};
use maud::{Markup, html};

const STYLE: &str = include_str!("../assets/map.css");
const SCRIPT: &str = "steerTheme(() => {}, () => {});\n";

/// The page as one HTML document that loads nothing.
pub fn render_map(figure: &MapFigure) -> String {
    let content = html! {
        section aria-labelledby="maps" {
            h2 #maps { "Next speed over " (figure.axes[0].name) " and " (figure.axes[1].name) }
            (legend(figure))
            div.maps { @for panel in &figure.panels { (picture(figure, panel)) } }
        }
        section aria-labelledby="extremes" { h2 #extremes { "Extremes" } (table(&figure.table)) }
        section aria-labelledby="basis" {
            h2 #basis { "What this rests on" }
            dl.facts { @for fact in &figure.facts { div { dt { (fact.name) } dd { (fact.value) } } } }
        }
    };
    let parts = PageParts { content, numbers: "{}".to_owned(), style: STYLE, scripts: SCRIPT };
    document(&figure.title, &figure.robot, parts)
}

fn picture(figure: &MapFigure, panel: &super::MapPanel) -> Markup {
    let (width, height) = panel_size();
    let words = format!("Speed of the next step {}", caption(figure, panel));
    html! {
        figure { svg viewBox=(format!("0 0 {width} {height}")) role="img" aria-label=(words) { (one(figure, panel, (0.0, 0.0))) } }
    }
}

fn legend(figure: &MapFigure) -> Markup {
    let [low, high] = figure.span();
    let colours: Vec<String> = (0..=16).map(|k| hex(shade(f64::from(k) / 16.0))).collect();
    let key = |symbol: Markup, words: &str| html! { span.key { svg viewBox="0 0 24 14" aria-hidden="true" { (symbol) } (words) } };
    html! {
        p.scale {
            span { "next speed (" (figure.unit) ")" }
            span { (significant(low, 3)) }
            span.bar style=(format!("background:linear-gradient(90deg,{})", colours.join(","))) {}
            span { (significant(high, 3)) }
        }
        p.keys {
            (key(html! { path class="line isocline" d="M0 7h24" {} }, "as fast as before"))
            (key(html! { rect class="bounds" x="1" y="2" width="22" height="10" {} }, "bounds"))
            (key(mark("fastest", 12.0, 8.0), "fastest within bounds"))
            (key(mark("slowest", 12.0, 6.0), "slowest within bounds"))
            @for reason in figure.reasons() {
                (key(html! { rect class="reason" x="1" y="2" width="22" height="10" fill=(hex(colour(reason))) {} }, reason.words()))
            }
        }
    }
}

/// A table that scrolls by itself where it is too wide.
pub(in crate::report) fn table(table: &Table) -> Markup {
    html! {
        div.table { table {
            caption { (table.caption) }
            thead { tr { @for head in &table.head { th scope="col" { (head) } } } }
            tbody { @for row in &table.rows { tr { @for field in row { td { (field) } } } } }
        } }
    }
}
