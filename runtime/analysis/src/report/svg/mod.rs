//! Pictures as SVG. Colours are classes: the page's style sheet gives them in light and dark, [`standalone`] in light.
pub(super) mod chart;
mod interval;
mod robot;
mod rows;
mod staircase;

pub(super) use interval::{causes, interval};
pub(super) use robot::{degree, legend, named_robot, outline, robot};
pub(super) use rows::{against, keys, torque_and_residual};
pub(super) use staircase::{headline, staircase, steps};

use maud::{Markup, PreEscaped, html};

/// The colours of the page, light, in words that every SVG reader knows. Okabe–Ito.
const STYLE: &str = include_str!("../assets/figure.css");

/// A picture as a file of its own: white ground, its own style.
pub(super) fn standalone(title: &str, (width, height): (f64, f64), content: &Markup) -> String {
    let body = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {height}")) width=(width) height=(height) {
            title { (title) }
            style { (PreEscaped(STYLE)) }
            rect width=(width) height=(height) class="ground" {}
            (content)
        }
    };
    format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{}\n", body.into_string())
}

/// A coordinate with one hundredth of a pixel.
pub(super) fn px(x: f64) -> String {
    let text = format!("{x:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
