//! Curves as a page.
use super::CurveFigure;
use super::picture::{SIZE, picture};
use crate::report::map::table;
use crate::report::page::{PageParts, document};
use maud::html;

const STYLE: &str = ".table th, .table td { white-space: nowrap; }\n";
const SCRIPT: &str = "steerTheme(() => {}, () => {});\n";

/// The page as one HTML document that loads nothing.
pub fn render_curves(figure: &CurveFigure) -> String {
    let content = html! {
        section aria-labelledby="curves" {
            h2 #curves { (figure.y) }
            figure {
                svg viewBox=(format!("0 20 {} {}", SIZE.0, SIZE.1 - 20.0)) role="img" aria-label=(figure.title) style="max-width:46rem;width:100%" {
                    (picture(figure))
                }
            }
        }
        section aria-labelledby="numbers-of-it" { h2 #numbers-of-it { "In numbers" } (table(&figure.table)) }
        section aria-labelledby="basis" {
            h2 #basis { "What this rests on" }
            dl.facts { @for fact in &figure.facts { div { dt { (fact.name) } dd { (fact.value) } } } }
        }
    };
    let parts = PageParts { content, numbers: "{}".to_owned(), style: STYLE, scripts: SCRIPT };
    document(&figure.title, &figure.robot, parts)
}
